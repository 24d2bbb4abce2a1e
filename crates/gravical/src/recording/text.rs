//! Rows of a text file.

use std::io::Read;
use std::path::Path;

use crate::scan::{Line, Lines};
use crate::{Error, Result};

use super::ReadOptions;
use super::dialect::{Dialect, sniff, terminator};
use super::foreign;
use super::format::Format;
use super::head::Head;
pub(crate) use super::head::HeadChannels;
use super::later::LaterHeaders;
use super::layout::{self, Request};
use super::ledger::{Aside, is_comment};
use super::metadata;
use super::monitor::{Facts, RecordingClaims};
use super::names::Role;
use super::open::Input;
use super::row::{RowDefect, RowScanner, RowStamps, Span, Values};
use super::rows::{Finished, Item, Rows, Source, Text};
use crate::finding::{Finding, FindingKind, LineSpans};

/// Beginning of the line in which a logger reports missing rows. After it the clock of the board
/// may have restarted.
pub const GAP_LINE: &str = "# gap:";

/// Lines of a file as rows.
pub(crate) struct TextRows<R> {
    lines: Lines<R>,
    name: String,
    format: Format,
    scanner: RowScanner,
    stamps: RowStamps,
    later: LaterHeaders,
    /// The current row was rewritten.
    rewritten: bool,
    /// Byte ranges of the fields are requested.
    with_spans: bool,
    spans: Vec<Span>,
    label: Span,
    number: u64,
    /// About how many lines there are; 0 if nothing tells.
    expected: usize,
    /// Number of the last blank line, and length of the run of blank lines that it ends.
    blank: (u64, u64),
    nul_lines: LineSpans,
    foreign_lines: LineSpans,
    /// The input is cut off: a last line without an end is ignored.
    cut: bool,
}

/// A file whose rows can be read.
pub(crate) struct OpenFile {
    pub rows: Rows<TextRows<Box<dyn Read>>>,
    pub format: Format,
    /// Findings about the columns.
    pub findings: Vec<Finding>,
    /// Its first lines.
    head: Head,
    /// The first lines are the whole file.
    pub whole: bool,
    /// Text of the first lines, without NUL bytes.
    pub head_bytes: Vec<u8>,
    input: Input,
}

/// Results of a file that was read to its end.
pub(crate) struct ReadFile {
    pub finished: Finished,
    /// Text format of the file in words.
    pub description: String,
    pub sha256: Option<String>,
    /// Findings about columns, lines and bytes.
    pub findings: Vec<Finding>,
}

/// Opens `input`, determines its format and columns, and evaluates the first rows unless `facts`
/// are given. `name` is used in messages.
///
/// # Errors
///
/// `empty-file`, `no-rows`, `no-accelerometer`, `no-gyroscope`, `columns-unknown` …; errors of
/// reading.
pub(crate) fn open_rows(
    mut input: Input,
    name: &str,
    role: Role,
    options: &ReadOptions,
    facts: Option<Facts>,
) -> Result<OpenFile> {
    let here = Path::new(name);
    let reader = std::mem::replace(&mut input.reader, Box::new(std::io::empty()));
    let mut lines = Lines::new(reader);
    let head = lines.peek(input.head_bytes);
    let head = head.map_err(|e| Error::io(here, e))?.to_vec();
    let whole = head.len() < input.head_bytes;
    let lines = lines.with_terminator(terminator(&head));
    let clean: Vec<u8> = head.iter().copied().filter(|b| *b != 0).collect();
    let mut findings = Vec::new();
    let format = find_format(&clean, whole, name, role, options, &mut findings)?;
    let claims = RecordingClaims {
        metadata_rate_hz: metadata::rate_hz(&format.dialect.metadata),
        layout: format.layout.clone(),
        options: options.clone(),
    };
    let of_head = Lines::new(&clean[..]).with_terminator(terminator(&clean));
    let of_head = TextRows::new(of_head, name, &format, !whole);
    let head = Head::read(of_head, &claims);
    let facts = facts.unwrap_or_else(|| head.facts());
    let mut of_file = TextRows::new(lines, name, &format, false);
    of_file.expected = head.expected(clean.len(), input.size);
    let rows = Rows::new(of_file, name, claims, facts);
    Ok(OpenFile {
        rows,
        format,
        findings,
        head,
        whole,
        head_bytes: clean,
        input,
    })
}

