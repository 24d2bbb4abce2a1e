//! The files of a session: as they are named, or all recordings of a folder.

use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::calibrate::CalibrateOptions;
use crate::finding::{Case, Finding, after};
use crate::poses::sections::read_sections;
use crate::problem::Problem;
use crate::recording::{
    ReadOptions, Recording, holds_gyroscope_alone, is_named_gyroscope, join_gyroscope, read,
    read_named,
};
use crate::{Error, Result};
use gravical_recording::output::ends_in;
use gravical_recording::source::{ENDINGS, Named, entries};

/// Files that a calibration takes beside the recordings.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct SessionFiles {
    /// Gyroscope in a second file, joined by time
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub gyro: Option<PathBuf>,
    /// Poses as row ranges: JSON of imucal or CSV
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    pub sections: Option<PathBuf>,
    /// Recording of warming at rest; repeatable
    ///
    /// A temperature model is fitted to it; by default to the session, if it spans more than 5 °C.
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "FILE", hide_short_help = true)
    )]
    pub thermal: Vec<PathBuf>,
}

impl SessionFiles {
    /// All of them.
    pub fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.gyro.iter().chain(&self.sections).chain(&self.thermal)
    }

    /// Reads sections and thermal recordings into the options.
    ///
    /// # Errors
    ///
    /// Those of [`read_sections`] and [`read`].
    pub fn read_into(&self, options: &mut CalibrateOptions, how: &ReadOptions) -> Result<()> {
        if let Some(path) = &self.sections {
            let (sections, list) = read_sections(path)?;
            options.segment.sections = Some(sections);
            options.other_inputs.push(list);
        }
        let thermal = self.thermal.iter().map(|path| read(path, how));
        options.thermal = thermal.collect::<Result<_>>()?;
        Ok(())
    }
}

/// Files of a folder that may be recordings, in the order of their names.
///
/// # Errors
///
/// What the file system says; `no-recordings` when there is none.
pub fn files_in(folder: impl AsRef<Path>) -> Result<Vec<PathBuf>> {
    let folder = folder.as_ref();
    let paths = listed(folder)?;
    if paths.is_empty() {
        return Err(no_recordings(folder, &folders_in(folder)?));
    }
    Ok(paths)
}

fn listed(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = entries(folder)?;
    paths.retain(|p| p.is_file() && may_be_recording(p));
    Ok(paths)
}

/// True for a name with the ending of a recording.
pub fn may_be_recording(path: &Path) -> bool {
    ENDINGS.into_iter().any(|ending| ends_in(path, ending))
}

/// The error of a folder without a recording, with the first that was left out.
fn no_recordings(folder: &Path, left_out: &[Finding]) -> Error {
    let error = Problem::NoneInFolder { endings: &ENDINGS }
        .error()
        .at(folder, None);
    after(error, left_out.get(..1).unwrap_or_default())
}

/// Folders in `folder` that hold what may be recordings: named, not read.
fn folders_in(folder: &Path) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for path in entries(folder)?.into_iter().filter(|p| p.is_dir()) {
        let files = listed(&path).map_or(0, |files| files.len());
        if files > 0 {
            let left = Case::FolderLeftOut { files }.finding();
            findings.push(left.in_file(&path.display().to_string()));
        }
    }
    Ok(findings)
}

/// True for a file of a folder that is no recording at all, such as a licence.
pub fn is_something_else(error: &Error) -> bool {
    matches!(
        error.code(),
        "no-rows" | "no-accelerometer" | "gyroscope-alone" | "is-a-calibration"
    )
}

/// Reads a file of a folder, of which nobody said that it is a recording.
///
/// # Errors
///
/// `no-rows` for prose, such as a licence; those of [`read`].
pub fn read_listed<'a>(file: impl Into<Named<'a>>, options: &ReadOptions) -> Result<Recording> {
    let file = file.into();
    if ends_in_words(file) {
        return Err(Problem::Prose.error().at(file.path(), None));
    }
    read_named(file, options)
}

/// True for a file that ends in words: however a recording begins, it ends in
/// rows.
fn ends_in_words(file: Named<'_>) -> bool {
    const TAIL: usize = 4096;
    let tail = || -> std::io::Result<Vec<u8>> {
        let path = match file {
            Named::Path(path) => path,
            Named::Bytes(_, bytes) => {
                return Ok(bytes[bytes.len().saturating_sub(TAIL)..].to_vec());
            }
        };
        let mut file = std::fs::File::open(path)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(TAIL as u64)))?;
        let mut tail = Vec::new();
        file.take(TAIL as u64).read_to_end(&mut tail)?;
        Ok(tail)
    };
    let is_packed = ends_in(file.path(), "gz");
    !is_packed && tail().is_ok_and(|tail| gravical_recording::is_prose(&tail))
}

/// True for `walk.rescued.csv` and `walk.rescued-2.csv`, by which `gravical log` saves what it
/// received. The recording itself may be beside it.
fn is_rescued(path: &Path) -> bool {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let kind = stem.rsplit_once('.').map_or("", |(_, kind)| kind);
    kind == "rescued" || kind.starts_with("rescued-")
}

/// A gyroscope's file beside several inputs.
pub fn several_with_gyro(inputs: usize) -> Error {
    let error = Problem::GyroOfSeveral { inputs }.error();
    error.of_option("gyro")
}

