//! Findings, and their addition to errors that they may have caused.

use std::path::Path;

use crate::Error;
use crate::escape::path_word;

pub use gravical_recording::{Advice, Finding, FindingKind, LineSpans, Severity, format_spans};

/// `finding!(Kind, "text {}", value)`: a [`Finding`] that matters as its kind does.
macro_rules! finding {
    ($kind:ident, $($text:tt)+) => {
        $crate::finding::Finding::new($crate::finding::FindingKind::$kind, format!($($text)+))
    };
}
pub(crate) use finding;

/// Adds the findings of `kind` to an error: a file that was left out can be its cause.
pub(crate) fn after(error: Error, findings: &[Finding], kind: FindingKind) -> Error {
    let of_kind = findings.iter().filter(|f| f.kind == kind);
    of_kind.fold(error, |error, finding| {
        let file = finding.file.as_deref().unwrap_or("-");
        error.with_detail(&format!("; {file}: {}", finding.message))
    })
}

/// Adds to an error what reading `recordings` lost, each with its findings: too few poses can be too few rows.
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
