//! What every exported file says of itself: the sensor, the date, the verdict, what is missing.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use super::Target;
use crate::calibration_file::CalibrationFile;
use crate::recording::units::AccelUnit;
use crate::{Error, Result};

/// Words that MATLAB reserves.
const MATLAB: [&str; 20] = [
    "break",
    "case",
    "catch",
    "classdef",
    "continue",
    "else",
    "elseif",
    "end",
    "for",
    "function",
    "global",
    "if",
    "otherwise",
    "parfor",
    "persistent",
    "return",
    "spmd",
    "switch",
    "try",
    "while",
];

/// Words that Rust reserves.
const RUST: [&str; 51] = [
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "crate",
    "do", "dyn", "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl",
    "in", "let", "loop", "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref",
    "return", "self", "static", "struct", "super", "trait", "true", "try", "type", "typeof",
    "unsafe", "unsized", "use", "virtual", "where", "while", "yield",
];

/// MATLAB cuts longer names; the functions add up to 13 characters.
const LONGEST_NAME: usize = 48;

/// Refuses a name that is no identifier in the language of `target`.
///
/// # Errors
///
/// `export-name` (usage).
pub(super) fn check_name(target: Target, name: &str) -> Result<()> {
    let reserved: &[&str] = match target {
        Target::Rust => &RUST,
        Target::Matlab => &MATLAB,
        // The names of functions begin with it, so that a reserved word does no harm.
        _ => &[],
    };
    let letters = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= LONGEST_NAME;
    let wrong = |why: String| {
        Err(Error::usage("export-name", why).of_option("name").with_hint(format!(
            "use letters, digits and underscores, a letter first, at most {LONGEST_NAME}: for example imu_left"
        )))
    };
    if !letters {
        return wrong(format!("{name} is no identifier"));
    }
    if name.contains("__") {
        return wrong(format!(
            "{name}: C++ reserves names with two underscores in a row"
        ));
    }
    if reserved.contains(&name) {
        return wrong(format!("{name} is a reserved word of {}", target.name()));
    }
    Ok(())
}

/// Lines about the calibration, without the marks of a comment.
pub(super) fn about(file: &CalibrationFile, target: Target, notes: &[String]) -> Vec<String> {
    let a = &file.accelerometer;
    let sensor = [&file.sensor.model, &file.sensor.id]
        .into_iter()
        .flatten()
        .map(|s| plain(s))
        .collect::<Vec<_>>()
        .join(" ");
    let of = match sensor.as_str() {
        "" => String::new(),
        some => format!(" of {some}"),
    };
    let mut lines = vec![
        format!("Calibration{of}, {}", plain(&file.created)),
        format!(
            "by {}, verdict {}, for {}",
            plain(&file.tool),
            file.verdict.grade.name(),
            target.name()
        ),
        match a.nominal_per_mps2() {
            Some(nominal) if a.input_unit == AccelUnit::Counts => format!(
                "made with raw values in counts, nominally {:.0} per g",
                nominal * STANDARD_GRAVITY_MPS2
            ),
            _ => format!("made with raw values in {}", a.input_unit.name()),
        },
    ];
    if let Some(t) = file.temperature_c {
        lines.push(format!(
            "Temperature of the poses: {:.1} to {:.1} degrees Celsius",
            t.min, t.max
        ));
    }
    lines.extend(notes.iter().map(|n| plain(n)));
    lines
}

/// Lines behind `mark`, each with a line break.
pub(super) fn marked(mark: &str, lines: &[String]) -> String {
    lines.iter().map(|l| format!("{mark} {l}\n")).collect()
}

/// A comment of C.
pub(super) fn c_comment(lines: &[String]) -> String {
    format!("/*\n{} */\n", marked(" *", lines))
}

/// Signs of units in ASCII, since some compilers warn of others.
pub(super) fn ascii(text: &str) -> String {
    text.replace('²', "^2")
        .replace('°', "deg")
        .replace('‖', "|")
}

/// Texts from outside cannot end a comment or a string, or continue it: other characters become underscores.
pub(super) fn plain(text: &str) -> String {
    ascii(text)
        .chars()
        .map(|c| match c {
            ' ' | '`' | '\'' | ',' | ';' | ':' | '.' | '(' | ')' | '+' | '-' | '=' | '/' | '^'
            | '_' | '|' | '<' | '>' | '%' | '&' => c,
            c if c.is_ascii_alphanumeric() => c,
            _ => '_',
        })
        .collect()
}

/// Notes on what no target but this program's own holds.
pub(super) fn without_drift(file: &CalibrationFile) -> Vec<String> {
    let drift = file
        .temperature_model
        .is_some()
        .then(|| "Without the drift with temperature, which `gravical apply` corrects.".to_owned());
    drift.into_iter().collect()
}

/// The same, and the gyroscope where the target has no place for it.
pub(super) fn without_gyroscope(file: &CalibrationFile, instead: &str) -> Vec<String> {
    let mut notes = without_drift(file);
    if file.gyroscope.is_some() {
        notes.push(format!("Without the gyroscope: {instead}."));
    }
    notes
}
