//! Helpers for the tests of the library and of the crates that it is made of.
#![allow(dead_code)] // each test crate uses its part

mod synthetic;

pub use synthetic::*;

use std::path::{Path, PathBuf};

use gravical_calibrate::calibrate::{CalibrateOptions, Calibrated, calibrate};
use gravical_calibrate::calibrate::{EstimateOptions, Method};
use gravical_calibrate::calibration_file::Calibration;
use gravical_calibrate::gravity::Gravity;
use gravical_calibrate::recording::{Finding, ReadOptions, Recording, read_bytes};

/// The report's header with the true units of its values.
pub const HEADER: &str =
    "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),gX (rad/s),gY (rad/s),gZ (rad/s)";

pub fn read(bytes: &[u8]) -> Recording {
    read_with(bytes, &ReadOptions::default())
}

/// The usual options with a change.
pub fn read_options(change: impl FnOnce(&mut ReadOptions)) -> ReadOptions {
    let mut options = ReadOptions::default();
    change(&mut options);
    options
}

/// Reads a file and checks that every line is accounted for.
pub fn read_with(bytes: &[u8], options: &ReadOptions) -> Recording {
    let recording = read_bytes(bytes, "test.csv", options).unwrap();
    assert_eq!(recording.ledger.rows(), recording.rows());
    recording
}

pub fn finding<'a>(recording: &'a Recording, kind: &str) -> &'a Finding {
    recording
        .findings
        .iter()
        .find(|f| f.kind == kind)
        .unwrap_or_else(|| panic!("no {kind} among {:?}", kinds(recording)))
}

pub fn kinds(recording: &Recording) -> Vec<&str> {
    recording.findings.iter().map(|f| &*f.kind).collect()
}

pub fn mean(values: &[f64]) -> f64 {
    let some: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    some.iter().sum::<f64>() / some.len() as f64
}

pub fn accel_means(recording: &Recording) -> [f64; 3] {
    std::array::from_fn(|i| mean(&recording.accel[i]))
}

pub fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} against {b} ± {tolerance}");
}

/// Calibrates at g = 9.81 and validates the file against the schema.
pub fn calibrated(session: &[Recording], options: &CalibrateOptions) -> Calibrated {
    let result = calibrate(session, options).unwrap();
    validate(&result.calibration);
    result
}

/// The usual options where gravity is known, m/s².
pub fn with_gravity(mps2: f64) -> CalibrateOptions {
    CalibrateOptions {
        gravity: Gravity::given(mps2).unwrap(),
        ..CalibrateOptions::default()
    }
}

/// Ferraris' closed form, for exact comparisons.
pub fn given_gravity() -> CalibrateOptions {
    CalibrateOptions {
        estimate: by_ferraris(None),
        ..with_gravity(GRAVITY)
    }
}

/// Ferraris' method, with a placement tilt in degrees.
pub fn by_ferraris(pose_tilt_deg: Option<f64>) -> EstimateOptions {
    EstimateOptions {
        method: Method::Ferraris,
        pose_tilt_deg,
        ..EstimateOptions::default()
    }
}

/// Validates a file against the schema.
pub fn validate(file: &Calibration) {
    let written: serde_json::Value = serde_json::from_str(&file.to_json().unwrap()).unwrap();
    let schema = Calibration::schema();
    if let Err(error) = jsonschema::validate(&schema, &written) {
        panic!("{error} at {}", error.instance_path());
    }
}

/// Six files of a synthetic sensor.
pub fn six_files(sensor: &Sensor, rows: usize) -> Vec<Recording> {
    FACES
        .iter()
        .enumerate()
        .map(|(i, (name, up))| {
            let text = sensor.file(*up, rows, 100 + i as u64);
            let name = format!("{name}.csv");
            read_bytes(text.as_bytes(), &name, &ReadOptions::default()).unwrap()
        })
        .collect()
}

/// Recordings in a folder and those below it.
pub fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e != "json" && e != "md") {
            found.push(path);
        }
    }
}
