//! From acceleration to velocity and position, with an error band.

mod options;
mod result;
pub mod samples;
pub mod still;

use crate::Result;
use crate::calibration_file::CalibrationFile;
use crate::recording::Recording;

pub use options::{GravityRemoval, MotionOptions};
pub use result::*;

/// Motion of a recording: the result, and the table behind it.
#[derive(Debug, Clone)]
pub struct Motion {
    /// What is said.
    pub result: MotionResult,
    /// Sample by sample.
    pub track: Track,
}

/// A calibration and the name it was given by.
#[derive(Debug, Clone, Copy)]
pub struct Calibrated<'a> {
    /// The file's content.
    pub file: &'a CalibrationFile,
    /// Its name, for messages.
    pub name: &'a str,
}

/// Velocity and position of `recording`.
///
/// # Errors
///
/// `unit-mismatch`, `unit-unknown`, `no-samples` (input); `option-range` (usage).
pub fn motion(
    recording: &Recording,
    calibration: Option<Calibrated<'_>>,
    options: &MotionOptions,
) -> Result<Motion> {
    options.validate()?;
    let _ = (recording, calibration);
    todo_motion()
}

fn todo_motion() -> Result<Motion> {
    Err(crate::Error::input("no-samples", "not built yet"))
}
