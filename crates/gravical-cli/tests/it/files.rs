//! What is written, and what is never written over.

use serde_json::Value;

use crate::support::*;

#[test]
fn an_existing_file_is_kept_unless_forced() {
    let folder = six_files(&Sensor::default());
    let path = folder.path();
    write(path, "cal.json", "precious");
    let line = "calibrate . --gravity 9.81 -o cal.json";
    let run = run_in(path, words(&format!("{line} --json")));
    assert_eq!((run.code, run.error_code().as_str()), (2, "exists"));
    let kept = || std::fs::read_to_string(path.join("cal.json")).unwrap();
    assert_eq!(kept(), "precious");
    let run = run_in(path, words(line));
    assert_eq!(run.code, 2);
    assert!(run.err.contains("--force"), "{}", run.err);
    assert_eq!(kept(), "precious");

    let run = run_in(path, words(&format!("{line} --force")));
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.out.contains("Saved to cal.json"), "{}", run.out);
    assert!(run.out.contains("gravical apply cal.json"), "{}", run.out);

    let run = run_in(path, words("export cal.json --to imucal -o cal.json"));
    assert_eq!(run.code, 2);
    assert!(kept().contains("gravical-calibration/2"));
}

#[test]
fn a_written_calibration_is_what_json_prints() {
    let folder = six_files(&Sensor::default());
    let printed = calibrate(folder.path(), ". --gravity 9.81 -o cal.json", 0);
    let text = std::fs::read_to_string(folder.path().join("cal.json")).unwrap();
    let written: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(printed, written);
    assert!(text.ends_with("}\n"));
    // No leftovers of writing in one step.
    let names: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(names.len(), 7, "{names:?}");
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
    let line = "calibrate . --gravity 9.81 -o cal.json --quiet";
    assert_eq!(run_in(path, words(line)).code, 0);
    for line in ["inspect cal.json", "calibrate cal.json", "motion cal.json"] {
        let run = run_in(path, words(line));
        assert_eq!(run.code, 3, "{line}");
        assert!(run.err.contains("code: is-a-calibration"), "{}", run.err);
        assert!(
            run.err.contains("gravical check cal.json RECORDING"),
            "{}",
            run.err
        );
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
    let run = run_in(folder.path(), words("calibrate torn.csv"));
    assert_eq!(run.code, 3, "{}", run.out);
    assert!(
        run.err
            .contains("reading torn.csv lost samples: 100 torn-line"),
        "{}",
        run.err
    );
    assert!(
        run.err.contains("`gravical inspect torn.csv`"),
        "{}",
        run.err
    );
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
        let run = run_in(path, words("export cal.json --to imucal"));
        assert!(run.code == 3 && run.out.is_empty(), "{text}");
        assert!(run.err.contains(&format!("code: {code}")), "{}", run.err);
        assert!(run.err.contains(place), "{text}: {}", run.err);
    }
}

#[test]
fn simulate_writes_nothing_over_and_says_the_same_twice() {
    let folder = tempfile::tempdir().unwrap();
    let line = "simulate six-position --hold 1 -o a --seed 5 --quiet";
    assert_eq!(run_in(folder.path(), words(line)).code, 0);
    let run = run_in(folder.path(), words(&format!("{line} --json")));
    assert_eq!((run.code, run.error_code().as_str()), (2, "exists"));
    let other = line.replace("-o a", "-o b");
    assert_eq!(run_in(folder.path(), words(&other)).code, 0);
    for entry in std::fs::read_dir(folder.path().join("a")).unwrap() {
        let one = entry.unwrap().path();
        let two = folder.path().join("b").join(one.file_name().unwrap());
        assert_eq!(std::fs::read(&one).unwrap(), std::fs::read(&two).unwrap());
    }
}
