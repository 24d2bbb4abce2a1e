//! How a result is shown and where it goes: `--report` and `--verbose`, JSON, the table of `-o`, and the
//! check of all targets of a command.

use std::io::{self, IsTerminal as _, Write};
use std::path::{Path, PathBuf};

use gravical::calibration_file::{InputFile, creation_time};
use gravical::escape::{one_line, path_text};
use gravical::motion::MotionTable;
use gravical::output::{write_atomic, write_text};
use gravical::recording::Finding;
use gravical::targets::{check_targets, place, same_target};
use gravical::{Error, Result, TOOL};
use gravical_report::document::{Block, Detail, Document, Remark, Section};
use gravical_report::figure::{Figure, check_figures, write_figures};
use serde::Serialize;

use crate::options::command_line;
use crate::text;

#[derive(Debug, Default, clap::Args)]
pub struct ReportArgs {
    /// Page with figures and tables to copy (.html)
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Folder for each figure as SVG
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Print all tables, notes and findings
    #[arg(short, long)]
    pub verbose: bool,
}

/// A result on a terminal.
fn in_words(document: &Document<'_>, verbose: bool) -> String {
    document.to_text(if verbose {
        Detail::Full
    } else {
        Detail::Summary
    })
}

impl ReportArgs {
    /// Whether a report, with its figures, is requested.
    pub fn is_wanted(&self) -> bool {
        self.report.is_some()
    }

    /// The page that is requested.
    ///
    /// # Errors
    ///
    /// `report-target` (usage) for what is no page.
    pub fn page(&self) -> Result<Option<&Path>> {
        let page = self.report.as_deref();
        page.map_or(Ok(()), is_page)?;
        Ok(page)
    }

    /// Whether a folder of figures is requested.
    pub fn has_folder(&self) -> bool {
        self.figures.is_some()
    }

    /// Whether figures are drawn: for a report, or for their folder.
    pub fn draws(&self) -> bool {
        self.report.is_some() || self.figures.is_some()
    }

    /// The figures, drawn for a report or their folder only.
    pub fn figures(&self, draw: impl FnOnce() -> Vec<Figure>) -> Vec<Figure> {
        if self.draws() { draw() } else { Vec::new() }
    }

    /// Checks everything that a command is going to write, before its work.
    ///
    /// # Errors
    ///
    /// `report-target` (usage) for what is no page; `same-target` (usage) for two results in one
    /// place; those of [`check_targets`] and [`check_figures`].
    pub fn check<'a>(
        &self,
        output: Option<&Path>,
        inputs: impl IntoIterator<Item = &'a PathBuf>,
        force: bool,
    ) -> Result<()> {
        let report = self.page()?;
        if let Some(folder) = &self.figures {
            check_figures(folder, force)?;
            if output
                .into_iter()
                .chain(report)
                .any(|file| place(file) == place(folder))
            {
                return Err(same_target(folder));
            }
        }
        let files = output.into_iter().chain(report).map(Path::to_owned);
        let inputs: Vec<PathBuf> = inputs.into_iter().cloned().collect();
        check_targets(&files.collect::<Vec<_>>(), &inputs, force)
    }

    /// Writes the report if requested, atomically.
    ///
    /// # Errors
    ///
    /// Those of [`write_report`].
    pub fn write(&self, force: bool, document: &Document<'_>) -> Result<()> {
        if let Some(folder) = &self.figures {
            let blocks = document.sections.iter().flat_map(|s| &s.blocks);
            let figures = blocks.filter_map(|(_, block)| match block {
                Block::Figure(figure) => Some(*figure),
                _ => None,
            });
            write_figures(figures, folder, force)?;
        }
        let write = |path: &PathBuf| write_report(path, force, document);
        self.report.as_ref().map_or(Ok(()), write)
    }

    /// Prints the path of the report on stderr, unless `quiet`.
    pub fn say(&self, quiet: bool) {
        for (what, path) in [("Report", &self.report), ("Figures", &self.figures)] {
            if let Some(path) = path.as_ref().filter(|_| !quiet) {
                text::say(&format!("{what}: {}", path_text(path)));
            }
        }
    }
}

/// The options of a command that prints its result.
#[derive(Debug, clap::Args)]
pub struct ResultArgs {
    #[command(flatten)]
    pub report: ReportArgs,
    /// Overwrite existing files
    #[arg(long)]
    pub force: bool,
    /// Print the result as JSON instead of the report
    #[arg(long)]
    pub json: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

impl ResultArgs {
    /// [`ReportArgs::check`].
    ///
    /// # Errors
    ///
    /// Those of [`ReportArgs::check`].
    pub fn check<'a>(
        &self,
        output: Option<&Path>,
        inputs: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Result<()> {
        self.report.check(output, inputs, self.force)
    }

