//! Account of all lines of a file: rows, and lines that were set aside, with the reason. Of a binary
//! file, samples and blocks are counted instead.

use gravical_recording::{Aside, Reason};
use serde::{Deserialize, Serialize};

/// Counts of all lines: `lines = rows + Σ aside`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Lines of the file, the last one without a newline included.
    pub lines: u64,
    /// Lines that are rows of the recording.
    pub rows: u64,
    /// Reasons that occurred, in order, and lines for each.
    pub aside: Vec<(Reason, u64)>,
}

impl Ledger {
    /// Of a reading with these rows.
    pub(super) fn of(aside: &Aside, rows: usize) -> Self {
        let of = |(reason, lines): (&Reason, &gravical_recording::AsideLines)| {
            (*reason, lines.lines.count())
        };
        Ledger {
            lines: aside.lines as u64,
            rows: rows as u64,
            aside: aside.reasons.iter().map(of).collect(),
        }
    }

    /// Lines set aside for `reason`.
    #[must_use]
    pub fn lines_aside(&self, reason: Reason) -> u64 {
        let all = self.aside.iter();
        all.filter(|(r, _)| *r == reason).map(|(_, n)| n).sum()
    }

    /// True if every line is a row or was set aside.
    #[must_use]
    pub fn balances(&self) -> bool {
        self.lines == self.rows + self.aside.iter().map(|(_, n)| n).sum::<u64>()
    }

    /// The sum as text: `1020 lines = 1000 rows + 1 header + …`.
    #[must_use]
    pub fn sum(&self) -> String {
        let mut text = format!("{} lines = {} rows", self.lines, self.rows);
        for (reason, n) in &self.aside {
            text.push_str(&format!(" + {n} {}", reason.name()));
        }
        text
    }
}
