//! Faults of real recordings, one at a time: each is reported with its lines, every line is
//! accounted for, and the mean is unaffected.

mod headers;

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

/// Of each fault: the finding of it, its lines, a part of it, and what is left: all values, the mean to a
/// fifth of the noise of a row, or the number of rows.
const FAULTS: &str = "\
nul-bytes | 1-1 | - | all
repeated-header | 202-202 403-403 | - | all
blank-rows | 302-304 | - | all
columns-guessed | - | t,ax,ay,az,temp,gx,gy,gz | all
torn-line | 602-602 | 6120,0.3051,-0.2 | all
too-many-fields | 101-101 | - | mean
not-a-number | 201-201 | - | mean
empty-cells | - | az 3 | mean
frozen-axis | 202-351 | ay  | rows
clipped | 102-121 | az  | rows
duplicate-time | 102-102 302-303 | - | all
burst-time | - | - | all";

fn damage(lines: &mut Vec<String>, kind: &str) {
    match kind {
        "nul-bytes" => lines[0].insert_str(0, &"\0".repeat(37)),
        "repeated-header" => {
            lines.insert(201, HEADER.to_owned());
            lines.insert(402, HEADER.to_owned());
        }
        "blank-rows" => drop(lines.splice(301..301, ["", ",,,,,,,", "   "].map(str::to_owned))),
        "columns-guessed" => drop(lines.remove(0)),
        "torn-line" => lines.push("6120,0.3051,-0.2".to_owned()),
        "too-many-fields" => {
            let next = lines.remove(101);
            lines[100].push_str(&next);
        }
        "not-a-number" => set(&mut lines[200..201], 1, "x?"),
        "empty-cells" => {
            set(&mut lines[50..53], 3, "");
            set(&mut lines[60..61], 1, "NaN");
        }
        "frozen-axis" => set(&mut lines[201..351], 2, "-0.1234"),
        "clipped" => set(&mut lines[101..121], 3, "19.6127"),
        "duplicate-time" => stamp(lines, |row| match row {
            100 => 990,
            300 | 301 => 2990,
            _ => 10 * row,
        }),
        _ => stamp(lines, |row| 100 * (row / 10)),
    }
}

#[test]
fn faults_are_reported_with_their_lines_and_leave_the_rest() {
    let clean = read(&joined(&lines()));
    for row in FAULTS.lines() {
        let [kind, spans, says, left] = row.split(" | ").collect::<Vec<_>>().try_into().unwrap();
        let mut lines = lines();
        damage(&mut lines, kind);
        let end = if kind == "torn-line" { "" } else { "\n" };
        let recording = read((lines.join("\n") + end).as_bytes());
        let found = finding(&recording, kind);
        let own = found.lines.iter().map(|[a, b]| format!("{a}-{b}"));
        let own = own.collect::<Vec<_>>().join(" ");
        assert!(spans == "-" || own == spans, "{found:?}");
        let said = format!("{found:?}");
        assert!(says == "-" || said.contains(says), "{said}");
        let lost = if kind == "too-many-fields" { 2 } else { 0 };
        assert_eq!(recording.rows(), ROWS - lost, "{kind}");
        let breaks: &[usize] = if kind == "blank-rows" { &[300] } else { &[] };
        assert_eq!(recording.breaks, breaks, "{kind}");
        let tolerance_hz = if kind == "burst-time" { 2.0 } else { 0.5 };
        close(recording.clock.rate_hz().unwrap(), 100.0, tolerance_hz);
        if left == "all" {
            unharmed(&recording);
        } else if left == "mean" {
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
    assert_eq!(recording.clock.nominal_rate_hz, Some(100.0));
    close(recording.clock.rate_hz().unwrap(), 62.5, 1e-9);
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
        assert_eq!(recording.clock.unit, Some(TimeUnit::Microsecond));
        let temperatures = recording.temperature_c.as_ref().unwrap();
        assert!(temperatures[1000].is_nan() && temperatures[1001] == 25.2);
        let empty = finding(&recording, "empty-cells");
        assert_eq!((empty.count, &empty.lines[..]), (1, &[[1002, 1002]][..]));
        assert!(empty.message.contains("1 of them outside -60 to 150 °C"));
    }
    let empty = read(text("").as_bytes());
    assert!(!finding(&empty, "empty-cells").message.contains("outside"));
}

/// Half of the cells are empty where each channel is written when it arrives; text is no such cell.
#[test]
fn values_hold_in_empty_cells_and_not_in_text() {
    for (cell, is_held) in [("", true), ("NaN", true), ("err", false)] {
        let mut lines = lines();
        for line in lines[2..].iter_mut().step_by(2) {
            set(std::slice::from_mut(line), 2, cell);
        }
        let recording = read(&joined(&lines));
        let held = recording.accel[1].windows(2).filter(|w| w[0] == w[1]);
        assert_eq!(held.count() > ROWS / 3, is_held, "{cell}");
    }
}

/// Counts of an MPU6050 at ±`range` g, at rest with z up.
fn counts(range: f64) -> Vec<u8> {
    let sensor = Sensor {
        unit: 32768.0 / range / 9.80665,
        decimals: 0,
        ..Sensor::default()
    };
    sensor.file([0.0, 0.0, 1.0], ROWS, 3).into_bytes()
}

#[test]
fn a_wrong_full_scale_setting_is_reported() {
    // ±4 g was set and ±2 g is claimed: the claim is used, with a warning.
    let claim =
        |accel_unit| read_options(|o| (o.accel_unit, o.accel_range_g) = (accel_unit, Some(2.0)));
    for (unit, kind, words) in [
        (None, "range-mismatch", "corresponds to ±4.000 g"),
        (Some(AccelUnit::Counts), "unit-mismatch", "0.53 g"),
    ] {
        let recording = read_with(&counts(4.0), &claim(unit));
        assert_eq!(recording.units.accel.lsb_per_g, Some(16384.0));
        let message = &finding(&recording, kind).message;
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn an_unnamed_index_column_does_not_shift_the_channels() {
    // R's write.table and pandas write no name for the index.
    for header in [format!(",{HEADER}"), HEADER.to_owned()] {
        let mut lines = lines();
        for (row, line) in lines.iter_mut().enumerate() {
            line.insert_str(0, &format!("{row},"));
        }
        lines[0] = header;
        unharmed(&read(&joined(&lines)));
    }
}

#[test]
fn columns_by_name_and_in_order() {
    let text = joined(&lines());
    let plain = read(&text);
    let by_name = |spec: &str| read_options(|o| o.columns = Some(spec.parse().unwrap()));
    // x and y are swapped by name; other columns are assigned automatically.
    let [x, y, z] = &plain.accel;
    for spec in ["ax=aY (m/s^2),ay=aX (m/s^2),temp=-", "_,ay,ax,az,-"] {
        let given = read_with(&text, &by_name(spec));
        assert_eq!(given.accel.each_ref(), [y, x, z], "{spec}");
        assert_eq!((&given.gyro, &given.time_s), (&plain.gyro, &plain.time_s));
        assert!(given.temperature_c.is_none());
    }
    let given = read_with(&text, &by_name("gx=-,gy=-,gz=-"));
    assert!(given.gyro.is_none() && given.temperature_c.is_some());
}
