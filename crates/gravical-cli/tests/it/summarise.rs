//! Epochs of a worn sensor.

use std::fs;
use std::path::Path;

use crate::support::*;

/// Two hours at 10 Hz, at rest but for 20 min after the first half hour, that begin at `start`.
fn recording(folder: &Path, name: &str, start: f64) {
    let mut csv = "time_s,ax_g,ay_g,az_g\n".to_owned();
    for i in 0..72_000 {
        let t = f64::from(i) / 10.0;
        let moved = (1800.0..3000.0).contains(&t) && i % 2 == 0;
        // Of three axes two have to move.
        let (y, z) = if moved { (0.2, 1.3) } else { (0.0, 1.0) };
        csv += &format!("{:.1},0.0{},{y},{z}\n", start + t, i % 3);
    }
    fs::write(folder.join(name), csv).unwrap();
}

/// 2026-03-29T00:00:00Z: an hour before the change to summer time.
const START: f64 = 1_774_742_400.0;

#[test]
fn table_and_summary_agree_and_go_where_they_are_wanted() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    recording(at, "wrist.csv", START);
    let line = "summarise wrist.csv --epoch 60 --time-zone Europe/Berlin";
    let done = run_in(at, words(&format!("{line} -o epochs.csv --json")));
    assert_eq!(done.code, 0, "{}", done.err);
    let summary = done.json();
    let table = fs::read_to_string(at.join("epochs.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table.lines().map(|l| l.split(',').collect()).collect();
    let (header, rows) = rows.split_first().unwrap();
    assert_eq!(summary["epochs"], rows.len());
    assert_eq!(summary["columns"], serde_json::json!(header));
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let times = [rows[59][0], rows[60][0]];
    assert_eq!(
        times,
        ["2026-03-29T01:59:00+01:00", "2026-03-29T03:00:00+02:00"]
    );
    // Every hour that touches the motion is worn: blocks 0 to 4 of eight.
    let worn: Vec<bool> = rows.iter().map(|r| r[column("nonwear")] == "0").collect();
    assert_eq!(summary["wear_s"], 60 * worn.iter().filter(|w| **w).count());
    assert_eq!(worn.iter().rposition(|w| *w), Some(74));
    assert!(worn[..75].iter().all(|w| *w));
    close(
        rows[40][column("enmo_mg")].parse::<f64>().unwrap(),
        157.7,
        0.2,
    );
    // The table alone goes to a pipe, and the summary to people.
    let piped = run_in(at, words(line));
    assert_eq!(piped.out, table);
    assert!(piped.err.contains("120 epochs of 60 s"), "{}", piped.err);
    assert!(
        piped.err.contains("no calibration was applied"),
        "{}",
        piped.err
    );
    // And from standard input.
    let shown = run_in(
        at,
        words("summarise wrist.csv -o again.csv --report page.html"),
    );
    assert_eq!(shown.code, 0, "{}", shown.err);
    assert!(
        fs::read_to_string(at.join("page.html"))
            .unwrap()
            .contains("2026-03-29")
    );
}

#[test]
fn wrong_calls_say_what_is_right() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    recording(at, "wrist.csv", 5.0);
    for (line, code, exit) in [
        ("wrist.csv --epoch 7", "option-range", 2),
        ("wrist.csv --time-zone Europe/Berlin", "time-zone-unused", 2),
        ("wrist.csv wrist.csv", "one-recording", 2),
        ("wrist.csv --summary all.csv", "each-option", 2),
        ("wrist.csv --calibration wrist.csv", "calibration-syntax", 3),
    ] {
        let refused = run_in(at, words(&format!("summarise {line} -o out.csv --json")));
        assert_eq!(
            (refused.code, &refused.error_code()[..]),
            (exit, code),
            "{line}"
        );
        assert!(!at.join("out.csv").exists());
    }
    let unknown = run_in(at, words("summarise wrist.csv --time-zone Mars/Olympus"));
    assert_eq!(unknown.code, 2);
    assert!(unknown.err.contains("Europe/Berlin"), "{}", unknown.err);
}

#[test]
fn many_recordings_have_a_table_each_and_a_row_in_the_summary() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("study")).unwrap();
    recording(&at.join("study"), "anna.csv", START);
    recording(&at.join("study"), "ben.csv", START + 86_400.0);
    fs::write(at.join("study/cleo.csv"), "t,ax,ay,az\n1,2\n").unwrap();
    let line = "summarise --each study -o tables --summary study.json --epoch 60 --quiet";
    let all = run_in(at, words(line));
    assert_eq!(all.code, 4, "{}", all.err);
    let alone = run_in(at, words("summarise study/ben.csv --epoch 60 --quiet"));
    assert_eq!(
        fs::read_to_string(at.join("tables/ben.csv")).unwrap(),
        alone.out
    );
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(at.join("study.json")).unwrap()).unwrap();
    let rows = summary["rows"].as_array().unwrap();
    assert_eq!(rows[0]["epochs"], 120);
    assert_eq!(rows[1]["start"], "2026-03-30T00:00:00Z");
    assert_eq!(rows[0]["wear_s"], rows[1]["wear_s"]);
    assert_eq!(rows[2]["status"], "error");
    let again = run_in(at, words("collect tables --json"));
    assert_eq!(again.json()["counts"]["done"], 2);
}
