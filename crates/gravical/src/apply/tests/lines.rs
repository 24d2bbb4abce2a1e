//! Lines, breaks, zero tails, and input in small pieces.

use super::*;

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
    assert_eq!(
        refused(&si(), "ax,ay,az\n0,0,0\n0,0,0\n", &options()).code(),
        "all-zero"
    );
}

/// Delivers a few bytes at a time, as a pipe does.
struct SmallReads<'a>(&'a [u8], usize);

impl Read for SmallReads<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.1 = self.1 * 5 % 97 + 1;
        let n = self.1.min(out.len()).min(self.0.len());
        let (now, later) = self.0.split_at(n);
        out[..n].copy_from_slice(now);
        self.0 = later;
        Ok(n)
    }
}

/// A recording with faults, longer than the head.
fn faulty() -> String {
    let row = |i: usize| {
        let x = i as f64;
        let stamp = match i {
            5000 => 10 * i - 60,
            5001..5003 => 50010,
            _ => 10 * i,
        };
        let ay = match i {
            6000..6300 => 0.25,
            _ => 0.2 + 0.01 * (1.7 * x).sin(),
        };
        let az = match i % 500 {
            ..4 if i > 4000 => 19.6127,
            _ => 9.8 + 0.01 * x.cos(),
        };
        let (ax, gx) = (0.01 * x.sin(), (0.3 * x).sin());
        let line = format!("{stamp},{ax:.4},{ay:.4},{az:.4},{gx:.3},0.01,0.500");
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
fn small_pieces_and_memory_give_equal_rows_and_findings() {
    let text: &'static str = Box::leak(faulty().into_boxed_str());
    let (whole, applied) = run(&si(), text);
    let input = from_reader(Box::new(SmallReads(text.as_bytes(), 7)), false).unwrap();
    let mut out = Vec::new();
    let by_pieces = apply(&si(), input, "rec.csv", &mut out, &options()).unwrap();
    assert!(whole.as_bytes() == out);
    assert_eq!(applied, by_pieces);

    let read = read_bytes(text.as_bytes(), "rec.csv", &ReadOptions::default()).unwrap();
    assert_eq!(applied.lines, read.ledger.lines as u64);
    let complete = applied.rows - applied.rows_without_acceleration;
    assert_eq!(complete, read.ledger.rows() as u64 - 1);
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
