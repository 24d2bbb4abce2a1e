//! `gravical motion`: its table, its summary, its flags.

use std::path::Path;

use serde_json::Value;

use crate::bad_input::all_refused;
use crate::support::*;

/// A line of 0.7 m and a calibration of the same sensor.
pub fn line(folder: &Path) {
    for line in [
        "simulate line -o line --seed 1 --quiet",
        "simulate poses -o poses --seed 1 --quiet",
        "calibrate poses/poses.csv -o cal.json --gravity 9.80665 --quiet",
    ] {
        ends(folder, line, 0);
    }
}

pub fn motion(folder: &Path, line: &str, code: i32) -> Value {
    let run = ends(folder, &format!("motion {line} --json --quiet"), code);
    assert!(run.err.is_empty(), "{}", run.err);
    run.json()
}

#[test]
fn the_table_goes_out_and_the_summary_aside() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let run = ends(path, "motion line/line.csv -c cal.json", 0);
    assert_eq!(run.out.lines().count(), 1201, "{}", run.err);
    narrow(&run.err);
    // The same into a file, with the summary as JSON.
    let saved = ends(path, "motion line/line.csv -c cal.json -o m.csv --json", 0);
    assert!(saved.err.contains("→ m.csv"), "{}", saved.err);
    assert!(read(path, "m.csv") == run.out);
    assert_eq!(saved.json(), motion(path, "line/line.csv -c cal.json", 0));
    // Read again by our own reader, which says which of its columns it reads.
    let again = motion(path, "m.csv -c cal.json", 0);
    let raw = finding(&again, "several-sensors")["message"].to_string();
    assert!(raw.contains("raw ones (raw_ax_mps2 …) are read"), "{raw}");
    assert!(!kinds(&again).contains(&"already-calibrated"));
}

#[test]
fn the_procedure_of_the_student_report() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    line(path);
    let by_report = "line/line.csv -c cal.json --procedure report";
    let report = motion(path, by_report, 4);
    assert_eq!(report["frame"], "the sensor's own axes");
    let tilt = "line/line.csv -c cal.json --procedure constant-tilt";
    let velocity = |result: &Value| numbers(&result["final"]["velocity_mps"]);
    assert_eq!(velocity(&motion(path, tilt, 0)), [0.0; 3]);

    // Rests by hand.
    let end = |result: &Value| numbers(&result["final"]["position_m"]);
    let given = motion(path, "line/line.csv --rests 0-4.8,7.2-", 0);
    assert_eq!(list(&given["rests"]).len(), 2);
    close(number(&given["rests"][0]["end_s"]), 4.8, 0.011);
    close(end(&given)[0], 0.02, 0.1);
    close(end(&given)[1], 0.7, 0.1);
    let open = motion(path, "line/line.csv --rests 0-4.8", 4);
    assert_eq!(open["verdict"]["judgement"], "open");
}

/// A board whose clock is set in the middle; the search for slow moves once went through all the
/// years.
#[test]
fn a_clock_that_is_set_by_thirty_years_begins_again() {
    let folder = tempfile::tempdir().unwrap();
    line(folder.path());
    let text = read(folder.path(), "line/line.csv");
    let later = |(i, row): (usize, &str)| match row.split_once(',') {
        Some((stamp, rest)) if i > 900 => {
            let stamp = stamp.parse::<u64>().unwrap() + 1_000_000_000_000;
            format!("{stamp},{rest}\n")
        }
        _ => format!("{row}\n"),
    };
    let text: String = text.lines().enumerate().map(later).collect();
    write(folder.path(), "set.csv", &text);
    let result = motion(folder.path(), "set.csv -c cal.json", 4);
    finding(&result, "restarted-time");
}

/// Calls that are refused, and write nothing.
const REFUSED: &str = "\
motion line/line.csv -o out.csv --gravity 5 | 2 option-range | gravity
motion line/line.csv -o out.csv -c cal.json --procedure report --rests 0-4 | 2 option-range | mean of the first rows
motion line/line.csv -o out.csv --rests 3-3.001 | 2 rests-outside
motion line/line.csv -o out.csv --gyro line/line.csv | 2 gyro-twice
motion none.csv -o out.csv | 3 not-found
motion line/line.csv -o out.csv -c none.json | 3 not-found
motion nan.csv -o out.csv | 3 no-values
motion bare.csv -o out.csv | 3 rate-unknown
motion line/line.csv -o out.csv -c raw.json | 3 unit-mismatch";

#[test]
fn what_cannot_be_read_or_meant() {
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
    all_refused(path, REFUSED);
    for wrong in ["--rests 5-3", "--rests five", "--procedure best"] {
        ends(path, &format!("motion line/line.csv -o out.csv {wrong}"), 2);
    }
    assert!(!path.join("out.csv").exists());
    // Without stamps a rate will do.
    let rated = motion(path, "bare.csv --rate 100", 0);
    close(number(&rated["duration_s"]), 8.99, 0.011);
}
