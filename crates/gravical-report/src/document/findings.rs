//! Findings, listed once if several files share them.

use std::collections::HashMap;

use gravical::escape::{one_line, shell_word};
use gravical::finding::{Advice, Finding, Severity, format_spans};
use gravical::numfmt::count;

/// A finding in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// Whether it is a warning; a note else.
    pub warning: bool,
    /// Kind of the finding.
    pub kind: String,
    /// The message with its options, as flags (reports are those of the program, in Python too), and
    /// its lines and files.
    pub text: String,
}

impl Remark {
    /// Findings by weight: quality gates, other warnings, notes. A finding that several files share
    /// is listed once, with the first of them.
    #[must_use]
    pub fn all(findings: &[Finding], several_files: bool) -> Vec<Self> {
        let mut sorted: Vec<&Finding> = findings.iter().collect();
        sorted.sort_by_key(|f| weight_of(f));
        // Findings of one message up to its numbers, and the files that have them.
        let key = |f: &Finding| (f.kind, skeleton(&f.worded(flag)));
        let mut files: HashMap<_, Vec<&Option<String>>> = HashMap::new();
        for finding in &sorted {
            let files = files.entry(key(finding)).or_default();
            if !files.contains(&&finding.file) {
                files.push(&finding.file);
            }
        }
        let remark = |finding: &Finding| {
            let files = &files[&key(finding)];
            if finding.file != *files[0] {
                return None;
            }
            let mut place = Vec::new();
            if !finding.lines.is_empty() {
                let word = if finding.count == 1 { "line" } else { "lines" };
                let lines = format_spans(&finding.lines, finding.count, 4);
                place.push(format!("{word} {lines}"));
            }
            if several_files && let Some(file) = &finding.file {
                place.push(short_name(file));
                if files.len() > 1 {
                    place.push(format!("also in {}", count(files.len() - 1, "other file")));
                }
            }
            let place = match place.join("; ") {
                none if none.is_empty() => none,
                place => format!(" [{place}]"),
            };
            Some(Remark {
                warning: finding.severity == Severity::Warning,
                kind: finding.kind.to_string(),
                text: finding.worded(flag) + &place,
            })
        };
        sorted.into_iter().filter_map(remark).collect()
    }
}

/// The option as the program takes it: `--accel-unit mg`.
#[must_use]
pub fn flag(option: &Advice) -> String {
    let flag = format!("--{}", option.name.replace('_', "-"));
    match option.value.as_str() {
        "" | "true" => flag,
        value => format!("{flag} {}", shell_word(value)),
    }
}

/// Order of the list.
fn weight_of(finding: &Finding) -> u8 {
    match finding.severity {
        Severity::Warning if finding.kind.is_gate() => 0,
        Severity::Warning => 1,
        Severity::Note => 2,
    }
}

/// The message without its numbers.
fn skeleton(message: &str) -> String {
    message
        .chars()
        .filter(|c| !c.is_ascii_digit() && !matches!(c, '.' | '-'))
        .collect()
}

/// Name of a file without its folder.
pub(crate) fn short_name(path: &str) -> String {
    let name = std::path::Path::new(path)
        .file_name()
        .map_or_else(|| path.into(), |n| n.to_string_lossy());
    one_line(&name).into_owned()
}
