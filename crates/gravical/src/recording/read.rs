//! Reading a recording, in order: open, find the dialect and the columns, scan
//! the lines, judge stamps, units and samples.

use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

use crate::scan::Lines;
use crate::{Error, Result};

use super::dialect::{Dialect, decode, sniff, terminator};
use super::finding::{Finding, LineSpans};
use super::layout::{self, Layout};
use super::ledger::{Aside, Ledger};
use super::names::Quantity;
use super::open::{self, Input};
use super::row::{ACCEL, GYRO, RowDefect, SLOTS, TEMPERATURE, TIME, Values};
use super::timing::{self, Claims};
use super::unit_choice::{decide_accel, looks_unsigned, quiet_norm};
use super::units::{GyroScale, GyroUnit, Origin};
use super::{Labels, LineMap, ReadOptions, Recording, quality};

/// How much of a file is looked at to find its dialect.
pub(crate) const HEAD: usize = 1 << 18;

/// Reads the recording at `path`; `-` is standard input.
///
/// # Errors
///
/// What keeps it from being read: `not-found`, `empty-file`, `no-rows`,
/// `no-accelerometer`, `columns-unknown`, `all-zero` …, each with the file and
/// what to do. Everything less is a [`Finding`] of the recording.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    options.validate()?;
    let input = open::open(path, options.hash)?;
    read_input(input, &path.display().to_string(), options)
}

/// Reads a recording that is in memory; `name` stands in messages.
///
/// # Errors
///
/// As [`read`].
pub fn read_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Recording> {
    options.validate()?;
    let reader = Box::new(std::io::Cursor::new(bytes.to_vec()));
    let input =
        open::from_reader(reader, options.hash).map_err(|e| Error::io(Path::new(name), e))?;
    read_input(input, name, options)
}

/// What was found out about a file before its rows are read.
pub(crate) struct Prepared<R> {
    pub lines: Lines<R>,
    pub dialect: Dialect,
    pub layout: Layout,
    pub findings: Vec<Finding>,
    /// The head of the file without NUL bytes.
    pub head: Vec<u8>,
    /// The head is all there is.
    pub whole: bool,
}

/// Looks at the head and finds dialect and columns; nothing is consumed.
pub(crate) fn prepare<R: Read>(
    reader: R,
    name: &str,
    options: &ReadOptions,
) -> Result<Prepared<R>> {
    let here = Path::new(name);
    let io = |e| Error::io(here, e);
    let mut lines = Lines::new(reader);
    let head = lines.peek(HEAD).map_err(io)?.to_vec();
    let whole = head.len() < HEAD;
    let lines = lines.with_terminator(terminator(&head));
    let clean: Vec<u8> = head.iter().copied().filter(|b| *b != 0).collect();
    if clean.iter().all(u8::is_ascii_whitespace) && whole {
        return Err(Error::input("empty-file", "the file is empty").at(here, None));
    }
    let min_columns = 3;
    let dialect = sniff(&clean, whole, min_columns).ok_or_else(|| {
        Error::input("no-rows", "there are no rows of at least three numbers in this file")
            .at(here, None)
            .with_hint("a recording is a table of text: one sample a line, its values separated by comma, semicolon, tab or spaces")
    })?;
    let mut findings = Vec::new();
    let layout = layout::find(&dialect, options.columns.as_ref(), &mut findings)
        .map_err(|e| e.at(here, dialect.header.as_ref().map(|h| h.lines[1])))?;
    Ok(Prepared {
        lines,
        dialect,
        layout,
        findings,
        head: clean,
        whole,
    })
}

struct Columns {
    slots: [Vec<f64>; SLOTS],
    labels: Labels,
    label_index: HashMap<Vec<u8>, u32>,
    lines: LineMap,
    breaks: Vec<usize>,
}

impl Columns {
    fn new() -> Self {
        Columns {
            slots: std::array::from_fn(|_| Vec::new()),
            labels: Labels::default(),
            label_index: HashMap::new(),
            lines: LineMap::default(),
            breaks: Vec::new(),
        }
    }

    fn rows(&self) -> usize {
        self.slots[ACCEL].len()
    }

    fn push(&mut self, values: &Values, present: &[bool; SLOTS], line: u64) {
        for slot in 0..SLOTS {
            if present[slot] {
                self.slots[slot].push(values[slot]);
            }
        }
        self.lines.push(line);
    }

    fn push_label(&mut self, text: &[u8]) {
        let text = text.trim_ascii();
        let index = match self.label_index.get(text) {
            Some(&index) => index,
            None => {
                let index = self.labels.names.len() as u32;
                self.labels
                    .names
                    .push(decode(text).trim_matches('"').to_owned());
                self.label_index.insert(text.to_vec(), index);
                index
            }
        };
        self.labels.of_row.push(index);
    }

