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

/// Adds findings to an error that they can be the cause of: a file that was left out.
pub(crate) fn after(error: Error, findings: &[Finding]) -> Error {
    findings.iter().fold(error, |error, finding| {
        let file = finding.file.as_deref().unwrap_or("-");
        error.with_detail(&format!("; {file}: {}", finding.message))
    })
}
