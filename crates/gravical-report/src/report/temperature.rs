//! Report of drift with temperature.

use gravical::calibration_file::TemperatureModel;
use gravical::numfmt::{small, unit};

use crate::document::{Cell, Section, Table};

/// Adds the drift of each channel with temperature to `section`.
pub(super) fn drift<'a>(section: Section<'a>, model: &TemperatureModel) -> Section<'a> {
    let [low, high] = model.range_c;
    let caption = format!("Drift of each channel, {low:.1} to {high:.1} °C at rest");
    let table = Table::new(caption).columns(["channel", "slope, per °C", "unit", "verdict"]);
    let table = model.channels.iter().fold(table, |table, c| {
        let not = if c.is_corrected() { "" } else { "not " };
        let cells = [
            Cell::maybe(c.per_c, |d| small(d, 3)),
            Cell::text(unit(&c.input_unit)),
            Cell::text(format!("{not}corrected")),
        ];
        table.row(&c.channel, cells)
    });
    // The numbers are enough for an accepted channel.
    let others = model.channels.iter().filter(|c| !c.is_corrected());
    let reasons = others.map(|c| (c.channel.clone(), c.reason.clone()));
    section.with(table).reasons(reasons)
}
