//! Account of all lines of a file: rows, and lines that were set aside, with the reason. Of a binary
//! file every sample is a line, and every block that is skipped.

use serde::{Deserialize, Serialize};

/// Why a line is not a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Aside {
    /// The line that names the columns.
    Header,
    /// Anything before the header.
    Metadata,
    /// A line that starts with `#`, `%` or `//` among the data.
    Comment,
    /// A comment `# gap: …` in which the logger reports missing rows.
    NamedGap,
    /// Empty, or only delimiters.
    Blank,
    /// Blank lines at regular intervals between rows.
    RegularBlank,
    /// The header repeated among the rows.
    RepeatedHeader,
    /// A row of another sensor.
    OtherSensor,
    /// Fewer fields than the other rows: half-written.
    TornLine,
    /// More fields than the other rows: two lines run together.
    TooManyFields,
    /// The field of a channel is not a number.
    NotANumber,
    /// A row of zeros in every channel: the sensor was not read.
    ZeroTail,
    /// A further line of a row that is written in several.
    Continuation,
    /// All channels repeat for longer than noise allows: sensor or bus hung.
    Hung,
    /// The values stand in the columns of others.
    Shifted,
    /// A block of a binary file that cannot be decoded.
    CorruptBlock,
    /// A block that repeats the one before.
    RepeatedBlock,
    /// A block that is earlier than the one before.
    LateBlock,
    /// A block that was never written.
    ErasedBlock,
}

impl Aside {
    /// All reasons, in the order of the output.
    pub const ALL: [Aside; 19] = [
        Aside::Header,
        Aside::Metadata,
        Aside::Comment,
        Aside::NamedGap,
        Aside::Blank,
        Aside::RegularBlank,
        Aside::RepeatedHeader,
        Aside::OtherSensor,
        Aside::TornLine,
        Aside::TooManyFields,
        Aside::NotANumber,
        Aside::ZeroTail,
        Aside::Continuation,
        Aside::Hung,
        Aside::Shifted,
        Aside::CorruptBlock,
        Aside::RepeatedBlock,
        Aside::LateBlock,
        Aside::ErasedBlock,
    ];

    /// True if a row after such a line does not continue the row before.
    #[must_use]
    pub fn is_break(self) -> bool {
        matches!(self, Aside::NamedGap | Aside::Blank | Aside::RepeatedHeader)
    }

    /// Name for messages: that of the finding about such lines, where there is one.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Aside::Header => "header",
            Aside::Metadata => "metadata-lines",
            Aside::Comment => "comment-lines",
            Aside::NamedGap => "named-gap",
            Aside::Blank => "blank-rows",
            Aside::RegularBlank => "regular-blank-rows",
            Aside::RepeatedHeader => "repeated-header",
            Aside::OtherSensor => "other-sensor",
            Aside::TornLine => "torn-line",
            Aside::TooManyFields => "too-many-fields",
            Aside::NotANumber => "not-a-number",
            Aside::ZeroTail => "zero-rows",
            Aside::Continuation => "continuation-lines",
            Aside::Hung => "sensor-hung",
            Aside::Shifted => "shifted-columns",
            Aside::CorruptBlock => "corrupt-block",
            Aside::RepeatedBlock => "repeated-block",
            Aside::LateBlock => "late-block",
            Aside::ErasedBlock => "erased-block",
        }
    }
}

/// Counts of all lines: `lines = rows + Σ aside`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Lines of the file, the last one without a newline included.
    pub lines: u64,
    /// Lines that are rows of the recording.
    pub rows: u64,
    /// Lines for each reason.
    aside: [u64; Aside::ALL.len()],
}

impl Ledger {
    /// Lines set aside for `reason`.
    #[must_use]
    pub fn lines_aside(&self, reason: Aside) -> u64 {
        self.aside[reason as usize]
    }

    /// Sets the number of lines of a reason.
    pub(super) fn set(&mut self, reason: Aside, lines: u64) {
        self.aside[reason as usize] = lines;
    }

    /// Reasons that occurred, and their numbers of lines.
    pub fn reasons(&self) -> impl Iterator<Item = (Aside, u64)> + '_ {
        Aside::ALL
            .into_iter()
            .map(|a| (a, self.aside[a as usize]))
            .filter(|(_, n)| *n > 0)
    }

    /// True if every line is a row or was set aside.
    #[must_use]
    pub fn balances(&self) -> bool {
        self.lines == self.rows + self.reasons().map(|(_, n)| n).sum::<u64>()
    }

    /// The sum as text: `1020 lines = 1000 rows + 1 header + …`.
    #[must_use]
    pub fn sum(&self) -> String {
        let mut text = format!("{} lines = {} rows", self.lines, self.rows);
        for (reason, n) in self.reasons() {
            text.push_str(&format!(" + {n} {}", reason.name()));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_balance_and_are_listed() {
        let mut ledger = Ledger {
            lines: 4,
            rows: 2,
            ..Ledger::default()
        };
        ledger.set(Aside::Header, 1);
        ledger.set(Aside::TornLine, 1);
        assert!(ledger.balances());
        assert_eq!(ledger.sum(), "4 lines = 2 rows + 1 header + 1 torn-line");
    }
}
