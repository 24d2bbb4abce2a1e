//! Findings, listed once if several files share them.

use std::collections::{BTreeSet, HashMap};

use gravical::escape::one_line;
use gravical::finding::{Finding, Severity, format_spans};

/// A finding with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// Whether it is a warning; a note else.
    pub warning: bool,
    /// Kind of the finding.
    pub kind: String,
    /// The message.
    pub text: String,
    /// Lines and files; empty for none.
    pub place: String,
}

impl Remark {
    /// Findings by weight: quality gates, other warnings, notes. A finding that several files share
    /// is listed once, with the first of them.
    #[must_use]
    pub fn all(findings: &[Finding], several_files: bool) -> Vec<Self> {
        // The same message up to its numbers.
        let alike = |f: &Finding| (f.kind, skeleton(&f.message));
        let mut files: HashMap<_, (&Option<String>, BTreeSet<&String>)> = HashMap::new();
        for finding in findings {
            let (_, all) = files
                .entry(alike(finding))
                .or_insert((&finding.file, BTreeSet::new()));
            all.extend(&finding.file);
        }
        let of_weight = |weight: u8| {
            let files = &files;
            let of = findings.iter().filter(move |f| weight_of(f) == weight);
            of.filter_map(move |finding| {
                let (first, all) = files.get(&alike(finding))?;
                let mut place = Vec::new();
                if !finding.lines.is_empty() {
                    let word = if finding.count == 1 { "line" } else { "lines" };
                    let lines = format_spans(&finding.lines, finding.count, 4);
                    place.push(format!("{word} {lines}"));
                }
                if several_files && let Some(file) = &finding.file {
                    place.push(short_name(file));
                    place.extend(match all.len() {
                        0 | 1 => None,
                        2 => Some("also in 1 other file".to_owned()),
                        n => Some(format!("also in {} other files", n - 1)),
                    });
                }
                (**first == finding.file).then(|| Remark {
                    warning: finding.severity == Severity::Warning,
                    kind: finding.kind.to_string(),
                    text: finding.message.clone(),
                    place: place.join("; "),
                })
            })
        };
        (0..3).flat_map(of_weight).collect()
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
