//! Pieces of text: numbers with as many digits as they are worth, wrapped
//! sentences, findings.

use std::collections::BTreeSet;

use crate::finding::format_spans;
use crate::output::one_line;
use crate::recording::{Finding, Severity};

/// Width of a line.
pub(super) const WIDTH: usize = 80;

/// Decimals that show `uncertainty` with two digits, 0 to 6.
pub(crate) fn decimals_for(uncertainty: f64) -> usize {
    if !(uncertainty.is_finite() && uncertainty > 0.0) {
        return 6;
    }
    (1.0 - uncertainty.log10().floor()).clamp(0.0, 6.0) as usize
}

/// Decimals that show `value` with `digits` significant digits, 0 to 6.
pub(super) fn decimals_of(value: f64, digits: i32) -> usize {
    let magnitude = value.abs().max(1e-9).log10().floor() as i32;
    (digits - 1 - magnitude).clamp(0, 6) as usize
}

/// A paragraph of 80 columns, its first line behind `first`, the others behind as
/// much space. Words, options and paths stay whole.
#[must_use]
pub fn paragraph(first: &str, text: &str) -> String {
    let rest = " ".repeat(first.chars().count());
    let options = textwrap::Options::new(WIDTH)
        .initial_indent(first)
        .subsequent_indent(&rest)
        .word_splitter(textwrap::WordSplitter::NoHyphenation)
        .break_words(false);
    let mut out = textwrap::fill(&one_line(text), options);
    out.push('\n');
    out
}

/// Findings, warnings first; what several files share is told of the first.
#[must_use]
pub fn findings_text(findings: &[Finding], several_files: bool) -> String {
    let mut out = String::new();
    let mut told: Vec<&Finding> = Vec::new();
    for severity in [Severity::Warning, Severity::Note] {
        for finding in findings.iter().filter(|f| f.severity == severity) {
            // Numbers differ from file to file; the words do not.
            let same = |f: &&&Finding| {
                f.kind == finding.kind && skeleton(&f.message) == skeleton(&finding.message)
            };
            if let Some(first) = told.iter().find(same)
                && first.file != finding.file
            {
                continue;
            }
            told.push(finding);
            let others: BTreeSet<&String> = findings
                .iter()
                .filter(|f| same(&f))
                .filter_map(|f| f.file.as_ref())
                .collect();
            let mark = match severity {
                Severity::Warning => "  ! ",
                Severity::Note => "  · ",
            };
            let mut text = format!("{}: {}", finding.kind, finding.message);
            if !finding.lines.is_empty() {
                let lines = format_spans(&finding.lines, finding.count, 4);
                let word = if finding.count == 1 { "line" } else { "lines" };
                text.push_str(&format!(" [{word} {lines}]"));
            }
            if several_files && let Some(file) = &finding.file {
                let name = short_name(file);
                text.push_str(&match others.len() {
                    0 | 1 => format!(" ({name})"),
                    2 => format!(" ({name}; 1 other file alike)"),
                    n => format!(" ({name}; {} other files alike)", n - 1),
                });
            }
            out.push_str(&paragraph(mark, &text));
        }
    }
    out
}

fn skeleton(message: &str) -> String {
    message
        .chars()
        .filter(|c| !c.is_ascii_digit() && !matches!(c, '.' | '-'))
        .collect()
}

/// "+z", "12° off +z", or all three components where no axis is near.
pub(super) fn direction(n: [f64; 3]) -> String {
    let (face, off) = crate::segment::face::Face::nearest(n);
    match off {
        off if off < 1.0 => face.name(),
        off if off < 25.0 => format!("{off:.0}° off {}", face.name()),
        _ => format!("({})", n.map(|v| format!("{v:+.2}")).join(", ")),
    }
}

/// Name of a file without its folder.
pub(super) fn short_name(path: &str) -> String {
    let name = std::path::Path::new(path)
        .file_name()
        .map_or_else(|| path.into(), |n| n.to_string_lossy());
    one_line(&name).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::FindingKind;

    #[test]
    fn digits_follow_the_uncertainty() {
        assert_eq!(decimals_for(0.0021), 4);
        assert_eq!(decimals_for(0.21), 2);
        assert_eq!(decimals_for(21.0), 0);
        assert_eq!(decimals_of(16384.0, 6), 1);
        assert_eq!(decimals_of(1.0015, 6), 5);
    }

    #[test]
    fn shared_findings_are_told_once() {
        let finding =
            |file: &str, n: u32| Finding::new(FindingKind::Gap, format!("{n} gaps")).in_file(file);
        let text = findings_text(&[finding("a/x.csv", 1), finding("a/y.csv", 2)], true);
        assert_eq!(text, "  ! gap: 1 gaps (x.csv; 1 other file alike)\n");
    }

    #[test]
    fn no_line_is_wider_than_the_screen() {
        let text = paragraph("  ! ", &"word ".repeat(60));
        assert!(text.lines().all(|l| l.chars().count() <= WIDTH));
    }
}
