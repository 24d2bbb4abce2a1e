//! Reports as pages: where they go, and how that is told.

use std::path::Path;

use gravical::output::{check_target, write_atomic};
use gravical::{Error, Result};

use crate::text;

/// Refuses a target before the work, not after it.
///
/// # Errors
///
/// `report-target` (usage) for standard output; `exists` (usage).
pub fn check_report(path: &Path, force: bool) -> Result<()> {
    if path == Path::new("-") {
        return Err(Error::usage(
            "report-target",
            "--report names a file; standard output is for tables and JSON",
        ));
    }
    check_target(path, force)
}

/// Writes the page in one step.
///
/// # Errors
///
/// What [`write_atomic`] says.
pub fn write_report(path: &Path, force: bool, page: &str) -> Result<()> {
    write_atomic(path, force, |out| {
        out.write_all(page.as_bytes())
            .map_err(|e| Error::io(path, e))
    })
}

/// Says where the report is.
pub fn say_report(path: Option<&Path>) {
    if let Some(path) = path {
        text::say(&format!("Report: {}", path.display()));
    }
}

/// The command as it was typed, with the program's plain name.
pub fn command_line() -> String {
    let words = std::env::args_os().skip(1).map(|word| {
        let word = word.to_string_lossy().into_owned();
        if word.contains(char::is_whitespace) {
            format!("'{word}'")
        } else {
            word
        }
    });
    std::iter::once("gravical".to_owned())
        .chain(words)
        .collect::<Vec<_>>()
        .join(" ")
}
