//! Account of all lines of a file: rows, and lines that were set aside, with the reason. Of a binary
//! file every sample is a line, and every block that is skipped.

use serde::{Deserialize, Serialize};

use crate::finding::{Finding, FindingKind, LineSpans};

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

    /// Kind of the finding about such lines; those that belong to every good file have none.
    #[must_use]
    pub fn finding_kind(self) -> Option<FindingKind> {
        Some(match self {
            Aside::Header
            | Aside::Metadata
            | Aside::Comment
            | Aside::RegularBlank
            | Aside::Continuation
            | Aside::ErasedBlock => return None,
            Aside::NamedGap => FindingKind::NamedGap,
            Aside::Blank => FindingKind::BlankRows,
            Aside::OtherSensor => FindingKind::OtherSensor,
            Aside::RepeatedHeader => FindingKind::RepeatedHeader,
            Aside::TornLine => FindingKind::TornLine,
            Aside::TooManyFields => FindingKind::TooManyFields,
            Aside::NotANumber => FindingKind::NotANumber,
            Aside::ZeroTail => FindingKind::ZeroRows,
            Aside::Hung => FindingKind::SensorHung,
            Aside::Shifted => FindingKind::ShiftedColumns,
            Aside::CorruptBlock => FindingKind::CorruptBlock,
            Aside::RepeatedBlock => FindingKind::RepeatedBlock,
            Aside::LateBlock => FindingKind::LateBlock,
        })
    }

    /// True for a block of a binary file.
    fn is_block(self) -> bool {
        matches!(
            self,
            Aside::CorruptBlock | Aside::RepeatedBlock | Aside::LateBlock | Aside::ErasedBlock
        )
    }

    /// Name for messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Aside::Metadata => "metadata-lines",
            Aside::Comment => "comment-lines",
            Aside::RegularBlank => "regular-blank-rows",
            Aside::ErasedBlock => "erased-block",
            Aside::Continuation => "continuation-lines",
            _ => self.finding_kind().map_or("header", FindingKind::name),
        }
    }

    fn meaning(self) -> &'static str {
        match self {
            Aside::Header => "names the columns",
            Aside::Metadata => "before the header; kept out of the data",
            Aside::Comment => "comment; kept out of the data",
            Aside::NamedGap => {
                "the logger reports missing rows; treated as a break between segments"
            }
            Aside::Blank => {
                "blank; a break between segments, unless it is a single line and the clock continues"
            }
            Aside::RegularBlank => {
                "blank, regularly between the rows (a line end written twice?); not treated as breaks"
            }
            Aside::OtherSensor => "rows of another sensor; not read",
            Aside::RepeatedHeader => {
                "the header repeated; kept out of the data, and a break unless the clock continues"
            }
            Aside::TornLine => "fewer fields than the other rows (half-written); set aside",
            Aside::TooManyFields => {
                "more fields than the other rows (lines run together?); set aside"
            }
            Aside::NotANumber => "a channel that is not a number; set aside",
            Aside::ZeroTail => {
                "all channels zero up to the end of the file (never written); set aside"
            }
            Aside::Continuation => "continues the row above",
            Aside::Hung => "all channels repeat for longer than noise allows; set aside",
            Aside::Shifted => "the values stand in the columns of others; set aside",
            Aside::CorruptBlock => "damaged; skipped",
            Aside::RepeatedBlock => "repeating the one before; skipped",
            Aside::LateBlock => "earlier than the one before (repeated or out of order); skipped",
            Aside::ErasedBlock => "never written; skipped",
        }
    }
}

/// True for a line that begins with `#`, `%` or `//`.
pub(crate) fn is_comment(text: &[u8]) -> bool {
    [&b"#"[..], b"%", b"//"]
        .iter()
        .any(|mark| text.starts_with(mark))
}

/// Counts of all lines: `lines = rows + Σ aside`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Lines of the file, the last one without a newline included.
    pub lines: u64,
    /// Lines that are rows of the recording.
    pub rows: u64,
    aside: [LineSpans; Aside::ALL.len()],
    /// For each reason the first text, shortened.
    examples: [Option<String>; Aside::ALL.len()],
    /// A line above the header is no comment.
    bare_metadata: bool,
}

impl Ledger {
    /// Counts a row.
    #[inline]
    pub fn row(&mut self) {
        self.lines += 1;
        self.rows += 1;
    }

    /// Counts a line that is not a row.
    pub fn aside(&mut self, reason: Aside, line: u64, text: &[u8]) {
        self.lines += 1;
        let i = reason as usize;
        self.aside[i].push(line);
        self.bare_metadata |= reason == Aside::Metadata && !is_comment(text.trim_ascii_start());
        if self.examples[i].is_none() {
            let shown: String = String::from_utf8_lossy(text).chars().take(60).collect();
            self.examples[i] = Some(shown);
        }
    }

    /// The lines of a reason, and the text of the first.
    pub(super) fn set(&mut self, reason: Aside, lines: &LineSpans, first: &str) {
        self.aside[reason as usize] = lines.clone();
        self.examples[reason as usize] = Some(first.to_owned());
    }

    /// Lines set aside for `reason`.
    #[must_use]
    pub fn lines_aside(&self, reason: Aside) -> &LineSpans {
        &self.aside[reason as usize]
    }

    /// Reasons that occurred, and their numbers of lines.
    pub fn reasons(&self) -> impl Iterator<Item = (Aside, u64)> + '_ {
        Aside::ALL
            .into_iter()
            .map(|a| (a, self.aside[a as usize].count()))
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

    /// Findings about lines set aside (none for the header and for comments above it).
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        self.reasons()
            .filter(|(reason, _)| *reason != Aside::Metadata || self.bare_metadata)
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
                    (Some(text), _) if reason.is_block() => format!(", first: {text}"),
                    _ => String::new(),
                };
                let noun = if reason.is_block() { "block" } else { "line" };
                let plural = if n == 1 { "" } else { "s" };
                let message = format!("{n} {noun}{plural}: {}{example}", reason.meaning());
                Some(Finding::new(kind, message).at_lines(self.lines_aside(reason)))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_balance_and_are_listed() {
        let mut ledger = Ledger::default();
        ledger.aside(Aside::Header, 1, b"a,b");
        ledger.row();
        ledger.row();
        ledger.aside(Aside::TornLine, 4, b"1,");
        assert!(ledger.balances());
        assert_eq!(ledger.sum(), "4 lines = 2 rows + 1 header + 1 torn-line");
        // Metadata is counted, and is nothing that anybody would have to act on.
        ledger.aside(Aside::Metadata, 5, b"# a comment");
        assert_eq!(ledger.findings().len(), 1);
    }
}
