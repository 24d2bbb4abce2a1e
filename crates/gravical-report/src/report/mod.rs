//! Reports: each result as a [`Document`]. Every number is one
//! of the JSON result.

mod calibration;
mod check;
mod denoise;
mod inspection;
mod motion;
mod noise;
mod sessions;

#[cfg(test)]
mod tests;

use gravical::calibration_file::{GravitySource, InputFile, TemperatureModel};
use gravical::numfmt::{small, unit, words};

pub use calibration::calibration;
pub use check::{check, comparison};
pub use denoise::denoise;
pub use inspection::{inspection, origin};
pub use motion::{motion, orientation};
pub use noise::noise;
pub use sessions::{Session, sessions};

use crate::document::{Block, Cell, Document, Place, Section, Table, short_name};

/// How local gravity is known.
fn gravity_source(source: GravitySource) -> &'static str {
    match source {
        GravitySource::Given => "given",
        GravitySource::Latitude => "from latitude",
        GravitySource::Standard => "assumed",
    }
}

/// The largest magnitude, which decides about digits.
fn largest<'v>(values: impl IntoIterator<Item = &'v f64>) -> f64 {
    values.into_iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Adds the drift of each channel with temperature to `section`.
fn drift<'a>(section: Section<'a>, model: &TemperatureModel) -> Section<'a> {
    let [low, high] = model.range_c;
    let caption = format!("Drift of each channel, {low:.1} to {high:.1} °C at rest");
    let table = Table::new(caption, ["channel", "slope, per °C", "unit", "verdict"]);
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

impl Document<'_> {
    /// Adds a section with the program, the command, if there was one, the time, UTC, and all files
    /// read.
    pub fn with_provenance(
        self,
        tool: &str,
        command: Option<&str>,
        created: &str,
        inputs: &[InputFile],
    ) -> Self {
        let mut facts = vec![("program".to_owned(), tool.to_owned())];
        let command = command.map(|command| ("command".to_owned(), format!("`{command}`")));
        facts.extend(command);
        facts.push(("computed".to_owned(), created.to_owned()));
        facts.extend(inputs.iter().map(|file| {
            let sum = file.sha256.as_deref().map(|sum| format!(", SHA-256 {sum}"));
            let text = file.path.clone() + &sum.unwrap_or_default();
            (words(&file.role), text)
        }));
        let section = Section::new("Provenance").full(Block::Facts(facts));
        let place = Place::Foot;
        self.with(Section { place, ..section })
    }
}
