//! Tests of the physics ([`physics`]), of the sensor ([`sensor`]), and of repeatability and file
//! output (here).

mod physics;
mod sensor;

use nalgebra::Vector3;

use super::*;

fn ideal(scenario: Scenario) -> SimulateOptions {
    SimulateOptions {
        tilt_sd_deg: 0.0,
        sensor: SensorOptions::ideal(),
        ..SimulateOptions::new(scenario)
    }
}

fn session() -> Scenario {
    Scenario::SixPosition(SixPositionOptions {
        continuous: true,
        hold_s: 3.0,
        ..Default::default()
    })
}

fn quick_six() -> SimulateOptions {
    SimulateOptions::new(Scenario::SixPosition(SixPositionOptions {
        hold_s: 1.0,
        ..Default::default()
    }))
}

fn still_for(duration_s: f64) -> Scenario {
    Scenario::Static(StaticOptions {
        duration_s,
        ..StaticOptions::default()
    })
}

fn accel(file: &SimulatedFile, row: usize) -> Vector3<f64> {
    Vector3::from(file.rows[row].reading.accel_mps2)
}

fn gyro(file: &SimulatedFile, row: usize) -> Vector3<f64> {
    Vector3::from(file.rows[row].reading.gyro_rad_s)
}

/// Rows with start ≤ t < end.
fn rows(file: &SimulatedFile, start_s: f64, end_s: f64) -> std::ops::Range<usize> {
    let first = |t_s: f64| file.rows.partition_point(|row| row.t_s < t_s);
    first(start_s)..first(end_s)
}

#[test]
fn changing_one_option_leaves_other_random_values_unchanged() {
    let base = simulate(&quick_six()).unwrap();
    let mut other = quick_six();
    other.sensor.noise_factor = 3.0;
    other.dropped_fraction = 0.2;
    other.stamp_jitter_ms = 2.0;
    other.sensor.accel_bias_mps2 = Some([0.1, 0.2, 0.3]);
    let other = simulate(&other).unwrap();
    let (a, b) = (&base.truth.accelerometer, &other.truth.accelerometer);
    assert_eq!(a.matrix, b.matrix);
    assert_eq!(a.bias_drift_mps2_per_c, b.bias_drift_mps2_per_c);
    assert_eq!(b.bias_mps2, [0.1, 0.2, 0.3]);
    let (a, b) = (&base.truth.gyroscope, &other.truth.gyroscope);
    assert_eq!(a.bias_rad_s, b.bias_rad_s);
    for (a, b) in base.truth.files.iter().zip(&other.truth.files) {
        assert_eq!(a.poses, b.poses);
        assert_eq!(a.first_stamp_ms, b.first_stamp_ms);
    }
}

#[test]
fn each_format_has_its_header_and_units() {
    let text = |raw, wrong_header| {
        let folder = tempfile::tempdir().unwrap();
        let mut options = SimulateOptions::new(still_for(0.5));
        options.file = FileOptions {
            raw,
            wrong_header,
            ..FileOptions::default()
        };
        let target = folder.path().join("new/folder");
        let (truth, paths) = simulate_to(&options, &target, false).unwrap();
        let again = simulate_to(&options, &target, false).unwrap_err();
        assert_eq!(again.code(), "exists");
        simulate_to(&options, &target, true).unwrap();
        let written: serde_json::Value =
            serde_json::from_slice(&std::fs::read(&paths[1]).unwrap()).unwrap();
        assert_eq!(written, serde_json::to_value(&truth).unwrap());
        std::fs::read_to_string(&paths[0]).unwrap()
    };
    let az = |text: &str| -> f64 {
        let row = text.lines().nth(4).unwrap();
        assert_eq!(row.split(',').count(), 8);
        row.split(',').nth(3).unwrap().parse().unwrap()
    };
    let report = text(false, true);
    assert!(report.lines().take(3).all(|l| l.starts_with("# ")));
    let header = "Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)";
    assert_eq!(report.lines().nth(3), Some(header));
    assert!((8.0..12.0).contains(&az(&report)));
    assert_eq!(report.lines().count(), 54);
    let honest = text(false, false);
    assert!(honest.contains("Timestamp (ms),aX (m/s^2)"));
    assert_eq!(az(&honest), az(&report));
    let raw = text(true, false);
    assert!(raw.contains("Timestamp (ms),ax,ay,az,temp,gx,gy,gz"));
    assert!((az(&raw) * 9.80665 / 16384.0 - az(&report)).abs() < 1e-4);
}

#[test]
fn nothing_is_written_if_one_target_exists() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("truth.json"), "mine").unwrap();
    assert!(simulate_to(&quick_six(), folder.path(), false).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn options_out_of_range_are_reported() {
    let mut options = SimulateOptions::new(still_for(10.0));
    options.rate_hz = f64::NAN;
    let error = simulate(&options).unwrap_err();
    assert!(error.is_usage() && error.message().contains("rate"));
    options.rate_hz = 100.0;
    options.sensor.accel_range_g = 3;
    assert!(simulate(&options).unwrap_err().message().contains("3 g"));
    let mut options = SimulateOptions::new(still_for(86_400.0));
    options.rate_hz = 1000.0;
    assert!(simulate(&options).unwrap_err().message().contains("rows"));
}
