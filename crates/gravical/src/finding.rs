//! What is wrong, or merely worth knowing, in a recording: typed, with its
//! lines and with what was done about it.

mod kinds;

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::escape::path_word;

pub use gravical_recording::{LineSpans, format_spans};
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
        self.lines = spans.ranges().to_vec();
        self.count = spans.count();
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

/// `finding!(Kind, "text {}", value)`: a [`Finding`] that matters as its kind does.
macro_rules! finding {
    ($kind:ident, $($text:tt)+) => {
        $crate::finding::Finding::new($crate::finding::FindingKind::$kind, format!($($text)+))
    };
}
pub(crate) use finding;

impl From<gravical_recording::Note> for Finding {
    fn from(note: gravical_recording::Note) -> Self {
        let kind = FindingKind::of_name(note.kind.name()).unwrap_or(FindingKind::Other);
        Finding::new(kind, note.message).at_lines(&note.lines)
    }
}

/// Adds the findings of `kind` to an error: a file that was left out can be its cause.
#[must_use]
pub(crate) fn after(error: Error, findings: &[Finding], kind: FindingKind) -> Error {
    let of_kind = findings.iter().filter(|f| f.kind == kind);
    of_kind.fold(error, |error, finding| {
        let file = finding.file.as_deref().unwrap_or("-");
        error.with_detail(&format!("; {file}: {}", finding.message))
    })
}

/// Adds to an error what reading `recordings` lost, each with its findings: too few poses can be too few rows.
#[must_use]
pub(crate) fn after_losses<'a>(
    error: Error,
    recordings: impl IntoIterator<Item = (&'a str, &'a [Finding])>,
) -> Error {
    let losses = |findings: &[Finding]| -> Vec<String> {
        let lost = findings.iter().filter(|f| f.kind.is_loss());
        let said = |f: &Finding| match f.count {
            0 => f.kind.to_string(),
            n => format!("{n} {}", f.kind),
        };
        lost.map(said).collect()
    };
    let mut damaged = recordings
        .into_iter()
        .map(|(name, all)| (name, losses(all)));
    let Some((name, losses)) = damaged.find(|(_, losses)| !losses.is_empty()) else {
        return error;
    };
    let file = path_word(Path::new(name));
    let look = format!("`gravical inspect {file}` shows the damaged lines");
    let hint = match error.hint() {
        Some(hint) => format!("{look}; {hint}"),
        None => look,
    };
    let losses = losses.join(", ");
    error
        .with_detail(&format!("; reading {name} lost samples: {losses}"))
        .with_hint(hint)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_note_on_a_recording_is_a_finding() {
        for kind in gravical_recording::NoteKind::ALL {
            assert!(
                FindingKind::of_name(kind.name()).is_some(),
                "{}",
                kind.name()
            );
        }
    }
}
