//! The error codes and the kinds of findings of the sources are those of docs/recording.md.

use std::fs;
use std::path::{Path, PathBuf};

use gravical::finding::FindingKind;

/// How a code is made.
const MAKERS: [&str; 3] = ["Error::input(", "Error::usage(", "Error::device("];

fn document() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    fs::read_to_string(root.join("docs/recording.md")).unwrap()
}

#[test]
fn every_kind_of_finding_is_documented_with_its_weight() {
    let text = document();
    let (_, findings) = text.split_once("\n## Findings\n").unwrap();
    let (findings, _) = findings.split_once("\n## ").unwrap();
    let rows: Vec<&str> = findings.lines().filter(|l| l.starts_with("| `")).collect();
    for kind in FindingKind::ALL {
        let row = format!("| `{kind}` | {} |", kind.weight());
        assert!(rows.iter().any(|r| r.starts_with(&row)), "{row}");
    }
    assert_eq!(
        rows.len(),
        FindingKind::ALL.len(),
        "each once, and no other"
    );
}

#[test]
fn every_code_is_documented() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let document = document();
    // Some names are of findings too.
    let (_, errors) = document.split_once("\n## Errors\n").unwrap();
    let documented = |name: &str| errors.contains(&format!("`{name}`"));
    let mut missing = Vec::new();
    let mut seen = 0;
    for source in sources(&root) {
        let text = fs::read_to_string(&source).unwrap();
        for name in names(code_of(&text)) {
            seen += 1;
            if !documented(&name) {
                missing.push(format!("error code `{name}` of {}", source.display()));
            }
        }
    }
    // What the sources make in another way.
    for name in [
        "not-found",
        "permission-denied",
        "unreadable",
        "io",
        "internal",
    ] {
        if !documented(name) {
            missing.push(format!("error code `{name}`"));
        }
    }
    missing.sort();
    missing.dedup();
    // A scan that finds nothing proves nothing.
    assert!(seen > 60, "only {seen} codes were found");
    assert!(
        missing.is_empty(),
        "docs/recording.md lacks:\n{}",
        missing.join("\n")
    );
}

/// The Rust files under `crates/*/src`, without those that hold tests only and
/// without the virtual board, which nobody gets.
fn sources(root: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> = entries(&root.join("crates"))
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

/// A file without the test module at its end.
fn code_of(text: &str) -> &str {
    let end = text.find("#[cfg(test)]\nmod tests {");
    &text[..end.unwrap_or(text.len())]
}

/// The literals that codes are made with.
fn names(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for maker in MAKERS {
        for (at, _) in code.match_indices(maker) {
            let rest = code[at + maker.len()..].trim_start();
            if let Some(literal) = rest.strip_prefix('"')
                && let Some(end) = literal.find('"')
            {
                found.push(literal[..end].to_owned());
            }
        }
    }
    found
}
