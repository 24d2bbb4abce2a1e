//! Checks that a calibration fits a recording: its unit and range, and the magnitude of its
//! quietest parts after calibration.

use std::path::Path;

use gravical_recording::judge::quiet_norm;

use crate::calibration_file::{CalibrationFile, judge_unit};
use crate::poses::gyro_unit;
use crate::poses::rests::find_rests;
use crate::recording::{Finding, GyroUnit, Recording};
use crate::{Error, Result};

use super::drift::Drift;

/// Judges the accelerometer by the rows of `recording`: the first of a file, or all. Returns the
/// calibrated magnitude in the quietest of them, m/s²; none if no row is complete.
///
/// # Errors
///
/// `unit-mismatch` as in [`super::apply`].
pub(super) fn judge_accelerometer(
    calibration: &CalibrationFile,
    recording: &Recording,
    drift: Option<&Drift>,
    findings: &mut Vec<Finding>,
) -> Result<Option<f64>> {
    let accelerometer = calibration.accelerometer_calibration();
    let mut axes: [Vec<f64>; 3] = Default::default();
    for row in 0..recording.rows() {
        let mut raw = recording.accel_at(row).map(|v| v + recording.zero_offset);
        let t_c = recording.temperature_c.as_ref().map(|t| t[row]);
        if let (Some(drift), Some(t_c)) = (drift, t_c.filter(|t| t.is_finite())) {
            let at = drift.model.drift_at(t_c);
            raw = std::array::from_fn(|axis| raw[axis] - at[axis]);
        }
        let calibrated = accelerometer.apply(raw);
        for (axis, value) in axes.iter_mut().zip(calibrated) {
            axis.push(value);
        }
    }
    let norm_mps2 = quiet_norm(axes.each_ref().map(Vec::as_slice));
    let at_rest = format!("the quietest parts of its first {} rows", recording.rows());
    let gravity_mps2 = calibration.gravity_mps2;
    judge_unit(
        calibration,
        recording,
        (&at_rest, norm_mps2),
        gravity_mps2,
        findings,
    )?;
    Ok(norm_mps2)
}

/// The unit of the gyroscope, if it is to be calibrated: by the rule of [`gyro_unit`], without
/// turns where only the head is known.
pub(super) fn judge_gyroscope(
    calibration: &CalibrationFile,
    recording: &Recording,
    findings: &mut Vec<Finding>,
) -> Result<Option<GyroUnit>> {
    let Some(section) = &calibration.gyroscope else {
        return Ok(None);
    };
    let rests = if recording.gyro_file.is_some() {
        find_rests(recording)
    } else {
        std::iter::once(0..recording.rows()).collect()
    };
    let judged = gyro_unit::judge(recording, Some(section), &rests, findings);
    let Some(scale) = judged else {
        return Ok(None);
    };
    match gyro_unit::mismatch(section, &scale) {
        None => Ok(Some(section.input_unit)),
        Some(why) => Err(Error::input("unit-mismatch", why)
            .at(Path::new(&recording.name), None)
            .with_hint("give its unit, if this is the right one")
            .advise("gyro_unit", section.input_unit.name())),
    }
}
