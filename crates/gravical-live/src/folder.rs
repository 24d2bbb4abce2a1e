//! The folder of a session: the recording, and the journal of its poses.
//!
//! The journal has an event a line, as it was shown, except the status. It is written before an
//! event is shown, so that an accepted pose is never lost. `gravical calibrate FOLDER` calibrates
//! with the poses of the journal.

use std::path::{Path, PathBuf};

use gravical_core::matrix3::{norm, sub};

use gravical_calibrate::calibrate::{CalibrateOptions, Calibrated, calibrate};
use gravical_calibrate::calibration_file::{InputFile, InputRole};
use gravical_calibrate::gravity::Gravity;
use gravical_calibrate::poses::sections::Section;
use gravical_calibrate::recording::source::Named;
use gravical_calibrate::recording::{ReadOptions, Recording, read, read_named};
use gravical_judge::Result;
use gravical_signal::stats::moments;

use crate::event::{Event, Message, Pose, SourceKind};
use crate::problem::Problem;

/// Name of the journal.
pub const JOURNAL: &str = "session.ndjson";
/// Name of the recording.
pub const RECORDING: &str = "recording.csv";

/// A mean that differs from that of the journal by more than this share was taken of other rows.
const SAME_MEAN: f64 = 1e-9;

/// A journal.
#[derive(Debug, Clone, Default)]
pub struct Journal {
    /// Where the rows came from, and its name.
    pub source: Option<(SourceKind, String)>,
    /// Local gravity.
    pub gravity: Gravity,
    /// The poses that count, in order.
    pub poses: Vec<Pose>,
    /// How many numbers of poses were used.
    pub numbers: u32,
    folder: PathBuf,
}

/// True for the folder of a session.
pub fn is_session(folder: &Path) -> bool {
    folder.join(JOURNAL).is_file()
}

impl Journal {
    /// Reads the journal of the session in `folder`. A last line that was not written completely
    /// does not count.
    ///
    /// # Errors
    ///
    /// Those of the file; `journal-syntax` (input) with the line.
    pub fn read(folder: &Path) -> Result<Self> {
        Self::read_with_input(Named::Path(&folder.join(JOURNAL))).map(|(journal, _)| journal)
    }

    /// Reads a journal, in memory too; with the file.
    ///
    /// # Errors
    ///
    /// As [`read`](Self::read).
    pub fn read_with_input(file: Named<'_>) -> Result<(Self, InputFile)> {
        let path = file.path();
        InputFile::read(file, InputRole::Sections, |bytes| {
            let mut journal = Journal {
                folder: path.parent().unwrap_or(Path::new("")).to_owned(),
                ..Journal::default()
            };
            let lines = bytes.split_inclusive(|b| *b == b'\n').zip(1..);
            for (line, number) in lines.filter(|(line, _)| line.ends_with(b"\n")) {
                if line.trim_ascii().is_empty() {
                    continue;
                }
                let message: Message = serde_json::from_slice(line).map_err(|e| {
                    let why = e.to_string();
                    Problem::NotAnEvent { why }.error().at(path, Some(number))
                })?;
                journal.add(message.event);
            }
            Ok(journal)
        })
    }

    fn add(&mut self, event: Event) {
        match event {
            Event::Session {
                source,
                name,
                gravity,
                ..
            } => (self.source, self.gravity) = (Some((source, name)), gravity),
            Event::Gravity(gravity) => self.gravity = gravity,
            Event::PoseAccepted(pose) => {
                self.numbers = self.numbers.max(pose.pose);
                self.poses.push(pose);
            }
            Event::PoseUndone { pose, .. } => self.poses.retain(|p| p.pose != pose),
            _ => {}
        }
    }

    /// Checks that the rows of the poses are still in the recording.
    ///
    /// # Errors
    ///
    /// Those of reading; `recording-changed`.
    pub fn verify(&self, options: &ReadOptions) -> Result<()> {
        if !self.poses.is_empty() {
            self.sections(&read(self.folder.join(RECORDING), options)?)?;
        }
        Ok(())
    }

    /// The poses as a section list of the recording.
    ///
    /// # Errors
    ///
    /// `sections-empty` (input) without any; `recording-changed` if the rows of a pose are not
    /// those that it was accepted with.
    pub fn sections(&self, recording: &Recording) -> Result<Vec<Section>> {
        if self.poses.is_empty() {
            return Err(Problem::NoPose
                .error()
                .advise("resume", "")
                .at(&self.folder, None));
        }
        let checked = |pose: &Pose| {
            let found = section(pose, recording);
            let mean = moments(&recording.accel, found.rows.clone()).0;
            let off = norm(&sub(&mean, &pose.mean));
            if off <= SAME_MEAN * norm(&pose.mean) {
                return Ok(found);
            }
            let (lines, pose) = (pose.lines, pose.pose);
            let error = Problem::OtherRows {
                lines,
                pose,
                journal: JOURNAL,
            }
            .error();
            Err(error.at(recording.name.as_ref(), None))
        };
        self.poses.iter().map(checked).collect()
    }
}

/// Calibrates with the session in `folder`, as [`calibrate_session`].
///
/// # Errors
///
/// As there.
pub fn calibrate_folder(
    folder: &Path,
    read_options: &ReadOptions,
    options: &CalibrateOptions,
    given: Option<Gravity>,
) -> Result<(Vec<Recording>, Calibrated)> {
    let [recording, journal] = [RECORDING, JOURNAL].map(|name| folder.join(name));
    let files = [Named::Path(&recording), Named::Path(&journal)];
    calibrate_session(files, read_options, options, given)
}

/// Calibrates with the poses of a session, its recording and its journal, and with its gravity unless one is `given`.
/// Returns the recording, too.
///
/// # Errors
///
/// Those of [`Journal`], of reading and of [`calibrate`].
pub fn calibrate_session(
    [recording, journal]: [Named<'_>; 2],
    read_options: &ReadOptions,
    options: &CalibrateOptions,
    given: Option<Gravity>,
) -> Result<(Vec<Recording>, Calibrated)> {
    let (journal, input) = Journal::read_with_input(journal)?;
    let recording = read_named(recording, read_options)?;
    let mut options = options.clone();
    options.segment.sections = Some(journal.sections(&recording)?);
    options.gravity = given.unwrap_or(journal.gravity);
    options.other_inputs.push(input);
    let recordings = vec![recording];
    let calibrated = calibrate(&recordings, &options)?;
    Ok((recordings, calibrated))
}

/// A pose in a section list: its name claims no face, so that the data decide.
pub(crate) fn section(pose: &Pose, recording: &Recording) -> Section {
    Section {
        label: format!("pose {}", pose.pose),
        rows: recording.rows_at(pose.lines),
    }
}
