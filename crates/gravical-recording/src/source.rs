//! Where a recording is read from: a path, standard input, bytes in memory.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use gravical_judge::{Error, ReadOptions, Result};

use crate::bytes::{Input, from_reader};
use crate::problem::Problem;

/// Endings of files that may be recordings.
pub const ENDINGS: [&str; 7] = ["csv", "txt", "tsv", "log", "dat", "gz", "cwa"];

/// Name of a file without folder and endings (`.csv.gz` is two).
pub fn stem(name: &str) -> String {
    let file = Path::new(name)
        .file_name()
        .map_or_else(|| name.into(), |f| f.to_string_lossy());
    let mut stem = file.as_ref();
    for _ in 0..2 {
        let (front, ending) = stem.rsplit_once('.').unwrap_or(("", ""));
        let is_known = ENDINGS.iter().any(|e| ending.eq_ignore_ascii_case(e));
        stem = if is_known && !front.is_empty() {
            front
        } else {
            stem
        };
    }
    stem.to_owned()
}

/// What is in a folder, in the order of the names.
///
/// # Errors
///
/// What the file system says.
pub fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io(folder, e))?;
    let mut paths: Vec<PathBuf> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
    paths.sort();
    Ok(paths)
}

/// A path in messages.
fn path_name(path: &Path) -> String {
    path.display().to_string()
}

/// A file by its name: on the disk (`-` is standard input), or its bytes in memory.
#[derive(Debug, Clone, Copy)]
pub enum Named<'a> {
    /// On the disk.
    Path(&'a Path),
    /// In memory, by this name.
    Bytes(&'a Path, &'a [u8]),
}

impl<'a, P: AsRef<Path> + ?Sized> From<&'a P> for Named<'a> {
    fn from(path: &'a P) -> Self {
        Named::Path(path.as_ref())
    }
}

impl<'a> Named<'a> {
    /// Its name.
    pub fn path(self) -> &'a Path {
        match self {
            Named::Path(path) | Named::Bytes(path, _) => path,
        }
    }

    /// Its name in messages.
    pub fn name(self) -> String {
        path_name(self.path())
    }
}

/// Opens a file; of the options only `hash` and `meter` are used.
///
/// # Errors
///
/// Errors of the file system; `is-a-directory` for a directory.
pub fn open<'a>(file: impl Into<Named<'a>>, options: &ReadOptions) -> Result<Input> {
    let path = match file.into() {
        Named::Path(path) => path,
        Named::Bytes(name, bytes) => {
            let reader = Box::new(io::Cursor::new(bytes.to_vec()));
            return input(name, reader, Some(bytes.len() as u64), options);
        }
    };
    if path == Path::new("-") {
        // Without a lock: who opens it a second time finds its end, and does not wait for ever.
        return input(path, Box::new(io::stdin()), None, options);
    }
    if path.is_dir() {
        return Err(Problem::IsDirectory.error().at(path, None));
    }
    let file = File::open(path).map_err(|e| Error::io(path, e))?;
    let total = file.metadata().ok().filter(std::fs::Metadata::is_file);
    input(path, Box::new(file), total.map(|m| m.len()), options)
}

fn input(
    path: &Path,
    reader: Box<dyn Read + Send>,
    total: Option<u64>,
    options: &ReadOptions,
) -> Result<Input> {
    let reader = match &options.meter {
        Some(meter) => meter.over(&path_name(path), total, reader),
        None => reader,
    };
    from_reader(reader, options.hash).map_err(|e| Error::io(path, e))
}
