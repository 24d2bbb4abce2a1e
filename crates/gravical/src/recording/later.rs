//! Headers between rows. A header that means the same as the first is a repeated header; rows
//! under a different header are rewritten in the columns and units of the first one.

use std::path::Path;

use crate::{Error, Result};

use super::dialect::{self, Header};
use super::format::Format;
use super::layout::later::{Correspondence, First, corresponding, names_sensor};
use super::row::{Delimiter, RowDefect, RowScanner, SLOTS, Span};
use crate::finding::{Finding, FindingKind, LineSpans};
use crate::scan::{Line, parse_field, parse_field_decimal_comma};

/// Largest number of stored lines before a header.
const MOST_LINES: usize = 64;
/// Longest line that can be a header.
const LONGEST: usize = 1 << 16;

/// Headers between rows.
#[derive(Debug, Default)]
pub(super) struct LaterHeaders {
    /// Lines of text since the last row.
    pending: Vec<(u64, Vec<u8>)>,
    /// How rows are rewritten, if necessary.
    rewrite: Option<Rewrite>,
    /// The rewritten row.
    row: Vec<u8>,
    /// Headers that differ from the first …
    changed: LineSpans,
    /// … and the differences of the first of them.
    changes: String,
}

#[derive(Debug)]
struct Rewrite {
    correspondence: Correspondence,
    scanner: RowScanner,
    spans: Vec<Span>,
}

impl LaterHeaders {
    /// Rows need not be rewritten, and no line before the next row can be a header.
    #[inline]
    pub fn is_idle(&self) -> bool {
        self.pending.is_empty() && self.rewrite.is_none()
    }

    /// All headers so far mean the same as the first.
    pub fn never_changed(&self) -> bool {
        self.rewrite.is_none() && self.changed.is_empty()
    }

    /// The last rewritten row.
    pub fn rewritten(&self) -> &[u8] {
        &self.row
    }

    /// Processes a line of the data part: true if it was [rewritten](Self::rewritten).
    /// `all_columns`: all columns are needed, not only those that are read.
    ///
    /// # Errors
    ///
    /// `header-differs` (input) if the header above cannot be converted to the first one.
    #[cold]
    pub fn line(
        &mut self,
        line: &[u8],
        format: &Format,
        name: &str,
        all_columns: bool,
    ) -> Result<Result<bool, RowDefect>> {
        let dialect = &format.dialect;
        if !self.pending.is_empty()
            && let Some(fields) = dialect::fields_of_row(line, dialect)
        {
            self.apply_header(fields, format, name, all_columns)?;
        } else if let Some(refused) = self.delimiter_error(line, format, name) {
            return Err(refused);
        }
        let Some(rewrite) = &mut self.rewrite else {
            return Ok(Ok(false));
        };
        let done = rewrite.row(
            line,
            dialect.delimiter,
            dialect.decimal_comma,
            &mut self.row,
        );
        Ok(done.map(|()| true))
    }

    /// Stores a line that is not a row; true if it is (the last line of) a header.
    #[cold]
    pub fn set_aside(&mut self, line: &Line<'_>, format: &Format, name: &str) -> bool {
        let text = line.bytes.trim_ascii();
        let has_words = text.iter().any(u8::is_ascii_alphabetic);
        if !has_words
            || text.len() > LONGEST
            || dialect::fields_of_row(text, &format.dialect).is_some()
        {
            return false;
        }
        if self.pending.len() == MOST_LINES {
            self.pending.remove(0);
        }
        self.pending.push((line.number, text.to_vec()));
        self.header(&first(format, name), self.pending.len())
            .is_some_and(|h| h.lines[1] == line.number)
    }

    /// The header at the end of the first `n` lines since the last row.
    fn header(&self, first: &First<'_>, n: usize) -> Option<Header> {
        let lines = self.pending.get(..n)?;
        let (_, last) = lines.last()?;
        let known = first.dialect.header.as_ref();
        // Names in a comment are a header only if the first header is a comment or missing.
        let in_comment = |t: &[u8]| dialect::strip_comment(t).len() < t.len();
        let comments = known.is_none_or(|h| h.texts.iter().any(|t| in_comment(t)));
        if in_comment(last) && !comments {
            return None;
        }
        if let Some(known) = known
            && known.texts.iter().rev().eq(lines
                .iter()
                .rev()
                .take(known.texts.len())
                .map(|(_, text)| text))
        {
            return Some(Header {
                lines: [
                    lines.get(n.checked_sub(known.texts.len())?)?.0,
                    lines.last()?.0,
                ],
                ..known.clone()
            });
        }
        let header = dialect::header_below(lines, first.dialect.delimiter)?;
        names_sensor(&header, first).then_some(header)
    }

    /// The error for a row under a header if both have another delimiter than the rows before.
    fn delimiter_error(&self, line: &[u8], format: &Format, name: &str) -> Option<Error> {
        let (number, names) = self.pending.last()?;
        let delimiter = dialect::other_delimiter(names, line, &format.dialect)?;
        let header = dialect::header_below(&self.pending, delimiter)?;
        let why = format!("has its names separated by {}", delimiter.name());
        names_sensor(&header, &first(format, name)).then(|| refused(*number, &why, name))
    }

