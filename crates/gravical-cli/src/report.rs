//! `--report` and `--verbose`, and the check of all targets of a command.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use gravical::TOOL;
use gravical::calibration_file::InputFile;
use gravical::escape::path_text;
use gravical::output::{is_special, write_text};
use gravical::targets::{check_targets, place, same_target};
use gravical::{Error, Result};
use gravical_report::document::{Block, Detail, Document, paragraph};
use gravical_report::figure::{Figure, check_figures, write_figures};
use gravical_report::report::Provenance;

use crate::figures::FigureArgs;
use crate::options::command_line;
use crate::text;

#[derive(Debug, Default, clap::Args)]
pub struct ReportArgs {
    /// Page with figures (.html) or Markdown (.md)
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print all tables, notes and findings
    #[arg(short, long)]
    verbose: bool,
}

/// Format of a report.
enum Form {
    Html,
    /// With its figures in this folder.
    Markdown(PathBuf),
}

impl ReportArgs {
    /// How much of a document is printed.
    pub fn detail(&self) -> Detail {
        Self::detail_of(self.verbose)
    }

    /// The same for a command without reports.
    pub fn detail_of(verbose: bool) -> Detail {
        if verbose {
            Detail::Full
        } else {
            Detail::Summary
        }
    }

    /// Whether a report is requested.
    pub fn is_wanted(&self) -> bool {
        self.report.is_some()
    }

    /// # Errors
    ///
    /// `report-target` (usage) for standard output and for any other kind of file.
    fn form(path: &Path) -> Result<Form> {
        let is = |ending: &str| {
            path.extension()
                .is_some_and(|e| e.eq_ignore_ascii_case(ending))
        };
        if is("html") || is("htm") {
            return Ok(Form::Html);
        }
        if is("md") {
            let mut name = path.file_stem().unwrap_or_default().to_owned();
            name.push("_figures");
            return Ok(Form::Markdown(path.with_file_name(name)));
        }
        const HINT: &str = "use a name that ends in .html or .md";
        let message = "--report needs a file name; standard output is for tables and JSON";
        if path == Path::new("-") {
            return Err(Error::usage("report-target", message).with_hint(HINT));
        }
        let message = "the format of the report is not clear from this name";
        Err(Error::usage("report-target", message)
            .with_hint(HINT)
            .at(path, None))
    }

    /// The file and the folder of its figures, checked before the work.
    fn targets(&self, force: bool) -> Result<(Option<&Path>, Option<PathBuf>)> {
        let Some(path) = self.report.as_deref() else {
            return Ok((None, None));
        };
        match Self::form(path)? {
            Form::Html => Ok((Some(path), None)),
            Form::Markdown(folder) => {
                check_figures(&folder, force)?;
                Ok((Some(path), Some(folder)))
            }
        }
    }

    /// Checks the targets of a command without `--figures`.
    ///
    /// # Errors
    ///
    /// As [`check_outputs`].
    pub fn check(&self, output: Option<&Path>, inputs: &[&Path], force: bool) -> Result<()> {
        check_outputs(output, self, None, inputs, force)
    }

    /// Writes the report if requested, atomically.
    ///
    /// # Errors
    ///
    /// Those of [`write_text`] and [`write_figures`].
    pub fn write(&self, force: bool, document: &Document<'_>) -> Result<()> {
        let Some(path) = self.report.as_deref() else {
            return Ok(());
        };
        write_report(path, force, document)
    }

    /// Prints the path of the report on stderr.
    pub fn say(&self) {
        if let Some(path) = &self.report {
            text::say(&format!("Report: {}", path_text(path)));
        }
    }
}

/// Writes the document in the format of the file name, atomically.
///
/// # Errors
///
/// Those of [`write_text`] and [`write_figures`].
pub fn write_report(path: &Path, force: bool, document: &Document<'_>) -> Result<()> {
    let text = match ReportArgs::form(path)? {
        Form::Html => document.to_html(),
        Form::Markdown(folder) => {
            let figures = figures_of(document);
            if figures.is_empty() {
                if folder.is_dir() {
                    // Those of an earlier report of this name.
                    write_figures(figures, &folder, force)?;
                    // A folder that holds something else stays.
                    let _ = std::fs::remove_dir(&folder);
                }
                document.to_markdown(None)
            } else {
                write_figures(figures, &folder, force)?;
                let name = folder.file_name().unwrap_or_default();
                document.to_markdown(Some(&name.to_string_lossy()))
            }
        }
    };
    write_text(path, force, &text)
}

fn figures_of<'a>(document: &Document<'a>) -> Vec<&'a Figure> {
    let blocks = document.sections.iter().flat_map(|s| &s.blocks);
    blocks
        .filter_map(|(_, block)| match block {
            Block::Figure(figure) => Some(*figure),
            _ => None,
        })
        .collect()
}

/// Adds command, time and inputs of this run.
pub fn with_origin<'a>(document: Document<'a>, inputs: &[InputFile]) -> Document<'a> {
    document.with_provenance(&Provenance {
        tool: TOOL,
        command: Some(&command_line()),
        created: &gravical::calibration_file::creation_time(),
        inputs,
    })
}

/// The next steps of a verdict, where its text does not list them.
pub fn next_step(document: &Document<'_>, detail: Detail) -> String {
    let steps = document.verdict.iter().flat_map(|v| &v.next);
    let shown = steps.filter(|_| detail == Detail::Summary).enumerate();
    let start = |i: usize| if i == 0 { "\nNext: " } else { "      " };
    shown.map(|(i, step)| paragraph(start(i), step)).collect()
}

/// Checks everything that a command is going to write, before its work.
///
/// # Errors
///
/// `report-target` (usage) for an unknown format; `same-target` (usage) for two results in one place;
/// those of [`check_targets`] and [`check_figures`].
pub fn check_outputs(
    output: Option<&Path>,
    report: &ReportArgs,
    figures: Option<&FigureArgs>,
    inputs: &[&Path],
    force: bool,
) -> Result<()> {
    let (report, beside) = report.targets(force)?;
    let figures = match figures {
        Some(figures) => figures.check(force)?,
        None => None,
    };
    let targets: Vec<PathBuf> = [output, report]
        .into_iter()
        .flatten()
        .map(Path::to_owned)
        .collect();
    let inputs: Vec<PathBuf> = inputs.iter().map(|p| p.to_path_buf()).collect();
    let folders = figures.into_iter().chain(beside.as_deref());
    // Files and folders alike: no two results in one place.
    let mut places = HashSet::new();
    for path in folders.chain(targets.iter().map(PathBuf::as_path)) {
        if !is_special(path) && !places.insert(place(path)) {
            return Err(same_target(path));
        }
    }
    check_targets(&targets, &inputs, force)
}
