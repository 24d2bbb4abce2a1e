//! Events of a recording, for people and for scripts.

use gravical::inspect::Inspection;
use gravical::recording::{AccelScale, Finding};
use serde::Serialize;

use super::gaps::Gap;

/// The recording at one moment.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Status {
    /// Rows stored.
    pub rows: u64,
    /// Since the first row, without pauses, s.
    pub elapsed_s: f64,
    /// Rows are not stored.
    pub paused: bool,
    /// Lines rejected so far.
    pub rejected: u64,
    /// Rows a second, by their stamps.
    pub rate_hz: Option<f64>,
    /// Magnitude of the acceleration, mean of the last half second, in the unit of the file.
    pub norm: Option<f64>,
    #[serde(skip)]
    pub accel: Option<AccelScale>,
    /// Temperature of the sensor, °C.
    pub temperature_c: Option<f64>,
    /// Whether the sensor is at rest.
    pub still: Option<bool>,
    /// The face that is up at rest: `+x`.
    pub up: Option<String>,
    /// Faces that were recorded as a pose.
    pub done: Option<Vec<String>>,
}

/// One event. As JSON an object a line with its `type`.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Event {
    /// Something is waited for.
    Waiting { text: String },
    /// A port is open; most boards reset on that.
    Opened {
        port: String,
        /// The device behind it, if it has a name.
        device: Option<String>,
    },
    /// A message of the board: a line that begins with `#`.
    Board { text: String },
    /// The first row is in the file; `columns` is its header, or its layout in words.
    Started { columns: String },
    /// The state of the recording, once a second.
    Status(Status),
    /// Rows are not stored.
    Paused,
    /// The recording continues.
    Resumed,
    /// Lines are no rows: how many so far, and the first since the last such event.
    Rejected { count: u64, first: String },
    /// Rows are missing; the gap is named in the file.
    Gap(Gap),
    /// Something is odd in the samples: an axis is frozen, a limit of the range is reached.
    Finding(Finding),
    /// Something to do, or to know.
    Warning { text: String },
    /// The port is lost; what the system says.
    Lost { text: String },
    /// The board sends nothing.
    Silent { duration_s: f64 },
    /// No row has arrived yet: what arrives instead.
    NoRows { text: String, hint: String },
    /// The end.
    Ended(Box<Ended>),
}

/// How many lines went where.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Rows in the file.
    pub rows: u64,
    /// Lines that are no rows: `# rejected:` in the file.
    pub rejected: u64,
    /// Rows that are missing by the clock of the board, in gaps.
    pub missing: u64,
    /// Gaps that the file names.
    pub gaps: u64,
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

/// What was recorded.
#[derive(Debug, Clone, Serialize)]
pub struct Ended {
    /// The file.
    pub file: String,
    /// Why it ended; none after an error.
    pub reason: Option<End>,
    /// Since the first row, without pauses, s.
    pub elapsed_s: f64,
    #[serde(flatten)]
    pub counts: Counts,
    /// What `inspect` says of the file; none of a long file, and of one that cannot be read as
    /// a recording.
    pub inspection: Option<Inspection>,
}
