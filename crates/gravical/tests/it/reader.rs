//! Faults of real recordings, one at a time: each is reported with its lines, every line is
//! accounted for, and the mean is unaffected.

mod headers;
mod units;

use std::fmt::Write as _;

use crate::support::*;
use gravical::recording::{AccelUnit, ReadOptions, Recording, TimeUnit, read_bytes};

const ROWS: usize = 600;

fn lines() -> Vec<String> {
    report_lines(HEADER, ROWS)
}

fn joined(lines: &[String]) -> Vec<u8> {
    (lines.join("\n") + "\n").into_bytes()
}

/// All rows were read unchanged.
fn unharmed(recording: &Recording) {
    let clean = read(&joined(&lines()));
    assert!(clean.findings.is_empty(), "{:?}", clean.findings);
    assert_eq!(recording.accel, clean.accel);
    assert_eq!(recording.gyro, clean.gyro);
}

/// Puts `value` into a column of these lines.
fn set(lines: &mut [String], column: usize, value: &str) {
    for line in lines {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[column] = value;
        *line = cells.join(",");
    }
}

/// Replaces the stamps by `stamp(row)`.
fn stamp(lines: &mut [String], stamp: fn(usize) -> usize) {
    for row in 0..ROWS {
        set(&mut lines[row + 1..row + 2], 0, &stamp(row).to_string());
    }
}

/// What a fault leaves of the values.
#[derive(PartialEq)]
enum Left {
    All,
    /// The mean changes by less than a fifth of the noise of a row.
    Mean,
    Rows,
}

/// A fault, and the finding of it with its lines and a part of its message.
struct Fault {
    damage: fn(&mut Vec<String>),
    kind: &'static str,
    lines: &'static [[u64; 2]],
    says: &'static str,
    left: Left,
    rows: usize,
}

const FAULT: Fault = Fault {
    damage: |_| (),
    kind: "",
    lines: &[],
    says: "",
    left: Left::All,
    rows: ROWS,
};

const FAULTS: [Fault; 12] = [
    Fault {
        damage: |lines| lines[0].insert_str(0, &"\0".repeat(37)),
        kind: "nul-bytes",
        lines: &[[1, 1]],
        ..FAULT
    },
    Fault {
        damage: |lines| {
            lines.insert(201, HEADER.to_owned());
            lines.insert(402, HEADER.to_owned());
        },
        kind: "repeated-header",
        lines: &[[202, 202], [403, 403]],
        ..FAULT
    },
    Fault {
        damage: |lines| drop(lines.splice(301..301, ["", ",,,,,,,", "   "].map(str::to_owned))),
        kind: "blank-rows",
        lines: &[[302, 304]],
        ..FAULT
    },
    Fault {
        damage: |lines| drop(lines.remove(0)),
        kind: "columns-guessed",
        says: "t,ax,ay,az,temp,gx,gy,gz",
        ..FAULT
    },
    Fault {
        damage: |lines| lines.push("6120,0.3051,-0.2".to_owned()),
        kind: "torn-line",
        lines: &[[602, 602]],
        says: "6120,0.3051,-0.2",
        ..FAULT
    },
    Fault {
        damage: |lines| {
            let next = lines.remove(101);
            lines[100].push_str(&next);
        },
        kind: "too-many-fields",
        lines: &[[101, 101]],
        left: Left::Mean,
        rows: ROWS - 2,
        ..FAULT
    },
    Fault {
        damage: |lines| set(&mut lines[200..201], 1, "x?"),
        kind: "not-a-number",
        lines: &[[201, 201]],
        left: Left::Mean,
        ..FAULT
    },
    Fault {
        damage: |lines| {
            set(&mut lines[50..53], 3, "");
            set(&mut lines[60..61], 1, "NaN");
        },
        kind: "empty-cells",
        says: "az 3",
        left: Left::Mean,
        ..FAULT
    },
    Fault {
        damage: |lines| set(&mut lines[201..351], 2, "-0.1234"),
        kind: "frozen-axis",
        lines: &[[202, 351]],
        says: "ay ",
        left: Left::Rows,
        ..FAULT
    },
    Fault {
        damage: |lines| set(&mut lines[101..121], 3, "19.6127"),
        kind: "clipped",
        lines: &[[102, 121]],
        says: "az ",
        left: Left::Rows,
        ..FAULT
    },
    Fault {
        damage: |lines| {
            stamp(lines, |row| match row {
                100 => 990,
                300 | 301 => 2990,
                _ => 10 * row,
            });
        },
        kind: "duplicate-time",
        lines: &[[102, 102], [302, 303]],
        ..FAULT
    },
    Fault {
        damage: |lines| stamp(lines, |row| 100 * (row / 10)),
        kind: "burst-time",
        ..FAULT
    },
];

