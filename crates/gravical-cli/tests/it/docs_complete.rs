//! The error codes and the kinds of findings of the sources are those of docs/recording.md, and links of
//! the documents lead to a file and a heading.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use gravical::finding::Weight;

use crate::support::below;

/// How a code is made.
const MAKERS: [&str; 3] = ["Error::input(", "Error::usage(", "Error::device("];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn document() -> String {
    fs::read_to_string(root().join("docs/recording.md")).unwrap()
}

/// The items of the lists are those of the enums; with `GRAVICAL_BLESS` they are written anew.
#[test]
fn every_kind_of_finding_is_documented() {
    let text = document();
    let mut written = text.clone();
    let (_, findings) = text.split_once("\n## Findings\n").unwrap();
    let (findings, _) = findings.split_once("\n## ").unwrap();
    let items: Vec<&str> = findings.lines().filter(|l| l.starts_with("- `")).collect();
    let kinds = gravical::finding::kinds();
    for kind in &kinds {
        let begin = format!("- `{}`", kind.name);
        let item = items.iter().find(|item| item.starts_with(&begin));
        let item = item.unwrap_or_else(|| panic!("no item {begin}"));
        let has = |weight| kind.of_cases.contains(&weight);
        let weight = match kind.weight {
            _ if has(Weight::Note) && has(Weight::Warning) => " (note or warning)",
            Weight::Note => " (note)",
            Weight::Warning | Weight::Loss => "",
            Weight::Gate => " (gate)",
        };
        let mut wanted = format!("{begin}{weight}: {}.", kind.meaning);
        if !kind.remedy.is_empty() {
            wanted += &format!(" {}.", kind.remedy);
        }
        written = written.replace(&format!("{item}\n"), &format!("{wanted}\n"));
    }
    if std::env::var_os("GRAVICAL_BLESS").is_some() {
        fs::write(root().join("docs/recording.md"), &written).unwrap();
    }
    assert!(written == text, "GRAVICAL_BLESS=1 writes the items anew");
    assert_eq!(items.len(), kinds.len(), "each once, and no other");
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
    // Rows of `errors!`.
    let row = |line: &str| {
        let (name, category) = line.trim().strip_prefix('"')?.split_once("\" ")?;
        ["input:", "usage:", "device:"]
            .contains(&category)
            .then(|| name.to_owned())
    };
    let rows = code.lines().filter_map(row);
    made.filter_map(literal).chain(rows).collect()
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
            let link = link.split(')').next().unwrap_or_default();
            let (target, anchor) = link.split_once('#').unwrap_or((link, ""));
            if !target.contains("://") {
                seen += 1;
                let full = match target {
                    "" => path.clone(),
                    target => path.parent().unwrap().join(target),
                };
                assert!(full.exists(), "{}: {link}", path.display());
                assert!(has_heading(&full, anchor), "{}: {link}", path.display());
            }
        }
    }
    assert!(seen > 20, "only {seen} links");
}

/// Whether a document has the heading that the forge gives this name; without a name true.
fn has_heading(document: &Path, anchor: &str) -> bool {
    let named = |heading: &str| {
        let words = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = words
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c })
            .collect::<String>()
    };
    let headings = || fs::read_to_string(document).unwrap();
    anchor.is_empty()
        || headings()
            .lines()
            .any(|l| l.starts_with('#') && named(l) == anchor)
}
