//! The files of a session: as they are named, or all recordings of a folder.

use std::path::{Path, PathBuf};

use gravical::recording::{Finding, ReadOptions, Recording, join_gyroscope, read};
use gravical::{Error, Result};

/// Endings of files in a folder that may be recordings.
const ENDINGS: [&str; 6] = ["csv", "txt", "tsv", "log", "dat", "gz"];

/// Files of a folder that may be recordings, in the order of their names.
///
/// # Errors
///
/// What the file system says; `no-recordings` when there is none.
pub fn files_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io(folder, e))?;
    let mut paths: Vec<PathBuf> = entries
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|p| p.is_file() && may_be_recording(p))
        .collect();
    paths.sort();
    if paths.is_empty() {
        return Err(no_recordings(folder));
    }
    Ok(paths)
}

fn may_be_recording(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| ENDINGS.iter().any(|x| e.eq_ignore_ascii_case(x)))
}

fn no_recordings(folder: &Path) -> Error {
    Error::input("no-recordings", "there is no recording in this folder")
        .at(folder, None)
        .with_hint("recordings are text files that end in .csv, .txt, .tsv, .log, .dat or .gz")
}

/// True for a file of a folder that is no recording at all, such as a licence.
pub fn is_something_else(error: &Error) -> bool {
    matches!(error.code(), "no-rows" | "no-accelerometer")
}

/// Joins the gyroscope of the file at `path` to the one recording there is.
///
/// # Errors
///
/// `gyro-inputs` (usage) when there are several; those of [`join_gyroscope`].
pub fn join_gyro(recordings: &mut [Recording], path: &Path, options: &ReadOptions) -> Result<()> {
    match recordings {
        [one] => join_gyroscope(one, path, options),
        several => Err(several_with_gyro(several.len())),
    }
}

/// `--gyro` beside several inputs.
pub fn several_with_gyro(inputs: usize) -> Error {
    Error::usage(
        "gyro-inputs",
        format!("--gyro belongs to one recording of the accelerometer; there are {inputs}"),
    )
    .with_hint("give one continuous recording, or files that hold both sensors")
}

/// Reads files, or the recordings of one folder; files of the folder that are
/// none come back as findings.
///
/// # Errors
///
/// The first file that cannot be read, `no-recordings`.
pub fn read_session(
    inputs: &[PathBuf],
    options: &ReadOptions,
) -> Result<(Vec<Recording>, Vec<Finding>)> {
    let folder = match inputs {
        [one] if one.as_path() != Path::new("-") && one.is_dir() => one,
        _ => {
            let recordings: Result<Vec<Recording>> =
                inputs.iter().map(|p| read(p, options)).collect();
            return Ok((recordings?, Vec::new()));
        }
    };
    let (mut recordings, mut left_out) = (Vec::new(), Vec::new());
    for path in files_in(folder)? {
        match read(&path, options) {
            // A result beside its sources is no placement.
            Ok(recording) if recording.is_calibrated() => {
                let finding = Finding::warning(
                    "already-calibrated",
                    "calibrated already, by its column names; left out",
                );
                left_out.push(finding.in_file(&recording.name));
            }
            Ok(recording) => recordings.push(recording),
            Err(error) if is_something_else(&error) => {
                let file = path.display().to_string();
                left_out.push(
                    Finding::note("no-recording", format!("{}; left out", error.message()))
                        .in_file(&file),
                );
            }
            Err(error) => return Err(error),
        }
    }
    if recordings.is_empty() {
        return Err(no_recordings(folder));
    }
    Ok((recordings, left_out))
}
