//! Events of a recording, for people and for scripts.

use gravical::inspect::Inspection;
use gravical::recording::{AccelScale, Finding};
use serde::Serialize;

use crate::device::no_rows::NoRows;

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
    NoRows {
        text: String,
        #[serde(skip)]
        why: NoRows,
    },
    /// The end.
    Ended(Box<Ended>),
}

/// Why rows are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// The port was lost: a cable was pulled, a hub was suspended.
    Unplugged,
    /// The clock of the board restarted.
    Reset,
    /// The board sent nothing for a while.
    Silent,
    /// The clock of the board jumped.
    Lost,
    /// The recording had ended and was continued.
    Continued,
}

/// Rows that are missing, why, and how many.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// The first cause.
    pub cause: Cause,
    /// Rows that are missing by the clock of the board; none where it does not tell.
    pub rows: Option<u64>,
    /// Time without a row, s: by the clock of the board, else by that of the computer.
    pub duration_s: f64,
    /// The clock of the board restarted.
    pub clock_restarts: bool,
    /// No row arrived after it.
    pub until_end: bool,
}

impl Gap {
    /// The line of the file, without its end.
    pub fn line(&self) -> String {
        let cause = match self.cause {
            Cause::Unplugged => "unplugged",
            Cause::Reset => "the board was reset",
            Cause::Silent => "the board sent nothing",
            Cause::Lost => "rows were lost on the way from the board",
            Cause::Continued => return "# gap: the recording was ended and continued".to_owned(),
        };
        let rows = match self.rows {
            _ if self.until_end => "no row arrived until the end".to_owned(),
            Some(1) => "1 row is missing".to_owned(),
            Some(n) => format!("{n} rows are missing"),
            None => "an unknown number of rows is missing".to_owned(),
        };
        let clock = if self.clock_restarts {
            ", the clock of the board restarts"
        } else {
            ""
        };
        format!("# gap: {cause}: {rows}, {:.1} s{clock}", self.duration_s)
    }
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
