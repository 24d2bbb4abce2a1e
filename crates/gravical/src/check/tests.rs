//! Recordings made by hand: what counts, what is refused, what is said.

use super::*;
use crate::calibrate::{CalibrateOptions, calibrate};
use crate::calibrate::{EstimateOptions, Method};
use crate::calibration_file::TemperatureRange;
use crate::recording::{ReadOptions, read_bytes};
use crate::segment::still::find_stills;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const G: f64 = 9.80665;
const UP: [[f64; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
];

/// `rows` readings at 100 Hz of a perfect sensor with `bias`, gravity `g` along
/// `up`; 25 °C, gyroscope at rest with `rate` (rad/s) about x.
fn rest(up: [f64; 3], rows: usize, bias: [f64; 3], g: f64, rate: f64, seed: u64) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let mut text = "t_ms,ax_m/s2,ay_m/s2,az_m/s2,temp,gx_rad/s,gy_rad/s,gz_rad/s\n".to_owned();
    for i in 0..rows {
        let a: [f64; 3] = std::array::from_fn(|k| g * up[k] + bias[k] + noise(0.02));
        let w = [rate + noise(1e-3), noise(1e-3), noise(1e-3)];
        text += &format!(
            "{},{:.5},{:.5},{:.5},25.0,{:.6},{:.6},{:.6}\n",
            10 * i,
            a[0],
            a[1],
            a[2],
            w[0],
            w[1],
            w[2]
        );
    }
    read_bytes(text.as_bytes(), "rest.csv", &ReadOptions::default()).unwrap()
}

fn calibration() -> CalibrationFile {
    let session: Vec<Recording> = (0..6)
        .map(|i| rest(UP[i], 500, [0.0; 3], G, 0.0, i as u64))
        .collect();
    let options = CalibrateOptions {
        gravity: Gravity::given(G).unwrap(),
        estimate: EstimateOptions {
            pose_tilt_deg: Some(0.1),
            method: Method::Ferraris,
            ..EstimateOptions::default()
        },
        ..CalibrateOptions::default()
    };
    calibrate(&session, &options).unwrap().file
}

fn checked(file: &CalibrationFile, recordings: &[Recording]) -> CheckReport {
    check(file, "cal.json", recordings, &CheckOptions::default()).unwrap()
}

fn has(report: &CheckReport, kind: &str) -> bool {
    report.findings.iter().any(|f| f.kind == kind)
}

#[test]
fn one_pose_is_enough_and_says_what_it_does_not_test() {
    let report = checked(&calibration(), &[rest(UP[4], 300, [0.0; 3], G, 0.0, 90)]);
    assert_eq!(
        report.verdict.judgement,
        Judgement::Fits,
        "{:?}",
        report.verdict
    );
    assert_eq!(report.static_intervals.len(), 1);
    assert_eq!(report.static_intervals[0].nearest, "+z");
    assert_eq!(report.coverage.untested_axes, ["x", "y"]);
    assert!(report.explanations.is_empty());
    assert_eq!(report.test.unwrap().degrees_of_freedom, 1);
}

#[test]
fn a_moved_bias_is_named_and_a_share_is_scale_or_gravity() {
    let file = calibration();
    let all = |bias: [f64; 3], g: f64| -> Vec<Recording> {
        (0..6)
            .map(|i| rest(UP[i], 300, bias, g, 0.0, 40 + i as u64))
            .collect()
    };
    let moved = checked(&file, &all([0.0, 0.05, 0.0], G));
    assert_eq!(moved.verdict.judgement, Judgement::DoesNotFit);
    let good: Vec<&Explanation> = moved.explanations.iter().filter(|e| e.explains).collect();
    assert_eq!(good.len(), 1, "{good:?}");
    assert_eq!(good[0].cause, Cause::BiasY);
    assert!((good[0].bias_mps2.unwrap()[1] - 0.05).abs() < 0.005);
    assert!(has(&moved, "off-along-axis"));

    let shared = checked(&file, &all([0.0; 3], 9.83));
    assert_eq!(shared.verdict.judgement, Judgement::DoesNotFit);
    assert!(has(&shared, "off-by-share") && !has(&shared, "off-along-axis"));
    // With the gravity of that place it fits.
    let options = CheckOptions {
        gravity: Some(Gravity::given(9.83).unwrap()),
        ..CheckOptions::default()
    };
    let there = check(&file, "cal.json", &all([0.0; 3], 9.83), &options).unwrap();
    assert_eq!(
        there.verdict.judgement,
        Judgement::Fits,
        "{:?}",
        there.verdict
    );
    assert!(has(&there, "gravity-differs"));
}

