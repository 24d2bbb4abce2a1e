//! Report of drift with temperature.

use crate::document::{Block, Cell, Row, Section, Table};
use gravical::calibration_file::{ChannelDrift, TemperatureModel};
use gravical::numfmt::{small, unit};

/// Adds the drift of each channel with temperature to `section`.
pub(super) fn drift<'a>(section: Section<'a>, model: &TemperatureModel) -> Section<'a> {
    let [low, high] = model.range_c;
    let columns = [
        "channel",
        "slope, per °C",
        "unit",
        "R² cooling → warming",
        "R² warming → cooling",
        "verdict",
    ];
    let table = Table::new("Drift of each channel")
        .columns(columns)
        .rows(model.channels.iter().map(channel));
    let range = format!("{low:.1} to {high:.1} °C at rest");
    section.with(Block::paragraph(range)).with(table)
}

fn channel(c: &ChannelDrift) -> Row {
    let verdict = if c.is_corrected() {
        format!("corrected, order {}", c.order)
    } else {
        "not corrected".to_owned()
    };
    let input_unit = match c.input_unit.as_str() {
        "unknown" => "?".to_owned(),
        known => unit(known),
    };
    let cells = Row::from([
        Cell::text(&c.channel),
        Cell::maybe(c.coefficients.first().copied(), |d| small(d, 3)),
        Cell::text(input_unit),
        Cell::maybe(c.r2_cooling_to_warming, r2_text),
        Cell::maybe(c.r2_warming_to_cooling, r2_text),
        Cell::text(verdict),
    ]);
    // The numbers are enough for an accepted channel.
    cells.noted(if c.is_corrected() {
        ""
    } else {
        c.reason.as_str()
    })
}

/// R² with two decimals, never rounded up to the limit of the test.
fn r2_text(r2: f64) -> String {
    if r2 < -99.0 {
        "< -99".to_owned()
    } else if (0.69..0.7).contains(&r2) {
        "0.69".to_owned()
    } else {
        format!("{r2:.2}")
    }
}
