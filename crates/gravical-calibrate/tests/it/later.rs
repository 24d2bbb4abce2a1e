//! `check` and `compare` of files and recordings made by hand: what counts, what is refused, what
//! is said.

use std::array::from_fn;

use gravical_calibrate::calibrate::{CalibrateOptions, Method, calibrate};
use gravical_calibrate::calibration_file::{
    Calibration, Covariance, FitQuality, InputFile, TemperatureRange,
};
use gravical_calibrate::check::{CheckOptions, CheckReport, Judgement, check};
use gravical_calibrate::compare::{Comparison, compare};
use gravical_calibrate::gravity::Gravity;
use gravical_calibrate::recording::{AccelUnit, Finding, ReadOptions, Recording, read_bytes};
use gravical_core::matrix3;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::support::{FACES, by_ferraris, calibrated, with_gravity};

const G: f64 = 9.80665;

/// `rows` readings at 100 Hz of a perfect sensor with `bias`, gravity `g` along the axis of a face; 25 °C, a
/// gyroscope at rest.
fn rest(face: usize, rows: usize, bias: [f64; 3], g: f64, seed: u64) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let mut text = "t_ms,ax_m/s2,ay_m/s2,az_m/s2,temp,gx_rad/s,gy_rad/s,gz_rad/s\n".to_owned();
    for i in 0..rows {
        let [x, y, z] = [0, 1, 2].map(|k| g * FACES[face].1[k] + bias[k] + noise(0.02));
        let [u, v, w] = [(); 3].map(|()| noise(1e-3));
        let t_ms = 10 * i;
        text += &format!("{t_ms},{x:.5},{y:.5},{z:.5},25.0,{u:.6},{v:.6},{w:.6}\n");
    }
    read_bytes(text.as_bytes(), "rest.csv", &ReadOptions::default()).unwrap()
}

fn calibration() -> Calibration {
    let session = (0..6).map(|face| rest(face, 500, [0.0; 3], G, face as u64));
    let options = CalibrateOptions {
        estimate: by_ferraris(Some(0.1)),
        ..with_gravity(G)
    };
    calibrated(&session.collect::<Vec<_>>(), &options).calibration
}

fn checked(file: &Calibration, recordings: &[Recording]) -> CheckReport {
    check(file, "cal.json", recordings, &CheckOptions::default()).unwrap()
}

#[track_caller]
fn assert_judged(report: &CheckReport, judgement: Judgement) {
    assert_eq!(report.verdict.judgement, judgement, "{:?}", report.verdict);
}

/// One temperature, °C.
fn at(mean: f64) -> Option<TemperatureRange> {
    let (min, max) = (mean, mean);
    Some(TemperatureRange { mean, min, max })
}

fn has(findings: &[Finding], kind: &str) -> bool {
    findings.iter().any(|f| f.kind == kind)
}

fn says(reasons: &[String], words: &str) -> bool {
    reasons.iter().any(|r| r.contains(words))
}

#[test]
fn one_pose_is_enough_and_says_what_it_does_not_test() {
    let report = checked(&calibration(), &[rest(4, 300, [0.0; 3], G, 90)]);
    assert_judged(&report, Judgement::Agrees);
    assert_eq!(report.static_intervals.len(), 1);
    assert_eq!(report.static_intervals[0].nearest, "+z");
    assert_eq!(report.untested_axes, ["x", "y"]);
    assert_eq!(report.test.degrees_of_freedom, 1);
}

#[test]
fn a_share_is_gravity_where_it_is_given() {
    let file = calibration();
    let session = [0, 1, 2, 3, 4, 5].map(|face| rest(face, 300, [0.0; 3], 9.83, 40 + face as u64));
    assert_judged(&checked(&file, &session), Judgement::DoesNotFit);
    // With the gravity of that place it fits.
    let options = CheckOptions {
        gravity: Some(Gravity::given(9.83).unwrap()),
        ..CheckOptions::default()
    };
    let there = check(&file, "cal.json", &session, &options).unwrap();
    assert_judged(&there, Judgement::Agrees);
    assert!(has(&there.findings, "gravity-differs"));
}

#[test]
fn without_covariance_only_gross_errors_are_told() {
    let mut file = calibration();
    file.accelerometer.covariance = None;
    for (bias, judgement) in [(0.1, Judgement::Undecided), (0.3, Judgement::DoesNotFit)] {
        let report = checked(&file, &[rest(0, 300, [bias, 0.0, 0.0], G, 7)]);
        assert_judged(&report, judgement);
    }
}

