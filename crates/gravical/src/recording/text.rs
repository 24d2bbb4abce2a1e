//! Rows of a text file.

use std::io::Read;
use std::path::Path;

use crate::scan::{Line, Lines};
use crate::{Error, Result};

use super::ReadOptions;
use super::dialect::{Dialect, sniff};
use super::foreign;
use super::format::Format;
use super::later::LaterHeaders;
use super::layout::{self, Request};
use super::ledger::{Aside, is_comment};
use super::row::{RowDefect, RowScanner, RowStamps, Span, Values};
use super::rows::{Item, Source};

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
    label: Span,
    number: u64,
    /// Number of the last blank line, and length of the run of blank lines that it ends.
    blank: (u64, u64),
    /// The input is cut off: a last line without an end is ignored.
    cut: bool,
}

/// Format and columns, from the first bytes of a file.
pub(super) fn find_format(
    head: &[u8],
    whole: bool,
    name: &str,
    options: &ReadOptions,
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
    let mut layout =
        layout::find(&dialect, request).map_err(|e| e.at(here, dialect.header_line()))?;
    layout.apply_board_settings(&dialect.metadata);
    Ok(Format {
        description: dialect.description(),
        dialect,
        layout,
    })
}

impl<R: Read> TextRows<R> {
    pub(super) fn new(lines: Lines<R>, name: &str, format: &Format, cut: bool) -> Self {
        let scanner = format.layout.scanner(&format.dialect);
        TextRows {
            lines,
            name: name.to_owned(),
            stamps: format.layout.stamps(),
            format: format.clone(),
            later: LaterHeaders::default(),
            scanner,
            label: (0, 0),
            number: 0,
            blank: (0, 0),
            cut,
        }
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
        if line.number >= self.format.dialect.first_data_line {
            let bytes = line.bytes;
            if !self.later.is_idle() {
                self.later.check(bytes, &self.format, &self.name)?;
            }
            match self.scanner.scan(bytes, values, &mut self.label) {
                Ok(()) => {
                    self.stamps.stamp(values);
                    return Ok(Some(Item::Row));
                }
                Err(defect) => {
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
        Ok(Some(Item::Aside(reason_before_data(
            &self.format.dialect,
            &line,
        ))))
    }

    #[inline]
    fn number(&self) -> u64 {
        self.number
    }

    #[inline]
    fn label(&self) -> &[u8] {
        let (from, to) = self.label;
        let line = self.lines.current().get(from as usize..to as usize);
        line.unwrap_or_default()
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
