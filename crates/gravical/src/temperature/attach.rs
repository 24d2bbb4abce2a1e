//! Temperature model for the calibration of a session.

use crate::calibration_file::{CHANNELS, InputFile, ReferenceSource, TemperatureModel};
use crate::recording::{Finding, FindingKind, GyroUnit, Recording};
use crate::segment::{Placement, Segmentation, check_units};
use crate::{Error, Result};

use super::{in_unit, study, study_if_any};

/// The model for a session: from the soak recordings `thermal`, or, without any, from the session
/// itself if its static intervals span enough temperature. Its drift is zero at the mean
/// temperature of the poses, where bias and matrix are valid; the means of the poses are
/// converted to that temperature.
///
/// # Errors
///
/// With soak recordings: those of [`study`], and `unit-unknown` and `units-differ` if they are
/// not in the unit of the session.
pub fn for_calibration(
    recordings: &[Recording],
    thermal: &[Recording],
    segmentation: &mut Segmentation,
) -> Result<Option<TemperatureModel>> {
    let findings = &mut segmentation.findings;
    let model = if thermal.is_empty() {
        study_if_any(recordings)
    } else {
        same_units(recordings, thermal, findings)?;
        Some(TemperatureModel {
            inputs: InputFile::of_soak(thermal),
            ..study(thermal)?
        })
    };
    let Some(model) = model else { return Ok(None) };
    findings.push(summary_finding(&model, !segmentation.turns.is_empty()));
    if !model.any_corrected() {
        // No drift is subtracted: the reference does not matter.
        return Ok(Some(model));
    }
    let [low, high] = model.range_c;
    let Some(session_c) = mean_c(&segmentation.placements) else {
        let reference_c = model.reference_c;
        findings.push(Finding::new(
            FindingKind::TemperatureReference,
            format!(
                "the poses have no temperature: bias and matrix are assumed to be valid at {reference_c:.1} °C, the middle of the soak; {}",
                cost_text(&model)
            ),
        ));
        return Ok(Some(model));
    };
    let inside_c = session_c.clamp(low, high);
    if inside_c != session_c {
        findings.push(Finding::new(
            FindingKind::TemperatureOutside,
            format!(
                "the poses were at {session_c:.1} °C, the soak spans {low:.1} to {high:.1} °C: bias and matrix are assumed to be valid at {inside_c:.1} °C; soak over the temperatures at which the sensor is calibrated and used"
            ),
        ));
    }
    let mut model = model.about(inside_c);
    model.reference_source = ReferenceSource::Session;
    let zero_offset = recordings.first().map_or(0.0, |r| r.zero_offset);
    for placement in &mut segmentation.placements {
        bring_to_reference(placement, &model, zero_offset);
    }
    Ok(Some(model))
}

fn mean_c(placements: &[Placement]) -> Option<f64> {
    let some: Vec<f64> = placements.iter().filter_map(|p| p.temperature_c).collect();
    (!some.is_empty()).then(|| some.iter().sum::<f64>() / some.len() as f64)
}

/// Converts the means of a pose to the reference temperature.
pub(super) fn bring_to_reference(
    placement: &mut Placement,
    model: &TemperatureModel,
    zero_offset: f64,
) {
    let Some(t_c) = placement.temperature_c else {
        return;
    };
    for (axis, mean) in placement.mean.iter_mut().enumerate() {
        *mean = model.at_reference(axis, t_c, *mean + zero_offset) - zero_offset;
    }
    if let Some((sum, rows)) = &mut placement.gyro_sum {
        for (axis, name) in CHANNELS[3..].iter().enumerate() {
            sum[axis] -= model.drift_at(name, t_c).0 * *rows as f64;
        }
    }
}

/// The finding that lists the channels that are corrected, and the others.
pub(crate) fn summary_finding(model: &TemperatureModel, with_gyro: bool) -> Finding {
    let list = |corrected: bool| -> Vec<&str> {
        let some = model.channels.iter();
        some.filter(|c| c.is_corrected() == corrected)
            .map(|c| c.channel.as_str())
            .collect()
    };
    let [low, high] = model.range_c;
    let (corrected, others) = (list(true).join(", "), list(false).join(", "));
    if corrected.is_empty() {
        return Finding::new(
            FindingKind::TemperatureRefused,
            format!(
                "the temperature changes at rest ({low:.1} to {high:.1} °C), but the drift of no channel is predictable ({others}): none is subtracted"
            ),
        );
    }
    let idle = !with_gyro && corrected.contains('g');
    let idle = if idle {
        " (for the gyroscope only after it is calibrated)"
    } else {
        ""
    };
    let rest = if others.is_empty() {
        String::new()
    } else {
        format!("; that of {others} is not predictable or not significant")
    };
    Finding::new(
        FindingKind::TemperatureModel,
        format!(
            "the temperature drift of {corrected} is subtracted{idle} between {low:.1} and {high:.1} °C{rest}"
        ),
    )
}

/// Text: largest error of a reading without the model, over its range.
pub(crate) fn cost_text(model: &TemperatureModel) -> String {
    let parts: Vec<String> = model
        .channels
        .iter()
        .filter(|c| c.is_corrected())
        .map(|c| {
            let [low, high] = model.range_c;
            let values = (0..=50).map(|i| {
                let t_c = low + (high - low) * f64::from(i) / 50.0;
                model.drift_at(&c.channel, t_c).0
            });
            let most = values.fold(0.0, |m: f64, v| m.max(v.abs()));
            let most = in_unit(most, &c.input_unit);
            format!("{} by up to {most}", c.channel)
        })
        .collect();
    format!(
        "between {:.1} and {:.1} °C the drift changes {}",
        model.range_c[0],
        model.range_c[1],
        parts.join(", ")
    )
}

fn same_units(
    recordings: &[Recording],
    thermal: &[Recording],
    findings: &mut Vec<Finding>,
) -> Result<()> {
    check_units(thermal)?;
    let (Some(session), Some(soak)) = (recordings.first(), thermal.first()) else {
        return Ok(());
    };
    let differ = |of: &str, soak_unit: String, session_unit: String| {
        Error::input(
            "units-differ",
            format!("the soak's {of} is in {soak_unit}, that of the session in {session_unit}"),
        )
        .at(soak.name.as_ref(), None)
        .with_hint(
            "record the soak with the same sensor, range and program as the session, or give its unit",
        )
    };
    let (a, b) = (session.accel_scale, soak.accel_scale);
    if a.unit != b.unit || a.lsb_per_g != b.lsb_per_g || session.zero_offset != soak.zero_offset {
        let describe = |r: &Recording| match r.accel_scale.lsb_per_g {
            Some(lsb) => format!("counts at {lsb:.0} per g"),
            None => r.accel_scale.unit.name().to_owned(),
        };
        return Err(differ("accelerometer", describe(soak), describe(session)));
    }
    if let (Some(a), Some(b)) = (session.gyro_scale, soak.gyro_scale) {
        if a.unit == GyroUnit::Unknown || b.unit == GyroUnit::Unknown {
            findings.push(Finding::new(
                FindingKind::UnitUnverified,
                format!(
                    "the gyroscope's unit is {} in the session and {} in the soak: assumed to be equal",
                    a.unit.name(),
                    b.unit.name()
                ),
            ));
        } else if a.unit != b.unit {
            return Err(differ(
                "gyroscope",
                b.unit.name().to_owned(),
                a.unit.name().to_owned(),
            ));
        }
    }
    Ok(())
}
