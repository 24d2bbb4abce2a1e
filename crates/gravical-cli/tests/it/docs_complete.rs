//! The error codes and the kinds of findings of the sources are those of docs/recording.md, and links of
//! the documents lead somewhere.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use gravical::finding::{FindingKind, Severity};

use crate::support::below;

/// How a code is made.
const MAKERS: [&str; 3] = ["Error::input(", "Error::usage(", "Error::device("];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn document() -> String {
    fs::read_to_string(root().join("docs/recording.md")).unwrap()
}

#[test]
fn every_kind_of_finding_is_documented_with_its_severity() {
    let text = document();
    let (_, findings) = text.split_once("\n## Findings\n").unwrap();
    let (findings, _) = findings.split_once("\n## ").unwrap();
    let rows: Vec<&str> = findings.lines().filter(|l| l.starts_with("| `")).collect();
    for kind in FindingKind::ALL {
        let begin = format!("| `{kind}` | ");
        let row = rows.iter().find_map(|r| r.strip_prefix(&begin));
        let (severity, _) = row.expect(&begin).split_once(" |").unwrap();
        let name = match kind.severity() {
            Severity::Note => "note",
            Severity::Warning => "warning",
        };
        assert!(severity.contains(name), "{kind} is a {name}");
        assert_eq!(severity.contains("gate"), kind.is_gate(), "{kind}");
    }
    let kinds = FindingKind::ALL.len();
    assert_eq!(rows.len(), kinds, "each once, and no other");
}

#[test]
fn every_code_is_documented() {
    let document = document();
    // Some names are of findings too.
    let (_, errors) = document.split_once("\n## Errors\n").unwrap();
    // What the sources make in another way.
    let others = "not-found permission-denied unreadable io internal";
    let mut names: BTreeSet<String> = others.split(' ').map(str::to_owned).collect();
    for entry in fs::read_dir(root().join("crates")).unwrap() {
        let source = entry.unwrap().path();
        // Nobody gets the virtual board.
        if !source.ends_with("virtual-board") {
            let is_test = |file: &PathBuf| file.iter().any(|p| p == "tests" || p == "tests.rs");
            let files = below(&source.join("src")).into_iter();
            for file in files.filter(|file| !is_test(file)) {
                names.extend(codes(&fs::read_to_string(file).unwrap_or_default()));
            }
        }
    }
    // A scan that finds nothing proves nothing.
    assert!(names.len() > 65, "only {} codes were found", names.len());
    names.retain(|name| !errors.contains(&format!("`{name}`")));
    assert!(names.is_empty(), "docs/recording.md lacks {names:?}");
}

/// The literals that codes are made with, those of the test module left out.
fn codes(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let made = MAKERS.iter().flat_map(|maker| code.split(maker).skip(1));
    let literal = |rest: &str| {
        let (name, _) = rest.trim_start().strip_prefix('"')?.split_once('"')?;
        Some(name.to_owned())
    };
    made.filter_map(literal).collect()
}

#[test]
fn links_lead_somewhere() {
    let mut paths = below(&root().join("docs"));
    paths.retain(|path| path.extension().is_some_and(|e| e == "md"));
    let at_root = ["README.md", "DESIGN.md", "CHANGELOG.md", "CONTRIBUTING.md"];
    paths.extend(at_root.map(|name| root().join(name)));
    let mut seen = 0;
    for path in paths {
        let text = fs::read_to_string(&path).unwrap();
        for link in text.split("](").skip(1) {
            let target = link.split([')', '#']).next().unwrap_or_default();
            if !target.is_empty() && !target.contains("://") {
                seen += 1;
                let full = path.parent().unwrap().join(target);
                assert!(full.exists(), "{}: {target}", path.display());
            }
        }
    }
    assert!(seen > 20, "only {seen} links");
}