    /// Writes the report if requested, and prints the result: as JSON, or in words.
    ///
    /// # Errors
    ///
    /// Those of [`write_report`] and of printing.
    pub fn present(&self, result: &impl Serialize, document: &Document<'_>) -> anyhow::Result<()> {
        self.report.write(self.force, document)?;
        if self.json {
            text::print_json(result)?;
        } else if !self.quiet {
            text::print_report(&in_words(document, self.report.verbose))?;
        }
        self.report.say(self.quiet);
        Ok(())
    }
}

#[derive(Debug, clap::Args)]
pub struct TableArgs {
    /// File; - is stdout [default: stdout if no terminal, and no --json]
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
    /// The file that the table goes to.
    pub fn file(&self) -> Option<&Path> {
        let output = self.output.as_deref();
        output.filter(|path| *path != Path::new("-"))
    }

    /// Whether the table goes to standard output: with `-o -`; without `-o` unless standard output is a terminal,
    /// where the table would scroll the summary away, or takes the summary as JSON.
    pub fn is_printed(&self) -> bool {
        match &self.output {
            Some(_) => self.file().is_none(),
            None => !self.json && !io::stdout().is_terminal(),
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
        if self.json && self.is_printed() {
            let what = "--json prints the summary on stdout, where the table goes, too";
            let error = Error::usage("json-needs-output", what);
            return Err(error.with_hint("write the table to a file with -o"));
        }
        report.check(self.file(), inputs, self.force)
    }

    /// Writes the table to its file, atomically, to stdout, or nowhere.
    ///
    /// # Errors
    ///
    /// Those of `fill` and [`write_atomic`].
    pub fn write<T>(&self, fill: impl FnOnce(&mut dyn Write) -> Result<T>) -> anyhow::Result<T> {
        match self.file() {
            Some(path) => Ok(write_atomic(path, self.force, fill)?),
            None if !self.is_printed() => Ok(fill(&mut io::sink())?),
            // On a terminal control characters are escaped.
            None if io::stdout().is_terminal() => {
                let mut table = Vec::new();
                let done = fill(&mut table)?;
                text::print(&String::from_utf8_lossy(&table))?;
                Ok(done)
            }
            None => Ok(fill(&mut io::stdout().lock())?),
        }
    }

    /// Writes the table of a motion, if it goes anywhere.
    ///
    /// # Errors
    ///
    /// Those of [`TableArgs::write`].
    pub fn write_table(&self, table: &MotionTable<'_>) -> anyhow::Result<()> {
        if self.file().is_none() && !self.is_printed() {
            return Ok(());
        }
        let path = self.file().unwrap_or(Path::new("standard output"));
        self.write(|out| table.write(out).map_err(|e| Error::io(path, e)))
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
        let to = match self.file() {
            Some(path) => format!(" → {}", path_text(path)),
            None if self.is_printed() => " → stdout".to_owned(),
            None => String::new(),
        };
        text::say(&format!("{}{to}", one_line(done)));
        text::say_report(in_words(document, verbose).trim_end());
        if to.is_empty() {
            text::say("No table was written: -o FILE writes it to a file.");
        }
        Ok(())
    }
}

/// The summary of a table as a document: its facts and what was found.
pub fn how_it_was_read(facts: Section<'static>, findings: &[Finding]) -> Document<'static> {
    let remarks = Remark::all(findings, false);
    let findings = Some(remarks).filter(|all| !all.is_empty());
    Document::default().with(facts.with(findings.map(Block::Findings)))
}

/// Whether this is the name of a page.
///
/// # Errors
///
/// `report-target` (usage) for any other name, that of standard output included.
fn is_page(path: &Path) -> Result<()> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    if ending == "html" || ending == "htm" {
        return Ok(());
    }
    let text = "a report is a page";
    let error = Error::usage("report-target", text).at(path, None);
    Err(error.with_hint("use a name that ends in .html; --figures writes each figure as SVG"))
}

/// Writes the page, atomically.
///
/// # Errors
///
/// `report-target` (usage) for another name; those of [`write_text`].
pub fn write_report(path: &Path, force: bool, document: &Document<'_>) -> Result<()> {
    is_page(path)?;
    write_text(path, force, &document.to_html())
}

/// Adds command, time and inputs of this run.
pub fn with_origin<'a>(document: Document<'a>, inputs: &[InputFile]) -> Document<'a> {
    document.with_provenance(TOOL, Some(&command_line()), &creation_time(), inputs)
}
