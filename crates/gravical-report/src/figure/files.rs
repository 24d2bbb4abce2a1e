//! Figures as files of a folder.
//!
//! A run draws what its data allow. A figure of an earlier run that this one does not draw would
//! pass for one of its figures: a run that may replace figures takes away all that are there.
//! Other files are never touched.

use std::path::{Path, PathBuf};

use gravical::output::write_text;
use gravical::{Error, Result};

use super::{Figure, calibration, motion, noise, svg};

/// Whether figures can be written to `folder`, before the work that they need. The folder may be
/// absent; the one that it is in may not.
///
/// # Errors
///
/// `exists` where there are figures and `force` is false, `no-folder`, `figures-target` (all usage).
pub fn check_figures(folder: &Path, force: bool) -> Result<()> {
    if folder == Path::new("-") {
        return Err(Error::usage(
            "figures-target",
            "--figures names a folder; standard output is for tables and JSON",
        ));
    }
    if folder.exists() && !folder.is_dir() {
        let error = Error::usage("no-folder", "figures go into a folder; this is a file");
        return Err(error.at(folder, None));
    }
    let parent = folder.parent().filter(|p| !p.as_os_str().is_empty());
    if let Some(parent) = parent.filter(|p| !p.is_dir()) {
        let message = format!("there is no folder \"{}\"", parent.display());
        return Err(Error::usage("no-folder", message)
            .at(folder, None)
            .with_hint("make it first, or name another folder"));
    }
    if !force && !figures_in(folder).is_empty() {
        return Err(
            Error::usage("exists", "this folder holds the figures of an earlier run")
                .at(folder, None)
                .with_hint("name another folder, or add --force to replace all of them"),
        );
    }
    Ok(())
}

/// The files of a folder that are called as figures are.
fn figures_in(folder: &Path) -> Vec<PathBuf> {
    let names = [&calibration::NAMES[..], &motion::NAMES, &noise::NAMES].concat();
    let paths = names
        .into_iter()
        .map(|name| folder.join(format!("{name}.svg")));
    paths.filter(|path| path.is_file()).collect()
}

/// Writes each figure to `folder` as NAME.svg, and makes the folder where it is absent. Figures of
/// an earlier run that this one does not draw are taken away, which `force` allows.
///
/// # Errors
///
/// Those of [`check_figures`], and what the file system says.
pub fn write_figures<'a>(
    figures: impl IntoIterator<Item = &'a Figure>,
    folder: &Path,
    force: bool,
) -> Result<()> {
    check_figures(folder, force)?;
    let mut earlier = figures_in(folder);
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, e))?;
    for figure in figures {
        let path = folder.join(format!("{}.svg", figure.name));
        write_text(&path, force, &svg::standalone(figure))?;
        earlier.retain(|p| *p != path);
    }
    for path in earlier {
        std::fs::remove_file(&path).map_err(|e| Error::io(&path, e))?;
    }
    Ok(())
}
