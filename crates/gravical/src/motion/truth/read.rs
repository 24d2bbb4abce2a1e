//! Reading a reference: stamps and positions out of any table that the reader of
//! recordings understands.

use std::io::{Cursor, Read};
use std::path::Path;

use gravical_recording::judge::{ClockOptions, clock};
use gravical_recording::{HEAD_BYTES, Reason, bytes, sniff_table, whole_lines};

use crate::calibration_file::{InputFile, InputRole};
use crate::finding::LineSpans;
use crate::recording::{Finding, FindingKind, ReadOptions, Recording, open};
use crate::{Error, Result};

use super::columns::Fields;

/// Positions that somebody else measured.
#[derive(Debug, Clone)]
pub struct Reference {
    /// The file as it was given.
    pub source: String,
    /// SHA-256 of the file, where the recording has one.
    pub sha256: Option<String>,
    /// Time, s; rising, without the rows that have no position.
    pub t_s: Vec<f64>,
    /// Position, m.
    pub position_m: Vec<[f64; 3]>,
    /// It stands in the recording itself: one clock, `t_s` is the recording's.
    pub same_file: bool,
    /// What was added to the file's stamps to get `t_s`, s: the recording counts
    /// from its first row, and a file with the recorder's own stamps is put there.
    pub base_s: f64,
    /// What is odd.
    pub findings: Vec<Finding>,
}

impl Reference {
    /// The file that it was read from, for the record.
    #[must_use]
    pub fn input(&self) -> InputFile {
        InputFile {
            path: self.source.clone(),
            sha256: self.sha256.clone(),
            role: InputRole::Reference,
        }
    }
}

/// Reads the reference at `path` for `recording`, which was read from
/// `recorded_at`. When both are one file, the rows keep the recording's time.
///
/// # Errors
///
/// `truth-columns-missing` (usage) when no columns are positions; `truth-time` (input) without usable stamps; `truth-empty`
/// (input) without two positions; and what keeps a file from being read.
pub fn read_reference(path: &Path, recording: &Recording, recorded_at: &Path) -> Result<Reference> {
    let same_file = same_file(path, recorded_at);
    let hash = recording.sha256.is_some();
    let mut raw = read_rows(path, same_file, hash)?;
    let rows = raw.lines.len();
    let time_s = if same_file {
        Some(times_of_lines(recording, &raw.lines))
    } else {
        stamps(&mut raw)
    };
    let time_s = time_s.ok_or_else(|| {
        Error::input("truth-time", "the reference has no usable time stamps")
            .at(path, None)
            .with_hint("name the column of time t_s")
    })?;
    let (mut t_s, mut position_m): (Vec<f64>, Vec<[f64; 3]>) = (Vec::new(), Vec::new());
    let mut absent = LineSpans::default();
    for ((&t, p), &line) in time_s.iter().zip(&raw.position).zip(&raw.lines) {
        let known = t.is_finite() && p.iter().all(|v| v.is_finite());
        // Time that runs backwards is no time; the reader has said so.
        if known && t_s.last().is_none_or(|last| *last <= t) {
            t_s.push(t);
            position_m.push(*p);
        } else {
            absent.push(line);
        }
    }
    if !absent.is_empty() {
        let text = format!(
            "{} of {rows} rows of the reference have no position; stepped over",
            absent.count()
        );
        raw.findings
            .push(Finding::new(FindingKind::TruthGaps, text).at_lines(&absent));
    }
    if t_s.len() < 2 {
        return Err(Error::input(
            "truth-empty",
            format!(
                "{} of {rows} rows of the reference have a position",
                t_s.len()
            ),
        )
        .at(path, None)
        .with_hint("name the columns of the positions px_m, py_m, pz_m"));
    }
    let base_s = if same_file {
        0.0
    } else {
        base(&t_s, recording)
    };
    for t in &mut t_s {
        *t += base_s;
    }
    Ok(Reference {
        source: path.display().to_string(),
        sha256: raw.sha256,
        t_s,
        position_m,
        same_file,
        base_s,
        findings: raw.findings,
    })
}

fn same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