/// Format and columns, from the first bytes of a file.
fn find_format(
    head: &[u8],
    whole: bool,
    name: &str,
    role: Role,
    options: &ReadOptions,
    findings: &mut Vec<Finding>,
) -> Result<Format> {
    let here = Path::new(name);
    if head.iter().all(u8::is_ascii_whitespace) && whole {
        return Err(Error::input("empty-file", "the file is empty")
            .at(here, None)
            .with_hint("record again: nothing was written to this file"));
    }
    foreign::refuse_calibration(head, here)?;
    let min_columns = 3;
    let dialect = sniff(head, whole, min_columns)
        .ok_or_else(|| foreign::no_table(head, here, "no rows of at least three numbers"))?;
    if options.columns.is_none() && foreign::is_no_table(head, &dialect) {
        let what = "only a few lines of numbers among others";
        return Err(foreign::no_table(head, here, what));
    }
    let request = Request {
        columns: options.columns.as_ref(),
        sensor: options.sensor.as_deref(),
        file: name,
    };
    let mut layout = layout::find(role, &dialect, request, findings)
        .map_err(|e| e.at(here, dialect.header.as_ref().map(|h| h.lines[1])))?;
    layout.apply_board_settings(&dialect.metadata);
    Ok(Format {
        dialect,
        layout,
        role,
        options: options.clone(),
    })
}

impl OpenFile {
    /// Channels of the first rows.
    pub fn head(&self) -> HeadChannels {
        self.head.channels(self.rows.facts())
    }

    /// Provides the byte ranges of all fields with every row.
    pub fn with_spans(mut self) -> Self {
        self.rows.source_mut().with_spans = true;
        self
    }

    /// Results; to be called after the last row.
    ///
    /// # Errors
    ///
    /// As [`Rows::finish`].
    pub fn finish(mut self) -> Result<ReadFile> {
        let finished = self.rows.finish()?;
        let mut findings = self.findings;
        if self.input.is_cut_off() {
            let rows = finished.ledger.rows;
            findings.push(Finding::new(
                FindingKind::TruncatedFile,
                format!("the packed file ends in the middle; {rows} rows could be unpacked"),
            ));
        }
        findings.extend(finished.ledger.findings());
        findings.extend(self.rows.source().odd_bytes(&self.input.unpacked));
        let mut description = self.input.unpacked.clone();
        description.push(self.format.dialect.description());
        Ok(ReadFile {
            finished,
            description: description.join(", "),
            sha256: self.input.sha256(),
            findings,
        })
    }
}

impl<R: Read> TextRows<R> {
    fn new(lines: Lines<R>, name: &str, format: &Format, cut: bool) -> Self {
        let scanner = format.layout.scanner(&format.dialect);
        TextRows {
            lines,
            name: name.to_owned(),
            stamps: format.layout.stamps(),
            format: format.clone(),
            later: LaterHeaders::default(),
            rewritten: false,
            with_spans: false,
            spans: Vec::with_capacity(scanner.fields()),
            scanner,
            label: (0, 0),
            number: 0,
            expected: 0,
            blank: (0, 0),
            nul_lines: LineSpans::default(),
            foreign_lines: LineSpans::default(),
            cut,
        }
    }

    /// Findings about headers and bytes; `unpacked`: the conversions applied.
    fn odd_bytes(&self, unpacked: &[String]) -> Vec<Finding> {
        let mut findings: Vec<Finding> = self.later.finding().into_iter().collect();
        if !self.nul_lines.is_empty() {
            findings.push(
                Finding::new(
                    FindingKind::NulBytes,
                    format!("NUL bytes in {} lines; removed", self.nul_lines.count()),
                )
                .at_lines(&self.nul_lines),
            );
        }
        if !self.foreign_lines.is_empty() {
            findings.push(
                Finding::new(
                    FindingKind::NotUtf8,
                    "text that is not UTF-8; read as Windows-1252",
                )
                .at_lines(&self.foreign_lines),
            );
        }
        if let Some(encoding) = unpacked.iter().find(|u| u.starts_with("UTF-16")) {
            findings.push(Finding::new(
                FindingKind::NotUtf8,
                format!("the file is {encoding}; read as such"),
            ));
        }
        findings
    }
}

