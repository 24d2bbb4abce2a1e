//! Figures as files of a folder.
//!
//! A run draws what its data allow. A figure of an earlier run that this one does not draw would
//! pass for one of its figures: a run with `--force` removes the figures of earlier runs. A file is one
//! of these if it begins as this program writes them; other files are never touched.

use std::path::{Path, PathBuf};

use gravical::output::{make_folder, write_text};
use gravical::{Error, Result};

use super::{Figure, draw};
use crate::problem::Problem;

/// Whether figures can be written to `folder`, before the work that they need.
///
/// # Errors
///
/// `no-folder` for what is none, `exists` where there are figures and `force` is false (both usage).
pub fn check_figures(folder: &Path, force: bool) -> Result<()> {
    if folder.exists() && !folder.is_dir() {
        return Err(Problem::NoFolder.error().at(folder, None));
    }
    if !force && !figures_in(folder).is_empty() {
        let error = Problem::EarlierFigures.error().at(folder, None);
        return Err(error.advise("force", "true"));
    }
    Ok(())
}

/// The figures in a folder.
fn figures_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_figure = |path: &PathBuf| {
        let is_svg = path.extension().is_some_and(|ending| ending == "svg");
        is_svg && std::fs::read(path).is_ok_and(|text| text.starts_with(draw::BEGIN.as_bytes()))
    };
    let paths = entries.map(|entry| entry.path());
    paths.filter(is_figure).collect()
}

/// Writes each figure to `folder` as NAME.svg, and makes the folder where it is absent. Figures of
/// an earlier run that this one does not draw are taken away, which `force` allows.
///
/// # Errors
///
/// Those of [`check_figures`]; `exists` (usage) for a file with the name of a figure that is none; and
/// what the file system says.
pub fn write_figures<'a>(
    figures: impl IntoIterator<Item = &'a Figure>,
    folder: &Path,
    force: bool,
) -> Result<()> {
    check_figures(folder, force)?;
    make_folder(folder)?;
    let mut earlier = figures_in(folder);
    let at = |figure: &'a Figure| (folder.join(format!("{}.svg", figure.name)), figure);
    let figures: Vec<(PathBuf, &Figure)> = figures.into_iter().map(at).collect();
    let is_foreign = |path: &PathBuf| path.exists() && !earlier.contains(path);
    if let Some((path, _)) = figures.iter().find(|(path, _)| is_foreign(path)) {
        return Err(Problem::ForeignFile.error().at(path, None));
    }
    for (path, figure) in figures {
        write_text(&path, force, &draw::standalone(figure))?;
        earlier.retain(|p| *p != path);
    }
    for path in earlier {
        std::fs::remove_file(&path).map_err(|e| Error::io(&path, e))?;
    }
    Ok(())
}