    /// Determines how the following rows are read, from the lines since the last row; `fields`:
    /// number of fields of the next row.
    fn apply_header(
        &mut self,
        fields: usize,
        format: &Format,
        name: &str,
        all_columns: bool,
    ) -> Result<()> {
        let first = first(format, name);
        let ends = (1..=self.pending.len()).rev();
        let header = ends.map(|n| self.header(&first, n)).find_map(|h| h);
        let lines = std::mem::take(&mut self.pending);
        let Some(header) = header else {
            return Ok(());
        };
        // Pieces of the first header, as a reset of the board leaves them, are not headers.
        let known = first.dialect.header.iter().flat_map(|h| &h.texts);
        let is_piece = |text: &[u8]| {
            let mut known = known.clone();
            known.any(|whole| whole != text && memchr::memmem::find(whole, text).is_some())
        };
        let names = lines.iter().find(|(number, _)| *number == header.lines[1]);
        let piece = names.is_some_and(|(_, text)| is_piece(text));
        if fields == first.dialect.fields && (piece || !header.fits(fields)) {
            return Ok(());
        }
        let line = header.lines[0];
        let refuse = |why: String| refused(line, &why, name);
        let metadata = lines.iter().map(|(_, text)| dialect::decode(text));
        let correspondence = corresponding(&first, &header, metadata.collect()).map_err(refuse)?;
        if all_columns && !correspondence.surplus.is_empty() {
            let names = correspondence.surplus.join(", ");
            return Err(refuse(format!(
                "names columns that the first one does not have: {names}"
            )));
        }
        if correspondence.is_identity() {
            self.rewrite = None;
            return Ok(());
        }
        if self.changed.is_empty() {
            self.changes = correspondence.changes.clone();
        }
        self.changed.push(line);
        let dialect = &format.dialect;
        self.rewrite = Some(Rewrite {
            scanner: RowScanner::new(
                dialect.delimiter,
                dialect.decimal_comma,
                correspondence.fields,
            ),
            correspondence,
            spans: Vec::new(),
        });
        Ok(())
    }

    /// The finding about headers that differ from the first.
    pub fn finding(&self) -> Option<Finding> {
        let line = self.changed.first()?;
        let what = match &self.changes[..] {
            "" => "columns that are missing or not read",
            changes => changes,
        };
        Some(
            Finding::new(
                FindingKind::HeaderChanged,
                format!(
                    "the header in line {line} differs from the first ({what}); its rows are converted to the columns and units of the first"
                ),
            )
            .at_lines(&self.changed),
        )
    }
}

fn refused(line: u64, why: &str, name: &str) -> Error {
    Error::input("header-differs", format!("the header in line {line} {why}"))
        .at(Path::new(name), Some(line))
        .with_hint(format!(
            "split the file before line {line} and read the parts separately"
        ))
}

fn first<'a>(format: &'a Format, name: &'a str) -> First<'a> {
    First {
        dialect: &format.dialect,
        layout: &format.layout,
        role: format.role,
        options: &format.options,
        file: name,
    }
}

impl Rewrite {
    /// Rewrites `line` in the columns and units of the first header.
    fn row(
        &mut self,
        line: &[u8],
        delimiter: Delimiter,
        decimal_comma: bool,
        out: &mut Vec<u8>,
    ) -> Result<(), RowDefect> {
        out.clear();
        let mut none = [f64::NAN; SLOTS];
        let scanned = self.scanner.scan_spans(line, &mut none, &mut self.spans);
        // No field is assigned, so that a correct line is blank.
        if let Err(defect) = scanned
            && (self.spans.len() != self.correspondence.fields || defect != RowDefect::Blank)
        {
            return Err(defect);
        }
        let (between, empty): (u8, &[u8]) = match delimiter {
            Delimiter::Byte(byte) => (byte, b""),
            Delimiter::Whitespace => (b'\t', b"-"),
        };
        for (i, (from, factor)) in self.correspondence.columns.iter().enumerate() {
            if i > 0 {
                out.push(between);
            }
            let span = from.and_then(|from| self.spans.get(from));
            let field = span.and_then(|&(a, b)| line.get(a as usize..b as usize));
            let field = field.unwrap_or_default();
            let number = (*factor != 1.0).then(|| number(field, decimal_comma));
            match number.flatten() {
                Some(value) => {
                    let text = format!("{}", value * factor);
                    match decimal_comma {
                        true => out.extend_from_slice(text.replace('.', ",").as_bytes()),
                        false => out.extend_from_slice(text.as_bytes()),
                    }
                }
                None if field.is_empty() => out.extend_from_slice(empty),
                None => out.extend_from_slice(field),
            }
        }
        Ok(())
    }
}

fn number(field: &[u8], decimal_comma: bool) -> Option<f64> {
    let text = field.trim_ascii();
    let text = match text {
        [b'"', inner @ .., b'"'] => inner.trim_ascii(),
        other => other,
    };
    match decimal_comma {
        true => parse_field_decimal_comma(text).or_else(|| parse_field(text)),
        false => parse_field(text),
    }
}
