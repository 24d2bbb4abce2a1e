//! A calibration with a temperature model: readings as they would be at its
//! reference temperature.

use super::rests::Rest;
use crate::calibration_file::CalibrationFile;
use crate::recording::{Finding, FindingKind};
use crate::temperature::cost_text;

/// Takes drift and gain of the accepted channels off the means of the rests, as
/// `apply` does row by row: (raw − drift(T)) / (1 + gain(T)), held at the edges
/// of the model's range.
pub(super) fn take_off(
    calibration: &CalibrationFile,
    rests: &mut [Rest],
    findings: &mut Vec<Finding>,
) {
    let Some(model) = calibration.drift_model() else {
        return;
    };
    let without = rests.iter().filter(|r| r.temperature_c.is_none()).count();
    if without > 0 {
        findings.push(Finding::new(
            FindingKind::TemperatureNotApplied,
            format!(
                "{without} of {} static intervals have no temperature, so the calibration's drift with temperature is not taken off there: {}",
                rests.len(),
                cost_text(model)
            ),
        ));
    }
    for rest in rests {
        let Some(t_c) = rest.temperature_c else {
            continue;
        };
        for axis in 0..3 {
            rest.mean[axis] = model.at_reference(axis, t_c, rest.mean[axis]);
            if let Some((gyro, _)) = &mut rest.gyro {
                gyro[axis] = model.at_reference(3 + axis, t_c, gyro[axis]);
            }
        }
    }
}
