//! Figures as files.

use std::path::{Path, PathBuf};

use crate::output::{check_target, write_atomic};
use crate::{Error, Result};

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

/// Whether figures called `names` can be written to `folder`, before the work that
/// they need. The folder may be absent; the one that it is in may not.
///
/// # Errors
///
/// `exists` where one of them is there and `force` is false, `no-folder`,
/// `no-png` (all usage).
pub fn check_figures(folder: &Path, names: &[&str], formats: Formats, force: bool) -> Result<()> {
    if formats.png && !cfg!(feature = "png") {
        return Err(
            Error::usage("no-png", "this build of the program cannot write PNG").with_hint(
                "leave --png out, or build with: cargo install gravical-cli --features png",
            ),
        );
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
    Ok(())
}

/// Writes each figure to `folder` as NAME.svg and NAME.csv (and NAME.png), each in
/// one step, and says which files these are. Makes the folder where it is absent.
///
/// # Errors
///
/// Those of [`check_figures`], and what the file system says.
pub fn write_figures(
    figures: &[Figure],
    folder: &Path,
    formats: Formats,
    force: bool,
) -> Result<Vec<PathBuf>> {
    let names: Vec<&str> = figures.iter().map(|f| f.name.as_str()).collect();
    check_figures(folder, &names, formats, force)?;
    if !folder.is_dir() {
        std::fs::create_dir(folder).map_err(|e| Error::io(folder, e))?;
    }
    let mut written = Vec::new();
    for figure in figures {
        for ending in formats.endings() {
            let path = path(folder, &figure.name, ending);
            write_atomic(&path, force, |out| {
                let io = |e| Error::io(&path, e);
                match ending {
                    "svg" => out
                        .write_all(svg::standalone(figure).as_bytes())
                        .map_err(io),
                    "csv" => write_csv(figure, out).map_err(io),
                    _ => out.write_all(&png(figure)?).map_err(io),
                }
            })?;
            written.push(path);
        }
    }
    Ok(written)
}

fn path(folder: &Path, name: &str, ending: &str) -> PathBuf {
    folder.join(format!("{name}.{ending}"))
}

#[cfg(feature = "png")]
fn png(figure: &Figure) -> Result<Vec<u8>> {
    super::png::png(figure)
}

#[cfg(not(feature = "png"))]
fn png(_: &Figure) -> Result<Vec<u8>> {
    Err(Error::usage("no-png", "this build cannot write PNG"))
}
