//! What a store holds and what is said of it.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::calibration_file::{CalibrationFile, InputFile};
use crate::utc::UtcTime;

/// A calibration in a store.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredCalibration {
    /// Its file.
    pub path: PathBuf,
    /// The sensor.
    pub sensor_id: String,
    /// When the sensor was calibrated.
    pub time: UtcTime,
    /// Source of that time.
    pub time_source: StoredTimeSource,
    /// The calibration.
    pub file: CalibrationFile,
    /// The file as an input of a result.
    pub input: InputFile,
}

/// Source of the time of a stored calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StoredTimeSource {
    /// When the session was recorded: `recorded` of the calibration file.
    Recording,
    /// When the calibration was computed: the recordings have no date.
    Calibration,
    /// The name of a file of imucal.
    FileName,
}

impl StoredTimeSource {
    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            StoredTimeSource::Recording => "recorded then",
            StoredTimeSource::Calibration => "computed then; its recordings have no date",
            StoredTimeSource::FileName => "by the name of the file",
        }
    }
}

/// A JSON file in a store that is no calibration of a sensor.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeftOutFile {
    /// The file.
    pub path: String,
    /// Why it is not used.
    pub reason: String,
}

/// Result of [`Store::add`](super::Store::add).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Added {
    /// The file.
    pub path: PathBuf,
    /// It was there already, with the same parameters from the same recordings; nothing was
    /// written.
    pub existed: bool,
}

/// A sensor of a store.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StoredSensor {
    /// Its id.
    pub sensor_id: String,
    /// Number of its calibrations.
    pub calibrations: usize,
    /// Time of the first one.
    pub first: UtcTime,
    /// Time of the last one.
    pub last: UtcTime,
    /// Verdict of the last one.
    pub last_grade: crate::calibration_file::Grade,
    /// Predicted error of the last one, m/s² (1σ); null without a covariance.
    pub last_predicted_norm_error_mps2: Option<f64>,
}

/// The sensors of a store.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StoreList {
    /// The folder.
    pub store: String,
    /// The sensors, by id.
    pub sensors: Vec<StoredSensor>,
    /// JSON files that are no calibration of a sensor.
    pub left_out: Vec<LeftOutFile>,
}

/// The calibrations of one sensor, and whether it changed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorHistory {
    /// The folder.
    pub store: String,
    /// The sensor.
    pub sensor_id: String,
    /// Its calibrations in order of time, as the entries of `history`.
    pub calibrations: Vec<HistoryCalibration>,
    /// Parameters and tests.
    pub history: crate::compare::History,
    /// JSON files of the store that are no calibration of a sensor.
    pub left_out: Vec<LeftOutFile>,
}

/// A calibration of a history.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HistoryCalibration {
    /// Its file.
    pub path: String,
    /// When the sensor was calibrated.
    pub time: UtcTime,
    /// Source of that time.
    pub time_source: StoredTimeSource,
    /// `joint`, `ferraris` ….
    pub method: String,
    /// Its verdict.
    pub grade: crate::calibration_file::Grade,
    /// Gravity that its scale rests on, m/s².
    pub gravity_mps2: f64,
    /// Temperature of the session, °C.
    pub temperature_c: Option<crate::calibration_file::TemperatureRange>,
    /// Bias of the gyroscope, °/s; null without a gyroscope. It changes with every start and is
    /// not tested.
    pub gyroscope_bias_deg_s: Option<[f64; 3]>,
}