#[test]
fn without_covariance_only_gross_errors_are_told() {
    let mut file = calibration();
    file.accelerometer.covariance = None;
    let small = checked(&file, &[rest(UP[0], 300, [0.1, 0.0, 0.0], G, 0.0, 7)]);
    assert_eq!(small.verdict.judgement, Judgement::Undecided);
    assert!(has(&small, "covariance-missing"));
    assert_eq!((small.test, small.static_intervals[0].z), (None, None));
    let large = checked(&file, &[rest(UP[0], 300, [0.3, 0.0, 0.0], G, 0.0, 7)]);
    assert_eq!(large.verdict.judgement, Judgement::DoesNotFit);
}

#[test]
fn another_unit_or_size_is_refused() {
    let file = calibration();
    let in_g = "ax,ay,az\n".to_owned() + &"0.001,0.0,1.002\n0.0,0.002,0.999\n".repeat(200);
    let in_g = read_bytes(in_g.as_bytes(), "g.csv", &ReadOptions::default()).unwrap();
    let error = check(&file, "cal.json", &[in_g], &CheckOptions::default()).unwrap_err();
    assert_eq!(error.code(), "unit-mismatch");
    let mut other = file.clone();
    other.accelerometer.bias[2] = 4.0;
    let still = [rest(UP[4], 300, [0.0; 3], G, 0.0, 3)];
    let error = check(&other, "cal.json", &still, &CheckOptions::default()).unwrap_err();
    assert_eq!(error.code(), "unit-mismatch");
    let error = check(&file, "cal.json", &[], &CheckOptions::default()).unwrap_err();
    assert_eq!(error.code(), "no-recordings");
}

#[test]
fn the_gyroscope_has_its_own_judgement() {
    let mut file = calibration();
    file.gyroscope = Some(crate::calibration_file::GyroscopeSection {
        input_unit: crate::recording::GyroUnit::RadianPerSecond,
        output_unit: crate::recording::GyroUnit::RadianPerSecond,
        bias: [0.0; 3],
        matrix: gravical_core::matrix3::identity(),
        scale: [1.0; 3],
        orientation: gravical_core::matrix3::identity(),
        g_sensitivity: [[0.0; 3]; 3],
        ..crate::calibration_file::GyroscopeSection::default()
    });
    let still = checked(&file, &[rest(UP[4], 300, [0.0; 3], G, 0.001, 5)]);
    assert_eq!(still.gyroscope.unwrap().judgement, Judgement::Fits);
    let moved = checked(&file, &[rest(UP[4], 300, [0.0; 3], G, 0.02, 5)]);
    let gyroscope = moved.gyroscope.unwrap();
    assert_eq!(gyroscope.judgement, Judgement::DoesNotFit);
    assert!((gyroscope.rate_deg_s[0] - 0.02_f64.to_degrees()).abs() < 0.01);
    assert!((gyroscope.bias_now[0] - 0.02).abs() < 2e-4);
    // It does not touch that of the accelerometer.
    assert_eq!(moved.verdict.judgement, Judgement::Fits);
}