#[test]
fn another_unit_or_size_or_nothing_at_rest_is_refused() {
    let file = calibration();
    let read = |text: String| {
        let options = ReadOptions::default();
        vec![read_bytes(text.as_bytes(), "later.csv", &options).unwrap()]
    };
    let in_g = "ax,ay,az\n".to_owned() + &"0.001,0.0,1.002\n0.0,0.002,0.999\n".repeat(200);
    let mut other = file.clone();
    other.accelerometer.bias[2] = 4.0;
    let mut shaken = "t_ms,ax_m/s2,ay_m/s2,az_m/s2\n".to_owned();
    for i in 0..400 {
        let t_s = f64::from(i) / 100.0;
        let (x, y) = (6.0 * (11.0 * t_s).sin(), 3.0 * (7.0 * t_s).cos());
        shaken += &format!("{},{x:.3},{y:.3},{:.3}\n", 10 * i, 9.8 - x);
    }
    for (file, recordings, code) in [
        (&file, read(in_g), "unit-mismatch"),
        (&other, vec![rest(4, 300, [0.0; 3], G, 3)], "unit-mismatch"),
        (&file, read(shaken), "never-static"),
        (&file, vec![], "no-recordings"),
    ] {
        let error = check(file, "cal.json", &recordings, &CheckOptions::default()).unwrap_err();
        assert_eq!(error.code(), code);
    }
}

#[test]
fn the_drift_is_taken_off() {
    let mut file = calibration();
    let mut later = [rest(4, 300, [0.0, 0.0, 0.2], G, 8)];
    assert_judged(&checked(&file, &later), Judgement::DoesNotFit);
    file.temperature_c = at(40.0);
    assert!(has(&checked(&file, &later).findings, "temperature-outside"));
    // 0.02 m/s² per °C on z, known at 15 °C: the recording is at 25.
    let model = serde_json::json!({
        "reference_c": 15.0, "range_c": [10.0, 30.0],
        "channels": [{
            "channel": "az", "input_unit": "m/s^2", "verdict": "corrected", "reason": "",
            "per_c": 0.02
        }]
    });
    file.temperature_c = at(25.0);
    file.drift = Some(serde_json::from_value(model).unwrap());
    let report = checked(&file, &later);
    assert_judged(&report, Judgement::Agrees);
    assert!(!has(&report.findings, "temperature-outside"));
    later[0].temperature_c = None;
    let report = checked(&file, &later);
    assert!(has(&report.findings, "temperature-not-applied"));
}

/// A file of six means with a covariance of `sigma` for all parameters.
fn file(sigma: f64) -> Calibration {
    let csv = "label,ax,ay,az\n-x,-9.43,-0.27,0.92\n+x,10.20,-0.04,-0.10\n\
               -y,0.46,-9.99,0.39\n+y,0.29,9.73,0.49\n-z,-0.05,-0.08,-9.54\n+z,0.83,-0.18,10.42\n";
    let session = [read_bytes(csv.as_bytes(), "means.csv", &ReadOptions::default()).unwrap()];
    let mut options = CalibrateOptions::default();
    options.estimate.method = Method::Ferraris;
    let mut file = calibrate(&session, &options).unwrap().calibration;
    file.accelerometer.covariance = Some(diagonal(sigma, 1.0));
    file.gravity_sd_mps2 = 0.0;
    file
}

/// `sigma` for the elements of M, g times it for the bias, in `per` units a m/s².
fn diagonal(sigma: f64, per: f64) -> Covariance {
    let sd = |i: usize| per * sigma * if i < 9 { 1.0 } else { 9.81 };
    let variance = |i: usize, k: usize| if i == k { sd(i).powi(2) } else { 0.0 };
    Covariance::new::<12>(from_fn(|i| from_fn(|k| variance(i, k))))
}

fn compared(a: &Calibration, b: &Calibration) -> Comparison {
    compare(a, b, ["a.json", "b.json"]).unwrap()
}

/// The same calibration for a board that is turned in its case.
fn turned(file: &Calibration, by: [f64; 3]) -> Calibration {
    let q = nalgebra::Rotation3::new(nalgebra::Vector3::from(by));
    // Columns of q are rows of its transpose.
    let transposed: [[f64; 3]; 3] = (*q.matrix()).into();
    let mut out = file.clone();
    out.accelerometer.matrix = matrix3::mul(&transposed, &file.accelerometer.matrix);
    out
}

#[test]
fn a_turned_board_differs_in_orientation_alone() {
    let a = file(1e-4);
    let result = compared(&a, &turned(&a, [0.0, 0.0, 0.02]));
    assert_eq!(result.magnitude.judgement, Judgement::Agrees);
    assert!(result.magnitude.norm_rms_mps2 < 1e-9);
    let orientation = result.orientation.as_ref().unwrap();
    assert_eq!(orientation.judgement, Judgement::Differs);
    assert!((orientation.angle_deg - 0.02_f64.to_degrees()).abs() < 1e-9);
    assert!((orientation.axis[2].abs() - 1.0).abs() < 1e-9);
    assert_eq!(result.verdict.judgement, Judgement::Differs);
    // σ of a rotation about one axis: two rows of two elements each.
    let sigma = result.parameters[11].sigma.unwrap().to_radians();
    assert!((sigma - 1e-4).abs() < 1e-5, "{sigma}");
    // A board that was put in on its side is still the same sensor.
    let side = compared(&a, &turned(&a, [1.2, -0.4, 0.9]));
    assert_eq!(side.magnitude.judgement, Judgement::Agrees);
}

