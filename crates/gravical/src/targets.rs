//! No result destroys what a command reads.

use std::collections::HashSet;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use crate::calibration_file::Calibration;
use crate::live::folder::JOURNAL;
use crate::output::{check_target, folder_of, is_special, no_folder};
use crate::problem::Problem;
use crate::recording::source::open;
use crate::recording::{ReadOptions, read_head};
use crate::session::files_in;
use crate::{Error, Result};

/// Checks all output files of a command before it starts: a result must replace neither another
/// result nor what the command reads. `inputs` are files and folders. In an input folder that is
/// whatever may be a recording by its name, except our results, and the journal of a session.
///
/// # Errors
///
/// Those of [`check_target`]; `no-folder`, `same-target`, and `target-is-input`, the last two
/// independent of `force` (all usage).
pub fn check_targets(targets: &[PathBuf], inputs: &[PathBuf], force: bool) -> Result<()> {
    let mut results: HashSet<PathBuf> = HashSet::new();
    let (files, listed) = read_files(inputs);
    for path in targets {
        // Before `exists`: --force would not help.
        check_target(path, true)?;
        let id = file_id(path).filter(|_| !is_special(path));
        if id.as_ref().is_some_and(|id| files.contains(id)) {
            return Err(Problem::TargetIsInput.error().at(path, None));
        }
        if id.is_some_and(|id| listed.contains(&id)) && !is_result_file(path) {
            return Err(Problem::TargetMayBeInput.error().at(path, None));
        }
        check_target(path, force)?;
        let folder = folder_of(path);
        if !folder.is_dir() {
            return Err(no_folder(folder, path));
        }
        if !is_special(path) && !results.insert(place(path)) {
            return Err(same_target(path));
        }
    }
    Ok(())
}

/// Columns that begin the summary of many sessions.
pub const SUMMARY_COLUMNS: [&str; 6] = ["path", "grade", "reason", "error_code", "hint", "result"];

/// True for a calibration, and for a table that holds results by its column names: of `apply`, of
/// `motion`, or the summary of many sessions. What `convert` and `denoise` write is a recording.
fn is_result_file(path: &Path) -> bool {
    read_head(path, &ReadOptions::default()).is_ok_and(|head| head.format.is_result())
        || is_summary(path)
        || Calibration::read(path).is_ok()
}

/// True for the summary of many sessions.
pub fn is_summary(path: &Path) -> bool {
    let columns = SUMMARY_COLUMNS.join(",");
    let mut head = vec![0; columns.len()];
    let read =
        open(path, &ReadOptions::default()).map(|mut input| input.reader.read_exact(&mut head));
    matches!(read, Ok(Ok(()))) && head == columns.as_bytes()
}

/// Identifies a file by more than its name: links to it are the same file.
#[cfg(unix)]
type FileId = (u64, u64);
#[cfg(not(unix))]
type FileId = PathBuf;

/// None for a file that does not exist.
fn file_id(path: &Path) -> Option<FileId> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let file = std::fs::metadata(path).ok()?;
        Some((file.dev(), file.ino()))
    }
    #[cfg(not(unix))]
    path.canonicalize().ok()
}

/// The files that are read from `inputs`, and those of folders that may be recordings.
fn read_files(inputs: &[PathBuf]) -> (HashSet<FileId>, HashSet<FileId>) {
    let (mut files, mut listed) = (HashSet::new(), HashSet::new());
    for input in inputs {
        if input.is_dir() {
            files.extend(file_id(&input.join(JOURNAL)));
            let recordings = files_in(input).unwrap_or_default();
            listed.extend(recordings.iter().filter_map(|p| file_id(p)));
        } else if input == Path::new("-") {
            files.extend(file_id(Path::new("/dev/stdin")));
        } else {
            files.extend(file_id(input));
        }
    }
    (files, listed)
}

/// The error of two results with one path.
pub fn same_target(path: &Path) -> Error {
    Problem::SameTarget.error().at(path, None)
}

/// Canonical path, for comparison. A file that does not exist is identified by its folder.
pub fn place(path: &Path) -> PathBuf {
    if let Ok(whole) = path.canonicalize() {
        return whole;
    }
    match (folder_of(path).canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}
