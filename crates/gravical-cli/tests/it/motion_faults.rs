//! `gravical motion` of what cannot be read, cannot be meant, or has gaps.

use crate::bad_input::refused;
use crate::motion::{line, motion};
use crate::support::*;

#[test]
fn wrong_calls() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    for (options, code, named) in [
        ("--gravity 5", "option-range", "gravity"),
        ("--causal --smooth butter:4,5Hz", "option-range", "filters"),
        ("--truth -", "truth-stdin", ""),
        ("--gyro line/line.csv", "gyro-twice", ""),
        ("--truth line/line.csv", "truth-columns-missing", ""),
    ] {
        let call = format!("motion line/line.csv {options}");
        refused(path, &call, 2, code, &[named]);
    }
    for wrong in [
        "--smooth best:5",
        "--smooth highpass:4,0.5Hz",
        "--rests 5-3",
        "--rests five",
        "--p0 1,2,up",
        "--gravity-removal best",
        "--zero-velocity maybe",
    ] {
        let run = run_in(path, words(&format!("motion line/line.csv {wrong}")));
        assert!(run.code == 2 && run.out.is_empty(), "{wrong}\n{}", run.err);
    }
}

#[test]
fn bad_input() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let nan = "10,nan,0.1,9.8\n20,nan,0.2,9.8\n".repeat(40);
    write(path, "nan.csv", &format!("Timestamp (ms),ax,ay,az\n{nan}"));
    let bare = (0..900).map(|i| format!("0.0{},0.1{},9.8{}\n", i % 3, i % 4, i % 5));
    write(
        path,
        "bare.csv",
        &format!("ax,ay,az\n{}", bare.collect::<String>()),
    );
    // A calibration in counts.
    for make in [
        "simulate poses -o raw --seed 1 --raw --quiet",
        "calibrate raw/poses.csv -o raw.json --gravity 9.80665 --quiet",
    ] {
        assert_eq!(run_in(path, words(make)).code, 0, "{make}");
    }
    for (what, code) in [
        ("none.csv", "not-found"),
        ("line/line.csv -c none.json", "not-found"),
        ("line/line.csv --truth none.csv", "not-found"),
        ("nan.csv", "no-values"),
        ("bare.csv", "rate-unknown"),
        ("line/line.csv -c raw.json", "unit-mismatch"),
    ] {
        refused(path, &format!("motion {what} -o out.csv"), 3, code, &[]);
    }
    assert!(!path.join("out.csv").exists());
    // Without stamps a rate will do.
    let rated = motion(path, "bare.csv --rate 100", 0);
    close(rated["duration_s"].as_f64().unwrap(), 8.99, 0.011);
}

#[test]
fn few_rows_and_odd_ones_do_not_end_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    type Row = fn(usize) -> String;
    let odd: [(usize, Row); 5] = [
        (1, |_| "0,0.1,0.2,9.8\n".to_owned()),
        (2, |i| format!("{},0.1,0.2,9.8\n", 10 * i)),
        (500, |i| format!("{},0.1,0.2,9.8\n", 10 * i)),
        (500, |i| format!("{},0.{},0.2,9.8\n", 10 * (i ^ 1), i % 7)),
        (500, |i| format!("{},{}e60,0.2,9.8\n", 10 * i, i % 7)),
    ];
    for (k, (rows, row)) in odd.into_iter().enumerate() {
        let rows: String = (0..rows).map(row).collect();
        write(path, "odd.csv", &format!("Timestamp (ms),ax,ay,az\n{rows}"));
        let run = run_in(path, words("motion odd.csv"));
        assert!([0, 3, 4].contains(&run.code), "{k}: {}", run.err);
        assert!(!run.out.contains("NaN") && !run.out.contains("inf"), "{k}");
    }
}

#[test]
fn a_gap_in_the_only_move_leaves_nothing_to_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let text = std::fs::read_to_string(path.join("line/line.csv")).unwrap();
    let rows = text
        .lines()
        .enumerate()
        .filter(|(i, _)| !(570..640).contains(i));
    let cut: String = rows.map(|(_, l)| format!("{l}\n")).collect();
    write(path, "cut.csv", &cut);
    let result = motion(path, "cut.csv -c cal.json", 4);
    assert!(result["final"]["position_m"].is_null());
    assert!(result["moves"][0]["unusable"].is_string());
}
