//! What is wanted of a recording, and what a recorder has done by others.

use crate::device::board::Wanted;
use crate::device::event::Event;

/// What is wanted of a recording.
#[derive(Debug, Clone)]
pub struct Options {
    /// Settings that the board has to have.
    pub wanted: Wanted,
    /// It ends with so many rows; none: when it is told to.
    pub rows: Option<u64>,
    /// It ends after so long, s, pauses left out; none: when it is told to.
    pub duration_s: Option<f64>,
    /// A silent board is waited for without end.
    pub wait: bool,
    /// Lines behind `#` at the head of the file.
    pub preamble: Vec<String>,
    /// The header of the file that is continued.
    pub continues: Option<Vec<u8>>,
    /// Bits a second of text; a port is opened so.
    pub baud: u32,
}

/// Bits a second of the firmware's text.
pub const TEXT_BAUD: u32 = 115_200;

impl Default for Options {
    fn default() -> Self {
        Options {
            wanted: Wanted::default(),
            rows: None,
            duration_s: None,
            wait: false,
            preamble: Vec::new(),
            continues: None,
            baud: TEXT_BAUD,
        }
    }
}

/// What has to be done.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Bytes for the board.
    Send(Vec<u8>),
    /// When all that was sent has left, the port has to be set to so many bits a second.
    /// Answer with [`Recorder::bytes`] for what came at the rate before, then with
    /// [`Recorder::baud_is_set`].
    Baud(u32),
    /// What is written has to be safe on the disk.
    Sync,
    /// Somebody may want to know.
    Tell(Event),
}
