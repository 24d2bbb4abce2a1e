//! Reading a recording, in order: open, find the dialect and the columns, scan
//! the lines, judge stamps, units and samples.

use std::io::Read;
use std::path::Path;

use crate::scan::{Line, Lines};
use crate::{Error, Result};

use super::assemble::assemble;
use super::columns::{Columns, refuse_silent_gyroscope, refuse_unusable, zero_tail};
use super::dialect::{Dialect, sniff, terminator};
use super::finding::{Finding, LineSpans};
use super::layout::{self, Layout, Request};
use super::ledger::{Aside, Ledger};
use super::names::Quantity;
use super::open::{self, Input};
use super::row::{ACCEL, GYRO, RowDefect, SLOTS, TEMPERATURE, TIME, Values};
use super::{ReadOptions, Recording};

/// How much of a file is looked at to find its dialect.
pub(crate) const HEAD: usize = 1 << 18;

/// How a line starts with which a logger names rows that it could not get. After it
/// the clock of the board may have started anew.
pub const GAP_LINE: &str = "# gap:";

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
    prepare_as(Role::Recording, reader, name, options)
}

/// What a file is read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// It has an accelerometer, and maybe more.
    Recording,
    /// Only its gyroscope and its time are wanted.
    Gyroscope,
}

fn prepare_as<R: Read>(
    role: Role,
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
        return Err(Error::input("empty-file", "the file is empty")
            .at(here, None)
            .with_hint("record again: nothing was written to this file"));
    }
    let min_columns = 3;
    let dialect = sniff(&clean, whole, min_columns).ok_or_else(|| {
        Error::input("no-rows", "there are no rows of at least three numbers in this file")
            .at(here, None)
            .with_hint("a recording is a table of text: one sample a line, its values separated by comma, semicolon, tab or spaces")
    })?;
    let mut findings = Vec::new();
    let request = Request {
        columns: options.columns.as_ref(),
        sensor: options.sensor.as_deref(),
        file: name,
    };
    let mut layout = layout::find(role, &dialect, request, &mut findings)
        .map_err(|e| e.at(here, dialect.header.as_ref().map(|h| h.lines[1])))?;
    layout.claim_of_board(&dialect.metadata);
    Ok(Prepared {
        lines,
        dialect,
        layout,
        findings,
        head: clean,
        whole,
    })
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

/// Why lines are no rows. It follows the lines one by one, since blank lines that stand
/// between the rows regularly part nothing, and more of them in a row do.
#[derive(Debug)]
pub(crate) struct LineReasons<'a> {
    dialect: &'a Dialect,
    /// The last blank line, and how many stand in a row up to it.
    blank: (u64, u64),
}

impl<'a> LineReasons<'a> {
    pub fn new(dialect: &'a Dialect) -> Self {
        LineReasons {
            dialect,
            blank: (0, 0),
        }
    }

    /// A line before the first row.
    pub fn before(&self, line: &Line<'_>) -> Aside {
        match &self.dialect.header {
            Some(header) if header.texts.iter().any(|t| t == line.bytes.trim_ascii()) => {
                Aside::Header
            }
            _ if !line.bytes.trim_ascii().is_empty() => Aside::Metadata,
            _ if self.dialect.regular_blanks > 0 => Aside::RegularBlank,
            _ => Aside::Blank,
        }
    }

    /// A line of the data part that is no row.
    pub fn among(&mut self, line: &Line<'_>, defect: RowDefect) -> Aside {
        let text = line.bytes.trim_ascii();
        let header = self.dialect.header.as_ref();
        if !text.is_empty() && header.is_some_and(|h| h.texts.iter().any(|t| t == text)) {
            return Aside::RepeatedHeader;
        }
        if text.starts_with(GAP_LINE.as_bytes()) {
            return Aside::NamedGap;
        }
        if text.starts_with(b"#") || text.starts_with(b"%") || text.starts_with(b"//") {
            return Aside::Comment;
        }
        match defect {
            RowDefect::Blank => {
                let (last, run) = self.blank;
                let run = if last + 1 == line.number { run + 1 } else { 1 };
                self.blank = (line.number, run);
                if run > self.dialect.regular_blanks {
                    Aside::Blank
                } else {
                    Aside::RegularBlank
                }
            }
            RowDefect::TooFewFields => Aside::TornLine,
            RowDefect::TooManyFields => Aside::TooManyFields,
            RowDefect::NotANumber(_) => Aside::NotANumber,
            RowDefect::OtherSensor => Aside::OtherSensor,
        }
    }
}

fn read_input(input: Input, name: &str, options: &ReadOptions) -> Result<Recording> {
    let scanned = scan_rows(Role::Recording, input, name, options)?;
    Ok(assemble(scanned, options, name))
}

/// The rows of a file before stamps, units and samples are judged.
pub(super) struct Scanned {
    pub columns: Columns,
    pub ledger: Ledger,
    pub findings: Vec<Finding>,
    pub dialect: Dialect,
    pub layout: Layout,
    pub description: String,
    pub sha256: Option<String>,
}

/// Reads all rows of a file.
///
/// # Errors
///
/// As [`read`]; for [`Role::Gyroscope`] `no-gyroscope` in place of
/// `no-accelerometer`.
pub(super) fn scan_rows(
    role: Role,
    mut input: Input,
    name: &str,
    options: &ReadOptions,
) -> Result<Scanned> {
    let here = Path::new(name);
    let mut unpacked = input.unpacked.clone();
    let reader = std::mem::replace(&mut input.reader, Box::new(std::io::empty()));
    let Prepared {
        mut lines,
        dialect,
        layout,
        mut findings,
        ..
    } = prepare_as(role, reader, name, options)?;
    let scanner = layout.scanner(&dialect);
    let label_field = layout.field(Quantity::Label);
    let mut present = [false; SLOTS];
    for (quantity, _) in &layout.fields {
        match quantity {
            Quantity::Time => present[TIME] = true,
            Quantity::Accel(i) => present[ACCEL + i] = true,
            Quantity::Gyro(i) => present[GYRO + i] = layout.has_gyro(),
            Quantity::Temperature => present[TEMPERATURE] = true,
            _ => {}
        }
    }
    let mut reasons = LineReasons::new(&dialect);
    let mut stamps = layout.stamps();
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
            ledger.aside(reasons.before(&line), line.number, line.bytes);
            continue;
        }
        let mut label = (0, 0);
        match scanner.scan(line.bytes, &mut values, &mut label) {
            Ok(()) => {
                ledger.row();
                stamps.stamp(&mut values);
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
                let reason = reasons.among(&line, defect);
                if reason.parts() {
                    columns.note_break(reason);
                }
                ledger.aside(reason, line.number, line.bytes);
            }
        }
    }
    drop(lines);
    if input.is_cut_off() {
        findings.push(cut_off(columns.rows() as u64));
    }
    match role {
        Role::Recording => {
            zero_tail(&mut columns, &mut ledger);
            refuse_unusable(&columns, &ledger, here)?;
        }
        // At rest a gyroscope may well read zero to the end.
        Role::Gyroscope => refuse_silent_gyroscope(&columns, &ledger, here)?,
    }
    findings.extend(ledger.findings());
    findings.extend(text_findings(&nul_lines, &foreign_lines, &unpacked));
    unpacked.push(dialect.description());
    let description = unpacked.join(", ");
    let sha256 = input.sha256();
    Ok(Scanned {
        columns,
        ledger,
        findings,
        dialect,
        layout,
        description,
        sha256,
    })
}
