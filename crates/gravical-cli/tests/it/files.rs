//! What is written, and what is never written over.

use serde_json::Value;

use crate::support::*;

#[test]
fn a_written_calibration_is_what_json_prints() {
    let folder = six_files(&Sensor::default());
    let printed = calibrate(folder.path(), ". --gravity 9.81 -o cal.json", 0);
    let text = read(folder.path(), "cal.json");
    assert_eq!(printed, serde_json::from_str::<Value>(&text).unwrap());
    assert!(text.ends_with("}\n"));
    // No leftovers of writing in one step.
    assert_eq!(listed(folder.path()).len(), 7);
}

#[test]
fn the_same_session_gives_the_same_bytes() {
    let folder = six_files(&Sensor::default());
    let write = |name: &str| {
        let status = std::process::Command::new(program())
            .args(["calibrate", ".", "--quiet", "-o", "cal.json", "--force"])
            .env("SOURCE_DATE_EPOCH", "1700000000")
            .current_dir(folder.path())
            .status()
            .unwrap();
        assert!(status.success());
        std::fs::rename(folder.path().join("cal.json"), folder.path().join(name)).unwrap();
        std::fs::read_to_string(folder.path().join(name)).unwrap()
    };
    let (one, two) = (write("one.out"), write("two.out"));
    assert_eq!(one, two);
    assert!(one.contains("2023-11-14T22:13:20Z"), "SOURCE_DATE_EPOCH");
}

#[test]
fn a_calibration_in_place_of_a_recording_is_named() {
    let folder = six_files(&Sensor::default());
    let path = folder.path();
    ends(path, "calibrate . --gravity 9.81 -o cal.json --quiet", 0);
    for line in ["inspect cal.json", "calibrate cal.json", "motion cal.json"] {
        let err = ends(path, line, 3).err;
        for said in [
            "code: is-a-calibration",
            "gravical check cal.json RECORDING",
        ] {
            assert!(err.contains(said), "{line}: {err}");
        }
    }
}

#[test]
fn what_reading_lost_is_named_with_the_error() {
    let folder = tempfile::tempdir().unwrap();
    let text = Sensor::default().file([0.0, 0.0, 1.0], 400, 7);
    let torn: String = text
        .lines()
        .enumerate()
        .map(|(i, line)| match i % 4 {
            3 => format!("{}\n", &line[..6]),
            _ => format!("{line}\n"),
        })
        .collect();
    write(folder.path(), "torn.csv", &torn);
    let err = ends(folder.path(), "calibrate torn.csv", 3).err;
    for said in [
        "reading torn.csv lost samples: 100 torn-line",
        "`gravical inspect torn.csv`",
    ] {
        assert!(err.contains(said), "{err}");
    }
}

#[test]
fn broken_calibrations_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (text, code, place) in [
        ("{\n\"format\": \n", "calibration-syntax", "cal.json:3"),
        (
            "{\"format\": \"gravical-calibration/9\"}",
            "calibration-format",
            "/9",
        ),
        ("{\"K_a\": 3}", "calibration-syntax", "cal.json"),
    ] {
        write(path, "cal.json", text);
        let run = ends(path, "export cal.json --to imucal", 3);
        assert!(run.out.is_empty(), "{text}");
        assert!(run.err.contains(&format!("code: {code}")), "{}", run.err);
        assert!(run.err.contains(place), "{text}: {}", run.err);
    }
}
