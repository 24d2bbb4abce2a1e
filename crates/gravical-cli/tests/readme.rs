//! Every command of the README and of the documentation runs and prints what is
//! written there: the ```console blocks, from the root of the repository.
//!
//! Each document runs in a folder of its own with a copy of `examples/`, so that
//! a command may write files. `cargo run --release --` stands for the program
//! that the tests were built with.

#![allow(clippy::unwrap_used, clippy::panic)] // helpers of a test may panic as it does

use std::fs;
use std::path::{Path, PathBuf};

const DOCUMENTS: [&str; 13] = [
    "README.md",
    "docs/tutorial.md",
    "docs/reading-results.md",
    "docs/recording.md",
    "docs/method.md",
    "docs/motion.md",
    "docs/denoise.md",
    "docs/many.md",
    "docs/noise.md",
    "docs/wearables.md",
    "docs/file-formats.md",
    "docs/exports.md",
    "examples/simulated-six-position/README.md",
];

/// One test and not one a document: the working folder belongs to the process.
#[test]
fn commands_of_the_documents_do_what_is_written() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for document in DOCUMENTS {
        let folder = tempfile::tempdir().unwrap();
        copy(&root.join("examples"), &folder.path().join("examples"));
        let text = fs::read_to_string(root.join(document)).unwrap();
        let script = folder.path().join(document.replace('/', "_"));
        let commands = text
            .replace("$ cargo run --release -- ", "$ gravical ")
            // trycmd takes the line break before the closing fence for layout;
            // here it is the end of the last line.
            .replace("\n```\n", "\n\n```\n");
        fs::write(&script, commands).unwrap();
        std::env::set_current_dir(folder.path()).unwrap();
        trycmd::TestCases::new()
            .register_bin("gravical", Path::new(env!("CARGO_BIN_EXE_gravical")))
            .env("SOURCE_DATE_EPOCH", "1767225600")
            .case(&script)
            .run();
        std::env::set_current_dir(&root).unwrap();
        if document.starts_with("examples") {
            // Its command has just simulated the example again. (The truth
            // carries every digit, and the last one is the mathematics library's.)
            let session = "examples/simulated-six-position";
            for made in files(&folder.path().join(session)) {
                let name = made.file_name().unwrap();
                if made.extension().is_some_and(|e| e == "csv") {
                    let is_same = fs::read(&made).unwrap()
                        == fs::read(root.join(session).join(name)).unwrap();
                    assert!(is_same, "{} is not what its command makes", made.display());
                }
            }
        }
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().path()).collect()
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for path in files(from) {
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).unwrap();
        }
    }
}
