//! Report of drift with temperature.

use crate::document::{Cell, Row, Section, Table};
use gravical::calibration_file::{ChannelDrift, TemperatureModel};
use gravical::numfmt::{small, unit};

/// Adds the drift of each channel with temperature to `section`.
pub(super) fn drift<'a>(section: Section<'a>, model: &TemperatureModel) -> Section<'a> {
    let [low, high] = model.range_c;
    let table = Table::new(format!(
        "Drift of each channel, {low:.1} to {high:.1} °C at rest"
    ))
    .columns(["channel", "slope, per °C", "unit", "verdict"])
    .rows(model.channels.iter().map(channel));
    section.with(table)
}

fn channel(c: &ChannelDrift) -> Row {
    let corrected = c.is_corrected();
    let verdict = if corrected {
        "corrected"
    } else {
        "not corrected"
    };
    let input_unit = match c.input_unit.as_str() {
        "unknown" => "?".to_owned(),
        known => unit(known),
    };
    let cells = [
        Cell::maybe(c.coefficients.first().copied(), |d| small(d, 3)),
        Cell::text(input_unit),
        Cell::text(verdict),
    ];
    // The numbers are enough for an accepted channel.
    Row::named(&c.channel, cells).noted(if corrected { "" } else { c.reason.as_str() })
}
