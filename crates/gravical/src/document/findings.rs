//! Findings, told once where several files share them.

use std::collections::{BTreeSet, HashMap};

use crate::finding::{Finding, Severity, format_spans};
use crate::output::one_line;

/// What was odd, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// Whether it is a warning; a note else.
    pub warning: bool,
    /// Its kind.
    pub kind: String,
    /// What it is.
    pub text: String,
    /// Lines and files; empty for none.
    pub place: String,
}

impl Remark {
    /// Findings, warnings first; what several files share is told of the first.
    #[must_use]
    pub fn all(findings: &[Finding], several_files: bool) -> Vec<Self> {
        // Numbers differ from file to file; the words do not.
        let alike = |f: &Finding| (f.kind, skeleton(&f.message));
        let mut files: HashMap<_, (&Option<String>, BTreeSet<&String>)> = HashMap::new();
        for finding in findings {
            let (_, all) = files
                .entry(alike(finding))
                .or_insert((&finding.file, BTreeSet::new()));
            all.extend(&finding.file);
        }
        let told = |severity: Severity| {
            let files = &files;
            let of = findings.iter().filter(move |f| f.severity == severity);
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
                        2 => Some("1 other file alike".to_owned()),
                        n => Some(format!("{} other files alike", n - 1)),
                    });
                }
                (**first == finding.file).then(|| Remark {
                    warning: severity == Severity::Warning,
                    kind: finding.kind.to_string(),
                    text: finding.message.clone(),
                    place: place.join("; "),
                })
            })
        };
        told(Severity::Warning)
            .chain(told(Severity::Note))
            .collect()
    }
}

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
