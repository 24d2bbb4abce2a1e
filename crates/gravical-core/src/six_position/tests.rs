use super::*;

/// A sensor of a few per cent of scale error and up to 3° of misalignment.
const MODEL: [[f64; 3]; 3] = [
    [1.02, 0.013, -0.021],
    [-0.008, 0.97, 0.034],
    [-0.052, 0.005, 1.01],
];

/// What a sensor with u = M a + b reads in six perfect placements.
fn placements(model: [[f64; 3]; 3], bias: [f64; 3], gravity: f64) -> SixPositionMeans<f64> {
    let hold = |axis: usize, g: f64| from_fn(|r| bias[r] + model[r][axis] * g);
    SixPositionMeans {
        plus: from_fn(|axis| hold(axis, gravity)),
        minus: from_fn(|axis| hold(axis, -gravity)),
    }
}

fn assert_close(got: &[f64], expected: &[f64], tolerance: f64) {
    for (g, e) in got.iter().zip(expected) {
        assert!((g - e).abs() <= tolerance, "{got:?} for {expected:?}");
    }
}

fn narrow(means: &SixPositionMeans<f64>) -> SixPositionMeans<f32> {
    SixPositionMeans {
        plus: means.plus.map(|row| row.map(|x| x as f32)),
        minus: means.minus.map(|row| row.map(|x| x as f32)),
    }
}

#[test]
fn simulated_parameters_come_back() {
    let (bias, g) = ([0.385, -0.13, 0.44], 9.793);
    let means = placements(MODEL, bias, g);
    let double = ferraris_accelerometer(&means, g).unwrap();
    let model = MODEL.as_flattened();
    assert_close(double.model().as_flattened(), model, 1e-12);
    assert_close(&double.bias, &bias, 1e-12);

    let single = ferraris_accelerometer(&narrow(&means), g as f32).unwrap();
    let found = single.model().map(|row| row.map(f64::from));
    assert_close(found.as_flattened(), model, 1e-5);
    assert_close(&single.bias.map(f64::from), &bias, 1e-5);

    let accel = [3.0, -4.0, 9.0];
    let raw = from_fn(|r| bias[r] + matrix3::dot(&MODEL[r], &accel));
    let back = double.calibration().unwrap().apply(raw);
    assert_close(&back, &accel, 1e-12);
    let back = single.calibration().unwrap().apply(raw.map(|x| x as f32));
    assert_close(&back.map(f64::from), &accel, 1e-5 * 9.0);
}

#[test]
fn what_is_wrong_is_named() {
    use SixPositionError::*;
    let means = placements(MODEL, [0.4, -0.1, 0.4], 9.81);
    let with = |change: &dyn Fn(&mut [f64; 3])| {
        let mut means = means;
        let rows = means.plus.iter_mut().chain(&mut means.minus);
        rows.for_each(change);
        means
    };
    let frozen = with(&|row| row[1] = 9.7);
    let mut almost_frozen = frozen;
    almost_frozen
        .plus
        .iter_mut()
        .for_each(|row| row[1] += 1e-14);
    for (changed, g, error) in [
        (with(&|row| row[2] = f64::NAN), 9.81, NotFinite),
        (means, f64::NAN, GravityNotPositive),
        (means, f64::INFINITY, GravityNotPositive),
        (means, 0.0, GravityNotPositive),
        (means, -9.81, GravityNotPositive),
        (frozen, 9.81, VanishedRow { channel: 1 }),
        (almost_frozen, 9.81, VanishedRow { channel: 1 }),
        // The z channel is wired to x.
        (with(&|row| row[2] = row[0]), 9.81, Singular),
    ] {
        assert_eq!(ferraris_accelerometer(&changed, g).unwrap_err(), error);
    }
}
