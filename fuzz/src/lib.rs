//! What has to hold whatever the bytes are: one function for each parser.
//!
//! The fuzz targets call them with bytes that libFuzzer makes up,
//! `crates/gravical-report/tests/fuzz_corpora.rs` with the files of `seeds` and
//! `regressions`, so that both check the same things.

mod recordings;

use gravical::calibration_file::{Calibration, from_imucal, to_imucal};
use gravical::poses::sections::parse_sections;

pub use recordings::reader;

/// A section list: what is accepted has rows, and says the same when it is
/// written as JSON and read again.
pub fn sections(data: &[u8]) {
    let Ok(sections) = parse_sections(data) else {
        return;
    };
    assert!(!sections.is_empty(), "an empty list was accepted");
    for section in &sections {
        assert!(section.rows.start < section.rows.end, "{section:?}");
    }
    let list: Vec<serde_json::Value> = sections
        .iter()
        .map(|s| serde_json::json!({"label": s.label, "start": s.rows.start, "end": s.rows.end}))
        .collect();
    let text = serde_json::Value::from(list).to_string();
    let again = parse_sections(text.as_bytes()).unwrap_or_else(|e| unreachable!("{text}: {e}"));
    assert_eq!(again, sections);
}

/// A calibration file, ours or imucal's: what is accepted can be written, read
/// again as the same, and written for imucal, where every number is one.
pub fn calibration_file(data: &[u8]) {
    let Ok(file) = Calibration::parse(data) else {
        return;
    };
    let text = file.to_json();
    let text = text.unwrap_or_else(|e| unreachable!("accepted and not writable: {e}"));
    let again = Calibration::parse(text.as_bytes());
    let again = again.unwrap_or_else(|e| unreachable!("not readable: {e}\n{text}"));
    assert_eq!(again, file);
    let imucal = to_imucal(&file);
    let imucal = imucal.unwrap_or_else(|e| unreachable!("not writable for imucal: {e}"));
    let value: serde_json::Value = serde_json::from_str(&imucal)
        .unwrap_or_else(|e| unreachable!("for imucal, but no JSON: {e}\n{imucal}"));
    for key in ["K_a", "R_a", "b_a", "K_g", "R_g", "K_ga", "b_g"] {
        assert!(!value[key].to_string().contains("null"), "{key}:\n{imucal}");
    }
    // A file written by hand may have a scale that has nothing to do with its
    // matrix; only then may imucal's form of it be refused, as singular.
    if let Err(e) = from_imucal(&value) {
        assert_eq!(e.code(), "calibration-values", "{e}\n{imucal}");
    }
}
