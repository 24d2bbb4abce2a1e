//! What is wrong, or merely worth knowing, in a recording: typed, with its
//! lines and with what was done about it.

mod kinds;

use serde::{Deserialize, Serialize};

use crate::advice::{Advice, with_options};
use crate::spans::LineSpans;

pub use kinds::{FindingKind, Severity};

/// One thing that was found, its lines, and what was done.
#[must_use = "a finding is told"]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// Kebab-case name of the case, stable, for scripts: `unit-mismatch`,
    /// `repeated-header`, `torn-line` …; `docs/recording.md` lists all.
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub kind: FindingKind,
    /// How much it matters.
    pub severity: Severity,
    /// What was found, with numbers, and what was done.
    pub message: String,
    /// Options that help, or that are better left out, as the message says.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub options: Vec<Advice>,
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
    pub fn new(kind: FindingKind, message: impl Into<String>) -> Self {
        Finding {
            kind,
            severity: kind.severity(),
            message: message.into(),
            options: Vec::new(),
            file: None,
            lines: Vec::new(),
            count: 0,
        }
    }

    /// A finding of a kind that matters little here.
    pub fn note(kind: FindingKind, message: impl Into<String>) -> Self {
        Finding {
            severity: Severity::Note,
            ..Self::new(kind, message)
        }
    }

    /// Adds an option that helps, or that is better left out; the value as of [`Advice`].
    pub fn advise(mut self, option: impl Into<String>, value: impl Into<String>) -> Self {
        self.options.push(Advice::new(option, value));
        self
    }

    /// The message with its options, in the words of a surface.
    pub fn worded(&self, word: impl Fn(&Advice) -> String) -> String {
        with_options(&self.message, &self.options, word)
    }

    /// Adds the lines it concerns.
    pub fn at_lines(mut self, spans: &LineSpans) -> Self {
        self.lines = spans.ranges().to_vec();
        self.count = spans.count();
        self
    }

    /// Adds how many lines, cells or samples it concerns.
    pub fn counting(mut self, count: u64) -> Self {
        self.count = count;
        self
    }

    /// Adds the file.
    pub fn in_file(mut self, file: &str) -> Self {
        self.file = Some(file.to_owned());
        self
    }
}