    fn note_break(&mut self) {
        let row = self.rows();
        if row > 0 && self.breaks.last() != Some(&row) {
            self.breaks.push(row);
        }
    }

    fn truncate(&mut self, rows: usize) {
        for slot in &mut self.slots {
            slot.truncate(rows);
        }
        self.labels.of_row.truncate(rows);
        self.breaks.retain(|b| *b < rows);
    }
}

/// A packed file that was cut off: what could be unpacked is kept.
pub(crate) fn cut_off(rows: u64) -> Finding {
    Finding::warning(
        "truncated-file",
        format!("the packed file ends in the middle; {rows} rows could be unpacked"),
    )
}

/// What is odd about the bytes of a file.
pub(crate) fn text_findings(
    nul_lines: &LineSpans,
    foreign_lines: &LineSpans,
    unpacked: &[String],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if !nul_lines.is_empty() {
        findings.push(
            Finding::warning(
                "nul-bytes",
                format!("NUL bytes in {} lines; taken out", nul_lines.count()),
            )
            .at_lines(nul_lines),
        );
    }
    if !foreign_lines.is_empty() {
        findings.push(
            Finding::note("not-utf8", "text that is not UTF-8; read as Windows-1252")
                .at_lines(foreign_lines),
        );
    }
    if let Some(encoding) = unpacked.iter().find(|u| u.starts_with("UTF-16")) {
        findings.push(Finding::note(
            "not-utf8",
            format!("the file is {encoding}; read as such"),
        ));
    }
    findings
}

/// Classifies one line of the data part that is no row.
pub(crate) fn reason_for(line: &[u8], defect: RowDefect, header: Option<&[u8]>) -> Aside {
    let text = line.trim_ascii();
    if header.is_some_and(|h| !text.is_empty() && text == h.trim_ascii()) {
        return Aside::RepeatedHeader;
    }
    if text.starts_with(b"#") || text.starts_with(b"%") || text.starts_with(b"//") {
        return Aside::Comment;
    }
    match defect {
        RowDefect::Blank => Aside::Blank,
        RowDefect::TooFewFields => Aside::TornLine,
        RowDefect::TooManyFields => Aside::TooManyFields,
        RowDefect::NotANumber(_) => Aside::NotANumber,
    }
}

/// What lines before the first row are.
pub(crate) fn reason_before(line: &[u8], number: u64, dialect: &Dialect) -> Aside {
    match &dialect.header {
        Some(header) if number >= header.lines[0] && number <= header.lines[1] => Aside::Header,
        _ if line.trim_ascii().is_empty() => Aside::Blank,
        _ => Aside::Metadata,
    }
}

fn read_input(mut input: Input, name: &str, options: &ReadOptions) -> Result<Recording> {
    let here = Path::new(name);
    let mut unpacked = input.unpacked.clone();
    let reader = std::mem::replace(&mut input.reader, Box::new(std::io::empty()));
    let Prepared {
        mut lines,
        dialect,
        layout,
        mut findings,
        ..
    } = prepare(reader, name, options)?;
    let scanner = layout.scanner(&dialect);
    let label_field = layout.field(Quantity::Label);
    let mut present = [false; SLOTS];
    for (quantity, _) in &layout.fields {
        match quantity {
            Quantity::Time => present[TIME] = true,
            Quantity::Accel(i) => present[ACCEL + i] = true,
            Quantity::Gyro(i) => present[GYRO + i] = layout.has_gyro(),
            Quantity::Temperature => present[TEMPERATURE] = true,
            Quantity::Label | Quantity::Index => {}
        }
    }
    let header_text = dialect.header.as_ref().map(|h| h.text.as_slice());
    let mut ledger = Ledger::default();
    let mut columns = Columns::new();
    let mut nul_lines = LineSpans::default();
    let mut foreign_lines = LineSpans::default();
    let mut values: Values = [f64::NAN; SLOTS];
    loop {
        let line = match lines.next_line() {
            Ok(Some(line)) => line,
            Ok(None) => break,
            Err(e) => return Err(Error::io(here, e)),
        };
        if line.nul_bytes > 0 {
            nul_lines.push(line.number);
        }
        if line.number < dialect.first_data_line {
            if std::str::from_utf8(line.bytes).is_err() {
                foreign_lines.push(line.number);
            }
            ledger.aside(
                reason_before(line.bytes, line.number, &dialect),
                line.number,
                line.bytes,
            );
            continue;
        }
        let mut label = (0, 0);
        match scanner.scan(line.bytes, &mut values, &mut label) {
            Ok(()) => {
                ledger.row();
                columns.push(&values, &present, line.number);
                if label_field.is_some() {
                    columns.push_label(
                        line.bytes
                            .get(label.0 as usize..label.1 as usize)
                            .unwrap_or(b""),
                    );
                }
            }
            Err(defect) => {
                if std::str::from_utf8(line.bytes).is_err() {
                    foreign_lines.push(line.number);
                }
                let reason = reason_for(line.bytes, defect, header_text);
                if matches!(reason, Aside::Blank | Aside::RepeatedHeader) {
                    columns.note_break();
                }
                ledger.aside(reason, line.number, line.bytes);
            }
        }
    }
    drop(lines);
    if input.is_cut_off() {
        findings.push(cut_off(columns.rows() as u64));
    }
    zero_tail(&mut columns, &mut ledger);
    refuse_unusable(&columns, &ledger, here)?;
    findings.extend(ledger.findings());
    findings.extend(text_findings(&nul_lines, &foreign_lines, &unpacked));
    unpacked.push(dialect.description());
    let description = unpacked.join(", ");
    let sha256 = input.sha256();
    Ok(assemble(
        columns,
        ledger,
        findings,
        &dialect,
        &layout,
        options,
        name,
        description,
        sha256,
    ))
}

