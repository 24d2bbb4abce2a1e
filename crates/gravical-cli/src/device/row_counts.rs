//! How many rows and lines went where.

use serde::Serialize;

/// Counts of lines and rows. All rows that arrived: [`received`](Self::received) = stored +
/// unstored + paused + before the start + after the end + other settings + waiting for
/// the disk.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct RowCounts {
    /// Rows that arrived from the board.
    pub received: u64,
    /// Rows in the file.
    pub stored: u64,
    /// Rows that arrived during a pause.
    pub paused: u64,
    /// Rows that arrived before the recording began.
    pub before_start: u64,
    /// Rows that arrived after the recording was complete, or had failed.
    pub after_end: u64,
    /// Rows that arrived while the board had other settings: in a named gap.
    pub other_settings: u64,
    /// Rows that could not be written: in a named gap.
    pub unstored: u64,
    /// Rows that did not arrive, by the board's clock: in a named gap.
    pub missing: u64,
    /// Named gaps.
    pub gaps: u64,
    /// Gaps in which rows are missing, or may be: their number may not be known.
    pub incomplete: u64,
    /// Rejected lines; they are in a file beside the recording.
    pub rejected: u64,
    /// Rejected lines that could not be written.
    pub rejected_unstored: u64,
    /// Lines of the board that begin with `#`.
    pub comments: u64,
}

impl RowCounts {
    /// Every row that arrived is counted once; `waiting` for the disk.
    #[cfg(test)]
    pub fn balances(&self, waiting: u64) -> bool {
        self.received
            == self.stored
                + self.paused
                + self.before_start
                + self.after_end
                + self.other_settings
                + self.unstored
                + waiting
    }

    /// Rows in named gaps.
    pub fn in_gaps(&self) -> u64 {
        self.missing + self.unstored + self.other_settings
    }
}
