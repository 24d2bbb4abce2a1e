//! What is found in recordings and results.

use gravical_calibrate::finding::Case as CalibrationCase;
#[doc(hidden)]
pub use gravical_calibrate::finding::*;
#[doc(inline)]
pub use gravical_calibrate::finding::{Advice, Finding, LineSpans, Severity};

gravical_recording::findings! {
    "noise-temperature" Warning "`noise`: the temperature moved by more than 1 °C" / "B and K are not corrected" / "record at constant temperature, after half an hour of warming":
        NoiseTemperature { changed_c: f64 } =>
            "the temperature moved by {changed_c:.1} °C: drift of the bias with temperature looks like bias instability and random walk";
}

/// The kinds of all crates, in the order of the documents.
#[doc(hidden)]
pub fn kinds() -> Vec<Kind> {
    [RecordingCase::KINDS, CalibrationCase::KINDS, Case::KINDS].concat()
}