/// Rows of zeros up to the end of the file were never written by the sensor.
fn zero_tail(columns: &mut Columns, ledger: &mut Ledger) {
    let zero = |row: usize| {
        (ACCEL..ACCEL + 6).all(|slot| columns.slots[slot].get(row).is_none_or(|v| *v == 0.0))
    };
    let rows = columns.rows();
    let kept = (0..rows)
        .rev()
        .find(|row| !zero(*row))
        .map_or(0, |row| row + 1);
    if kept > 0 && rows - kept >= 2 {
        let lines: Vec<u64> = (kept..rows).map(|row| columns.lines.line(row)).collect();
        ledger.move_rows_aside(Aside::ZeroTail, lines.into_iter());
        columns.truncate(kept);
    }
}

fn refuse_unusable(columns: &Columns, ledger: &Ledger, here: &Path) -> Result<()> {
    let rows = columns.rows();
    if rows == 0 {
        return Err(
            Error::input("no-rows", format!("no row could be read: {}", ledger.sum()))
                .at(here, None),
        );
    }
    let accel = &columns.slots[ACCEL..ACCEL + 3];
    if let Some(axis) = (0..3).find(|i| accel[*i].iter().all(|v| v.is_nan())) {
        return Err(Error::input(
            "no-values",
            format!(
                "a{} has no value in any of the {rows} rows (empty or NaN)",
                ["x", "y", "z"][axis]
            ),
        )
        .at(here, None)
        .with_hint(
            "look at the columns with `gravical inspect`, or choose others with --columns",
        ));
    }
    if accel.iter().all(|c| c.iter().all(|v| *v == 0.0)) {
        return Err(Error::input(
            "all-zero",
            format!("the accelerometer reads zero in all {rows} rows: it did not answer"),
        )
        .at(here, None)
        .with_hint("check the wiring (SDA, SCL, power) and that the sketch wakes the sensor"));
    }
    Ok(())
}

/// The rate that the metadata claim: `Fs,100`, `# rate: 62.5 Hz`.
pub(crate) fn claimed_rate(metadata: &[(String, String)]) -> Option<f64> {
    metadata.iter().find_map(|(key, value)| {
        let is_rate = ["fs", "rate", "odr"].contains(&key.as_str())
            || [
                "sampling",
                "sample rate",
                "sample_rate",
                "frequency",
                "rate_hz",
                "rate hz",
            ]
            .iter()
            .any(|w| key.contains(w));
        let number = value
            .split(|c: char| c.is_whitespace() || c.is_alphabetic())
            .next()?;
        let rate: f64 = number.parse().ok()?;
        (is_rate && rate.is_finite() && rate > 0.0).then_some(rate)
    })
}

