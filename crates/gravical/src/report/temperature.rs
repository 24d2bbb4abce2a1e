//! Drift with temperature as text.

use crate::calibration_file::{
    CalibrationFile, ChannelDrift, ReferenceSource, SweepDirection, TemperatureModel,
};
use crate::temperature::{r2_text, short};

use super::text::{findings_text, paragraph, short_name};

/// Sweeps that are listed one by one.
const LISTED: usize = 4;

/// What temperature does to each channel, and which of it is predictable.
#[must_use]
pub fn temperature_text(model: &TemperatureModel) -> String {
    let [low, high] = model.range_c;
    let mut out = paragraph(
        "Temperature: ",
        &format!(
            "{low:.1} to {high:.1} °C while still, in {}; {}",
            match model.poses {
                1 => "one placement".to_owned(),
                n => format!("{n} placements"),
            },
            sweeps(model)
        ),
    );
    out.push_str(&format!(
        "\n  {:<4}{:>10} {:<7}{:>11}{:>11}{:>10}  {}\n  {:<4}{:>10} {:<7}{:>11}{:>11}{:>10}\n",
        "",
        "slope",
        "",
        "cooling →",
        "warming →",
        "at most",
        "verdict",
        "",
        "per °C",
        "",
        "warming R²",
        "cooling R²",
        "apart"
    ));
    for channel in &model.channels {
        out.push_str(&line(channel));
    }
    out.push('\n');
    for channel in &model.channels {
        // What the table says of a success needs no words.
        let reason = match channel.reason.split_once("; ") {
            _ if !channel.is_accepted() => &channel.reason,
            Some((_, remark)) => remark,
            None => continue,
        };
        out.push_str(&paragraph(&format!("  {}  ", channel.channel), reason));
    }
    out
}

fn sweeps(model: &TemperatureModel) -> String {
    let listed: Vec<String> = model
        .sweeps
        .iter()
        .take(LISTED)
        .map(|s| format!("{} {:.1} → {:.1}", s.direction.name(), s.from_c, s.to_c))
        .collect();
    let more = match model.sweeps.len().saturating_sub(LISTED) {
        0 => "",
        _ => ", …",
    };
    let count = |way: SweepDirection| model.sweeps.iter().filter(|s| s.direction == way).count();
    if model.sweeps.len() > LISTED {
        return format!(
            "{} sweeps cooling, {} warming: {}{more}",
            count(SweepDirection::Cooling),
            count(SweepDirection::Warming),
            listed.join(", ")
        );
    }
    listed.join(", ")
}

fn line(channel: &ChannelDrift) -> String {
    let r2 = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), r2_text);
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), small);
    let verdict = if channel.is_accepted() {
        format!("taken off, order {}", channel.order)
    } else {
        "refused".to_owned()
    };
    let unit = match channel.input_unit.as_str() {
        "unknown" => "?",
        known => known,
    };
    format!(
        "  {:<4}{:>10} {:<7}{:>11}{:>11}{:>10}  {verdict}\n",
        channel.channel,
        number(channel.slope),
        unit,
        r2(channel.r2_cooling_to_warming),
        r2(channel.r2_warming_to_cooling),
        number(channel.hysteresis),
    )
}

/// Three digits, with a power of ten where zeros would fill the place.
fn small(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.01 {
        format!("{value:.2e}")
    } else {
        short(value)
    }
}

/// The part of a calibration's report: the table, and where the drift is zero.
#[must_use]
pub(super) fn model_text(file: &CalibrationFile) -> String {
    let Some(model) = &file.temperature_model else {
        return String::new();
    };
    let mut out = format!("\n{}", temperature_text(model));
    if model.any_accepted() {
        let how = match model.reference_source {
            ReferenceSource::Session => "the mean of the placements",
            ReferenceSource::Soak => "the middle of the soak",
        };
        out.push('\n');
        out.push_str(&paragraph(
            "  ",
            &format!(
                "The drift counts from {:.1} °C, {how}; outside of the range its edge is held.",
                model.reference_c
            ),
        ));
    }
    out
}

/// The report of a calibration that comes from a soak alone.
#[must_use]
pub(super) fn soak_text(file: &CalibrationFile) -> String {
    let inputs: Vec<String> = file.recordings().map(|i| short_name(&i.path)).collect();
    let mut out = paragraph(
        "",
        &format!(
            "Temperature calibration of {}, raw in {}: nominal scale, no bias of the accelerometer",
            inputs.join(", "),
            file.accelerometer.input_unit.name()
        ),
    );
    if let Some(gyro) = &file.gyroscope {
        let [x, y, z] = gyro.bias.map(short);
        out.push_str(&paragraph(
            "",
            &format!(
                "Gyroscope at rest: bias {x}, {y}, {z} {}",
                gyro.input_unit.name()
            ),
        ));
    }
    out.push_str(&model_text(file));
    if !file.findings.is_empty() {
        out.push_str("\nFindings\n");
        out.push_str(&findings_text(&file.findings, file.inputs.len() > 1));
    }
    out
}
