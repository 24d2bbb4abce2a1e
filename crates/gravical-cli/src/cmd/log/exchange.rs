//! What passes between a recorder and what drives it.

use gravical::recording::ColumnsSpec;

use super::event::Event;
use crate::device::board::Wanted;

/// What is wanted of a recording.
#[derive(Default)]
pub struct Options {
    /// Name of the file, for messages.
    pub name: String,
    pub wanted: Wanted,
    pub columns: Option<ColumnsSpec>,
    /// The recording ends after so many rows.
    pub rows: Option<u64>,
    /// It ends this long after the first row, s, without pauses.
    pub duration_s: Option<f64>,
    /// Rows are waited for without end.
    pub wait: bool,
    /// Time of day at the time zero, s (UTC).
    pub day_s: f64,
}

/// What has to be done.
#[derive(Default)]
pub struct Output {
    /// Comes before the next line for the file.
    pub preamble: String,
    /// Whole lines for the file.
    pub text: Vec<u8>,
    /// Commands for the board.
    pub commands: String,
    pub events: Vec<Event>,
}

impl Output {
    /// A line for the file, without its end.
    pub fn line(&mut self, line: &[u8]) {
        let preamble = std::mem::take(&mut self.preamble);
        self.text.extend_from_slice(preamble.as_bytes());
        self.text.extend_from_slice(line);
        self.text.push(b'\n');
    }
}

/// A line as it was received.
pub struct Received {
    pub at_s: f64,
    pub text: Vec<u8>,
}
