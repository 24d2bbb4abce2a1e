//! Provenance of a result.

use crate::document::{Block, Cell, Document, Section, Table};
use gravical::calibration_file::InputFile;
use gravical::numfmt::words;

/// Program, command, time and inputs of a result.
#[derive(Debug, Clone, Copy)]
pub struct Provenance<'a> {
    /// The program.
    pub tool: &'a str,
    /// The command, if there was one.
    pub command: Option<&'a str>,
    /// Time, UTC.
    pub created: &'a str,
    /// All files read.
    pub inputs: &'a [InputFile],
}

impl Document<'_> {
    /// Adds the date below the title and a section with the provenance.
    pub fn with_provenance(mut self, origin: &Provenance<'_>) -> Self {
        self.stamp = format!("{} · {}", origin.created, origin.tool);
        let command = origin.command.map(|command| format!("`{command}`"));
        let section = Section::new("provenance", "Provenance").full(Block::facts([
            ("program", Some(origin.tool.to_owned())),
            ("command", command),
            ("computed", Some(origin.created.to_owned())),
        ]));
        self.with(match origin.inputs {
            [] => section,
            some => section.full(files(some)),
        })
    }
}

/// Files with their checksums.
fn files(files: &[InputFile]) -> Table {
    let row = |file: &InputFile| {
        [
            Cell::text(&file.path),
            Cell::text(words(&file.role)),
            file.sha256
                .clone()
                .map_or_else(|| Cell::text("–"), Cell::Code),
        ]
        .into()
    };
    Table::new("Files")
        .columns(["file", "used as", "SHA-256"])
        .rows(files.iter().map(row))
}