impl<R: Read> Source for TextRows<R> {
    #[inline]
    fn next(&mut self, values: &mut Values) -> Result<Option<Item>> {
        let line = self
            .lines
            .next_line()
            .map_err(|e| Error::io(Path::new(&self.name), e))?;
        let Some(line) = line.filter(|line| line.terminated || !self.cut) else {
            return Ok(None);
        };
        self.number = line.number;
        if line.nul_bytes > 0 {
            self.nul_lines.push(line.number);
        }
        if line.number >= self.format.dialect.first_data_line {
            let mut bytes = line.bytes;
            let mut read = Ok(false);
            if !self.later.is_idle() {
                let (format, name) = (&self.format, &self.name);
                read = self.later.line(bytes, format, name, self.with_spans)?;
                self.rewritten = read == Ok(true);
                if self.rewritten {
                    bytes = self.later.rewritten();
                }
            }
            let scanned = read.and_then(|_| match self.with_spans {
                true => self.scanner.scan_spans(bytes, values, &mut self.spans),
                false => self.scanner.scan(bytes, values, &mut self.label),
            });
            match scanned {
                Ok(()) => {
                    self.stamps.stamp(values);
                    return Ok(Some(Item::Row));
                }
                Err(defect) => {
                    self.rewritten = false;
                    if std::str::from_utf8(line.bytes).is_err() {
                        self.foreign_lines.push(line.number);
                    }
                    let reason =
                        reason_in_data(&self.format.dialect, &line, defect, &mut self.blank);
                    let is_header = self.later.set_aside(&line, &self.format, &self.name);
                    return Ok(Some(Item::Aside(match is_header {
                        true => Aside::RepeatedHeader,
                        false => reason,
                    })));
                }
            }
        }
        if std::str::from_utf8(line.bytes).is_err() {
            self.foreign_lines.push(line.number);
        }
        Ok(Some(Item::Aside(reason_before_data(
            &self.format.dialect,
            &line,
        ))))
    }

    #[inline]
    fn number(&self) -> u64 {
        self.number
    }

    fn expected(&self) -> usize {
        self.expected
    }

    fn can_skip(&self) -> bool {
        // A skipped line may be a header that changes the rows after it.
        !self.stamps.sums() && self.later.never_changed()
    }

    fn skip_to(&mut self, line: u64) -> Result<()> {
        while self.number < line {
            let passed = self.lines.next_line();
            match passed.map_err(|e| Error::io(Path::new(&self.name), e))? {
                Some(passed) => self.number = passed.number,
                None => break,
            }
        }
        Ok(())
    }

    #[inline]
    fn text(&self) -> Text<'_> {
        let bytes = match self.rewritten {
            true => self.later.rewritten(),
            false => self.lines.current(),
        };
        let (from, to) = self.label;
        Text {
            bytes,
            spans: &self.spans,
            label: bytes.get(from as usize..to as usize).unwrap_or_default(),
        }
    }
}

/// Reason for a line before the first row.
fn reason_before_data(dialect: &Dialect, line: &Line<'_>) -> Aside {
    match &dialect.header {
        Some(header) if header.texts.iter().any(|t| t == line.bytes.trim_ascii()) => Aside::Header,
        _ if !line.bytes.trim_ascii().is_empty() => Aside::Metadata,
        _ if dialect.regular_blanks > 0 => Aside::RegularBlank,
        _ => Aside::Blank,
    }
}

/// Reason for a line after the first row. Regular blank lines are no breaks, longer runs are;
/// `blank`: the number of the last blank line, and the length of its run.
fn reason_in_data(
    dialect: &Dialect,
    line: &Line<'_>,
    defect: RowDefect,
    blank: &mut (u64, u64),
) -> Aside {
    let text = line.bytes.trim_ascii();
    let header = dialect.header.as_ref();
    if !text.is_empty() && header.is_some_and(|h| h.texts.iter().any(|t| t == text)) {
        return Aside::RepeatedHeader;
    }
    if text.starts_with(GAP_LINE.as_bytes()) {
        return Aside::NamedGap;
    }
    if is_comment(text) {
        return Aside::Comment;
    }
    match defect {
        RowDefect::Blank => {
            let (last, run) = *blank;
            let run = if last + 1 == line.number { run + 1 } else { 1 };
            *blank = (line.number, run);
            if run > dialect.regular_blanks {
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
