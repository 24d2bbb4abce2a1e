//! Replays the seeds of the fuzzers (`fuzz/seeds`) and their former failures (`fuzz/regressions`)
//! through the same checks, with the stable compiler.

use std::fs;
use std::path::{Path, PathBuf};

#[path = "../../../fuzz/src/lib.rs"]
mod checks;

/// Checks every file of a target: at least `least` seeds, and all regressions.
fn replay(target: &str, least: usize, check: fn(&[u8])) {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz");
    let seeds = files(&fuzz.join("seeds").join(target));
    assert!(seeds.len() >= least, "only {} seeds", seeds.len());
    let regressions = files(&fuzz.join("regressions").join(target));
    for file in seeds.into_iter().chain(regressions) {
        // Printed if the check fails.
        println!("{}", file.display());
        match fs::read(&file) {
            Ok(bytes) => check(&bytes),
            Err(e) => unreachable!("{e}"),
        }
    }
}

/// The files of a folder, sorted; none if the folder does not exist.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    files.sort();
    files
}

#[test]
fn every_target() {
    replay("reader", 40, checks::reader);
    replay("sections", 10, checks::sections);
    replay("calibration_file", 6, checks::calibration_file);
}
