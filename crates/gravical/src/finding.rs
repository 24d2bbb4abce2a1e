//! What is wrong, or merely worth knowing, in a recording: typed, with its
//! lines and with what was done about it.

mod kinds;

use serde::{Deserialize, Serialize};

pub use kinds::FindingKind;

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// Worth knowing; the result does not suffer.
    Note,
    /// The result may suffer, or an assumption was made that can be wrong.
    Warning,
}

/// One thing that was found, its lines, and what was done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// Kebab-case name of the case, stable, for scripts: `unit-mismatch`,
    /// `repeated-header`, `torn-line` …; all of them stand in
    /// `docs/recording.md`.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub kind: FindingKind,
    /// How much it matters.
    pub severity: Severity,
    /// What was found, with numbers, and what was done.
    pub message: String,
    /// The file, as it was given; null when it concerns all inputs together.
    #[serde(default)]
    pub file: Option<String>,
    /// Line ranges of the file, from 1, both ends included; the first
    /// [`LineSpans::KEPT`] of them.
    #[serde(default)]
    pub lines: Vec<[u64; 2]>,
    /// How many lines (or cells, or samples) are concerned in all.
    #[serde(default)]
    pub count: u64,
}

impl Finding {
    /// A finding that matters as its kind does.
    #[must_use]
    pub fn new(kind: FindingKind, message: impl Into<String>) -> Self {
        Finding {
            kind,
            severity: kind.severity(),
            message: message.into(),
            file: None,
            lines: Vec::new(),
            count: 0,
        }
    }

    /// A finding of a kind that matters little here.
    #[must_use]
    pub fn note(kind: FindingKind, message: impl Into<String>) -> Self {
        Finding {
            severity: Severity::Note,
            ..Self::new(kind, message)
        }
    }

    /// A finding of a kind that may spoil the result here.
    #[must_use]
    pub fn warning(kind: FindingKind, message: impl Into<String>) -> Self {
        Finding {
            severity: Severity::Warning,
            ..Self::new(kind, message)
        }
    }

    /// Adds the lines it concerns.
    #[must_use]
    pub fn at_lines(mut self, spans: &LineSpans) -> Self {
        self.lines = spans.spans.clone();
        self.count = spans.count;
        self
    }

    /// Adds how many lines, cells or samples it concerns.
    #[must_use]
    pub fn counting(mut self, count: u64) -> Self {
        self.count = count;
        self
    }

    /// Adds the file.
    #[must_use]
    pub fn in_file(mut self, file: &str) -> Self {
        self.file = Some(file.to_owned());
        self
    }
}

/// Line numbers gathered into ranges; memory stays flat on any file because
/// only the first ranges are kept, while all lines are counted.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LineSpans {
    spans: Vec<[u64; 2]>,
    last: u64,
    count: u64,
}

impl LineSpans {
    /// How many ranges are kept.
    pub const KEPT: usize = 64;

    /// Adds one line; lines come in rising order.
    pub fn push(&mut self, line: u64) {
        self.count += 1;
        let follows = line == self.last + 1 && self.last != 0;
        self.last = line;
        let kept = self.spans.len();
        match self.spans.last_mut() {
            Some(span) if follows && span[1] + 1 == line => span[1] = line,
            _ if kept < Self::KEPT => self.spans.push([line, line]),
            _ => {}
        }
    }

    /// Adds a range in which `count` lines are concerned; `from` comes after
    /// all lines so far.
    pub fn push_range(&mut self, from: u64, to: u64, count: u64) {
        self.push(from);
        self.count += count.saturating_sub(1);
        if let Some(span) = self.spans.last_mut()
            && span[1] == from
        {
            span[1] = to;
        }
        self.last = to;
    }

    /// How many lines were added.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// True when no line was added.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The first line.
    #[must_use]
    pub fn first(&self) -> Option<u64> {
        self.spans.first().map(|s| s[0])
    }

    /// "12, 40-43, …" for people: at most `most` ranges.
    #[must_use]
    pub fn display(&self, most: usize) -> String {
        format_spans(&self.spans, self.count, most)
    }
}

/// "lines 12, 40-43, …" of the ranges of a finding.
#[must_use]
pub fn format_spans(spans: &[[u64; 2]], count: u64, most: usize) -> String {
    let mut shown: u64 = 0;
    let mut parts = Vec::new();
    for &[from, to] in spans.iter().take(most) {
        shown += to - from + 1;
        parts.push(if from == to {
            from.to_string()
        } else {
            format!("{from}-{to}")
        });
    }
    if shown < count {
        parts.push("…".to_owned());
    }
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_join_and_all_are_counted() {
        let mut spans = LineSpans::default();
        for line in [1, 2, 3, 7, 9, 10] {
            spans.push(line);
        }
        assert_eq!(spans.display(9), "1-3, 7, 9-10");
        assert_eq!(spans.display(2), "1-3, 7, …");
        assert_eq!(spans.count(), 6);
        spans.push_range(11, 20, 9);
        spans.push(21);
        assert_eq!(spans.display(9), "1-3, 7, 9-21");
        assert_eq!(spans.count(), 16);
    }

    #[test]
    fn memory_stays_flat() {
        let mut spans = LineSpans::default();
        for line in 0..100_000 {
            spans.push(2 * line + 1);
        }
        assert_eq!(spans.count(), 100_000);
        assert_eq!(spans.spans.len(), LineSpans::KEPT);
    }
}
