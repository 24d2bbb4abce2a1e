//! `--report`: where it goes, what it leaves alone, and the files that it names. What else is in it is tested
//! in `gravical-report` and by `tests/browser`.

use gravical::calibration_file::{InputFile, InputRole};

use crate::support::*;

#[test]
fn a_motion_names_and_sums_everything_that_went_in() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    crate::motion::line(path);
    let inputs = "line/line.csv -c cal.json";
    json(path, &format!("motion {inputs} --report r.html"), 0);
    let page = read(path, "r.html");
    for name in ["line/line.csv", "cal.json"] {
        let file = InputFile::read(&path.join(name), InputRole::Other, |_| Ok(()));
        let sum = file.unwrap().1.sha256.unwrap();
        assert!(page.contains(&format!("{name}, SHA-256 {sum}")), "{name}");
    }
}

/// Every verb that has a document writes it as a page, with figures.
#[test]
fn every_verb_reports() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    crate::motion::line(path);
    let lines = [
        "check cal.json line/line.csv",
        "compare cal.json cal.json",
        "inspect line/line.csv",
        "denoise line/line.csv --filter savgol:5,2 -o smooth.csv",
        "calibrate poses/poses.csv",
        "motion line/line.csv -c cal.json -o moved.csv",
        "orient line/line.csv -c cal.json -o turned.csv",
    ];
    for (i, line) in lines.iter().enumerate() {
        let line = format!("{line} --report report{i}.html --figures figures{i} --force --json");
        let run = run_in(path, words(&line));
        assert!([0, 4].contains(&run.code), "{line}{}{}", run.out, run.err);
        let text = read(path, &format!("report{i}.html"));
        let inputs = ["line.csv", "cal.json", "poses.csv"];
        assert!(inputs.iter().any(|input| text.contains(input)), "{line}");
        assert!(
            text.contains(&format!("--report report{i}")),
            "its command: {line}"
        );
        // Each figure of the page is a file.
        let files = listed(&path.join(format!("figures{i}")));
        let drawn = text.matches("<figure id=").count();
        assert!(drawn > 0 && files.len() == drawn, "{line}: {files:?}");
    }
    let two = "inspect line/line.csv poses/poses.csv --report two.html";
    fails(path, two, 2, "report-of-one");
    fails(
        path,
        "inspect line/line.csv --report page.md",
        2,
        "report-target",
    );
}