/// What has to be added to stamps so that they count from the recording's first
/// row: nothing where they overlap with it as they are; its first stamp, taken
/// off, where they overlap then; else their own first one, taken off.
fn base(t_s: &[f64], recording: &Recording) -> f64 {
    let (Some(&from), Some(&to)) = (t_s.first(), t_s.last()) else {
        return 0.0;
    };
    let duration = recording.timing.duration_s.unwrap_or(0.0);
    let overlaps = |base: f64| from + base <= duration && to + base >= 0.0;
    [0.0, -recording.time_origin_s.unwrap_or(0.0)]
        .into_iter()
        .find(|base| overlaps(*base))
        .unwrap_or(-from)
}

/// Rows as they stand in the file.
struct Raw {
    /// The column itself; NaN where empty; empty without such a column.
    time: Vec<f64>,
    time_unit_s: Option<f64>,
    position: Vec<[f64; 3]>,
    lines: Vec<u64>,
    findings: Vec<Finding>,
    sha256: Option<String>,
}

/// Times by the stamps, on their own clock.
fn stamps(raw: &mut Raw) -> Option<Vec<f64>> {
    let options = ClockOptions {
        unit_s: raw.time_unit_s,
        ..ClockOptions::default()
    };
    let clock = clock(std::mem::take(&mut raw.time), options).ok()?;
    Some(clock.time_s.iter().map(|t| t + clock.start_s).collect())
}

/// The recording's own time of each line; NaN for a line that is no row of it.
fn times_of_lines(recording: &Recording, lines: &[u64]) -> Vec<f64> {
    let (rate_hz, _) = recording.working_rate_hz();
    let mut row = 0;
    let of_line = |line: &u64| {
        while row < recording.rows() && recording.line(row) < *line {
            row += 1;
        }
        if row >= recording.rows() || recording.line(row) != *line {
            return f64::NAN;
        }
        match &recording.time_s {
            Some(time) => time.get(row).copied().unwrap_or(f64::NAN),
            None => row as f64 / rate_hz,
        }
    };
    lines.iter().map(of_line).collect()
}

fn read_rows(path: &Path, same_file: bool, hash: bool) -> Result<Raw> {
    let options = ReadOptions {
        hash,
        ..ReadOptions::default()
    };
    let mut input = open::open(path, &options)?;
    let io = |e| Error::io(path, e);
    let reader = std::mem::replace(&mut input.reader, Box::new(std::io::empty()));
    let mut text = bytes::utf8(reader).map_err(io)?;
    let head = bytes::read_head(&mut text, HEAD_BYTES).map_err(io)?;
    let format = sniff_table(&whole_lines(&head)).map_err(|_| {
        Error::input(
            "no-rows",
            "there are no rows of at least three numbers in this file",
        )
        .at(path, None)
        .with_hint("a reference is a table of text with the columns t_s,px_m,py_m,pz_m")
    })?;
    let fields = Fields::find(&format, same_file).map_err(|e| e.at(path, None))?;
    let mut raw = Raw {
        time: Vec::new(),
        time_unit_s: fields.time_unit_s,
        position: Vec::new(),
        lines: Vec::new(),
        findings: Vec::new(),
        sha256: None,
    };
    let (mut odd, mut ranges, mut others) = (LineSpans::default(), Vec::new(), 0);
    for batch in format.batches(Cursor::new(head).chain(text)) {
        let batch = batch.map_err(io)?;
        let columns = fields.position.map(|c| &batch.columns[c]);
        let metres = |row: usize| columns.map(|c| c[row] * fields.metres);
        raw.position.extend((0..batch.rows()).map(metres));
        raw.lines.extend(batch.lines.iter().map(|l| u64::from(*l)));
        if let Some(time) = fields.time {
            raw.time.extend_from_slice(&batch.columns[time]);
        }
        for reason in [Reason::TornLine, Reason::TooManyFields, Reason::NotANumber] {
            if let Some(aside) = batch.aside.reasons.get(&reason) {
                others += aside.lines.count();
                ranges.extend_from_slice(aside.lines.ranges());
            }
        }
    }
    ranges.sort_unstable();
    for [from, to] in ranges {
        odd.push_range(from, to, to - from + 1);
    }
    if others > 0 {
        let text = format!("{others} lines of the reference are no rows; left out");
        raw.findings
            .push(Finding::new(FindingKind::TruthLines, text).at_lines(&odd));
    }
    raw.sha256 = input.sha256();
    Ok(raw)
}
