//! Ranges of lines.

use serde::{Deserialize, Serialize};

/// Line numbers gathered into ranges; memory stays flat on any file because
/// only the first ranges are kept, while all lines are counted.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LineSpans {
    spans: Vec<[u64; 2]>,
    count: u64,
}

impl LineSpans {
    /// How many ranges are kept.
    pub const KEPT: usize = 64;

    /// Adds one line; lines come in rising order.
    pub fn push(&mut self, line: u64) {
        self.push_range(line, line, 1);
    }

    /// Adds a range in which `count` lines are concerned; `from` comes after
    /// all lines so far.
    pub fn push_range(&mut self, from: u64, to: u64, count: u64) {
        self.count += count;
        let kept = self.spans.len();
        match self.spans.last_mut() {
            Some(span) if span[1] + 1 == from => span[1] = to,
            _ if kept < Self::KEPT => self.spans.push([from, to]),
            _ => {}
        }
    }

    /// Adds lines that come after all so far.
    pub fn append(&mut self, later: &LineSpans) {
        for [from, to] in &later.spans {
            self.push_range(*from, *to, 0);
        }
        self.count += later.count;
    }

    /// How many lines were added.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// True when no line was added.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The first ranges, both ends included.
    pub fn ranges(&self) -> &[[u64; 2]] {
        &self.spans
    }
}

impl FromIterator<u64> for LineSpans {
    fn from_iter<I: IntoIterator<Item = u64>>(lines: I) -> Self {
        let mut spans = LineSpans::default();
        lines.into_iter().for_each(|line| spans.push(line));
        spans
    }
}

/// "lines 12, 40-43, …" of the ranges of a finding.
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
    if shown < count || spans.len() > most {
        parts.push("…".to_owned());
    }
    parts.join(", ")
}
