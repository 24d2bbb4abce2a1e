//! A calibration from a folder of them: of the same sensor, the last one before the recording.

use std::path::Path;

use crate::support::*;

fn gravical(folder: &Path, line: &str, code: i32) -> Run {
    let run = run_in(folder, words(line));
    assert_eq!(run.code, code, "{line}\n{}{}", run.out, run.err);
    run
}

/// Calibrations of two sensors, the first one twice, and a recording.
fn calibrated() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::create_dir(at.join("cals")).unwrap();
    for (seed, sensor, date) in [
        (1, "left", "2026-03-01"),
        (2, "left", "2026-05-01"),
        (3, "right", "2026-04-01"),
    ] {
        gravical(
            at,
            &format!("simulate poses -o s{seed} --seed {seed} --hold 2 --free 2 -q"),
            0,
        );
        let line = format!(
            "calibrate s{seed}/poses.csv -q --sensor-id {sensor} --recorded {date} -o cals/{sensor}-{date}.json"
        );
        gravical(at, &line, 0);
    }
    write(at, "cals/notes.json", "{}");
    gravical(at, "simulate line -o line --seed 1 --rest 2 -q", 0);
    folder
}

#[test]
fn the_last_of_the_sensor_before_the_recording_is_taken() {
    let folder = calibrated();
    let at = folder.path();
    for (options, expected) in [
        (
            "--sensor-id left --recorded 2026-04-15",
            "cals/left-2026-03-01.json",
        ),
        (
            "--sensor-id left --recorded 2026-06-01",
            "cals/left-2026-05-01.json",
        ),
        ("--sensor-id left", "cals/left-2026-05-01.json"),
        ("--sensor-id right", "cals/right-2026-04-01.json"),
    ] {
        let applied = gravical(
            at,
            &format!("apply cals line/line.csv -o a.csv --force {options}"),
            0,
        );
        assert!(
            applied
                .err
                .contains(&format!("Calibration: {expected}, the last")),
            "{}",
            applied.err
        );
        let is_dated = options.contains("--recorded");
        assert_eq!(
            applied.err.contains("has no date"),
            !is_dated,
            "{}",
            applied.err
        );
        gravical(
            at,
            &format!("apply {expected} line/line.csv -o b.csv --force"),
            0,
        );
        let read = |name: &str| std::fs::read(at.join(name)).unwrap();
        assert!(read("a.csv") == read("b.csv"), "{options}");
    }
    let moved = gravical(
        at,
        "motion line/line.csv -c cals --sensor-id left --recorded 2026-04-15 --json",
        0,
    );
    assert_eq!(moved.json()["calibration"], "cals/left-2026-03-01.json");
    gravical(at, "check cals s3/poses.csv --sensor-id right --json", 0);
    // Of one sensor no name is needed.
    std::fs::remove_file(at.join("cals/right-2026-04-01.json")).unwrap();
    let applied = gravical(
        at,
        "apply cals line/line.csv -o a.csv --force --json --quiet",
        0,
    );
    assert_eq!(applied.json()["calibration"], "cals/left-2026-05-01.json");
}

#[test]
fn a_calibration_that_might_be_the_one_is_not_passed_over() {
    let folder = calibrated();
    let at = folder.path();
    let apply = "apply cals line/line.csv -o a.csv --force --sensor-id left";
    // A day stands for its end.
    let run = gravical(at, &format!("{apply} --recorded 2026-05-01"), 0);
    assert!(run.err.contains("left-2026-05-01"), "{}", run.err);
    let cut = std::fs::read_to_string(at.join("cals/left-2026-05-01.json")).unwrap();
    write(at, "cals/left-2026-05-01.json", &cut[..cut.len() / 2]);
    let run = gravical(at, apply, 3);
    assert!(run.err.contains("left-2026-05-01.json"), "{}", run.err);
    // Calibrations without a sensor may be of several.
    for seed in [1, 2] {
        let line = format!("calibrate s{seed}/poses.csv -q -o unnamed/{seed}.json");
        std::fs::create_dir_all(at.join("unnamed")).unwrap();
        gravical(at, &line, 0);
    }
    let run = gravical(at, "apply unnamed line/line.csv -o b.csv", 2);
    assert!(run.err.contains("code: sensor-id-missing"), "{}", run.err);
    std::fs::remove_file(at.join("unnamed/2.json")).unwrap();
    gravical(at, "apply unnamed line/line.csv -o b.csv", 0);
}

#[test]
fn what_fits_nothing_is_refused_with_what_is_there() {
    let folder = calibrated();
    let at = folder.path();
    gravical(at, "simulate line -o raw --seed 1 --rest 2 --raw -q", 0);
    for (line, code, there) in [
        (
            "apply cals line/line.csv -o a.csv",
            "sensor-id-missing",
            "right-2026-04-01.json: right",
        ),
        (
            "apply cals line/line.csv -o a.csv --sensor-id foot",
            "no-calibration",
            "left-2026-03-01.json: left",
        ),
        (
            "apply cals line/line.csv -o a.csv --sensor-id right --recorded 2026-01-01",
            "no-calibration",
            "2026-04-01",
        ),
        (
            "motion raw/line.csv -c cals --sensor-id left",
            "no-calibration",
            "the recording is in counts, 16384 per g",
        ),
        (
            "apply cals/left-2026-03-01.json line/line.csv -o a.csv --sensor-id left",
            "origin-unused",
            "this is a file",
        ),
        (
            "apply line line/line.csv -o a.csv",
            "no-calibration",
            "no calibration is in this folder",
        ),
    ] {
        let run = run_in(at, words(line));
        assert!([2, 3].contains(&run.code), "{line}\n{}", run.err);
        assert!(
            run.err.contains(&format!("code: {code}")),
            "{line}\n{}",
            run.err
        );
        assert!(run.err.contains(there), "{line}\n{}", run.err);
    }
}
