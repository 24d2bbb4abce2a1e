//! Report of drift with temperature.

use crate::document::{Block, Cell, Column, Row, Section, Table};
use gravical::calibration_file::{ChannelDrift, SweepDirection, TemperatureModel};
use gravical::numfmt::{count, unit};
use gravical::temperature::{r2_text, short};

/// Sweeps that are listed one by one.
const LISTED: usize = 4;

/// Adds the drift of each channel with temperature to `section`.
pub(super) fn drift<'a>(section: Section<'a>, model: &TemperatureModel) -> Section<'a> {
    let [low, high] = model.range_c;
    let poses = count(model.poses, "pose");
    let columns = [
        Column::left("channel"),
        Column::number("slope, per °C"),
        Column::left("unit"),
        Column::number("R² cooling → warming"),
        Column::number("R² warming → cooling"),
        Column::number("hysteresis"),
        Column::number("rms before").full(),
        Column::number("rms after").full(),
        Column::left("verdict"),
    ];
    let channels = model.channels.iter();
    let table = Table::new("Drift of each channel")
        .columns(columns)
        .rows(channels.map(channel));
    let reasons = model.channels.iter().filter_map(|c| {
        // The table is enough for an accepted channel.
        let reason = match c.reason.split_once("; ") {
            _ if !c.is_corrected() => &c.reason,
            Some((_, remark)) => remark,
            None => return None,
        };
        Some((c.channel.clone(), reason.to_owned()))
    });
    let reasons: Vec<_> = reasons.collect();
    let section = section
        .with(Block::paragraph(format!(
            "{low:.1} to {high:.1} °C at rest, {poses}; {}",
            sweeps(model)
        )))
        .with(table);
    match reasons.is_empty() {
        true => section,
        false => section.with(Block::Facts(reasons)),
    }
}

fn sweeps(model: &TemperatureModel) -> String {
    let listed: Vec<String> = model
        .sweeps
        .iter()
        .take(LISTED)
        .map(|s| format!("{} {:.1} → {:.1}", s.direction.name(), s.from_c, s.to_c))
        .collect();
    let listed = listed.join(", ");
    if model.sweeps.len() <= LISTED {
        return listed;
    }
    let count = |d: SweepDirection| model.sweeps.iter().filter(|s| s.direction == d).count();
    format!(
        "{} sweeps cooling, {} warming: {listed}, …",
        count(SweepDirection::Cooling),
        count(SweepDirection::Warming),
    )
}

fn channel(c: &ChannelDrift) -> Row {
    let verdict = match c.is_corrected() {
        true => format!("corrected, order {}", c.order),
        false => "not corrected".to_owned(),
    };
    let input_unit = match c.input_unit.as_str() {
        "unknown" => "?".to_owned(),
        known => unit(known),
    };
    Row::from([
        Cell::text(&c.channel),
        Cell::maybe(c.slope, small),
        Cell::text(input_unit),
        Cell::maybe(c.r2_cooling_to_warming, r2_text),
        Cell::maybe(c.r2_warming_to_cooling, r2_text),
        Cell::maybe(c.hysteresis, small),
        Cell::number(small(c.drift_rms)),
        Cell::maybe(c.residual_rms, small),
        Cell::text(verdict),
    ])
}

/// Three digits, with a power of ten for small values.
fn small(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.01 {
        format!("{value:.2e}")
    } else {
        short(value)
    }
}
