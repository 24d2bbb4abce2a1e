//! Events of a recording, for people and for scripts.

use gravical::inspect::Inspection;
use gravical::recording::{AccelScale, Finding, GyroScale, Timing};
use serde::Serialize;

use super::gap::Gap;
use super::item::Reason;
use super::live::{RecordedPose, Status};
use super::row_counts::RowCounts;

/// One event. As JSON an object a line with its `type`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Event {
    /// A port is open; most boards reset on that.
    Opened {
        /// Its name.
        port: String,
        /// The device behind it, if it has a name.
        device: Option<String>,
    },
    /// Other programs have the port open too: rows that they read are lost here.
    Shared {
        /// Their names.
        programs: String,
    },
    /// Something is waited for.
    Waiting {
        /// For what, and what to do.
        text: String,
    },
    /// Commands were sent to the board.
    Commands {
        /// The commands, separated by spaces.
        text: String,
    },
    /// An option that does not have its full effect, or something to check.
    Warning {
        /// What, and what to do.
        text: String,
    },
    /// A message of the board: a line that begins with `#`.
    Board {
        /// The line.
        text: String,
    },
    /// The recording begins.
    Started {
        /// The header.
        columns: String,
    },
    /// The state of the recording; about once a second.
    Status {
        /// Rows stored.
        rows: u64,
        /// Since the first row, without pauses, s.
        elapsed_s: f64,
        /// Rows are not stored.
        paused: bool,
        /// Lines rejected so far.
        rejected: u64,
        /// The state of the stream.
        #[serde(flatten)]
        live: Status,
    },
    /// Paused.
    Paused,
    /// The recording continues.
    Resumed,
    /// A line is not a row. Reported for the first ten.
    Rejected {
        /// Why.
        reason: Reason,
        /// The line; bytes that are not UTF-8 are replaced.
        text: String,
    },
    /// Rows are missing; the gap is named in the recording.
    Gap(Gap),
    /// Something is odd in the samples: an axis is frozen, a limit of the range is reached.
    Finding(Finding),
    /// The port is lost.
    Lost {
        /// What the system says.
        text: String,
    },
    /// The board sends nothing.
    Silent {
        /// Duration so far, s.
        duration_s: f64,
    },
    /// The disk does not take the rows.
    DiskFailed {
        /// What the system says.
        text: String,
    },
    /// The disk takes rows again.
    DiskRecovered,
    /// The end.
    Ended {
        /// The file.
        file: String,
        /// The file of rejected lines.
        rejected_file: Option<String>,
        /// Why it ended.
        reason: End,
        /// Since the first row, without pauses, s.
        elapsed_s: f64,
        /// Faces that were recorded as a pose; none where the accelerometer is not known.
        poses: Option<Vec<RecordedPose>>,
        /// Number of free poses.
        free_poses: Option<u64>,
        /// Counts of rows and lines.
        #[serde(flatten)]
        counts: Box<RowCounts>,
        /// What the file holds; none if it cannot be read as a recording, or the user did not wait.
        #[serde(flatten)]
        content: Option<Box<FileContent>>,
    },
}

/// The part of [`Inspection`] that is not in the counts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FileContent {
    /// Unit of the accelerometer.
    pub accelerometer: AccelScale,
    /// Unit of the gyroscope.
    pub gyroscope: Option<GyroScale>,
    /// Rates, duration, jitter.
    pub timing: Timing,
    /// Faults of the file.
    pub findings: Vec<Finding>,
}

impl From<Inspection> for FileContent {
    fn from(inspection: Inspection) -> Self {
        FileContent {
            accelerometer: inspection.accelerometer,
            gyroscope: inspection.gyroscope,
            timing: inspection.timing,
            findings: inspection.findings,
        }
    }
}

/// Why it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// All rows that were asked for are stored.
    Rows,
    /// The time that was asked for has passed.
    Duration,
    /// The user ended it.
    User,
}
