//! The content of an item: which bytes its result came from.

use std::fs::{self, File, Metadata};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::hash::hex;
use crate::live::folder::JOURNAL;
use crate::output::is_special;
use crate::session::files_in;
use crate::{Error, Result};

/// Bytes that are hashed at a time.
const PIECE: usize = 1 << 16;

/// Size and time of a file: if both stayed, it is taken as unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    pub bytes: u64,
    /// Time of the last change, nanoseconds since 1970.
    pub changed_ns: u64,
}

impl Stamp {
    /// None if there is no such file.
    pub fn of(path: &Path) -> Option<Self> {
        fs::metadata(path).ok().map(|m| Self::from(&m))
    }
}

impl From<&Metadata> for Stamp {
    fn from(metadata: &Metadata) -> Self {
        let since = metadata.modified().ok();
        let since = since.and_then(|t| t.duration_since(UNIX_EPOCH).ok());
        Stamp {
            bytes: metadata.len(),
            changed_ns: since.map_or(0, |t| u64::try_from(t.as_nanos()).unwrap_or(u64::MAX)),
        }
    }
}

/// The files of an item as they were when it was begun.
pub struct Content {
    /// SHA-256: of the file, or for a folder of the list of its files with theirs, as `sha256sum`
    /// writes it.
    pub sha256: String,
    files: Vec<(PathBuf, Stamp)>,
}

impl Content {
    /// Reads the file, or the recordings of the folder.
    ///
    /// # Errors
    ///
    /// Those of the file system; `no-recordings`; `each-input` (usage) for a pipe, which can be
    /// read only once.
    pub fn of(path: &Path) -> Result<Self> {
        if !path.is_dir() {
            let (sha256, stamp) = of_file(path)?;
            let files = vec![(path.to_owned(), stamp)];
            return Ok(Content { sha256, files });
        }
        let mut paths = files_in(path)?;
        // A guided session has its poses in the journal.
        paths.extend(Some(path.join(JOURNAL)).filter(|journal| journal.is_file()));
        let (mut list, mut files) = (Sha256::new(), Vec::new());
        for path in paths {
            let (sha256, stamp) = of_file(&path)?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            list.update(format!("{sha256}  {name}\n"));
            files.push((path, stamp));
        }
        Ok(Content {
            sha256: hex(&list.finalize()),
            files,
        })
    }

    /// To be called before a result is published: it must belong to this content.
    ///
    /// # Errors
    ///
    /// `changed` (input).
    pub fn check_unchanged(&self) -> Result<()> {
        match self
            .files
            .iter()
            .find(|(path, stamp)| Stamp::of(path) != Some(*stamp))
        {
            None => Ok(()),
            Some((path, _)) => Err(Error::input(
                "changed",
                "the file changed while it was read; nothing was written",
            )
            .at(path, None)
            .with_hint("wait until nothing writes to it, then run again with --resume")),
        }
    }
}

/// SHA-256 of a file, and its stamp before it was read.
///
/// # Errors
///
/// As [`Content::of`].
fn of_file(path: &Path) -> Result<(String, Stamp)> {
    let io = |e| Error::io(path, e);
    if is_special(path) {
        return Err(not_twice(path));
    }
    let mut file = File::open(path).map_err(io)?;
    let stamp = Stamp::from(&file.metadata().map_err(io)?);
    let (mut digest, mut piece) = (Sha256::new(), vec![0; PIECE]);
    loop {
        match file.read(&mut piece).map_err(io)? {
            0 => return Ok((hex(&digest.finalize()), stamp)),
            n => digest.update(&piece[..n]),
        }
    }
}

/// SHA-256 of a file whose content belongs to the options.
///
/// # Errors
///
/// As [`Content::of`].
pub fn sha256_of(path: &Path) -> Result<String> {
    of_file(path).map(|(sha256, _)| sha256)
}

/// Standard input or a pipe in place of a file.
pub fn not_twice(path: &Path) -> Error {
    Error::usage(
        "each-input",
        "this can be read only once; a run over many sessions needs files",
    )
    .at(path, None)
    .with_hint("save it to a file first; @LIST reads the paths from a file, @- from standard input")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_the_list_of_its_recordings() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let all = || Content::of(folder.path()).unwrap();
        fs::write(at("a.csv"), "abc").unwrap();
        fs::write(at("b.csv"), "").unwrap();
        let first = all();
        // `sha256sum *.csv | sha256sum`
        assert_eq!(
            first.sha256,
            "92ff0903327c775bdaf3bf1d4516911b6cb0c3a21e17e6f45515268267786a66"
        );
        // What is no recording does not belong to it.
        fs::write(at("notes.md"), "x").unwrap();
        assert_eq!(all().sha256, first.sha256);
        first.check_unchanged().unwrap();
        fs::write(at("b.csv"), "1").unwrap();
        assert_ne!(all().sha256, first.sha256);
        assert_eq!(first.check_unchanged().unwrap_err().code(), "changed");
        fs::rename(at("a.csv"), at("c.csv")).unwrap();
        assert_ne!(all().sha256, first.sha256);
    }
}
