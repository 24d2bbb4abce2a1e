//! Files made by hand: what is said of units, gravity, temperature, gaps.

use super::*;
use crate::calibrate::Method;
use crate::calibrate::{CalibrateOptions, calibrate};
use crate::calibration_file::{Covariance, GyroscopeSection, InputFile, TemperatureRange};
use crate::recording::units::GyroUnit;
use crate::recording::{AccelUnit, ReadOptions, read_bytes};

/// A file of six means with a covariance of `sigma` for all parameters.
fn file(sigma: f64) -> CalibrationFile {
    let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
               -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
    let session = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default()).unwrap()];
    let mut options = CalibrateOptions::default();
    options.estimate.method = Method::Ferraris;
    let mut file = calibrate(&session, &options).unwrap().file;
    file.accelerometer.covariance = Some(diagonal(sigma, 1.0));
    file.accelerometer.gravity_sd_mps2 = 0.0;
    file
}

/// `sigma` for the elements of M, g times it for the bias, in `per` units a m/s².
fn diagonal(sigma: f64, per: f64) -> Covariance {
    let variance = |i: usize| (per * if i < 9 { sigma } else { 9.81 * sigma }).powi(2);
    Covariance {
        parameters: Covariance::parameter_names(),
        values: (0..12)
            .map(|r| {
                (0..12)
                    .map(|c| if r == c { variance(r) } else { 0.0 })
                    .collect()
            })
            .collect(),
    }
}

fn compared(a: &CalibrationFile, b: &CalibrationFile) -> Comparison {
    compare(a, b, ["a.json", "b.json"]).unwrap()
}

fn has(c: &Comparison, kind: &str) -> bool {
    c.findings.iter().any(|f| f.kind == kind)
}

/// The same calibration for a board that is turned in its case.
fn turned(file: &CalibrationFile, by: [f64; 3]) -> CalibrationFile {
    let q = nalgebra::Rotation3::new(nalgebra::Vector3::from(by));
    let q: [[f64; 3]; 3] = std::array::from_fn(|r| std::array::from_fn(|c| q.matrix()[(r, c)]));
    let mut out = file.clone();
    let transposed = gravical_core::matrix3::transpose(&q);
    out.accelerometer.matrix = gravical_core::matrix3::mul(&transposed, &file.accelerometer.matrix);
    out
}

#[test]
fn a_turned_board_differs_in_orientation_alone() {
    let a = file(1e-4);
    let result = compared(&a, &turned(&a, [0.0, 0.0, 0.02]));
    assert_eq!(result.magnitude.judgement, Agreement::Agree);
    assert!(result.magnitude.norm_rms_mps2 < 1e-9);
    let orientation = result.orientation.as_ref().unwrap();
    assert_eq!(orientation.judgement, Agreement::Differ);
    assert!((orientation.angle_deg - 0.02_f64.to_degrees()).abs() < 1e-9);
    assert!((orientation.axis[2].abs() - 1.0).abs() < 1e-9);
    assert_eq!(result.verdict.judgement, Agreement::Differ);
    // σ of a rotation about one axis: two rows of two elements each.
    let sigma = result.parameters[11].sigma.unwrap().to_radians();
    assert!((sigma - 1e-4).abs() < 1e-5, "{sigma}");
    // A board that was put in on its side is still the same sensor.
    let side = compared(&a, &turned(&a, [1.2, -0.4, 0.9]));
    assert_eq!(side.magnitude.judgement, Agreement::Agree);
}

#[test]
fn a_moved_bias_differs_in_length_alone() {
    let a = file(1e-4);
    let mut b = a.clone();
    b.accelerometer.bias[1] += 5.0 * 2_f64.sqrt() * 9.81e-4;
    let result = compared(&a, &b);
    assert_eq!(result.magnitude.judgement, Agreement::Differ);
    assert_eq!(result.orientation.unwrap().judgement, Agreement::Agree);
    assert!((result.parameters[1].z.unwrap() - 5.0).abs() < 1e-6);
    assert!(result.magnitude.largest_at[1].abs() > 0.9);
    assert!((result.magnitude.test.unwrap().chi2 - 25.0).abs() < 1e-4);
}

#[test]
fn counts_and_g_are_compared_by_their_nominal_scale() {
    let a = file(1e-4);
    let mut b = a.clone();
    let per = 16384.0 / 9.80665;
    let s = &mut b.accelerometer;
    s.input_unit = AccelUnit::Counts;
    s.matrix = s.matrix.map(|row| row.map(|v| v / per));
    s.bias = s.bias.map(|v| v * per);
    s.scale = s.scale.map(|v| v * per);
    s.covariance = Some(diagonal(1e-4, per));
    let result = compared(&a, &b);
    assert!(has(&result, "units-converted"));
    assert!(result.magnitude.test.unwrap().chi2 < 1e-12);
    assert!((result.parameters[0].sigma.unwrap() - 2_f64.sqrt() * 9.81e-4).abs() < 1e-9);

    b.accelerometer.scale_deviation_percent = None;
    let error = compare(&a, &b, ["a.json", "b.json"]).unwrap_err();
    assert_eq!(error.code(), "units-differ");
    // Two of unknown range compare when they are of one size.
    assert!(compared(&b, &b.clone()).magnitude.norm_rms_mps2 < 1e-9);
    // Unsigned counts carry 32768 in their bias.
    let mut unsigned = b.clone();
    unsigned.accelerometer.bias = unsigned.accelerometer.bias.map(|v| v + 32768.0);
    let result = compared(&b, &unsigned);
    assert!(result.magnitude.test.unwrap().chi2 < 1e-9);
    assert!(has(&result, "units-converted"));
}

