//! Findings, and their addition to errors that they may have caused.

mod cases;

use crate::Error;

pub use cases::{Case, LeftOut};

pub use gravical_recording::finding::{Case as RecordingCase, Kind, Weight};
pub use gravical_recording::{Advice, Finding, FindingKind, LineSpans, Severity, format_spans};

/// `finding!(Kind, "text {}", value)`: a [`Finding`] that matters as its kind does.
#[doc(hidden)]
#[macro_export]
macro_rules! __finding {
    ($kind:ident, $($text:tt)+) => {
        $crate::finding::Finding::new($crate::finding::FindingKind::$kind, format!($($text)+))
    };
}
#[doc(hidden)]
pub use __finding as finding;

/// Adds the findings of `kind` to an error: a file that was left out can be its cause.
pub(crate) fn after(error: Error, findings: &[Finding], kind: &str) -> Error {
    let of_kind = findings.iter().filter(|f| f.kind == kind);
    of_kind.fold(error, |error, finding| {
        let file = finding.file.as_deref().unwrap_or("-");
        error.with_detail(&format!("; {file}: {}", finding.message))
    })
}
