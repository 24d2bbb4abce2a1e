//! What is written, and what is never written over.

use std::fs;

use serde_json::Value;

use crate::support::*;

/// What is written is what `--json` prints, and the same session gives the same bytes.
#[test]
fn a_written_calibration() {
    let folder = six_files(&Sensor::default());
    let written = || {
        let line = words("calibrate . --json -o cal.json --force");
        let dated = ("SOURCE_DATE_EPOCH", "1700000000");
        let run = run_with(folder.path(), |c| c.args(line).env(dated.0, dated.1));
        let text = read(folder.path(), "cal.json");
        assert_eq!(run.json(), serde_json::from_str::<Value>(&text).unwrap());
        text
    };
    let one = written();
    assert_eq!(one, written());
    assert!(one.contains("2023-11-14T22:13:20Z"), "SOURCE_DATE_EPOCH");
    // No leftovers of writing in one step.
    assert_eq!(listed(folder.path()).len(), 7);
}

#[test]
fn what_reading_lost_is_named_with_the_error() {
    let folder = tempfile::tempdir().unwrap();
    let text = Sensor::default().file([0.0, 0.0, 1.0], 400, 7);
    let torn = |(i, line): (usize, &str)| match i % 4 {
        3 => format!("{}\n", &line[..6]),
        _ => format!("{line}\n"),
    };
    let text: String = text.lines().enumerate().map(torn).collect();
    write(folder.path(), "torn.csv", &text);
    let err = ends(folder.path(), "calibrate torn.csv", 3).err;
    let said = "reading torn.csv lost samples: 100 torn-line";
    assert!(err.contains(said), "{err}");
}

#[test]
fn broken_calibrations_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let older = "{\"format\": \"gravical-calibration/2\"}";
    for (text, code, place) in [
        ("{\n\"format\": \n", "calibration-syntax", "cal.json:3"),
        (older, "calibration-format", "calibrate again"),
        ("{\"K_a\": 3}", "calibration-syntax", "cal.json"),
    ] {
        write(folder.path(), "cal.json", text);
        let run = ends(folder.path(), "export cal.json --to imucal", 3);
        assert!(run.out.is_empty(), "{text}");
        assert!(run.err.contains(&format!("code: {code}")), "{}", run.err);
        assert!(run.err.contains(place), "{text}: {}", run.err);
    }
}

#[test]
fn parameters_that_no_sensor_has_are_refused() {
    let folder = demo();
    let path = folder.path().join("d/calibration.json");
    let file: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    for (bias, code) in [(9e3, 0), (1e6, 3)] {
        let mut file = file.clone();
        file["accelerometer"]["bias"][1] = bias.into();
        write(folder.path(), "cal.json", &file.to_string());
        let run = ends(folder.path(), "export cal.json --to gravical", code);
        let said = "accelerometer.bias: matrix · bias is ";
        assert_eq!(run.err.contains(said), code == 3, "{}", run.err);
    }
}
