//! What of a folder of figures is ours: which run wrote which file.
//!
//! A run that replaces an earlier one draws what its data allow, which may be less.
//! What the earlier run drew and this one does not would stay beside the new
//! figures and pass for one of them. The manifest names the files of each run with
//! their SHA-256, so that such a file can be taken away and nothing else ever is:
//! not what somebody put there, and not a figure that somebody has worked on since.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::calibration_file::creation_time;
use crate::hash::sha256;
use crate::output::write_atomic;
use crate::{Error, Result};

/// Name of the manifest in a folder of figures.
pub const MANIFEST: &str = "gravical-figures.json";

/// The value of its `format`.
const FORMAT: &str = "gravical-figures/1";

/// Who draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run<'a> {
    /// What kind of result is drawn, as `motion`: a run takes the place of the
    /// earlier one of its kind.
    pub verb: &'a str,
    /// The command, for the record.
    pub command: Option<&'a str>,
}

/// The manifest of one folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Manifest {
    format: String,
    /// Runs of which something is there, the latest last.
    runs: Vec<Entry>,
}

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Entry {
    verb: String,
    command: Option<String>,
    created: String,
    tool: String,
    files: Vec<File>,
}

/// One file that a run wrote.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct File {
    name: String,
    sha256: String,
}

impl File {
    pub(super) fn of(name: String, bytes: &[u8]) -> Self {
        let sha256 = sha256(bytes);
        File { name, sha256 }
    }
}

/// What became of the files of earlier runs that this run did not write.
#[derive(Debug, Default)]
pub(super) struct Swept {
    pub(super) removed: Vec<PathBuf>,
    pub(super) kept: Vec<PathBuf>,
}

impl Manifest {
    fn empty() -> Self {
        Manifest {
            format: FORMAT.to_owned(),
            runs: Vec::new(),
        }
    }

    /// That of `folder`; an empty one where there is none yet.
    ///
    /// # Errors
    ///
    /// `exists` (usage) for a file of its name that is something else, unless
    /// `force` is given: then it is replaced, and no figure is known to be ours.
    pub(super) fn read(folder: &Path, force: bool) -> Result<Self> {
        let path = folder.join(MANIFEST);
        if !path.exists() {
            return Ok(Manifest::empty());
        }
        let read = std::fs::read(&path).ok();
        let ours = read
            .and_then(|bytes| serde_json::from_slice::<Manifest>(&bytes).ok())
            .filter(|m| m.format == FORMAT);
        match ours {
            Some(manifest) => Ok(manifest),
            None if force && !path.is_dir() => Ok(Manifest::empty()),
            None => Err(Error::usage(
                "exists",
                "the list of figures goes here, and this is something else",
            )
            .at(&path, None)
            .with_hint("name another folder, or add --force to replace it")),
        }
    }

    /// Enters what `run` wrote to `folder`. With `force` takes away what the earlier
    /// run of its kind wrote and this one did not, where that is as it was written.
    ///
    /// # Errors
    ///
    /// What the file system says.
    pub(super) fn enter(
        mut self,
        folder: &Path,
        run: Run<'_>,
        files: Vec<File>,
        force: bool,
    ) -> Result<Swept> {
        let mut swept = Swept::default();
        let new = |name: &str| files.iter().any(|f| f.name == name);
        let earlier = self.runs.iter().filter(|r| r.verb == run.verb);
        for file in earlier.flat_map(|r| &r.files).filter(|f| !new(&f.name)) {
            let Some(path) = own_path(folder, &file.name) else {
                continue;
            };
            // A link is not what was written, whatever it leads to.
            if !path.symlink_metadata().is_ok_and(|m| m.is_file()) {
                continue;
            }
            let same = || std::fs::read(&path).is_ok_and(|b| sha256(&b) == file.sha256);
            if force && same() {
                std::fs::remove_file(&path).map_err(|e| Error::io(&path, e))?;
                swept.removed.push(path);
            } else {
                swept.kept.push(path);
            }
        }
        // What was written over belongs to this run, whoever drew it first.
        let stays = |r: &Entry, f: &File| match own_path(folder, &f.name) {
            Some(path) if r.verb == run.verb => swept.kept.contains(&path),
            Some(_) => !new(&f.name),
            None => false,
        };
        for earlier in &mut self.runs {
            let files = std::mem::take(&mut earlier.files);
            earlier.files = files.into_iter().filter(|f| stays(earlier, f)).collect();
        }
        self.runs.retain(|r| !r.files.is_empty());
        self.runs.push(Entry {
            verb: run.verb.to_owned(),
            command: run.command.map(str::to_owned),
            created: creation_time(),
            tool: concat!("gravical ", env!("CARGO_PKG_VERSION")).to_owned(),
            files,
        });
        let path = folder.join(MANIFEST);
        write_atomic(&path, true, |out| {
            serde_json::to_writer_pretty(&mut *out, &self)
                .map_err(std::io::Error::from)
                .and_then(|()| out.write_all(b"\n"))
                .map_err(|e| Error::io(&path, e))
        })?;
        Ok(swept)
    }
}

/// The file of a figure, by a name as this program gives it. The manifest may have
/// been written by anybody: no other name leads to a file.
fn own_path(folder: &Path, name: &str) -> Option<PathBuf> {
    let (stem, ending) = name.split_once('.')?;
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    (!stem.is_empty() && stem.chars().all(plain) && ["svg", "csv", "png"].contains(&ending))
        .then(|| folder.join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_figures_lead_to_files() {
        let folder = Path::new("plots");
        assert!(own_path(folder, "position-3d.svg").is_some());
        for name in [
            "../cal.csv",
            "/etc/x.csv",
            "a/b.csv",
            "a\\b.csv",
            "notes.txt",
            ".svg",
            "a.b.svg",
            "C:x.csv",
            "",
            MANIFEST,
        ] {
            assert!(own_path(folder, name).is_none(), "{name}");
        }
    }
}