#[test]
fn calibrations_are_compared_in_one_unit() {
    let a = file(1e-4);
    let mut b = a.clone();
    let per = 16384.0 / 9.80665;
    let s = &mut b.accelerometer;
    s.input_unit = AccelUnit::Counts;
    s.matrix = s.matrix.map(|row| row.map(|v| v / per));
    s.bias = s.bias.map(|v| v * per);
    s.covariance = Some(diagonal(1e-4, per));
    let error = compare(&a, &b, ["a.json", "b.json"]).unwrap_err();
    assert_eq!(error.code(), "units-differ");
    // Two of unknown range compare when they are of one size.
    b.accelerometer.nominal_scale = None;
    assert!(compared(&b, &b.clone()).magnitude.norm_rms_mps2 < 1e-9);
    // Unsigned counts carry 32768 in their bias.
    let mut unsigned = b.clone();
    unsigned.accelerometer.bias = unsigned.accelerometer.bias.map(|v| v + 32768.0);
    let result = compared(&b, &unsigned);
    assert!(result.magnitude.test.unwrap().chi2 < 1e-9);
}

#[test]
fn without_covariance_differences_are_shown_and_not_judged() {
    let (a, mut b) = (file(1e-4), file(1e-4));
    b.accelerometer.covariance = None;
    b.accelerometer.bias[0] += 1.0;
    let result = compared(&a, &b);
    assert_eq!(result.verdict.judgement, Judgement::Undecided);
    assert!((result.parameters[0].difference - 1.0).abs() < 1e-9);
    assert_eq!(result.parameters[0].sigma, None);
    assert_eq!(result.magnitude.test, None);
}

#[test]
fn another_gravity_is_told_and_taken_off() {
    let a = file(1e-4);
    let mut b = a.clone();
    b.gravity_mps2 = a.gravity_mps2 * 1.002;
    b.accelerometer.matrix = a.accelerometer.matrix.map(|r| r.map(|v| v * 1.002));
    let result = compared(&a, &b);
    assert!(has(&result.findings, "gravity-differs"));
    assert_eq!(result.magnitude.judgement, Judgement::Differs);
    // Assumed, it may be the same: the covariance of a file contains it.
    b.gravity_sd_mps2 = 0.015;
    let m = b.accelerometer.parameters().unwrap() * (0.015 / b.gravity_mps2);
    let values = &mut b.accelerometer.covariance.as_mut().unwrap().values;
    for (i, k) in (0..81).map(|n| (n / 9, n % 9)) {
        values[i][k] += m[i] * m[k];
    }
    assert_eq!(compared(&a, &b).verdict.judgement, Judgement::Agrees);
}

#[test]
fn shared_recordings_and_equal_files_prove_nothing() {
    let (mut a, mut b) = (file(1e-4), file(1e-4));
    b.accelerometer.bias[0] += 1e-4;
    let input = InputFile {
        path: "x.csv".into(),
        sha256: Some("00".into()),
        role: Default::default(),
    };
    (a.inputs, b.inputs) = (vec![input.clone()], vec![input]);
    let result = compared(&a, &b);
    assert!(has(&result.findings, "same-recordings"));
    assert_eq!(result.verdict.judgement, Judgement::Undecided);
    let same = compared(&a, &a.clone());
    assert_eq!(same.verdict.judgement, Judgement::Agrees);
    // What may be behind a difference.
    (a.sensor.id, b.sensor.id) = (Some("1".into()), Some("2".into()));
    b.accelerometer.bias[0] += 1.0;
    let reasons = compared(&a, &b).verdict.reasons;
    assert!(says(&reasons, "most of all bias x, by +1.00"));
    assert!(says(&reasons, "two sensors, \"1\" and \"2\""));
}

#[test]
fn without_faces_the_frame_is_a_convention() {
    let a = file(1e-4);
    let mut b = turned(&a, [0.0, 0.1, 0.0]);
    b.reliability.fit = Some(FitQuality {
        chi2_per_freedom: None,
        freedom: 5.0,
        model_error_mps2: 0.0,
        oriented: false,
        tilt_degrees_of_freedom: 0.0,
        prior: true,
    });
    let result = compared(&a, &b);
    assert!(says(&result.verdict.reasons, "faces on less than two axes"));
    assert_eq!(result.orientation.unwrap().judgement, Judgement::Undecided);
    assert_eq!(result.verdict.judgement, Judgement::Agrees);
}

#[test]
fn mirror_images_differ() {
    let a = file(1e-4);
    let mut b = a.clone();
    b.accelerometer.matrix[2] = a.accelerometer.matrix[2].map(|v| -v);
    let result = compared(&a, &b);
    assert!(has(&result.findings, "frames-mirrored"));
    assert_eq!(result.verdict.judgement, Judgement::Differs);
    assert_eq!(result.parameters.len(), 9);
}