#[test]
fn faults_are_reported_with_their_lines_and_leave_the_rest() {
    let clean = read(&joined(&lines()));
    for fault in &FAULTS {
        let (mut lines, kind) = (lines(), fault.kind);
        (fault.damage)(&mut lines);
        let end = if kind == "torn-line" { "" } else { "\n" };
        let recording = read((lines.join("\n") + end).as_bytes());
        let found = finding(&recording, kind);
        assert!(
            fault.lines.is_empty() || found.lines == fault.lines,
            "{found:?}"
        );
        assert!(format!("{found:?}").contains(fault.says), "{found:?}");
        assert_eq!(recording.rows(), fault.rows, "{kind}");
        let breaks: &[usize] = if kind == "blank-rows" { &[300] } else { &[] };
        assert_eq!(recording.breaks, breaks, "{kind}");
        let tolerance_hz = if kind == "burst-time" { 2.0 } else { 0.5 };
        close(recording.timing.rate_hz().unwrap(), 100.0, tolerance_hz);
        if fault.left == Left::All {
            unharmed(&recording);
        } else if fault.left == Left::Mean {
            for (got, want) in accel_means(&recording).into_iter().zip(accel_means(&clean)) {
                close(got, want, 0.006);
            }
        }
    }
}

#[test]
fn headers_and_single_blank_lines_are_breaks_only_if_the_clock_jumps() {
    for line in [HEADER, ""] {
        let mut lines = lines();
        lines.insert(301, line.to_owned());
        assert!(read(&joined(&lines)).breaks.is_empty(), "{line}");
        lines.drain(302..350);
        assert_eq!(read(&joined(&lines)).breaks, [300], "{line}");
    }
}

#[test]
fn a_rate_other_than_the_claimed_one_is_reported() {
    let mut lines = lines();
    stamp(&mut lines, |row| 16 * row);
    let recording = read(&[&b"Fs,100\n"[..], &joined(&lines)].concat());
    let found = finding(&recording, "rate-mismatch");
    assert!(found.message.contains("62.50 Hz"), "{}", found.message);
    assert_eq!(recording.timing.nominal_rate_hz, Some(100.0));
    close(recording.timing.rate_hz().unwrap(), 62.5, 1e-9);
    unharmed(&recording);
}

#[test]
fn rows_read_faster_than_the_sensor_measures_are_reported() {
    let mut lines = lines();
    for i in (1..ROWS).step_by(2) {
        let values = lines[i].split_once(',').unwrap().1.to_owned();
        let stamp = lines[i + 1].split_once(',').unwrap().0.to_owned();
        lines[i + 1] = format!("{stamp},{values}");
    }
    let recording = read(&joined(&lines));
    assert_eq!(finding(&recording, "repeated-rows").count, ROWS as u64 / 2);
}

#[test]
fn impossible_temperatures_are_empty_cells() {
    // Steps of 500: 4000 rows in 2 s, if they are microseconds, which 3300 °C would exclude.
    let text = |driver: &str| {
        let mut text = "t,ax,ay,az,temp (C)\n".to_owned();
        for i in 0..4000 {
            let t_c = match i {
                1000 => driver.to_owned(),
                _ => format!("25.{}", i % 3),
            };
            writeln!(text, "{},0.0{},0.1,9.8{},{t_c}", 500 * i, i % 7, i % 5).unwrap();
        }
        text
    };
    for driver in ["-3276.80", "-999", "1e9"] {
        let recording = read(text(driver).as_bytes());
        assert_eq!(recording.timing.unit, Some(TimeUnit::Microsecond));
        let temperatures = recording.temperature_c.as_ref().unwrap();
        assert!(temperatures[1000].is_nan() && temperatures[1001] == 25.2);
        let empty = finding(&recording, "empty-cells");
        assert_eq!((empty.count, &empty.lines[..]), (1, &[[1002, 1002]][..]));
        assert!(empty.message.contains("1 of them outside -60 to 150 °C"));
    }
    let empty = read(text("").as_bytes());
    assert!(!finding(&empty, "empty-cells").message.contains("outside"));
}
