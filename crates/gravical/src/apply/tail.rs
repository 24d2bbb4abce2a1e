//! Rows of zeros are held back: only the end of the recording tells whether
//! they were ever measured.

use crate::recording::LineSpans;

/// Output text that is held back at most.
const LIMIT: usize = 4 << 20;

/// Rows of zeros at what may be the end.
pub(super) struct Tail {
    /// What they and the blank lines among them become, when they are data.
    pub text: Vec<u8>,
    /// Line and time stamp of each.
    pub rows: Vec<(u64, f64)>,
    limit: usize,
    /// Rows of zeros that were written because they were too many to hold.
    pub given_up: LineSpans,
}

impl Default for Tail {
    fn default() -> Self {
        Tail {
            text: Vec::new(),
            rows: Vec::new(),
            limit: LIMIT,
            given_up: LineSpans::default(),
        }
    }
}

impl Tail {
    #[cfg(test)]
    pub fn set_limit(&mut self, limit: usize) {
        self.limit = limit;
    }

    /// True when the next row of zeros is to be held back.
    pub fn holds(&self) -> bool {
        self.given_up.is_empty()
    }

    /// True while nothing is held back and nothing was given up.
    #[inline]
    pub fn is_clear(&self) -> bool {
        self.rows.is_empty() && self.given_up.is_empty()
    }

    pub fn is_full(&self) -> bool {
        self.text.len() >= self.limit
    }

    /// Rows that will be written after all: they are too many to wait longer.
    pub fn give_up(&mut self) {
        for (line, _) in &self.rows {
            self.given_up.push(*line);
        }
    }
}
