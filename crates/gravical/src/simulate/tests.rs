//! Physics, sensor, repeatability and files.

use nalgebra::{UnitQuaternion, Vector3};

use super::*;

fn still_for(duration_s: f64) -> Scenario {
    Scenario::Static(StaticOptions { duration_s })
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

/// The header of a file, its first row and the truth beside it.
#[test]
fn files_hold_what_their_header_says() {
    let first = |raw, wrong_header| {
        let folder = tempfile::tempdir().unwrap();
        let mut options = SimulateOptions::new(still_for(0.5));
        (options.file.raw, options.file.wrong_header) = (raw, wrong_header);
        let target = folder.path().join("new/folder");
        let (truth, paths) = simulate_to(&options, &target, false).unwrap();
        let written = std::fs::read(&paths[1]).unwrap();
        let written: serde_json::Value = serde_json::from_slice(&written).unwrap();
        assert_eq!(written, serde_json::to_value(&truth).unwrap());
        let text = std::fs::read_to_string(&paths[0]).unwrap();
        let mut lines = text.lines().filter(|line| !line.starts_with("# "));
        let header = lines.next().unwrap().to_owned();
        let az = lines.next().unwrap().split(',').nth(3).unwrap();
        assert_eq!(lines.count(), 49);
        (header, az.parse::<f64>().unwrap())
    };
    let (header, az) = first(false, false);
    assert!(header.starts_with("Timestamp (ms),aX (m/s^2)") && (8.0..12.0).contains(&az));
    let (header, same) = first(false, true);
    assert!(header.starts_with("Timestamp,aX (g)") && same == az);
    let (header, counts) = first(true, false);
    assert_eq!(header, "Timestamp (ms),ax,ay,az,temp,gx,gy,gz");
    assert!((counts * 9.80665 / 16384.0 - az).abs() < 1e-4);
}

#[test]
fn nothing_is_written_if_one_target_exists() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("truth.json"), "mine").unwrap();
    let options = SimulateOptions::new(still_for(1.0));
    assert!(simulate_to(&options, folder.path(), false).is_err());
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

/// Change of attitude measured by the gyroscope over `rows`, midpoint rule.
fn turned(file: &SimulatedFile, rows: std::ops::Range<usize>) -> UnitQuaternion<f64> {
    let mut q = UnitQuaternion::identity();
    for row in rows {
        let dt = file.rows[row + 1].t_s - file.rows[row].t_s;
        let rate = 0.5 * (gyro(file, row) + gyro(file, row + 1));
        q *= UnitQuaternion::from_scaled_axis(rate * dt);
    }
    q
}

#[test]
fn gyroscope_and_accelerometer_agree_on_gravity() {
    let mut options = SimulateOptions::new(Scenario::Poses(PosesOptions::default()));
    options.sensor = SensorOptions::ideal();
    options.rate_hz = 500.0;
    options.tilt_sd_deg = 2.0;
    let simulation = simulate(&options).unwrap();
    let (file, truth) = (&simulation.files[0], &simulation.truth.files[0]);
    assert_eq!(truth.poses.len(), 12);
    for pair in truth.poses.windows(2) {
        let between = rows(file, pair[0].end_s - 0.1, pair[1].start_s + 0.1);
        let before = accel(file, between.start).normalize();
        let after = accel(file, between.end).normalize();
        let predicted = turned(file, between).inverse() * before;
        let off = (predicted - after).norm();
        assert!(off < 1e-6, "{} to {}: {off}", pair[0].label, pair[1].label);
        assert!((after - Vector3::from(pair[1].up)).norm() < 1e-9);
    }
}
