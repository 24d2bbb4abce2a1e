//! A recording that grows.

use std::path::Path;

use gravical_recording::{self as new, Follow};
pub use gravical_recording::{Form, LinesRead};

use super::reading::of_judged;
use super::text_options::text_options;
use super::{ReadOptions, Recording};
use crate::Result;

/// Reads a recording while it grows, and holds its last rows.
pub struct Following {
    name: String,
    follow: Follow,
}

impl Following {
    /// `name` is used in messages; `max_rows`: so many rows, up to twice as many, are held.
    #[must_use]
    pub fn new(name: &str, options: &ReadOptions, max_rows: usize) -> Self {
        let file = Path::new(name).file_name().unwrap_or_default();
        let options = text_options(options, false);
        Following {
            name: name.to_owned(),
            follow: Follow::new(&file.to_string_lossy(), options, max_rows),
        }
    }

    /// Notes what becomes of each line, for [`take_lines`](Self::take_lines).
    #[must_use]
    pub fn noting_lines(mut self) -> Self {
        self.follow = self.follow.noting_lines();
        self
    }

    /// Takes the next bytes and returns the rows that they complete; none before the format is
    /// known.
    ///
    /// # Errors
    ///
    /// Those of reading, once enough lines show that it is no recording.
    pub fn push(&mut self, bytes: &[u8]) -> Result<Vec<new::Sample>> {
        let read = self.follow.push(bytes);
        read.map_err(|e| e.in_file(Path::new(&self.name)))
    }

    /// The rows that are held up to this line, judged as a file; `None` before the format is known.
    ///
    /// # Errors
    ///
    /// Those of reading.
    #[must_use]
    pub fn recording(&self, last_line: u32) -> Option<Result<Recording>> {
        let judged = self.follow.recording(last_line)?;
        let recording = judged.map(|judged| of_judged(judged, &self.name));
        Some(recording.map_err(|e| e.in_file(Path::new(&self.name))))
    }

    /// Detects the format from the lines so far if they hold so many rows: because the recording ends,
    /// or its sensor is slow.
    ///
    /// # Errors
    ///
    /// Those of reading: so far the lines are no recording.
    pub fn settle(&mut self, min_rows: usize) -> Result<Vec<new::Sample>> {
        let settled = self.follow.settle(min_rows);
        settled.map_err(|e| e.in_file(Path::new(&self.name)))
    }

    /// What became of the lines that were read since the last call; nothing before the format is
    /// known.
    pub fn take_lines(&mut self) -> LinesRead {
        self.follow.take_lines()
    }

    /// How the rows are written, once that is known.
    #[must_use]
    pub fn form(&self) -> Option<Form> {
        self.follow.form()
    }

    /// The board says that it sends calibrated values.
    pub(crate) fn is_calibrated_by_board(&self) -> bool {
        let board = self.follow.board();
        board.is_some_and(|board| board.is_calibrated())
    }
}
