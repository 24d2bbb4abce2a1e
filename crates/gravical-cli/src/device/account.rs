//! Where every line went.

use serde::Serialize;

/// Counts of lines and rows. All rows that came: [`received`](Self::received) = stored +
/// unstored + paused + before the start + after the end + other settings + waiting for
/// the disk. All rows that the board sent as frames, while it was not reset: received +
/// missing + lost + rejected − fragments.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Account {
    /// Rows of eight numbers that came from the board.
    pub received: u64,
    /// Rows that are in the file.
    pub stored: u64,
    /// Rows that came while it was paused.
    pub paused: u64,
    /// Rows that came before the recording began.
    pub before_start: u64,
    /// Rows that came after all that was wanted had come, or when it could not go on.
    pub after_end: u64,
    /// Rows that came while the board had other settings: in a named gap.
    pub other_settings: u64,
    /// Rows that the disk did not take: in a named gap.
    pub unstored: u64,
    /// Rows that never came, by the board's clock: in a named gap.
    pub missing: u64,
    /// Rows that never came, by the numbers of binary frames, and are in no named gap:
    /// too few of them, or it was paused.
    pub lost: u64,
    /// Gaps that have a name.
    pub gaps: u64,
    /// Those of them in which rows are missing, or may be: their number may not be known.
    pub incomplete: u64,
    /// Lines that are no row; kept beside the recording.
    pub rejected: u64,
    /// Rejected pieces of binary frames that stand for no row: the numbers of the frames
    /// show fewer rows missing there than pieces came.
    pub fragments: u64,
    /// Rejected lines that the disk did not take.
    pub rejected_unstored: u64,
    /// Lines of the board behind `#`.
    pub comments: u64,
}

impl Account {
    /// Every row that came is somewhere; `waiting`: for the disk.
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

    /// Rows that are in named gaps.
    pub fn in_gaps(&self) -> u64 {
        self.missing + self.unstored + self.other_settings
    }
}
