//! Findings, and their addition to errors that they may have caused.

mod cases;

use crate::Error;

pub use cases::{Case, NoTemperature, OrderOf, Restless};
pub use gravical_judge::finding::{Case as RecordingCase, GyroMismatch, Kind, Weight};
pub use gravical_judge::{Advice, Finding, LineSpans, Severity, format_spans};

/// Adds findings to an error that they can be the cause of: a file that was left out.
pub(crate) fn after(error: Error, findings: &[Finding]) -> Error {
    findings.iter().fold(error, |error, finding| {
        let file = finding.file.as_deref().unwrap_or("-");
        error.with_detail(&format!("; {file}: {}", finding.message))
    })
}
