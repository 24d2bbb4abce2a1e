//! Lines, breaks and zero tails.

use super::*;

#[test]
fn every_line_is_accounted_for() {
    let text = "Fs,100\n\nt,ax,ay,az\n\
                0,0.1,0.2,9.8\n\n,,,\n1,0.1,0.2,9.8\n# a remark\nt,ax,ay,az\n2,0.1,0.2\n\
                3,0.1,0.2,9.8,4,0.1\n4,0.1,abc,9.8\n5,,0.2,9.8\n\u{0}6,0.1,0.2,9.8\n";
    let (out, summary) = run(&si(), text);
    let starts: Vec<&str> = out.lines().map(|l| l.split(',').next().unwrap()).collect();
    assert_eq!(starts, ["t", "0", "", "1", "4", "5", "6"]);
    assert_eq!(out.lines().nth(4).unwrap(), "4,,,");
    let aside = |reason: Reason| {
        let entry = summary.set_aside.iter().find(|s| s.reason == reason);
        entry.map_or(0, |s| s.lines)
    };
    assert_eq!((summary.lines, summary.rows), (14, 5));
    for (reason, lines) in [
        (Reason::Header, 1),
        (Reason::Metadata, 2),
        (Reason::Blank, 2),
        (Reason::Comment, 1),
        (Reason::RepeatedHeader, 1),
        (Reason::TornLine, 1),
        (Reason::TooManyFields, 1),
    ] {
        assert_eq!(aside(reason), lines, "{reason:?}");
    }
    assert_eq!(finding(&summary, "torn-line").lines, [[10, 10]]);
    assert_eq!(finding(&summary, "empty-cells").lines, [[12, 13]]);
    assert_eq!(finding(&summary, "nul-bytes").lines, [[14, 14]]);
    assert_eq!(summary.rows_without_acceleration, 2);
}

#[test]
fn a_named_gap_is_written_as_a_break() {
    let row = |i: usize| match i {
        50 => "# gap: the board was reset, the clock of the board starts anew".to_owned(),
        ..50 => format!("{},0.1,0.{},9.8,7", 9000 + 10 * i, i % 3),
        _ => format!("{},0.1,0.{},9.8,7", 6000 + 10 * i, i % 3),
    };
    let text = still("t_ms,ax,ay,az,n", 100, row);
    let (out, summary) = run(&si(), &text);
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!((lines.len(), lines[51], summary.rows), (101, "", 99));
    assert_eq!(finding(&summary, "named-gap").lines, [[52, 52]]);
    assert_eq!(finding(&summary, "restarted-time").lines, [[53, 53]]);
}

#[test]
fn rows_that_are_no_measurement_stay_rows_without_values() {
    // Zeros, and a sensor that hangs, which repeats what it last measured.
    let row = |i: usize| match i {
        200..230 => format!("{i},0,0,0,7"),
        300..340 => format!("{i},0.11,0.22,9.8,7"),
        _ => format!("{i},0.1,0.{:03},9.8,7", 200 + i % 7),
    };
    let (out, summary) = run(&si(), &still("t,ax,ay,az,n", 400, row));
    let is_empty = |i: usize| out.lines().any(|l| l == format!("{i},,,,7"));
    assert_eq!((summary.rows, summary.rows_without_acceleration), (400, 69));
    assert!(is_empty(200) && is_empty(229) && !is_empty(230));
    assert!(!is_empty(300) && is_empty(301) && is_empty(339) && !is_empty(340));
    finding(&summary, "zero-rows");
    finding(&summary, "sensor-hung");
    let error = refused(&si(), "ax,ay,az\n0,0,0\n0,0,0\n", &options());
    assert_eq!(error.code(), "all-zero");
}

/// A recording with faults.
fn faulty() -> String {
    let row = |i: usize| {
        let x = i as f64;
        let is_clipped = i % 500 < 4 && i > 4000;
        let az = 9.8 + 0.01 * x.cos();
        let az = if is_clipped { 19.6127 } else { az };
        let stamp = if i == 5000 { 49_940 } else { 10 * i };
        let ax = 0.01 * x.sin();
        let gx = (0.3 * x).sin();
        let line = format!("{stamp},{ax:.4},0.2,{az:.4},{gx:.3},0.01,0.5");
        match i {
            7000 => format!("{line}\n\nt_ms,ax,ay,az,gx,gy,gz"),
            7100 => line[..12].to_owned(),
            7200 => format!("{stamp},,0.2,9.8,1,2,3"),
            9990.. => format!("{stamp},0.0000,0.0000,0.0000,0.000,0.000,0.000"),
            _ => line,
        }
    };
    still("t_ms,ax,ay,az,gx,gy,gz", 10_000, row)
}

#[test]
fn findings_equal_those_of_reading_into_memory() {
    let text = faulty();
    let (_, applied) = run(&si(), &text);
    let read = read_bytes(text.as_bytes(), "rec.csv", &ReadOptions::default()).unwrap();
    assert_eq!(applied.lines, read.ledger.lines as u64);
    let measured = applied.rows - applied.rows_without_acceleration;
    assert_eq!(measured, read.ledger.rows() as u64 - 1);
    assert_eq!(applied.findings, read.findings);
    for kind in ["clipped", "zero-rows", "torn-line", "repeated-header"] {
        finding(&applied, kind);
    }
}

#[test]
fn files_without_rows_are_refused_before_writing() {
    let input = from_reader(Box::new(&b"ax,ay,az\n,0.1,9.8\n,0.2,9.8\n"[..]), false).unwrap();
    let mut out = Vec::new();
    let error = apply(&si(), input, "rec.csv", &mut out, &options()).unwrap_err();
    assert_eq!((error.code(), out.len()), ("no-values", 0));
    assert_eq!(refused(&si(), "", &options()).code(), "empty-file");
}
