//! Headers among the rows. One that means the same as the first is a repeated header; the
//! rows under another one are rewritten as the first header has them, so that one recording
//! has one meaning.

use std::path::Path;

use crate::{Error, Result};

use super::dialect::{self, Header};
use super::format::Format;
use super::layout::later::{Correspondence, First, corresponding, names_sensor};
use super::row::{Delimiter, RowDefect, RowScanner, SLOTS, Span};
use crate::finding::{Finding, FindingKind, LineSpans};
use crate::scan::{Line, parse_field, parse_field_decimal_comma};

/// Lines in front of a header that are kept at most.
const MOST_LINES: usize = 64;
/// Longer lines are no header.
const LONGEST: usize = 1 << 16;

/// What came of the headers among the rows.
#[derive(Debug, Default)]
pub(super) struct LaterHeaders {
    /// Lines of text since the last row.
    since: Vec<(u64, Vec<u8>)>,
    /// How rows are rewritten.
    rewrite: Option<Rewrite>,
    /// A row as the first header has it.
    row: Vec<u8>,
    /// Headers that mean something else than the first …
    changed: LineSpans,
    /// … and what the first of them changes.
    changes: String,
}

#[derive(Debug)]
struct Rewrite {
    by: Correspondence,
    scanner: RowScanner,
    spans: Vec<Span>,
}

impl LaterHeaders {
    /// Rows are read as they stand, and no line in front of the next one may be a header.
    #[inline]
    pub fn is_idle(&self) -> bool {
        self.since.is_empty() && self.rewrite.is_none()
    }

    /// No header so far meant anything else than the first.
    pub fn never_changed(&self) -> bool {
        self.rewrite.is_none() && self.changed.is_empty()
    }

    /// The row that was rewritten last.
    pub fn rewritten(&self) -> &[u8] {
        &self.row
    }

    /// A line of the data part: true where it had to be [rewritten](Self::rewritten).
    /// `all_columns`: even those that are not read are wanted.
    ///
    /// # Errors
    ///
    /// `header-differs` (input) where the header above it means what the first one cannot.
    #[cold]
    pub fn line(
        &mut self,
        line: &[u8],
        format: &Format,
        name: &str,
        all_columns: bool,
    ) -> Result<Result<bool, RowDefect>> {
        let dialect = &format.dialect;
        if !self.since.is_empty()
            && let Some(fields) = dialect::fields_of_row(line, dialect)
        {
            self.settle(fields, format, name, all_columns)?;
        } else if let Some(refused) = self.parted_otherwise(line, format, name) {
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

    /// Keeps a line that is no row; true where it is (part of) a header.
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
        if self.since.len() == MOST_LINES {
            self.since.remove(0);
        }
        self.since.push((line.number, text.to_vec()));
        self.header(&first(format, name), self.since.len())
            .is_some_and(|h| h.lines[1] == line.number)
    }

    /// The header that the first `n` lines since the last row end with.
    fn header(&self, first: &First<'_>, n: usize) -> Option<Header> {
        let lines = self.since.get(..n)?;
        let (_, last) = lines.last()?;
        let known = first.dialect.header.as_ref();
        // Where the first header is none, a comment may name the columns.
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

    /// Why `line` cannot be read, where it stands under a header of its own and both are
    /// parted by something else than the rows before.
    fn parted_otherwise(&self, line: &[u8], format: &Format, name: &str) -> Option<Error> {
        let (number, names) = self.since.last()?;
        let way = dialect::parted_otherwise(names, line, &format.dialect)?;
        let header = dialect::header_below(&self.since, way)?;
        let why = format!("has its names separated by {}", way.name());
        names_sensor(&header, &first(format, name)).then(|| refused(*number, &why, name))
    }

    /// What the lines since the last row make of the rows to come, the next of which has
    /// so many fields.
    fn settle(
        &mut self,
        fields: usize,
        format: &Format,
        name: &str,
        all_columns: bool,
    ) -> Result<()> {
        let first = first(format, name);
        let ends = (1..=self.since.len()).rev();
        let header = ends.map(|n| self.header(&first, n)).find_map(|h| h);
        let lines = std::mem::take(&mut self.since);
        let Some(header) = header else {
            return Ok(());
        };
        // Pieces of headers, as a reset of the board leaves them, are none.
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
        let by = corresponding(&first, &header, metadata.collect()).map_err(refuse)?;
        if all_columns && !by.surplus.is_empty() {
            let names = by.surplus.join(", ");
            return Err(refuse(format!(
                "names columns that the first one has not: {names}"
            )));
        }
        if by.is_identity() {
            self.rewrite = None;
            return Ok(());
        }
        if self.changed.is_empty() {
            self.changes = by.changes.clone();
        }
        self.changed.push(line);
        let dialect = &format.dialect;
        self.rewrite = Some(Rewrite {
            scanner: RowScanner::new(dialect.delimiter, dialect.decimal_comma, by.fields),
            by,
            spans: Vec::new(),
        });
        Ok(())
    }

    /// What is said of headers that mean something else than the first.
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
                    "the header in line {line} means something else than the first ({what}); its rows are read as the first header has them"
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
            "cut the file in front of line {line}, and give each part on its own"
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
    /// `line` as the first header has it.
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
        // Nothing is assigned, so that every line is blank at the best.
        if let Err(defect) = scanned
            && (self.spans.len() != self.by.fields || defect != RowDefect::Blank)
        {
            return Err(defect);
        }
        let (between, empty): (u8, &[u8]) = match delimiter {
            Delimiter::Byte(byte) => (byte, b""),
            Delimiter::Whitespace => (b'\t', b"-"),
        };
        for (i, (from, factor)) in self.by.columns.iter().enumerate() {
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
