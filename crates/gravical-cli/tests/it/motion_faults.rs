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
        let run = ends(path, &format!("motion line/line.csv {wrong}"), 2);
        assert!(run.out.is_empty(), "{wrong}");
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
    let bare = format!("ax,ay,az\n{}", bare.collect::<String>());
    write(path, "bare.csv", &bare);
    // A calibration in counts.
    for make in [
        "simulate poses -o raw --seed 1 --raw --quiet",
        "calibrate raw/poses.csv -o raw.json --gravity 9.80665 --quiet",
    ] {
        ends(path, make, 0);
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
    close(number(&rated["duration_s"]), 8.99, 0.011);
}