#[test]
fn without_covariance_differences_are_shown_and_not_judged() {
    let (a, mut b) = (file(1e-4), file(1e-4));
    b.accelerometer.covariance = None;
    b.accelerometer.bias[0] += 1.0;
    let result = compared(&a, &b);
    assert_eq!(result.verdict.judgement, Agreement::Undecided);
    assert!((result.parameters[0].difference - 1.0).abs() < 1e-9);
    assert_eq!(result.parameters[0].sigma, None);
    assert_eq!(result.magnitude.test, None);
    assert!(has(&result, "covariance-missing"));
}

#[test]
fn another_gravity_is_told_and_taken_off() {
    let a = file(1e-4);
    let mut b = a.clone();
    b.gravity_mps2 = a.gravity_mps2 * 1.002;
    b.accelerometer.matrix = a.accelerometer.matrix.map(|r| r.map(|v| v * 1.002));
    let result = compared(&a, &b);
    assert!(has(&result, "gravity-differs"));
    assert_eq!(result.magnitude.judgement, Agreement::Differ);
    assert!(result.magnitude.test_at_one_gravity.unwrap().chi2 < 1e-9);
}

#[test]
fn what_else_has_to_be_known_is_said() {
    let (mut a, mut b) = (file(1e-4), file(1e-4));
    let at = |mean: f64| {
        Some(TemperatureRange {
            mean,
            min: mean,
            max: mean,
        })
    };
    (a.temperature_c, b.temperature_c) = (at(22.0), at(41.0));
    (a.sensor.id, b.sensor.id) = (Some("1".into()), Some("2".into()));
    b.accelerometer.bias[0] += 1e-4;
    let input = InputFile {
        path: "x.csv".into(),
        sha256: Some("00".into()),
        role: Default::default(),
    };
    (a.inputs, b.inputs) = (vec![input.clone()], vec![input]);
    let result = compared(&a, &b);
    for kind in ["temperature-differs", "sensor-differs", "same-recordings"] {
        assert!(has(&result, kind), "{kind}");
    }
    let reported = result
        .findings
        .iter()
        .find(|f| f.kind == "temperature-differs");
    assert!(reported.unwrap().message.contains("22.0 °C and 41.0 °C"));
    // Shared recordings: agreement proves nothing.
    assert_eq!(result.verdict.judgement, Agreement::Undecided);
    let same = compared(&a, &a.clone());
    assert!(has(&same, "same-calibration"));
    assert_eq!(same.verdict.judgement, Agreement::Undecided);
}

#[test]
fn directions_without_variance_are_no_proof() {
    let (mut a, mut b) = (file(1e-4), file(1e-4));
    for f in [&mut a, &mut b] {
        // As for poses without faces: nothing is said of the x bias.
        if let Some(c) = &mut f.accelerometer.covariance {
            c.values[9][9] = 0.0;
        }
    }
    b.accelerometer.bias[0] += 0.5;
    let result = compared(&a, &b);
    assert!(has(&result, "undetermined-direction"));
    let test = result.magnitude.test.unwrap();
    assert_eq!(test.degrees_of_freedom, 8);
    assert!(test.chi2 < 1e-9, "{test:?}");
}

#[test]
fn without_faces_the_frame_is_a_convention() {
    let a = file(1e-4);
    let mut b = turned(&a, [0.0, 0.1, 0.0]);
    b.accelerometer
        .poses
        .iter_mut()
        .for_each(|p| p.kind = crate::calibration_file::PoseKind::Free);
    let result = compared(&a, &b);
    assert!(has(&result, "orientation-unknown"));
    assert_eq!(result.orientation.unwrap().judgement, Agreement::Undecided);
    assert_eq!(result.verdict.judgement, Agreement::Agree);
}

#[test]
fn mirror_images_and_gyroscopes() {
    let a = file(1e-4);
    let mut b = a.clone();
    b.accelerometer.matrix[2] = a.accelerometer.matrix[2].map(|v| -v);
    let result = compared(&a, &b);
    assert!(has(&result, "frames-mirrored"));
    assert_eq!(result.verdict.judgement, Agreement::Differ);
    assert_eq!(result.parameters.len(), 9);

    // 131 counts per °/s; channel x along the y axis of the case, y against its x axis.
    let per_rad_s = 131.0_f64.to_degrees();
    let orientation = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let back = gravical_core::matrix3::transpose(&orientation);
    let gyro = |bias: [f64; 3]| GyroscopeSection {
        input_unit: GyroUnit::Counts,
        output_unit: GyroUnit::RadianPerSecond,
        bias,
        matrix: back.map(|row| row.map(|v| v / per_rad_s)),
        scale: [per_rad_s; 3],
        orientation,
        ..GyroscopeSection::default()
    };
    let (mut a, mut b) = (a.clone(), a);
    a.gyroscope = Some(gyro([0.0; 3]));
    // Unsigned counts read 32768 at rest.
    for zero in [0.0, 32768.0] {
        b.gyroscope = Some(gyro([131.0, 262.0, 393.0].map(|v| v + zero)));
        let gyroscope = compared(&a, &b).gyroscope.unwrap();
        for (got, want) in gyroscope.bias_b_deg_s.iter().zip([-2.0, 1.0, 3.0]) {
            assert!((got - want).abs() < 1e-9, "{gyroscope:?}");
        }
        assert_eq!(gyroscope.bias_difference_deg_s, gyroscope.bias_b_deg_s);
        assert_eq!(gyroscope.scale_difference_percent, Some([0.0; 3]));
    }
}
