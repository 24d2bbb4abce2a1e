//! `gravical denoise`: what is written, what is said, and what is refused.

use std::path::Path;

use serde_json::Value;

use crate::support::*;

/// A rest of 600 rows with two more columns, one of them text.
fn rest(folder: &Path) -> Vec<String> {
    let header = "t_ms,ax,ay,az,Temp (C),gx (rad/s),gy (rad/s),gz (rad/s)";
    let mut lines = report_lines(header, 600);
    for (i, line) in lines.iter_mut().enumerate() {
        line.push_str(if i == 0 { ",note" } else { ",\"a, b\"" });
    }
    write(folder, "rest.csv", &(lines.join("\n") + "\n"));
    lines
}

/// The summary of `denoise FILE -o out.csv --force …`, and the cells that were written.
fn denoised(folder: &Path, line: &str) -> (Value, Vec<Vec<String>>) {
    let line = format!("denoise {line} -o out.csv --force --json --quiet");
    let run = ends(folder, &line, 0);
    assert!(run.err.is_empty(), "{}", run.err);
    let cells = |line: &str| -> Vec<String> { line.split(',').map(str::to_owned).collect() };
    let written = read(folder, "out.csv").lines().map(cells).collect();
    (run.json(), written)
}

#[test]
fn only_the_channels_change() {
    let folder = tempfile::tempdir().unwrap();
    let before = rest(folder.path());
    let (reported, after) = denoised(folder.path(), "rest.csv --filter savgol:5,2");
    assert_eq!(after.len(), before.len());
    assert_eq!(after[0].join(","), before[0]);
    let mut changed = 0;
    for (after, before) in after.iter().zip(&before).skip(1) {
        let before: Vec<&str> = before.split(',').collect();
        assert_eq!(after[0], before[0]);
        assert_eq!(after[4], before[4]);
        assert_eq!(after[8..], before[8..]);
        let value = |cell: &str| -> f64 { cell.parse().unwrap() };
        changed += usize::from(value(&after[1]) != value(before[1]));
    }
    assert!(changed > 500, "{changed}");

    // What it says of the noise is true of what was written.
    let gain = reported["filters"][0]["noise_gain"].as_f64().unwrap();
    close(gain, (17.0_f64 / 35.0).sqrt(), 1e-12);
    let filtered = numbers(&reported["filters"][0]["sigma"]["accelerometer"]);
    let recorded = numbers(&reported["recorded"]["accelerometer"]);
    for (recorded, filtered) in recorded.iter().zip(filtered) {
        close(filtered / recorded, gain, 0.06);
    }
}

/// Calls of `denoise`, the exit code and the code of each.
const WRONG: &str = "\
rest.csv -o new.csv: 2 no-filter
rest.csv -o new.csv --filter butter:4,60Hz: 2 filter-range
rest.csv -o new.csv --filter butter:4,1e-9Hz: 2 filter-range
untimed.csv -o new.csv --filter butter:4,5Hz: 2 rate-unknown
. -o new.csv --filter savgol:5,2: 3 is-a-directory
rest.csv -o - --filter savgol:5,2: 2 json-needs-output
anyhow.csv -o new.csv --filter savgol:7,2: 3 uneven-stamps
anyhow.csv -o new.csv --filter butter:2,5Hz: 3 uneven-stamps";

#[test]
fn wrong_calls() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    rest(at);
    uneven(at);
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
        let (reported, rows) = denoised(folder.path(), &line);
        assert_eq!(reported["accel_unit"], "counts");
        let cells: Vec<&str> = rows[row][0].split('\t').collect();
        close(cells[1].trim().parse().unwrap(), wanted, 20.0);
    }
}

#[test]
fn gaps_breaks_and_what_is_too_short() {
    let folder = tempfile::tempdir().unwrap();
    // A step from one level to another across the gap, as after a pause.
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for i in 0..300 {
        let (pause, level) = if i < 150 { (0, 0.0) } else { (300, 5.0) };
        text += &format!("{},{level},0.1,9.81\n", 10 * i + pause);
    }
    text += "3700,1,1,9.81\n3710,1,1,9.81\n\n\n3720,2,2,9.81\n";
    write(folder.path(), "gap.csv", &text);
    for filter in ["savgol:11,2", "butter:4,2Hz"] {
        let (reported, rows) = denoised(folder.path(), &format!("gap.csv --filter {filter}"));
        assert_eq!(reported["segments"], 4, "{filter}");
        let samples = rows.iter().skip(1).filter(|r| r.len() == 4);
        for (i, row) in samples.take(300).enumerate() {
            let want = if i < 150 { 0.0 } else { 5.0 };
            // Nothing of one side gets to the other.
            close(row[1].parse().unwrap(), want, 1e-6);
        }
        assert_eq!(finding(&reported, "not-filtered")["count"], 9, "{filter}");
        // Blank rows are still a break.
        assert_eq!(rows.iter().filter(|r| r.join("").is_empty()).count(), 1);
    }
}

#[test]
fn empty_cells_stay_empty_and_spoil_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let text = Sensor::default().file([0.0, 0.0, 1.0], 400, 4);
    let mut holes: Vec<&str> = text.lines().collect();
    (holes[101], holes[251]) = ("1000,,0.1,9.8", "2500,0.1,NaN,");
    write(folder.path(), "holes.csv", &(holes.join("\n") + "\n"));
    for filter in ["savgol:5,2", "butter:4,5Hz", "hampel:7,3"] {
        let (reported, rows) = denoised(folder.path(), &format!("holes.csv --filter {filter}"));
        assert_eq!(finding(&reported, "empty-cells")["count"], 2, "{filter}");
        let cells = (1..rows.len()).flat_map(|r| (1..4).map(move |c| (r, c)));
        let empty = cells.filter(|(r, c)| rows[*r][*c].is_empty());
        let wanted = [(101, 1), (251, 2), (251, 3)];
        assert_eq!(empty.collect::<Vec<_>>(), wanted, "{filter}");
    }
}

/// A slope in time, which interpolation keeps: sampled anyhow, and with lost rows.
fn slope(t: f64) -> f64 {
    1.0 + 2.0 * t
}

fn uneven(folder: &Path) {
    let (mut anyhow, mut lost) = ("t,ax,ay,az\n".to_owned(), "t,ax,ay,az\n".to_owned());
    for i in 0..300 {
        let t = 0.01 * f64::from(i) + 0.0037 * f64::from(i * 7 % 3 - 1);
        anyhow += &format!("{t:.6},{:.9},0.5,9.81\n", slope(t));
        let t = 0.01 * f64::from(i);
        if i % 37 != 5 {
            lost += &format!("{t:.6},{:.9},0.5,9.81\n", slope(t));
        }
    }
    write(folder, "anyhow.csv", &anyhow);
    write(folder, "lost.csv", &lost);
}

#[test]
fn lost_rows_are_bridged() {
    let folder = tempfile::tempdir().unwrap();
    uneven(folder.path());
    for line in [
        "anyhow.csv --filter hampel:7,3",
        "anyhow.csv --filter savgol:7,2 --columns t=- --rate 100",
        "lost.csv --filter savgol:7,2",
    ] {
        let (reported, rows) = denoised(folder.path(), line);
        assert_eq!(reported["segments"], 1, "{line}");
        if line.starts_with("lost") {
            for row in &rows[1..] {
                let t_s = row[0].parse().unwrap();
                close(row[1].parse().unwrap(), slope(t_s), 3e-6);
            }
        }
    }
}
