//! A calibration as code to paste: C, Python, and the equation.

use crate::document::Snippet;
use gravical::calibration_file::CalibrationFile;
use gravical::export::formula::{Formula, Language, comment};

/// The formulas with their numbers.
pub(super) fn snippets(file: &CalibrationFile) -> Vec<Snippet> {
    let accelerometer =
        Formula::accelerometer(file, "calibrate_accelerometer".to_owned(), ["r", "a", "a"]);
    let gyroscope = file
        .gyroscope
        .as_ref()
        .map(|g| Formula::gyroscope(g, "calibrate_gyroscope".to_owned(), ["r", "a", "w"], false));
    let formulas: Vec<Formula<'_>> = std::iter::once(accelerometer).chain(gyroscope).collect();
    let code = |language| {
        let mut parts: Vec<String> = formulas.iter().map(|f| f.code(language)).collect();
        if file.temperature_model.is_some() {
            let note = "without temperature drift, which gravical apply corrects";
            parts.push(comment(language, note));
        }
        parts.join("\n")
    };
    [
        ("C", "c", Language::C),
        ("Python", "python", Language::Python),
        ("Equation", "", Language::Equation),
    ]
    .map(|(name, fence, language)| Snippet {
        language: name,
        fence,
        code: code(language),
    })
    .into()
}