#[test]
fn temperature_clipping_and_old_recordings_are_told() {
    let mut file = calibration();
    file.temperature_c = Some(TemperatureRange {
        mean: 40.0,
        min: 39.0,
        max: 41.0,
    });
    let mut again = rest(UP[4], 300, [0.0; 3], G, 0.0, 5);
    again.sha256 = Some("00".into());
    file.inputs[0].sha256 = Some("00".into());
    let report = checked(&file, &[again]);
    assert!(has(&report, "temperature-outside") && has(&report, "same-recordings"));
    assert_ne!(report.verdict.judgement, Judgement::Fits);

    // At ±1 g full scale nothing is left above: whole counts at the end.
    let mut clipped = rest(UP[4], 300, [0.0; 3], G, 0.0, 5);
    let end = 2.0 * G;
    (0..50).for_each(|row| clipped.accel[0][row] = end);
    let rests_of =
        |r: &[Recording]| rests::rests(r, &StillOptions::short_rests(), &mut Vec::new()).unwrap();
    let both = [clipped, rest(UP[0], 300, [0.0; 3], G, 0.0, 6)];
    let found = rests_of(&both);
    let clipped_stills = found.iter().filter(|r| r.clipped > 0).count();
    let report = checked(&calibration(), &both);
    assert_eq!(
        report.static_intervals.iter().filter(|s| !s.counts).count(),
        clipped_stills
    );
}

#[test]
fn a_temperature_model_is_taken_off() {
    let mut file = calibration();
    let later = [rest(UP[4], 300, [0.0, 0.0, 0.2], G, 0.0, 8)];
    assert_eq!(
        checked(&file, &later).verdict.judgement,
        Judgement::DoesNotFit
    );
    // 0.02 m/s² per °C on z, known at 15 °C: the recording is at 25.
    let channel = serde_json::json!({
        "channel": "az", "input_unit": "m/s^2", "verdict": "corrected", "reason": "",
        "order": 1, "drift_rms": 0.1, "coefficients": [0.02], "scale_coefficients": [],
        "scale_observed": false
    });
    let model = serde_json::json!({
        "reference_c": 15.0, "reference_source": "session", "range_c": [10.0, 30.0],
        "poses": 1, "sweeps": [], "channels": [channel], "inputs": []
    });
    file.temperature_model = Some(serde_json::from_value(model).unwrap());
    let report = checked(&file, &later);
    assert_eq!(
        report.verdict.judgement,
        Judgement::Fits,
        "{:?}",
        report.verdict
    );
    assert!(!has(&report, "temperature-outside"));
    let mut cold = later;
    cold[0].temperature_c = None;
    assert!(has(&checked(&file, &cold), "temperature-not-applied"));
}

/// A rest of 0.15 s between motions at 1 kHz is found wherever it begins.
#[test]
fn a_short_rest_is_found_wherever_it_begins() {
    for shift in [0, 7, 19, 26, 33, 48] {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut text = "t_ms,ax,ay,az\n".to_owned();
        for row in 0..1600 {
            let t = row as f64 / 1000.0;
            let noise: [f64; 3] =
                std::array::from_fn(|_| 0.015 * rng.sample::<f64, _>(StandardNormal));
            let still = row < 400 || (1200 + shift..1356 + shift).contains(&row);
            let shake = if still { 0.0 } else { 2.0 * (40.0 * t).sin() };
            text += &format!(
                "{row},{:.5},{:.5},{:.5}\n",
                noise[0] + shake,
                noise[1] - shake,
                G + noise[2]
            );
        }
        let recording = read_bytes(text.as_bytes(), "lift.csv", &ReadOptions::default()).unwrap();
        let found = find_stills(&recording, &StillOptions::short_rests()).spans;
        let short: Vec<_> = found.iter().filter(|s| s.start > 600).collect();
        assert_eq!(short.len(), 1, "shift {shift}: {found:?}");
        assert!(short[0].len() >= 150 && short[0].len() <= 170, "{short:?}");
    }
}
