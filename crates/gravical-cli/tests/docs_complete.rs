//! Every finding, every error code and every reason for setting a line aside
//! that stands in the sources stands in docs/recording.md, so that its tables
//! cannot fall behind.

#![allow(clippy::unwrap_used, clippy::panic)] // helpers of a test may panic as it does

use std::fs;
use std::path::{Path, PathBuf};

/// How a kind or code is made, and what the document calls it.
const MAKERS: [(&str, &str); 5] = [
    ("Finding::note(", "finding"),
    ("Finding::warning(", "finding"),
    ("Error::input(", "error code"),
    ("Error::usage(", "error code"),
    ("Error::device(", "error code"),
];

#[test]
fn every_kind_and_code_is_documented() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let document = fs::read_to_string(root.join("docs/recording.md")).unwrap();
    // Some names are both: each needs its row in both parts.
    let (findings, errors) = document.split_once("\n## Errors\n").unwrap();
    let documented = |what: &str, name: &str| {
        let part = if what == "finding" { findings } else { errors };
        part.contains(&format!("| `{name}` |"))
    };
    let mut missing = Vec::new();
    let mut seen = 0;
    for source in sources(&root) {
        let text = fs::read_to_string(&source).unwrap();
        for (what, name) in names(code_of(&text)) {
            seen += 1;
            if !documented(what, &name) {
                missing.push(format!("{what} `{name}` of {}", source.display()));
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
        if !documented("error code", name) {
            missing.push(format!("error code `{name}`"));
        }
    }
    for aside in gravical::recording::Aside::ALL {
        if !findings.contains(&format!("`{}`", aside.name())) {
            missing.push(format!("reason `{}`", aside.name()));
        }
    }
    missing.sort();
    missing.dedup();
    // A scan that finds nothing proves nothing.
    assert!(seen > 90, "only {seen} kinds and codes were found");
    assert!(
        missing.is_empty(),
        "docs/recording.md lacks a row for:\n{}",
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

/// What is made, and the literal it is made with; a name that is computed (the
/// reasons of the ledger) is looked at elsewhere.
fn names(code: &str) -> Vec<(&'static str, String)> {
    let mut found = Vec::new();
    for (maker, what) in MAKERS {
        for (at, _) in code.match_indices(maker) {
            let rest = code[at + maker.len()..].trim_start();
            if let Some(literal) = rest.strip_prefix('"')
                && let Some(end) = literal.find('"')
            {
                found.push((what, literal[..end].to_owned()));
            }
        }
    }
    found
}

#[test]
fn the_scan_reads_over_line_breaks_and_stops_at_the_tests() {
    let text = "Error::input(\n    \"torn\",\nFinding::note(reason.name(), x)\nFinding::warning(\"gap\"\n#[cfg(test)]\nmod tests {\nError::usage(\"not-me\"";
    assert_eq!(
        names(code_of(text)),
        [
            ("finding", "gap".to_owned()),
            ("error code", "torn".to_owned())
        ]
    );
}
