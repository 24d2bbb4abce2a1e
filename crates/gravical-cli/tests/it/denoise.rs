//! `gravical denoise`: what is written, what is said, and what is refused.

mod stamps;

use crate::support::*;
use serde_json::Value;
use std::path::Path;

/// A rest of 600 rows with two more columns, one of them text.
fn rest(folder: &Path) -> Vec<String> {
    let mut lines = report_lines(
        "t_ms,ax,ay,az,Temp (C),gx (rad/s),gy (rad/s),gz (rad/s)",
        600,
    );
    for (i, line) in lines.iter_mut().enumerate() {
        line.push_str(if i == 0 { ",note" } else { ",\"a, b\"" });
    }
    write(folder, "rest.csv", &(lines.join("\n") + "\n"));
    lines
}

/// The summary of `denoise FILE -o out.csv --force …`.
fn summary(folder: &Path, line: &str) -> Value {
    let run = ends(
        folder,
        &format!("denoise {line} -o out.csv --force --json --quiet"),
        0,
    );
    assert!(run.err.is_empty(), "{}", run.err);
    run.json()
}

fn written(folder: &Path) -> Vec<Vec<String>> {
    let cells = |line: &str| -> Vec<String> { line.split(',').map(str::to_owned).collect() };
    read(folder, "out.csv").lines().map(cells).collect()
}

#[test]
fn only_the_channels_change() {
    let folder = tempfile::tempdir().unwrap();
    let before = rest(folder.path());
    let reported = summary(folder.path(), "rest.csv --filter savgol:5,2");
    let after = written(folder.path());
    assert_eq!(after.len(), before.len());
    assert_eq!(after[0].join(","), before[0]);
    assert_eq!(reported["columns"][1], "ax");
    let mut changed = 0;
    for (after, before) in after.iter().zip(&before).skip(1) {
        let before: Vec<&str> = before.split(',').collect();
        assert_eq!(after[0], before[0]);
        assert_eq!(after[4], before[4]);
        assert_eq!(after[8..], before[8..]);
        changed +=
            usize::from(after[1].parse::<f64>().unwrap() != before[1].parse::<f64>().unwrap());
    }
    assert!(changed > 500, "{changed}");

    // What it says of the noise is true of what was written.
    let gain = reported["filters"][0]["noise_gain"].as_f64().unwrap();
    close(gain, (17.0_f64 / 35.0).sqrt(), 1e-12);
    let sigma = |of: &Value| numbers(&of["accelerometer"]);
    let (recorded, filtered) = (
        sigma(&reported["recorded"]),
        sigma(&reported["filters"][0]["sigma"]),
    );
    for (recorded, filtered) in recorded.iter().zip(filtered) {
        close(filtered / recorded, gain, 0.06);
    }
}

#[test]
fn the_summary_says_what_smoothing_does_not_do() {
    let folder = tempfile::tempdir().unwrap();
    rest(folder.path());
    let line = "denoise rest.csv --filter butter:4,5Hz --filter mean:3";
    let run = ends(folder.path(), line, 0);
    for said in ["600 rows filtered → stdout", "does not reduce drift"] {
        assert!(run.err.contains(said), "{}", run.err);
    }
    crate::compare_check::narrow(&run.err);
}

/// Calls of `denoise`, the exit code and the code of each.
const WRONG: &str = "\
rest.csv -o new.csv: 2 no-filter
rest.csv -o new.csv --filter butter:4,60Hz: 2 filter-range
rest.csv -o new.csv --filter butter:4,1e-9Hz: 2 filter-range
untimed.csv -o new.csv --filter butter:4,5Hz: 2 rate-unknown
. -o new.csv --filter mean:3: 3 is-a-directory
rest.csv --filter mean:3: 2 json-needs-output";

#[test]
fn wrong_calls() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    rest(at);
    write(at, "untimed.csv", &"ax,ay,az\n0.1,0.2,9.8\n".repeat(30));
    for row in WRONG.lines() {
        let (line, wanted) = row.split_once(": ").unwrap();
        let (exit, code) = wanted.split_once(' ').unwrap();
        let error = fails(at, &format!("denoise {line}"), exit.parse().unwrap(), code);
        assert!(error["hint"].is_string(), "{line}: {error}");
        assert!(!at.join("new.csv").exists(), "{line}");
    }
}

#[test]
fn counts_stay_counts() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().unwrap();
    // Unsigned counts: what is subtracted on reading is there again when written. A high-pass leaves
    // nothing of it.
    let path = data.join("imu_tk-xsens/xsens_acc.txt.gz");
    for (filter, row, wanted) in [("savgol:11,2", 1, 33108.0), ("highpass:2,5Hz", 100, 0.0)] {
        let line = format!("{} --filter {filter}", path.display());
        let reported = summary(folder.path(), &line);
        assert_eq!(reported["accel_unit"], "counts");
        let rows = read(folder.path(), "out.csv");
        let cells: Vec<&str> = rows.lines().nth(row).unwrap().split('\t').collect();
        close(cells[1].trim().parse().unwrap(), wanted, 20.0);
    }
}
