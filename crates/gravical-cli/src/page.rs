//! Reports as pages: where they go, and how that is told.

use std::path::{Path, PathBuf};

use gravical::calibration_file::CalibrationFile;
use gravical::figure::{self, calibration::Session};
use gravical::motion::Motion;
use gravical::output::{check_targets, path_text, write_atomic};
use gravical::recording::Recording;
use gravical::report::html::{Provenance, calibration_html, motion_html};
use gravical::{Error, Result};

use crate::figures::FigureArgs;
use crate::text;

/// Looks at everything that a command is going to write, before its work.
///
/// # Errors
///
/// `report-target` (usage) for a report on standard output; those of
/// [`check_targets`] and of the figures.
pub fn check_outputs(
    output: Option<&Path>,
    report: Option<&Path>,
    (figures, names): (&FigureArgs, &[&str]),
    inputs: &[Option<&Path>],
    force: bool,
) -> Result<()> {
    if report == Some(Path::new("-")) {
        return Err(Error::usage(
            "report-target",
            "--report names a file; standard output is for tables and JSON",
        ));
    }
    figures.check(names, force)?;
    let own = |path: Option<&Path>| path.map(Path::to_owned);
    let mut targets: Vec<PathBuf> = [own(output), own(report)].into_iter().flatten().collect();
    let inputs: Vec<PathBuf> = inputs.iter().copied().filter_map(own).collect();
    check_targets(&targets, &inputs, force)?;
    let drawn = figures.files(names);
    if drawn.iter().any(|f| f.parent().is_some_and(Path::is_dir)) {
        targets.extend(drawn);
        // What is there was judged above, and the list of figures may be.
        return check_targets(&targets, &inputs, true);
    }
    // The folder is made later: nothing else may be called like it.
    match figures.figures.as_ref().filter(|f| targets.contains(f)) {
        Some(folder) => Err(
            Error::usage("same-target", "a folder and a file of one name")
                .at(folder, None)
                .with_hint("give each a name of its own"),
        ),
        None => Ok(()),
    }
}

/// Writes the page in one step.
///
/// # Errors
///
/// What [`write_atomic`] says.
fn write_report(path: &Path, force: bool, page: &str) -> Result<()> {
    write_atomic(path, force, |out| {
        out.write_all(page.as_bytes())
            .map_err(|e| Error::io(path, e))
    })
}

/// The report of a calibration, with the figures of its session where there is one.
///
/// # Errors
///
/// What [`write_atomic`] says.
pub fn write_calibration(
    path: &Path,
    force: bool,
    file: &CalibrationFile,
    session: Option<Session<'_>>,
) -> Result<()> {
    let figures = figure::calibration::figures(file, session);
    write_report(path, force, &calibration_html(file, &figures))
}

/// The report of a motion.
///
/// # Errors
///
/// What [`write_atomic`] says.
pub fn write_motion(
    path: &Path,
    force: bool,
    motion: &Motion,
    recording: &Recording,
    origin: Provenance<'_>,
) -> Result<()> {
    let figures = figure::motion::figures(motion);
    let page = motion_html(&motion.result, recording, &figures, origin);
    write_report(path, force, &page)
}

/// Says where the report is.
pub fn say_report(path: Option<&Path>) {
    if let Some(path) = path {
        text::say(&format!("Report: {}", path_text(path)));
    }
}
