//! A calibration as code to paste: C, Python, and the equation.

use crate::document::Snippet;
use gravical::calibration_file::CalibrationFile;
use gravical::export;

/// The formulas with their numbers.
pub(super) fn snippets(file: &CalibrationFile) -> Vec<Snippet> {
    let snippet = |(language, fence, code)| Snippet {
        language,
        fence,
        code,
    };
    export::snippets(file).map(snippet).into()
}