#[allow(clippy::too_many_arguments)] // the parts of one value, put together once
fn assemble(
    columns: Columns,
    ledger: Ledger,
    mut findings: Vec<Finding>,
    dialect: &Dialect,
    layout: &Layout,
    options: &ReadOptions,
    name: &str,
    description: String,
    sha256: Option<String>,
) -> Recording {
    let [time, ax, ay, az, gx, gy, gz, temperature] = columns.slots;
    let mut accel = [ax, ay, az];
    let line_map = columns.lines;
    let some = |v: Vec<f64>| (!v.is_empty()).then_some(v);

    let unsigned = options.zero_offset.is_none() && looks_unsigned(&accel);
    let zero_offset = options
        .zero_offset
        .unwrap_or(if unsigned { 32768.0 } else { 0.0 });
    if zero_offset != 0.0 {
        for value in accel.iter_mut().flatten() {
            *value -= zero_offset;
        }
        if unsigned {
            findings.push(Finding::note(
                "unsigned-counts",
                "unsigned 16-bit values around 32768: that is subtracted; the range is not known",
            ));
        }
    }
    let temperature_c = some(temperature);
    let span = temperature_c.as_deref().map_or(0.0, |t| {
        let (low, high) = t
            .iter()
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(*v), h.max(*v))
            });
        (high - low).max(0.0)
    });
    let claims = Claims {
        unit: options.time_unit.or(layout.time_claim),
        nominal_rate_hz: options.rate_hz.or_else(|| claimed_rate(&dialect.metadata)),
        temperature_span_c: span,
    };
    let timed = match some(time) {
        Some(raw) => timing::judge(raw, &claims, |row| line_map.line(row)),
        None => timing::untimed(accel[0].len(), &claims, Vec::new()),
    };
    findings.extend(timed.findings);
    let mut breaks = columns.breaks;
    breaks.extend(timed.restarts);
    breaks.sort_unstable();
    breaks.dedup();

    let gyro = (!gx.is_empty()).then_some([gx, gy, gz]);
    findings.extend(quality::empty_cells(
        &accel,
        gyro.as_ref(),
        temperature_c.as_deref(),
    ));
    if is_sparse(&accel) {
        hold_last_values(&mut accel);
    }
    let accel_scale = decide_accel(
        quiet_norm(&accel),
        unsigned,
        layout.accel_claim,
        options,
        &mut findings,
    );
    let gyro_scale = gyro.as_ref().map(|g| gyro_by_claim(g, layout, options));
    let mut recording = Recording {
        name: name.to_owned(),
        sha256,
        description,
        column_names: dialect
            .header
            .as_ref()
            .map_or_else(Vec::new, |h| h.names.clone()),
        accel,
        gyro,
        temperature_c,
        time_s: timed.time_s,
        labels: (!columns.labels.of_row.is_empty()).then_some(columns.labels),
        breaks,
        zero_offset,
        accel_scale,
        gyro_scale,
        timing: timed.timing,
        ledger,
        findings,
        line_map,
    };
    let samples = quality::inspect(&recording);
    recording.findings.extend(samples);
    for finding in &mut recording.findings {
        finding.file = Some(name.to_owned());
    }
    recording
}

/// A recorder that writes each channel when it arrives leaves most cells
/// empty; there the last value of a channel holds until the next comes.
/// Elsewhere ([`is_sparse`]) an empty cell stays empty.
pub(crate) fn hold_last_values(channels: &mut [Vec<f64>; 3]) {
    for channel in channels {
        let mut last = f64::NAN;
        for value in channel {
            if value.is_nan() {
                *value = last;
            } else {
                last = *value;
            }
        }
    }
}

/// More than a fifth of the rows lack a value.
pub(crate) fn is_sparse(channels: &[Vec<f64>; 3]) -> bool {
    let rows = channels[0].len();
    let incomplete = (0..rows)
        .filter(|&i| channels.iter().any(|c| c[i].is_nan()))
        .count();
    incomplete * 5 > rows
}

/// The gyroscope's unit before any turn has been looked at.
fn gyro_by_claim(gyro: &[Vec<f64>; 3], layout: &Layout, options: &ReadOptions) -> GyroScale {
    let lsb_per_deg_s = options.gyro_range_deg_s.map(|range| 32768.0 / range);
    if let Some(unit) = options.gyro_unit {
        return GyroScale {
            unit,
            lsb_per_deg_s,
            origin: Origin::Given,
        };
    }
    if let Some(unit) = layout.gyro_claim {
        return GyroScale {
            unit,
            lsb_per_deg_s,
            origin: Origin::Header,
        };
    }
    let integers = gyro
        .iter()
        .all(|c| c.iter().all(|v| v.is_nan() || v.fract() == 0.0));
    let moves = gyro.iter().flatten().any(|v| v.abs() >= 1.0);
    GyroScale {
        unit: if integers && moves {
            GyroUnit::Counts
        } else {
            GyroUnit::Unknown
        },
        lsb_per_deg_s,
        origin: if integers && moves {
            Origin::Data
        } else {
            Origin::Assumed
        },
    }
}
