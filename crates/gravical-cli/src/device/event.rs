//! What happens while it records, for people and for scripts.

use serde::Serialize;

use super::account::Account;
use super::gap::Gap;
use super::item::Reason;
use super::live::Status;

/// One thing that happened. As JSON an object a line, `type` says which.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Event {
    /// A port is open; most boards reset on that.
    Opened {
        /// Its name.
        port: String,
        /// What is behind it, as far as it says.
        device: Option<String>,
    },
    /// Other programs have the port open, too: what they read does not come here.
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
        /// The commands, separated by blanks.
        text: String,
    },
    /// The port is set to another rate.
    Speed {
        /// Bits a second.
        baud: u32,
    },
    /// Something that is asked for does not work as one may think, or needs a look.
    Warning {
        /// What, and what to do.
        text: String,
    },
    /// A line of the board behind `#`.
    Board {
        /// The line.
        text: String,
    },
    /// The recording begins.
    Started {
        /// The header.
        columns: String,
    },
    /// How it goes; about once a second.
    Status {
        /// Rows stored.
        rows: u64,
        /// Since the start, pauses left out, s.
        elapsed_s: f64,
        /// Nothing is stored.
        paused: bool,
        /// Lines rejected so far.
        rejected: u64,
        /// What the stream looks like.
        #[serde(flatten)]
        live: Status,
    },
    /// Paused.
    Paused,
    /// It goes on.
    Resumed,
    /// A line is no row. Told for the first ten.
    Rejected {
        /// Why.
        reason: Reason,
        /// The line, what is no UTF-8 replaced.
        text: String,
    },
    /// Rows are missing, and the recording says so.
    Gap(Gap),
    /// The port is gone.
    Lost {
        /// What the system says.
        text: String,
    },
    /// Nothing comes any more.
    Silent {
        /// For so long, s.
        duration_s: f64,
    },
    /// The disk does not take the rows.
    DiskFailed {
        /// What the system says.
        text: String,
    },
    /// It does again.
    DiskRecovered,
    /// The end.
    Ended {
        /// The file.
        file: String,
        /// Rejected lines are here.
        rejected_file: Option<String>,
        /// Why it ended.
        reason: End,
        /// Since the start, pauses left out, s.
        elapsed_s: f64,
        /// Where every line went.
        #[serde(flatten)]
        account: Account,
    },
}

/// Why it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// All the rows that were asked for.
    Rows,
    /// The time that was asked for.
    Duration,
    /// The user ended it.
    User,
}
