//! Figures as files, in a folder of their own.
//!
//! A run draws what its data allow. What an earlier run drew and this one does not would
//! pass for one of its figures, so the folder is one run's: it holds figures and nothing
//! else, and a run that may replace them takes all of them away. Nothing that is not
//! called like a figure is ever touched.

use std::path::{Path, PathBuf};

use gravical::output::write_text;
use gravical::{Error, Result};

use super::{Figure, calibration, motion, noise, svg};

/// Whether figures can be written to `folder`, before the work that they need. The
/// folder may be absent; the one that it is in may not.
///
/// # Errors
///
/// `exists` where there are figures and `force` is false, `foreign-files` where there
/// is anything else, `no-folder`, `figures-target` (all usage).
pub fn check_figures(folder: &Path, force: bool) -> Result<()> {
    if folder == Path::new("-") {
        return Err(Error::usage(
            "figures-target",
            "--figures names a folder; standard output is for tables and JSON",
        ));
    }
    if folder.exists() && !folder.is_dir() {
        return Err(
            Error::usage("no-folder", "figures go into a folder; this is a file").at(folder, None),
        );
    }
    let parent = folder.parent().filter(|p| !p.as_os_str().is_empty());
    if let Some(parent) = parent.filter(|p| !p.is_dir()) {
        return Err(Error::usage(
            "no-folder",
            format!("there is no folder \"{}\"", parent.display()),
        )
        .at(folder, None)
        .with_hint("make it first, or name another folder"));
    }
    let earlier = figures_in(folder)?;
    if !earlier.is_empty() && !force {
        return Err(
            Error::usage("exists", "this folder holds the figures of an earlier run")
                .at(folder, None)
                .with_hint("name another folder, or add --force to replace all of them"),
        );
    }
    Ok(())
}

/// The figures in a folder, which may be absent.
///
/// # Errors
///
/// `foreign-files` (usage) where there is anything else, and what the file system says.
fn figures_in(folder: &Path) -> Result<Vec<PathBuf>> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let io = |e| Error::io(folder, e);
    let mut figures = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        let name = entry.file_name();
        // A link is not what was written, whatever it leads to.
        let is_file = entry.file_type().map_err(io)?.is_file();
        if !is_file || !name.to_str().is_some_and(is_figure) {
            return Err(Error::usage(
                "foreign-files",
                format!(
                    "the figures of a run have a folder to themselves; in this one there is \"{}\"",
                    name.to_string_lossy()
                ),
            )
            .at(folder, None)
            .with_hint("name another folder, which may be absent"));
        }
        figures.push(entry.path());
    }
    figures.sort();
    Ok(figures)
}

/// Whether a file is called as the files of figures are.
fn is_figure(name: &str) -> bool {
    name.split_once('.').is_some_and(|(stem, ending)| {
        let known = calibration::NAMES.iter().chain(&motion::NAMES);
        let known = known.chain(&noise::NAMES);
        ending == "svg" && known.into_iter().any(|n| *n == stem)
    })
}

/// Writes each figure to `folder` as NAME.svg, and makes the folder where it is absent. Figures of an
/// earlier run that this one does not draw are taken away, which `force` allows.
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
    let mut earlier = figures_in(folder)?;
    if !folder.is_dir() {
        std::fs::create_dir(folder).map_err(|e| Error::io(folder, e))?;
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn draw(names: &[&str], folder: &Path) -> Result<()> {
        let figures: Vec<Figure> = names
            .iter()
            .map(|n| Figure::new(n, "A figure", ""))
            .collect();
        write_figures(&figures, folder, true)
    }

    #[test]
    fn nothing_foreign_is_touched() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        for name in ["notes.txt", "mine.svg", "norm.svg.bak", "norm.SVG", "norm"] {
            draw(&["norm"], path).unwrap();
            std::fs::write(path.join(name), "mine").unwrap();
            let error = draw(&["tilt"], path).unwrap_err();
            assert_eq!(error.code(), "foreign-files", "{name}");
            assert!(error.to_string().contains(name), "{error}");
            assert!(path.join("norm.svg").is_file() && !path.join("tilt.svg").exists());
            std::fs::remove_file(path.join(name)).unwrap();
        }
        // A folder that is called like a figure is none; nor is a link.
        std::fs::remove_file(path.join("norm.svg")).unwrap();
        std::fs::create_dir(path.join("norm.svg")).unwrap();
        assert_eq!(draw(&["tilt"], path).unwrap_err().code(), "foreign-files");
        #[cfg(unix)]
        {
            std::fs::remove_dir(path.join("norm.svg")).unwrap();
            std::os::unix::fs::symlink("/nowhere", path.join("norm.svg")).unwrap();
            assert_eq!(draw(&["norm"], path).unwrap_err().code(), "foreign-files");
        }
    }
}
