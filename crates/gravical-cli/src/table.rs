//! Output of the commands that turn one table into another.

use std::io::{self, IsTerminal as _, Write};
use std::path::{Path, PathBuf};

use gravical::escape::{one_line, path_text};
use gravical::output::write_atomic;
use gravical::recording::Finding;
use gravical::{Error, Result};
use gravical_report::document::{Block, Document, Remark, Section};
use serde::Serialize;

use crate::report::{ReportArgs, in_words};
use crate::text;

#[derive(Debug, clap::Args)]
pub struct TableArgs {
    /// File; - is stdout [default: stdout if no terminal]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Print the summary as JSON; the table needs -o
    #[arg(long)]
    pub json: bool,
}

impl TableArgs {
    /// Where the table goes. Without `-o` it goes nowhere if standard output has the summary as JSON.
    pub fn target(&self) -> Target<'_> {
        match self.output.as_deref() {
            Some(path) if path != Path::new("-") => Target::File(path),
            None if self.json || io::stdout().is_terminal() => Target::Nowhere,
            _ => Target::Stdout,
        }
    }

    /// Checks the targets before the work. `inputs` are the files read.
    ///
    /// # Errors
    ///
    /// `json-needs-output` (usage) if table and summary would both go to stdout; those of
    /// [`ReportArgs::check`].
    pub fn check<'a>(
        &self,
        report: &ReportArgs,
        inputs: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Result<()> {
        if self.json && self.target() == Target::Stdout {
            let what = "--json prints the summary on stdout, where the table goes, too";
            let error = Error::usage("json-needs-output", what);
            return Err(error.with_hint("write the table to a file with -o"));
        }
        report.check(self.target().file(), inputs, self.force)
    }

    /// Writes the table to its file, atomically, or to stdout.
    ///
    /// # Errors
    ///
    /// Those of `fill` and [`write_atomic`].
    pub fn write<T>(&self, fill: impl FnOnce(&mut dyn Write) -> Result<T>) -> anyhow::Result<T> {
        match self.target() {
            // On a terminal control characters are escaped.
            Target::Stdout if io::stdout().is_terminal() => {
                let mut table = Vec::new();
                let done = fill(&mut table)?;
                text::print(&String::from_utf8_lossy(&table))?;
                Ok(done)
            }
            Target::Stdout => Ok(fill(&mut io::stdout().lock())?),
            Target::Nowhere => Ok(fill(&mut io::sink())?),
            Target::File(path) => Ok(write_atomic(path, self.force, fill)?),
        }
    }

    /// Prints the summary: as JSON on stdout if asked for, and what was `done` with the document on
    /// stderr.
    ///
    /// # Errors
    ///
    /// Errors of printing.
    pub fn print_summary(
        &self,
        summary: &impl Serialize,
        done: &str,
        document: &Document<'_>,
        verbose: bool,
    ) -> anyhow::Result<()> {
        if self.json {
            text::print_json(summary)?;
        }
        if self.quiet {
            return Ok(());
        }
        let target = self.target();
        let to = match target {
            Target::File(path) => format!(" → {}", path_text(path)),
            Target::Stdout => " → stdout".to_owned(),
            Target::Nowhere => String::new(),
        };
        text::say(&format!("{}{to}", one_line(done)));
        text::say_report(in_words(document, verbose).trim_end());
        if target == Target::Nowhere && !self.json {
            text::say("No table was written: -o FILE writes it to a file, -o - prints it here.");
        }
        Ok(())
    }
}

/// Target of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target<'a> {
    /// The file of `-o`.
    File(&'a Path),
    /// Standard output: a pipe or a file, or `-o -`.
    Stdout,
    /// No `-o`, and a terminal, where the table would scroll the summary away, or JSON.
    Nowhere,
}

impl<'a> Target<'a> {
    /// The file of `-o`.
    pub fn file(self) -> Option<&'a Path> {
        match self {
            Target::File(path) => Some(path),
            Target::Stdout | Target::Nowhere => None,
        }
    }
}

/// The summary of a table as a document: its facts and what was found.
pub fn how_it_was_read(facts: Section<'static>, findings: &[Finding]) -> Document<'static> {
    let remarks = Remark::all(findings, false);
    let findings = Some(remarks).filter(|all| !all.is_empty());
    Document::default().with(facts.with(findings.map(Block::Findings)))
}
