//! Reports: each result as a [`Document`]. Every number is one
//! of the JSON result.

mod calibration;
mod check;
mod compare;
mod denoise;
mod inspection;
mod motion;
mod noise;
mod temperature;

#[cfg(test)]
mod tests;

use gravical::calibration_file::{GravitySource, InputFile};
use gravical::numfmt::words;

pub use calibration::calibration;
pub use check::check;
pub use compare::comparison;
pub use denoise::denoise;
pub use inspection::{inspection, origin};
pub use motion::motion;
pub use noise::noise;

use crate::document::{Block, Document, Section, short_name};

/// How local gravity is known.
fn gravity_source(source: GravitySource) -> &'static str {
    match source {
        GravitySource::Given => "given",
        GravitySource::Latitude => "from latitude",
        GravitySource::Standard => "assumed",
    }
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
        self.with(Section::new("Provenance").full(Block::Facts(facts)))
    }
}
