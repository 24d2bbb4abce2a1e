//! Every line of a file is accounted for: read, or set aside for a reason.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::finding::{Finding, FindingKind, LineSpans};

/// Why a line gave no row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Aside {
    /// The line that names the columns.
    Header,
    /// Anything before the header.
    Metadata,
    /// A line that starts with `#`, `%` or `//` among the data.
    Comment,
    /// A comment that says `# gap: …`: the logger names rows that it could not get.
    NamedGap,
    /// Nothing in it, or only delimiters.
    Blank,
    /// Blank lines between rows all through the file, every so many rows.
    RegularBlank,
    /// The header once more, in the middle.
    RepeatedHeader,
    /// A row of another sensor than the one that is read.
    OtherSensor,
    /// Fewer fields than the others: half-written.
    TornLine,
    /// More fields than the others: two lines run together.
    TooManyFields,
    /// A channel that is not a number.
    NotANumber,
    /// A row of zeros in every channel at the end of the file: never written.
    ZeroTail,
}

impl Aside {
    /// All reasons, in the order in which they are shown.
    pub const ALL: [Aside; 12] = [
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
    ];

    /// No sample follows its predecessor across such a line.
    #[must_use]
    pub fn parts(self) -> bool {
        matches!(self, Aside::NamedGap | Aside::Blank | Aside::RepeatedHeader)
    }

    /// The finding that such lines are; the header itself is none.
    #[must_use]
    pub fn finding_kind(self) -> Option<FindingKind> {
        Some(match self {
            Aside::Header => return None,
            Aside::Metadata => FindingKind::MetadataLines,
            Aside::Comment => FindingKind::CommentLines,
            Aside::NamedGap => FindingKind::NamedGap,
            Aside::Blank => FindingKind::BlankRows,
            Aside::RegularBlank => FindingKind::RegularBlankRows,
            Aside::OtherSensor => FindingKind::OtherSensor,
            Aside::RepeatedHeader => FindingKind::RepeatedHeader,
            Aside::TornLine => FindingKind::TornLine,
            Aside::TooManyFields => FindingKind::TooManyFields,
            Aside::NotANumber => FindingKind::NotANumber,
            Aside::ZeroTail => FindingKind::ZeroTail,
        })
    }

    /// Name for people.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.finding_kind().map_or("header", FindingKind::name)
    }

    fn meaning(self) -> &'static str {
        match self {
            Aside::Header => "names the columns",
            Aside::Metadata => "before the header; kept out of the data",
            Aside::Comment => "comment; kept out of the data",
            Aside::NamedGap => {
                "the logger names rows that it could not get; taken as a break between segments"
            }
            Aside::Blank => {
                "blank; a break between segments, unless it is a single line and the clock goes on"
            }
            Aside::RegularBlank => {
                "blank, regularly between the rows (a line end written twice?); they part nothing"
            }
            Aside::OtherSensor => "rows of another sensor; not read",
            Aside::RepeatedHeader => {
                "the header once more; kept out of the data, and a break unless the clock goes on"
            }
            Aside::TornLine => "fewer fields than the other rows (half-written); set aside",
            Aside::TooManyFields => {
                "more fields than the other rows (lines run together?); set aside"
            }
            Aside::NotANumber => "a channel that is not a number; set aside",
            Aside::ZeroTail => {
                "all channels zero up to the end of the file (never written); set aside"
            }
        }
    }
}

/// The sum that [`crate::recording`] owes its user: `lines = rows + Σ aside`.
#[derive(Debug, Clone, Default)]
pub struct Ledger {
    /// Lines of the file, the last one without a newline included.
    pub lines: u64,
    /// Lines that became rows of the recording.
    pub rows: u64,
    aside: [LineSpans; Aside::ALL.len()],
    /// The first offending text of each reason, shortened.
    examples: [Option<String>; Aside::ALL.len()],
}

impl Ledger {
    /// Books a line that became a row.
    #[inline]
    pub fn row(&mut self) {
        self.lines += 1;
        self.rows += 1;
    }

    /// Books a line that did not.
    pub fn aside(&mut self, reason: Aside, line: u64, text: &[u8]) {
        self.lines += 1;
        let i = reason as usize;
        self.aside[i].push(line);
        if self.examples[i].is_none() {
            let shown: String = String::from_utf8_lossy(text).chars().take(60).collect();
            self.examples[i] = Some(shown);
        }
    }

    /// Moves rows that were booked as read to a reason (a tail of zeros is
    /// only known at the end).
    pub fn move_rows_aside(&mut self, reason: Aside, lines: impl Iterator<Item = u64>) {
        for line in lines {
            self.rows -= 1;
            self.aside[reason as usize].push(line);
        }
    }

    /// Lines set aside for `reason`.
    #[must_use]
    pub fn lines_aside(&self, reason: Aside) -> &LineSpans {
        &self.aside[reason as usize]
    }

    /// Reasons that occurred with their number of lines.
    pub fn reasons(&self) -> impl Iterator<Item = (Aside, u64)> + '_ {
        Aside::ALL
            .into_iter()
            .map(|a| (a, self.aside[a as usize].count()))
            .filter(|(_, n)| *n > 0)
    }

    /// True when every line is either a row or set aside.
    #[must_use]
    pub fn balances(&self) -> bool {
        self.lines == self.rows + self.reasons().map(|(_, n)| n).sum::<u64>()
    }

    /// The sum for people: `1020 lines = 1000 rows + 1 header + …`.
    #[must_use]
    pub fn sum(&self) -> String {
        let mut text = format!("{} lines = {} rows", self.lines, self.rows);
        for (reason, n) in self.reasons() {
            text.push_str(&format!(" + {n} {}", reason.name()));
        }
        text
    }

    /// Findings for what was set aside (the header itself is none).
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        self.reasons()
            .filter_map(|(reason, n)| {
                let kind = reason.finding_kind()?;
                let example = match (&self.examples[reason as usize], reason) {
                    (
                        Some(text),
                        Aside::NamedGap
                        | Aside::TornLine
                        | Aside::TooManyFields
                        | Aside::NotANumber,
                    ) => {
                        format!(", first: \"{text}\"")
                    }
                    _ => String::new(),
                };
                let lines = if n == 1 { "line" } else { "lines" };
                let message = format!("{n} {lines}: {}{example}", reason.meaning());
                Some(Finding::new(kind, message).at_lines(self.lines_aside(reason)))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_balances_and_names_its_parts() {
        let mut ledger = Ledger::default();
        ledger.aside(Aside::Header, 1, b"a,b");
        ledger.row();
        ledger.row();
        ledger.aside(Aside::TornLine, 4, b"1,");
        assert!(ledger.balances());
        assert_eq!(ledger.sum(), "4 lines = 2 rows + 1 header + 1 torn-line");
        ledger.move_rows_aside(Aside::ZeroTail, [3].into_iter());
        assert!(ledger.balances());
        assert_eq!(ledger.findings().len(), 2);
    }
}
