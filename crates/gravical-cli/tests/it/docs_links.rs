//! What the documents point at is there: pages, examples of cargo, files.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// README, DESIGN, CHANGELOG, CONTRIBUTING and everything in `docs`.
fn documents() -> Vec<(PathBuf, String)> {
    let root = root();
    let mut paths: Vec<PathBuf> = ["README.md", "DESIGN.md", "CHANGELOG.md", "CONTRIBUTING.md"]
        .map(|name| root.join(name))
        .to_vec();
    let docs = fs::read_dir(root.join("docs")).unwrap();
    paths.extend(
        docs.map(|e| e.unwrap().path())
            .filter(|p| p.extension().is_some_and(|e| e == "md")),
    );
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).unwrap();
        (path, text)
    };
    paths.into_iter().map(read).collect()
}

/// What follows each `mark`, up to one of `ends`.
fn after<'a>(text: &'a str, mark: &str, ends: &[char]) -> Vec<&'a str> {
    text.match_indices(mark)
        .map(|(at, _)| {
            let rest = &text[at + mark.len()..];
            &rest[..rest.find(ends).unwrap_or(rest.len())]
        })
        .collect()
}

#[test]
fn links_lead_somewhere() {
    let mut seen = 0;
    for (path, text) in documents() {
        for link in after(&text, "](", &[')']) {
            let target = link.split('#').next().unwrap_or_default();
            if target.is_empty() || target.contains("://") {
                continue;
            }
            seen += 1;
            let full = path.parent().unwrap().join(target);
            assert!(full.exists(), "{}: {link}", path.display());
        }
    }
    assert!(seen > 20, "only {seen} links");
}

#[test]
fn examples_that_the_documents_run_exist() {
    let sources = fs::read_dir(root().join("crates")).unwrap();
    let folders: Vec<PathBuf> = sources
        .map(|e| e.unwrap().path().join("examples"))
        .collect();
    let mut seen = 0;
    for (path, text) in documents() {
        for name in after(&text, "--example ", &[' ', '`', '\n', ')']) {
            seen += 1;
            let there = folders.iter().any(|f| {
                f.join(format!("{name}.rs")).exists() || f.join(name).join("main.rs").exists()
            });
            assert!(there, "{}: no example {name}", path.display());
        }
    }
    assert!(seen >= 3, "only {seen} examples");
}
