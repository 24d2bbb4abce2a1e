//! A calibration with a temperature model: readings as they would be at its
//! reference temperature.

use super::rests::Rest;
use crate::calibration_file::{CHANNELS, CalibrationFile, TemperatureModel};
use crate::recording::{Finding, FindingKind};
use crate::temperature::{cost_text, evaluate};

/// Takes drift and gain of the accepted channels off the means of the rests, as
/// `apply` does row by row: (raw − drift(T)) / (1 + gain(T)), held at the edges
/// of the model's range.
pub(super) fn take_off(
    calibration: &CalibrationFile,
    rests: &mut [Rest],
    findings: &mut Vec<Finding>,
) {
    let Some(model) = accepted(calibration) else {
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
            rest.mean[axis] = at_reference(model, axis, t_c, rest.mean[axis]);
            if let Some((gyro, _)) = &mut rest.gyro {
                gyro[axis] = at_reference(model, 3 + axis, t_c, gyro[axis]);
            }
        }
    }
}

/// The model, where it takes anything off.
pub(crate) fn accepted(calibration: &CalibrationFile) -> Option<&TemperatureModel> {
    calibration
        .temperature_model
        .as_ref()
        .filter(|m| m.any_corrected())
}

/// A reading as it would be at the reference temperature.
pub(crate) fn at_reference(model: &TemperatureModel, channel: usize, t_c: f64, raw: f64) -> f64 {
    let (drift, gain) = drift_at(model, channel, t_c);
    (raw - drift) / gain
}

/// The other way round: a reading at `t_c` that would be `value` at the reference.
pub(crate) fn at_temperature(
    model: &TemperatureModel,
    channel: usize,
    t_c: f64,
    value: f64,
) -> f64 {
    let (drift, gain) = drift_at(model, channel, t_c);
    value * gain + drift
}

/// What a channel is off by at a temperature, and how much more it reads.
fn drift_at(model: &TemperatureModel, channel: usize, t_c: f64) -> (f64, f64) {
    let Some(drift) = model
        .channel(CHANNELS[channel])
        .filter(|c| c.is_corrected())
    else {
        return (0.0, 1.0);
    };
    let [low, high] = model.range_c;
    let x = t_c.clamp(low, high) - model.reference_c;
    (
        evaluate(&drift.coefficients, x),
        1.0 + evaluate(&drift.scale_coefficients, x),
    )
}
