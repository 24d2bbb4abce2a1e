//! The error codes and the kinds of findings of the sources are those of docs/recording.md.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use gravical::finding::{FindingKind, Severity};

/// How a code is made.
const MAKERS: [&str; 3] = ["Error::input(", "Error::usage(", "Error::device("];

fn document() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    fs::read_to_string(root.join("docs/recording.md")).unwrap()
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
    assert_eq!(
        rows.len(),
        FindingKind::ALL.len(),
        "each once, and no other"
    );
}

#[test]
fn every_code_is_documented() {
    let document = document();
    // Some names are of findings too.
    let (_, errors) = document.split_once("\n## Errors\n").unwrap();
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut names: BTreeSet<String> = BTreeSet::new();
    for source in sources(&crates) {
        let text = fs::read_to_string(&source).unwrap();
        names.extend(codes(&text));
    }
    // A scan that finds nothing proves nothing.
    assert!(names.len() > 60, "only {} codes were found", names.len());
    // What the sources make in another way.
    let others = "not-found permission-denied unreadable io internal";
    names.extend(others.split(' ').map(str::to_owned));
    names.retain(|name| !errors.contains(&format!("`{name}`")));
    assert!(names.is_empty(), "docs/recording.md lacks {names:?}");
}

/// The Rust files under `crates/*/src`, without those that hold tests only and
/// without the virtual board, which nobody gets.
fn sources(crates: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> = entries(crates)
        .filter(|c| !c.ends_with("virtual-board"))
        .map(|c| c.join("src"))
        .collect();
    while let Some(folder) = folders.pop() {
        for path in entries(&folder) {
            if path.is_dir() && !path.ends_with("tests") {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs") {
                found.push(path);
            }
        }
    }
    found
}

fn entries(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let list = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    list.map(|entry| entry.unwrap().path())
}

/// The literals that codes are made with, those of the test module left out.
fn codes(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let made = MAKERS.iter().flat_map(|maker| code.split(maker).skip(1));
    let literal = |rest: &str| {
        rest.trim_start()
            .strip_prefix('"')?
            .split_once('"')
            .map(|l| l.0.to_owned())
    };
    made.filter_map(literal).collect()
}
