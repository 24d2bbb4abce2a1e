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

/// Every verb that has a document writes it in both forms.
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
    ];
    for (i, line) in lines.iter().enumerate() {
        for ending in ["html", "md"] {
            let name = format!("report{i}.{ending}");
            let line = format!("{line} --report {name} --force --json");
            let run = run_in(path, words(&line));
            assert!([0, 4].contains(&run.code), "{line}{}{}", run.out, run.err);
            let text = read(path, &name);
            let inputs = ["line.csv", "cal.json", "poses.csv"];
            assert!(inputs.iter().any(|input| text.contains(input)), "{line}");
            assert!(text.contains(&format!("report{i}")), "its command: {line}");
            // Every figure that Markdown links to is there.
            for link in text.split("](<").skip(1).filter(|_| ending == "md") {
                let link = link.split(">)").next().unwrap();
                assert!(link.starts_with(&format!("report{i}_figures/")), "{link}");
                assert!(path.join(link).is_file(), "{link}");
            }
            let figures = path.join(format!("report{i}_figures")).is_dir();
            assert_eq!(figures, ending == "md" && i > 3, "{line}");
        }
    }
    let two = "inspect line/line.csv poses/poses.csv --report two.md";
    fails(path, two, 2, "report-of-one");
}
