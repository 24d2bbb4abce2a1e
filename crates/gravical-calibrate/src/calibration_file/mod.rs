//! The calibration file `gravical-calibration/3`: JSON with the parameters of a sensor, their
//! origin and their quality.
//!
//! All quantities of raw values are in the unit of the recording (`input_unit`): `calibrated =
//! matrix · (raw − bias)` in m/s², and for the gyroscope `matrix · (raw − bias − g_sensitivity ·
//! a)` in rad/s with a in m/s². Readers ignore unknown fields; within `/3` fields are only added.

mod check;
mod derived;
mod imucal;
mod input;
mod readable;
mod types;
mod unit;
mod verdict;

use std::path::Path;

use gravical_core::calibration::{GyroscopeCalibration, LinearCalibration};
use gravical_judge::escape::shown_json;
use gravical_judge::utc::UtcTime;
use serde_json::error::Category;

use crate::finding::Case;
use crate::problem::Problem;
use crate::recording::Finding;
use crate::{Error, Result};
use gravical_recording::output::write_text;
use gravical_recording::source::Named;

pub use gravical_fit::{
    Deviations, FitQuality, Grade, Mounting, NextPose, Undetected, WorstDirection,
};
pub use imucal::{from_imucal, to_imucal};
pub use input::*;
pub use types::*;
#[doc(hidden)]
pub use unit::{judge_unit, other_range};

impl Calibration {
    /// Parameters of the accelerometer for the core crate.
    pub fn accelerometer_calibration(&self) -> LinearCalibration<f64> {
        LinearCalibration {
            matrix: self.accelerometer.matrix,
            bias: self.accelerometer.bias,
        }
    }

    /// Parameters of the gyroscope for the core crate.
    pub fn gyroscope_calibration(&self) -> Option<GyroscopeCalibration<f64>> {
        let section = self.gyroscope.as_ref()?;
        Some(GyroscopeCalibration {
            matrix: section.matrix,
            bias: section.bias,
            g_sensitivity: section.g_sensitivity,
        })
    }

    /// Text of the file: JSON with a newline at the end.
    ///
    /// # Errors
    ///
    /// `calibration-values` (input) if a parameter cannot be applied, for example a NaN, which
    /// JSON cannot represent.
    pub fn to_json(&self) -> Result<String> {
        self.check()?;
        Ok(shown_json(&to_text(self)?).into_owned())
    }

    /// Writes the file to `path` atomically; nothing that cannot be read back.
    ///
    /// # Errors
    ///
    /// As [`to_json`](Self::to_json), [`parse`](Self::parse) and [`write_text`].
    pub fn write(&self, path: impl AsRef<Path>, force: bool) -> Result<()> {
        let path = path.as_ref();
        let text = self.to_json()?;
        Self::parse(text.as_bytes())?;
        write_text(path, force, &text)
    }

    /// Reads a calibration of this program or of imucal (2.0 and before).
    ///
    /// # Errors
    ///
    /// `calibration-syntax`, `calibration-format` and `calibration-values`
    /// (input) with the file and, where known, the line.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        Self::read_with_input(path.as_ref()).map(|(file, _)| file)
    }

    /// The same, of a file on the disk or in memory, with the input file for a result.
    ///
    /// # Errors
    ///
    /// As [`read`](Self::read).
    pub fn read_with_input<'a>(file: impl Into<Named<'a>>) -> Result<(Self, InputFile)> {
        InputFile::read(file, InputRole::Calibration, Self::parse)
    }

    /// That its verdict is poor, for what it is used for.
    #[doc(hidden)]
    pub fn poor_finding(&self) -> Option<Finding> {
        (self.grade() == Grade::Poor).then(|| {
            let reasons = self.verdict().reasons;
            Case::PoorCalibration { reasons }.finding()
        })
    }

    /// The recordings among the input files.
    pub fn recordings(&self) -> impl Iterator<Item = &InputFile> {
        let samples = [InputRole::Recording, InputRole::Gyroscope];
        let inputs = self.inputs.iter();
        inputs.filter(move |input| samples.contains(&input.role))
    }

    /// The same from memory.
    ///
    /// # Errors
    ///
    /// As [`read`](Self::read).
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let value: serde_json::Value = serde_json::from_slice(bytes).map_err(|e| syntax(&e))?;
        match value.get("format").and_then(serde_json::Value::as_str) {
            _ if value.get("K_a").is_some() => return from_imucal(&value),
            Some(FORMAT) => {}
            Some(other) => {
                let format = other.to_owned();
                let wanted = FORMAT;
                let error = Problem::OtherFormat { format, wanted }.error();
                return Err(if other.starts_with("gravical-calibration/") {
                    error.with_hint("calibrate again from the recordings")
                } else {
                    error
                });
            }
            None => return Err(Problem::NoFormat.error()),
        }
        let file: Calibration = serde_json::from_slice(bytes).map_err(|e| syntax(&e))?;
        file.check()?;
        Ok(file)
    }

    /// The JSON schema of the format.
    #[cfg(feature = "schema")]
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(Calibration).to_value()
    }
}

/// `calibration-syntax` (input) with line and column; the file is for the caller to add.
fn syntax(error: &serde_json::Error) -> Error {
    let (line, column) = (error.line() as u64, error.column() as u64);
    let text = error.to_string();
    let place = format!(" at line {line} column {column}");
    let why = text.strip_suffix(&place).unwrap_or(&text).to_owned();
    let mut out = match error.classify() {
        Category::Eof if line <= 1 && column == 0 => Problem::EmptyFile.error(),
        Category::Data => Problem::NotValid { why }.error(),
        _ => Problem::NotJson { why }.error(),
    };
    if line > 0 {
        out = out.at(Path::new(""), Some(line));
    }
    if column > 0 {
        out = out.at_column(column);
    }
    out
}

/// JSON with a newline at the end.
fn to_text(value: &impl serde::Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(value);
    let text = text.map_err(|e| Problem::NotWritten { why: e.to_string() }.error())?;
    Ok(text + "\n")
}

/// Time for `created`: the current time, or SOURCE_DATE_EPOCH.
pub fn creation_time() -> String {
    UtcTime::now().to_string()
}
