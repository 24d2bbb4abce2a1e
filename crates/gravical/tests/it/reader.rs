//! Faults of real recordings, one at a time: each is reported with its lines, every line is
//! accounted for, and the mean is unaffected.

mod cells;
mod headers;
mod stamps;
mod units;

use crate::support::*;
use gravical::recording::{AccelUnit, ReadOptions, Recording, Severity, read_bytes};

const ROWS: usize = 600;

fn lines() -> Vec<String> {
    report_lines(HEADER, ROWS)
}

fn joined(lines: &[String]) -> Vec<u8> {
    (lines.join("\n") + "\n").into_bytes()
}

/// The undamaged recording, without findings.
fn clean() -> Recording {
    let recording = read(&joined(&lines()));
    assert_eq!(recording.rows(), ROWS);
    assert!(recording.findings.is_empty(), "{:?}", recording.findings);
    recording
}

/// All rows were read unchanged.
fn unharmed(recording: &Recording) {
    let clean = clean();
    assert_eq!(recording.accel, clean.accel);
    assert_eq!(recording.gyro, clean.gyro);
}

/// Rows were lost, but the mean changed by less than a fifth of the noise of a row.
fn nearly_unharmed(recording: &Recording) {
    let clean = accel_means(&clean());
    for (got, want) in accel_means(recording).into_iter().zip(clean) {
        close(got, want, 0.006);
    }
}

#[test]
fn nul_bytes_before_the_header_are_removed() {
    let mut bytes = vec![0; 37];
    bytes.extend(joined(&lines()));
    let recording = read(&bytes);
    assert_eq!(finding(&recording, "nul-bytes").lines, [[1, 1]]);
    unharmed(&recording);
}

#[test]
fn repeated_headers_are_breaks_only_if_the_clock_jumps() {
    let mut lines = lines();
    lines.insert(201, HEADER.to_owned());
    lines.insert(402, HEADER.to_owned());
    let recording = read(&joined(&lines));
    let found = finding(&recording, "repeated-header");
    assert_eq!(found.lines, [[202, 202], [403, 403]]);
    assert_eq!(found.severity, Severity::Warning);
    assert!(recording.breaks.is_empty());
    unharmed(&recording);
    // Rows are missing at the first header.
    lines.drain(202..252);
    let recording = read(&joined(&lines));
    assert_eq!(recording.breaks, [200]);
}

#[test]
fn a_single_blank_line_is_a_break_only_if_the_clock_jumps() {
    let mut lines = lines();
    lines.insert(301, String::new());
    assert!(read(&joined(&lines)).breaks.is_empty());
    lines.drain(302..350);
    assert_eq!(read(&joined(&lines)).breaks, [300]);
}

#[test]
fn blank_rows_are_breaks() {
    let mut lines = lines();
    for blank in ["", ",,,,,,,", "   "] {
        lines.insert(301, blank.to_owned());
    }
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "blank-rows").lines, [[302, 304]]);
    assert_eq!(recording.breaks, [300]);
    assert_eq!(recording.line(299), 301);
    assert_eq!(recording.line(300), 305);
    unharmed(&recording);
}

#[test]
fn columns_without_a_header_are_assigned_by_values() {
    let recording = read(&joined(&lines()[1..]));
    let found = finding(&recording, "columns-guessed");
    assert!(
        found.message.contains("t,ax,ay,az,temp,gx,gy,gz"),
        "{}",
        found.message
    );
    assert_eq!(recording.accel_scale.unit, AccelUnit::MetrePerSecondSquared);
    unharmed(&recording);
}

#[test]
fn empty_cells_are_counted_and_not_in_means() {
    let mut lines = lines();
    for at in [50, 51, 52] {
        let mut cells: Vec<&str> = lines[at].split(',').collect();
        cells[3] = "";
        lines[at] = cells.join(",");
    }
    lines[60] = lines[60]
        .split(',')
        .enumerate()
        .map(|(i, c)| if i == 1 { "NaN" } else { c })
        .collect::<Vec<_>>()
        .join(",");
    let recording = read(&joined(&lines));
    let found = finding(&recording, "empty-cells");
    assert_eq!(found.count, 4);
    assert!(found.message.contains("az 3"), "{}", found.message);
    assert_eq!(recording.rows(), ROWS);
    assert!(recording.accel[2][49].is_nan() && recording.accel[0][59].is_nan());
    nearly_unharmed(&recording);
}

#[test]
fn a_half_written_last_line_is_set_aside() {
    let mut bytes = joined(&lines());
    bytes.extend(b"6120,0.3051,-0.2");
    let recording = read(&bytes);
    let found = finding(&recording, "torn-line");
    assert_eq!(found.lines, [[602, 602]]);
    assert!(
        found.message.contains("6120,0.3051,-0.2"),
        "{}",
        found.message
    );
    unharmed(&recording);
}

#[test]
fn joined_lines_and_garbage_are_set_aside() {
    let mut lines = lines();
    let next = lines.remove(101);
    lines[100].push_str(&next);
    lines[200] = lines[200].replacen(',', ",x?", 1);
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "too-many-fields").lines, [[101, 101]]);
    assert_eq!(finding(&recording, "not-a-number").lines, [[201, 201]]);
    assert_eq!(recording.rows(), ROWS - 2);
    nearly_unharmed(&recording);
}

#[test]
fn a_frozen_axis_is_reported() {
    let mut lines = lines();
    for line in &mut lines[201..351] {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[2] = "-0.1234";
        *line = cells.join(",");
    }
    let recording = read(&joined(&lines));
    let found = finding(&recording, "frozen-axis");
    assert_eq!(found.lines, [[202, 351]]);
    assert!(found.message.starts_with("ay"), "{}", found.message);
}
