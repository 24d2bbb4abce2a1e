//! Where results go: nothing is replaced by another result, or by what is made of
//! it, and what cannot be written is said before the work.

use std::fs;
use std::path::Path;

use crate::support::*;

/// A folder with a line and what it was calibrated with.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let run = run_in(folder.path(), ["demo", "d", "--json"]);
    assert_eq!(run.code, 0, "{}", run.err);
    for (from, to) in [
        ("line/line.csv", "line.csv"),
        ("calibration.json", "cal.json"),
    ] {
        fs::copy(folder.path().join("d").join(from), folder.path().join(to)).unwrap();
    }
    folder
}

/// Refused with this code, and nothing new in the folder.
fn refused(folder: &Path, line: &str, code: &str) {
    let names = || {
        let mut all: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name())
            .collect();
        all.sort();
        all
    };
    let (before, line_csv) = (names(), fs::read(folder.join("line.csv")).unwrap());
    let run = run_in(folder, words(line).into_iter().chain(["--json".to_owned()]));
    assert_eq!(
        (run.code, run.error_code().as_str()),
        (2, code),
        "{line}: {}",
        run.out
    );
    assert_eq!(names(), before, "{line}");
    assert!(
        fs::read(folder.join("line.csv")).unwrap() == line_csv,
        "{line}"
    );
}

#[test]
fn two_results_never_share_a_file() {
    let folder = folder();
    let at = folder.path();
    refused(
        at,
        "motion line.csv -o a.html --report a.html --force",
        "same-target",
    );
    refused(
        at,
        "motion line.csv -o a.html --report ./a.html",
        "same-target",
    );
    refused(at, "motion line.csv --report f --figures f", "same-target");
    refused(
        at,
        "calibrate d/poses/poses.csv -o c.html --report c.html",
        "same-target",
    );
    fs::create_dir(at.join("figs")).unwrap();
    refused(
        at,
        "motion line.csv -o figs/position.csv --figures figs --force",
        "same-target",
    );
}

#[test]
fn what_is_read_is_never_replaced() {
    let folder = folder();
    let at = folder.path();
    refused(at, "motion line.csv -o line.csv --force", "target-is-input");
    refused(
        at,
        "motion line.csv --report d/../line.csv --force",
        "target-is-input",
    );
    refused(
        at,
        "motion line.csv -c cal.json --report cal.json --force",
        "target-is-input",
    );
    refused(
        at,
        "apply cal.json line.csv -o line.csv --force",
        "target-is-input",
    );
    refused(
        at,
        "denoise line.csv --filter mean:5 -o line.csv --force",
        "target-is-input",
    );
    refused(
        at,
        "calibrate line.csv -o line.csv --force",
        "target-is-input",
    );
}

#[test]
fn what_cannot_be_written_is_said_before_the_work() {
    let folder = folder();
    let at = folder.path();
    refused(
        at,
        "motion line.csv -o t.csv --report nope/x.html",
        "no-folder",
    );
    refused(
        at,
        "motion line.csv -o t.csv --report d --force",
        "is-folder",
    );
    refused(at, "motion line.csv -o t.csv --figures -", "figures-target");
    refused(at, "motion line.csv -o t.csv --report -", "report-target");
    refused(
        at,
        "calibrate d/poses/poses.csv -o c.json --report nope/x.html",
        "no-folder",
    );
    fs::create_dir(at.join("figs")).unwrap();
    fs::write(at.join("figs/position.svg"), "mine").unwrap();
    refused(at, "motion line.csv -o t.csv --figures figs", "exists");
    refused(
        at,
        "motion line.csv -o t.csv --figures figs --causal",
        "not-causal",
    );
}

#[test]
fn a_line_breaks_where_samples_are_missing() {
    let folder = folder();
    let at = folder.path();
    let text = fs::read_to_string(at.join("line.csv")).unwrap();
    // A second at rest is gone.
    let kept: Vec<&str> = text
        .lines()
        .enumerate()
        .filter(|(i, _)| !(200..300).contains(i))
        .map(|(_, l)| l)
        .collect();
    fs::write(at.join("gap.csv"), kept.join("\n")).unwrap();
    let run = run_in(
        at,
        words("motion gap.csv -c cal.json --figures f --report r.html --json --quiet"),
    );
    assert_eq!(run.code, 0, "{}", run.err);
    for name in ["acceleration", "velocity", "position"] {
        let csv = fs::read_to_string(at.join(format!("f/{name}.csv"))).unwrap();
        let own: Vec<&str> = csv
            .lines()
            .filter(|l| l.starts_with("x,calibrated,"))
            .collect();
        let breaks: Vec<usize> = (0..own.len())
            .filter(|i| own[*i].starts_with("x,calibrated,,"))
            .collect();
        let [only] = breaks[..] else {
            panic!("{name}: {breaks:?}")
        };
        let time = |i: usize| own[i].split(',').nth(2).unwrap().parse::<f64>().unwrap();
        assert!(time(only + 1) - time(only - 1) > 0.9, "{name}");
    }
}
