//! Figures as files.

use std::path::{Path, PathBuf};

use crate::output::{check_target, write_atomic};
use crate::{Error, Result};

use super::manifest::{File, MANIFEST, Manifest, Run};
use super::{Figure, svg, write_csv};

/// What is written of each figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Formats {
    /// As a picture of dots, too; needs the feature `png`.
    pub png: bool,
}

impl Formats {
    fn endings(self) -> impl Iterator<Item = &'static str> {
        ["svg", "csv"].into_iter().chain(self.png.then_some("png"))
    }
}

/// What writing did.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Written {
    /// The files of the figures.
    pub files: Vec<PathBuf>,
    /// Files of the earlier run that this one does not draw, taken away.
    pub removed: Vec<PathBuf>,
    /// The like that stay: somebody has changed them, or `force` was not given.
    pub kept: Vec<PathBuf>,
}

/// Whether figures called `names` can be written to `folder`, before the work that
/// they need. The folder may be absent; the one that it is in may not.
///
/// # Errors
///
/// `exists` where one of them is there and `force` is false, `no-folder`,
/// `figures-target`, `no-png` (all usage).
pub fn check_figures(folder: &Path, names: &[&str], formats: Formats, force: bool) -> Result<()> {
    if formats.png && !cfg!(feature = "png") {
        return Err(
            Error::usage("no-png", "this build of the program cannot write PNG").with_hint(
                "leave --png out, or build with: cargo install gravical-cli --features png",
            ),
        );
    }
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
    for name in names {
        for ending in formats.endings() {
            check_target(&path(folder, name, ending), force)?;
        }
    }
    Manifest::read(folder, force).map(|_| ())
}

/// The files that figures called `names` may be written to, and the list of them.
#[must_use]
pub fn figure_files(folder: &Path, names: &[&str], formats: Formats) -> Vec<PathBuf> {
    let of = |name| {
        formats
            .endings()
            .map(move |ending| path(folder, name, ending))
    };
    let list = std::iter::once(folder.join(MANIFEST));
    names.iter().flat_map(|name| of(name)).chain(list).collect()
}

/// Writes each figure to `folder` as NAME.svg and NAME.csv (and NAME.png), each in
/// one step, and says which files these are. Makes the folder where it is absent.
///
/// The folder's [`MANIFEST`] says which run wrote what. Files that the earlier run of
/// the same kind wrote and this one does not are taken away where `force` is given,
/// unless somebody has changed them. Nothing else is ever removed.
///
/// # Errors
///
/// Those of [`check_figures`], and what the file system says.
pub fn write_figures(
    figures: &[Figure],
    folder: &Path,
    run: Run<'_>,
    formats: Formats,
    force: bool,
) -> Result<Written> {
    let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
    check_figures(folder, &names, formats, force)?;
    let manifest = Manifest::read(folder, force)?;
    if !folder.is_dir() {
        std::fs::create_dir(folder).map_err(|e| Error::io(folder, e))?;
    }
    let (mut files, mut entries) = (Vec::new(), Vec::new());
    for figure in figures {
        for ending in formats.endings() {
            let path = path(folder, &figure.name, ending);
            let bytes = bytes(figure, ending).map_err(|e| Error::io(&path, e))?;
            write_atomic(&path, force, |out| {
                out.write_all(&bytes).map_err(|e| Error::io(&path, e))
            })?;
            entries.push(File::of(format!("{}.{ending}", figure.name), &bytes));
            files.push(path);
        }
    }
    let swept = manifest.enter(folder, run, entries, force)?;
    Ok(Written {
        files,
        removed: swept.removed,
        kept: swept.kept,
    })
}

fn bytes(figure: &Figure, ending: &str) -> std::io::Result<Vec<u8>> {
    match ending {
        "svg" => Ok(svg::standalone(figure).into_bytes()),
        "csv" => {
            let mut bytes = Vec::new();
            write_csv(figure, &mut bytes)?;
            Ok(bytes)
        }
        _ => png(figure),
    }
}

fn path(folder: &Path, name: &str, ending: &str) -> PathBuf {
    folder.join(format!("{name}.{ending}"))
}

#[cfg(feature = "png")]
use super::png::png;

/// [`check_figures`] has refused it.
#[cfg(not(feature = "png"))]
fn png(_: &Figure) -> std::io::Result<Vec<u8>> {
    Err(std::io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests;
