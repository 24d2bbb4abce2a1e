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
    Ok(())
}

/// The files that figures called `names` may be written to.
#[must_use]
pub fn figure_files(folder: &Path, names: &[&str], formats: Formats) -> Vec<PathBuf> {
    let of = |name| {
        formats
            .endings()
            .map(move |ending| path(folder, name, ending))
    };
    names.iter().flat_map(|name| of(name)).collect()
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
                    _ => png(figure)
                        .and_then(|bytes| out.write_all(&bytes))
                        .map_err(io),
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
use super::png::png;

/// [`check_figures`] has refused it.
#[cfg(not(feature = "png"))]
fn png(_: &Figure) -> std::io::Result<Vec<u8>> {
    Err(std::io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Panel, Role, Series};
    use super::*;

    fn figure(name: &str) -> Figure {
        let line = Series::line("a", Role::Raw, vec![0.0, 1.0], vec![0.0, 1.0]);
        let panel = Panel::new(Axis::new("time", "s"), Axis::new("way", "m")).with(line);
        Figure::new(name, "A figure", "").with(panel)
    }

    #[test]
    fn files_are_written_once() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("plots");
        let formats = Formats { png: false };
        let files = write_figures(&[figure("a"), figure("b")], &inner, formats, false).unwrap();
        assert_eq!(files.len(), 4);
        assert!(files.iter().all(|f| f.is_file()));
        let again = write_figures(&[figure("b")], &inner, formats, false).unwrap_err();
        assert_eq!(again.code(), "exists");
        assert!(check_figures(&inner, &["c"], formats, false).is_ok());
        assert!(write_figures(&[figure("b")], &inner, formats, true).is_ok());
        let csv = std::fs::read_to_string(inner.join("b.csv")).unwrap();
        assert_eq!(csv.lines().nth(1), Some("panel,series,x,y,low,high,label"));
        assert_eq!(csv.lines().nth(3), Some("1,a,1,1,,,"));
    }

    #[test]
    fn folders_that_cannot_be() {
        let folder = tempfile::tempdir().unwrap();
        let formats = Formats { png: false };
        let deep = folder.path().join("a/b");
        assert_eq!(
            check_figures(&deep, &[], formats, true).unwrap_err().code(),
            "no-folder"
        );
        let file = folder.path().join("file");
        std::fs::write(&file, "x").unwrap();
        assert_eq!(
            check_figures(&file, &[], formats, true).unwrap_err().code(),
            "no-folder"
        );
    }

    #[test]
    fn png_is_a_picture_or_says_how_to_have_it() {
        let folder = tempfile::tempdir().unwrap();
        let done = write_figures(&[figure("a")], folder.path(), Formats { png: true }, false);
        if cfg!(feature = "png") {
            let bytes = std::fs::read(folder.path().join("a.png")).unwrap();
            assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 4000);
            assert_eq!(done.unwrap().len(), 3);
        } else {
            let error = done.unwrap_err();
            assert_eq!(error.code(), "no-png");
            assert!(error.hint().unwrap().contains("--features png"));
        }
    }
}
