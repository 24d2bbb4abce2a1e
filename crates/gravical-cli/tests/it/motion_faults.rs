//! `gravical motion` of what cannot be read, cannot be meant, or has gaps.

use crate::bad_input::refused;
use crate::compare_check::narrow;
use crate::motion::{column, line, motion};
use crate::support::*;

#[test]
fn wrong_calls() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    refused(
        path,
        "motion line/line.csv --gravity 5",
        2,
        "option-range",
        &["gravity"],
    );
    refused(
        path,
        "motion line/line.csv --truth -",
        2,
        "truth-stdin",
        &[],
    );
    refused(
        path,
        "motion line/line.csv --gyro line/line.csv",
        2,
        "gyro-twice",
        &[],
    );
    refused(
        path,
        "motion line/line.csv --truth line/line.csv",
        2,
        "truth-columns-missing",
        &[],
    );
    for wrong in [
        "--smooth best:5",
        "--rests 5-3",
        "--rests five",
        "--v0 1,2",
        "--p0 1,2,up",
        "--gravity-removal best",
        "--zero-velocity maybe",
    ] {
        let run = run_in(path, words(&format!("motion line/line.csv {wrong}")));
        assert_eq!(run.code, 2, "{wrong}\n{}", run.err);
        assert!(run.out.is_empty(), "{wrong}");
    }
    let filter = "motion line/line.csv --smooth highpass:4,0.5Hz --json";
    let run = run_in(path, words(filter));
    assert_eq!((run.code, run.error_code().as_str()), (2, "option-range"));
}

#[test]
fn bad_input() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    refused(path, "motion none.csv", 3, "not-found", &[]);
    refused(
        path,
        "motion line/line.csv -c none.json",
        3,
        "not-found",
        &[],
    );
    refused(
        path,
        "motion line/line.csv --truth none.csv",
        3,
        "not-found",
        &[],
    );
    write(path, "empty.csv", "");
    refused(path, "motion empty.csv", 3, "empty-file", &[]);
    let head = "Timestamp (ms),ax,ay,az\n";
    write(
        path,
        "nan.csv",
        &format!("{head}{}", "10,nan,0.1,9.8\n20,nan,0.2,9.8\n".repeat(40)),
    );
    refused(path, "motion nan.csv", 3, "no-values", &[]);
    // Without stamps a rate is needed, and will do.
    let bare: String = (0..900)
        .map(|i| format!("0.0{},0.1{},9.8{}\n", i % 3, i % 4, i % 5))
        .collect();
    write(path, "bare.csv", &format!("ax,ay,az\n{bare}"));
    refused(path, "motion bare.csv", 3, "rate-unknown", &[]);
    let rated = motion(path, "bare.csv --rate 100", 0);
    close(rated["duration_s"].as_f64().unwrap(), 8.99, 0.011);
    // A calibration in counts.
    for make in [
        "simulate poses -o raw --seed 1 --raw --quiet",
        "calibrate raw/poses.csv -o raw.json --gravity 9.80665 --quiet",
    ] {
        assert_eq!(run_in(path, words(make)).code, 0, "{make}");
    }
    refused(
        path,
        "motion line/line.csv -c raw.json",
        3,
        "unit-mismatch",
        &[],
    );
    // Nothing was written by any of them.
    let run = run_in(path, words("motion line/line.csv -c raw.json -o out.csv"));
    assert_eq!(run.code, 3);
    assert!(!path.join("out.csv").exists());
}

#[test]
fn few_rows_and_odd_ones_do_not_end_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let head = "Timestamp (ms),ax,ay,az\n";
    for (name, rows, codes) in [
        ("one", "0,0.1,0.2,9.8\n".to_owned(), vec![0, 3]),
        (
            "two",
            "0,0.1,0.2,9.8\n10,0.1,0.2,9.8\n".to_owned(),
            // Too short to rest: nothing of it can be known.
            vec![3, 4],
        ),
        (
            "constant",
            (0..500)
                .map(|i| format!("{},0.1,0.2,9.8\n", 10 * i))
                .collect(),
            vec![0, 3],
        ),
        (
            "backwards",
            (0..500)
                .map(|i| format!("{},0.{},0.2,9.8\n", 10 * (i ^ 1), i % 7))
                .collect(),
            vec![0, 3],
        ),
        (
            "huge",
            (0..500)
                .map(|i| format!("{},{}e60,0.2,9.8\n", 10 * i, i % 7))
                .collect(),
            vec![0, 3],
        ),
    ] {
        let file = format!("{name}.csv");
        write(path, &file, &format!("{head}{rows}"));
        let run = run_in(path, words(&format!("motion {file}")));
        assert!(
            codes.contains(&run.code),
            "{name}: {}\n{}",
            run.code,
            run.err
        );
        assert!(
            !run.out.contains("NaN") && !run.out.contains("inf"),
            "{name}"
        );
    }
}

#[test]
fn a_gap_in_the_only_move_leaves_nothing_to_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let text = std::fs::read_to_string(path.join("line/line.csv")).unwrap();
    let cut: String = text
        .lines()
        .enumerate()
        .filter(|(i, _)| !(570..640).contains(i))
        .map(|(_, l)| format!("{l}\n"))
        .collect();
    write(path, "cut.csv", &cut);
    let result = motion(path, "cut.csv -c cal.json", 4);
    assert!(result["final"]["position_m"].is_null());
    assert!(
        result["moves"][0]["unusable"]
            .as_str()
            .unwrap()
            .contains("missing")
    );
    assert!(kinds(&result).contains(&"move-unusable".to_owned()));
    let run = run_in(path, words("motion cut.csv -c cal.json -o m.csv"));
    assert_eq!(run.code, 4);
    narrow(&run.err);
    assert!(run.err.contains("not usable"), "{}", run.err);
    let table = std::fs::read_to_string(path.join("m.csv")).unwrap();
    assert!(column(&table, "py_m").iter().any(|p| p.is_nan()));
}