/// The recordings among files, and those that hold a gyroscope alone; `of_folder`: nobody said that they are
/// recordings, and what is none goes to `left_out`. With other files beside it, a gyroscope may be theirs.
fn read_files<'a>(
    files: &[Named<'a>],
    of_folder: bool,
    [of_recordings, of_gyroscopes]: [&ReadOptions; 2],
    left_out: &mut Vec<Finding>,
) -> Result<(Vec<Recording>, Vec<Named<'a>>)> {
    let (mut recordings, mut gyroscopes) = (Vec::new(), Vec::new());
    for &file in files {
        let mut leave_out = |why: Finding| left_out.push(why.in_file(&file.name()));
        if of_folder && is_rescued(file.path()) {
            leave_out(Case::Rescued.finding());
            continue;
        }
        let recording = if of_folder {
            read_listed(file, of_recordings)
        } else {
            read_named(file, of_recordings)
        };
        let is_doubtful = recording.as_ref().map_or(true, |r| {
            r.gyro.is_none() && is_named_gyroscope(file.path())
        });
        if is_doubtful && files.len() > 1 && holds_gyroscope_alone(file, of_gyroscopes) {
            gyroscopes.push(file);
            continue;
        }
        match recording {
            // A result beside its sources is no placement.
            Ok(recording) if of_folder && recording.format.is_result() => {
                leave_out(Case::ResultLeftOut.finding());
            }
            Err(error) if of_folder && is_something_else(&error) => {
                let why = error.message().to_owned();
                leave_out(Case::NoRecording { why }.finding());
            }
            recording => recordings.push(recording?),
        }
    }
    Ok((recordings, gyroscopes))
}

/// Reads files, or the recordings of one folder, with the gyroscope of `gyro`
/// joined to the one recording that there is. A file with a gyroscope alone is
/// no placement: it is joined where it can belong to one recording only. What is
/// left out comes back as findings.
///
/// # Errors
///
/// The first file that cannot be read, `no-recordings`;
/// `gyro-inputs` (usage) for `gyro` beside several recordings.
pub fn read_session(
    inputs: &[PathBuf],
    gyro: Option<&Path>,
    options: &ReadOptions,
) -> Result<(Vec<Recording>, Vec<Finding>)> {
    let folder = match inputs {
        [one] if one.as_path() != Path::new("-") && one.is_dir() => Some(one),
        _ => None,
    };
    let (mut paths, mut left_out) = match folder {
        Some(folder) => (files_in(folder)?, folders_in(folder)?),
        None => (inputs.to_vec(), Vec::new()),
    };
    let is_only = paths.len() == 1;
    paths.retain(|path| is_only || !gyro.is_some_and(|gyro| is_same(gyro, path)));
    let files: Vec<Named<'_>> = paths.iter().map(Named::from).collect();
    let found = read_named_session(&files, folder.is_some(), gyro.map(Named::from), options)?;
    left_out.extend(found.1);
    if found.0.is_empty() {
        let first = folder.or(paths.first());
        let first = first.map_or(Path::new("-"), PathBuf::as_path);
        return Err(no_recordings(first, &left_out));
    }
    Ok((found.0, left_out))
}

/// The same of files on the disk or in memory; `of_folder`: nobody said that each is a recording. There may be no
/// recording among them.
///
/// # Errors
///
/// As [`read_session`], but for `no-recordings`.
pub fn read_named_session(
    files: &[Named<'_>],
    of_folder: bool,
    gyro: Option<Named<'_>>,
    options: &ReadOptions,
) -> Result<(Vec<Recording>, Vec<Finding>)> {
    let of_recordings = match gyro {
        Some(_) => options.beside_gyroscope_file(),
        None => options.clone(),
    };
    let mut left_out = Vec::new();
    let how = [&of_recordings, options];
    let (mut recordings, gyroscopes) = read_files(files, of_folder, how, &mut left_out)?;
    if of_folder {
        leave_out_linear(&mut recordings, &mut left_out);
    }
    if let (true, false, Some(file)) = (recordings.is_empty(), of_folder, gyroscopes.first()) {
        // Of files that were named, each is a recording or an error.
        return Ok((vec![read_named(*file, options)?], left_out));
    }
    match (&mut recordings[..], gyro, &gyroscopes[..]) {
        ([one], Some(gyro), _) => join_gyroscope(one, gyro, options)?,
        (several @ [_, ..], Some(_), _) => return Err(several_with_gyro(several.len())),
        ([one], None, [gyro]) if one.gyro.is_none() => {
            let joined = join_gyroscope(one, *gyro, options);
            let recording = one.name.clone();
            let case = match joined {
                Ok(()) => Case::GyroJoined { recording },
                Err(why) => Case::GyroOfAnother {
                    recording,
                    why: why.message().to_owned(),
                },
            };
            left_out.push(case.finding().in_file(&gyro.name()));
        }
        (_, _, gyroscopes) => {
            for file in gyroscopes {
                let alone = Case::GyroAlone.finding().advise("gyro", "");
                left_out.push(alone.in_file(&file.name()));
            }
        }
    }
    Ok((recordings, left_out))
}

/// Apps write acceleration without gravity beside that with it: in a folder only the
/// latter is meant.
fn leave_out_linear(recordings: &mut Vec<Recording>, left_out: &mut Vec<Finding>) {
    if recordings.iter().all(|r| r.units.is_without_gravity) {
        return;
    }
    for recording in recordings.extract_if(.., |r| r.units.is_without_gravity) {
        let why = Case::LinearLeftOut.finding();
        left_out.push(why.in_file(&recording.name));
    }
}

fn is_same(a: &Path, b: &Path) -> bool {
    a == b
        || a.canonicalize()
            .is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b))
}
