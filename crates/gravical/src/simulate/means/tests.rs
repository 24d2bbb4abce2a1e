use super::*;

#[test]
fn parts_do_not_depend_on_each_other() {
    let options = MeansOptions::default();
    let mut one = Part::draw(&options, 3, 5);
    let mut same = Part::draw(&options, 3, 5);
    let other = Part::draw(&options, 3, 6);
    assert_eq!(
        one.place(&Planned::six_faces()),
        same.place(&Planned::six_faces())
    );
    assert_ne!(one.model(), other.model());
}

#[test]
fn true_parameters_have_no_error() {
    let part = Part::draw(&MeansOptions::default(), 1, 0);
    let errors = part.errors(&part.model(), &part.bias_mps2()).unwrap();
    assert!(errors.norm_mps2 < 1e-12 && errors.direction_rad < 1e-12);
    assert_eq!(errors.bias_mps2, 0.0);
}

#[test]
fn rotation_by_180_degrees_reverses_the_tilt_of_the_table() {
    let options = MeansOptions {
        tilt_sd_rad: 0.0,
        table_sd_rad: 0.03,
        ..MeansOptions::default()
    };
    let mut part = Part::draw(&options, 1, 0);
    let once = part.place(&Planned::six_faces());
    let turned = part.place(&Planned::faces_turned(PI));
    for (a, b) in once.iter().zip(&turned) {
        let nominal = a.face.unwrap().direction();
        let angle = angle_deg(a.direction, nominal);
        assert!(angle > 0.1 && (angle - angle_deg(b.direction, nominal)).abs() < 1e-9);
        let middle = std::array::from_fn(|i| a.direction[i] + b.direction[i]);
        assert!(angle_deg(middle, nominal) < 1e-9);
    }
}

#[test]
fn a_rotated_board_has_rotated_axes_and_equal_scales() {
    let options = MeansOptions {
        misalignment_sd_rad: 0.0,
        ..MeansOptions::default()
    };
    let straight = Part::draw(&options, 1, 0);
    let turned = Part::draw(
        &MeansOptions {
            board_turn_rad: 0.05,
            ..options
        },
        1,
        0,
    );
    let (a, b) = (straight.model(), turned.model());
    for i in 0..3 {
        assert!((matrix3::norm(&a[i]) - matrix3::norm(&b[i])).abs() < 1e-12);
    }
    let largest = (0..3)
        .map(|i| angle_deg(a[i], b[i]).to_radians())
        .fold(0.0, f64::max);
    assert!(largest > 0.03 && largest < 0.050_001, "{largest}");
}
