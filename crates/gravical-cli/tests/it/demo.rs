//! `gravical demo`: what a stranger runs first.

use std::fs;
use std::path::Path;

use crate::support::*;

fn example(name: &str) -> Vec<u8> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/demo");
    fs::read(root.join(name)).unwrap()
}

fn three(value: &serde_json::Value) -> [f64; 3] {
    [0, 1, 2].map(|k| value[k].as_f64().unwrap())
}

#[test]
fn it_calibrates_moves_and_reports() {
    let folder = tempfile::tempdir().unwrap();
    let run = run_in(folder.path(), ["demo", "--json"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let said = run.json();

    // Everything is there, and the recordings are those of the examples.
    let files = said["files"].as_array().unwrap();
    assert_eq!(files.len(), 8);
    for file in files {
        let path = folder.path().join(file.as_str().unwrap());
        assert!(
            fs::metadata(&path).unwrap().len() > 1000,
            "{}",
            path.display()
        );
    }
    for name in ["poses/poses.csv", "line/line.csv"] {
        let made = fs::read(folder.path().join("gravical-demo").join(name)).unwrap();
        assert!(made == example(name), "{name}");
    }
    let page = fs::read_to_string(folder.path().join("gravical-demo/motion.html")).unwrap();
    assert!(page.len() < 2_000_000 && page.contains("<svg"));

    // What it claims is so.
    let number = |key: &str| said[key].as_f64().unwrap();
    assert_eq!(said["verdict"], "good");
    assert!(number("norm_error_left_out_mps2") < 0.05 * number("norm_error_uncalibrated_mps2"));
    let (found, sigma, truth) = (
        three(&said["displacement_m"]),
        three(&said["sigma_m"]),
        three(&said["true_displacement_m"]),
    );
    assert_eq!(truth[1], 0.7);
    for k in 0..3 {
        assert!((found[k] - truth[k]).abs() < 2.0 * sigma[k], "axis {k}");
    }
    assert!(number("end_error_m") < 0.01);
    assert!(number("end_error_report_m") > 0.05);
}

#[test]
fn nothing_of_an_earlier_run_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let first = run_in(folder.path(), ["demo", "-o", "here"]);
    assert_eq!(first.code, 0, "{}", first.err);
    assert!(first.out.contains("Verdict: good") && first.out.contains("here/motion.html"));
    let before = fs::read(folder.path().join("here/motion.html")).unwrap();
    fs::remove_file(folder.path().join("here/poses/poses.csv")).unwrap();

    let again = run_in(folder.path(), ["demo", "-o", "here", "--json"]);
    assert_eq!((again.code, again.error_code().as_str()), (2, "exists"));
    assert!(
        !folder.path().join("here/poses/poses.csv").exists(),
        "refused before it writes"
    );
    assert_eq!(
        fs::read(folder.path().join("here/motion.html")).unwrap(),
        before
    );
    assert_eq!(
        run_in(folder.path(), ["demo", "-o", "here", "--force"]).code,
        0
    );
    // Without a name it takes the next number.
    for written in ["gravical-demo/motion.html", "gravical-demo-2/motion.html"] {
        assert_eq!(run_in(folder.path(), ["demo"]).code, 0);
        assert!(folder.path().join(written).is_file());
    }
}

/// The README shows a figure of the demo. `GRAVICAL_BLESS=1` writes it anew.
#[test]
fn the_figure_of_the_readme_is_what_the_demo_draws() {
    let folder = tempfile::tempdir().unwrap();
    for line in [
        "demo -o here --json",
        "motion here/line/line.csv -c here/calibration.json --figures figures --json --quiet",
    ] {
        let run = run_in(folder.path(), words(line));
        assert_eq!(run.code, 0, "{}", run.err);
    }
    let drawn = fs::read_to_string(folder.path().join("figures/position.svg")).unwrap();
    let shown = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/images/position.svg");
    if std::env::var_os("GRAVICAL_BLESS").is_some() {
        fs::write(&shown, &drawn).unwrap();
    }
    assert!(
        drawn == fs::read_to_string(&shown).unwrap(),
        "docs/images/position.svg is stale; GRAVICAL_BLESS=1 rewrites it"
    );
}
