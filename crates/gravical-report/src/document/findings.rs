//! Findings, listed once if several files share them.

use std::cmp::Reverse;
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
    pub fn all(findings: &[Finding], several_files: bool) -> Vec<Self> {
        // A recording may have its gyroscope in a second file.
        let mut named = findings.iter().filter_map(|f| f.file.as_ref());
        let first = named.next();
        let several_files = several_files || named.any(|file| Some(file) != first);
        let mut sorted: Vec<&Finding> = findings.iter().collect();
        sorted.sort_by_key(|f| (Reverse(f.severity), !f.gate));
        // Findings of one message up to its numbers, and the files that have them.
        let key = |f: &Finding| {
            let mut text = f.worded(flag);
            text.retain(|c| !c.is_ascii_digit() && !matches!(c, '.' | '-'));
            (f.kind.clone(), text)
        };
        let mut files: HashMap<_, Vec<&Option<String>>> = HashMap::new();
        for finding in &sorted {
            let files = files.entry(key(finding)).or_default();
            if !files.contains(&&finding.file) {
                files.push(&finding.file);
            }
        }
        let remark = |finding: &Finding| {
            let files = &files[&key(finding)];
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
            let mut text = finding.worded(flag);
            if !place.is_empty() {
                text += &format!(" [{}]", place.join("; "));
            }
            let remark = Remark {
                warning: finding.severity == Severity::Warning,
                kind: finding.kind.to_string(),
                text,
            };
            (finding.file == *files[0]).then_some(remark)
        };
        sorted.into_iter().filter_map(remark).collect()
    }
}

/// The option as the program takes it: `--accel-unit mg`.
pub fn flag(option: &Advice) -> String {
    let flag = format!("--{}", option.name.replace('_', "-"));
    match option.value.as_str() {
        "" | "true" => flag,
        value => format!("{flag} {}", shell_word(value)),
    }
}

/// Name of a file without its folder.
pub(crate) fn short_name(path: &str) -> String {
    let name = std::path::Path::new(path)
        .file_name()
        .map_or_else(|| path.into(), |n| n.to_string_lossy());
    one_line(&name).into_owned()
}
