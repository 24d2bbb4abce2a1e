//! Headers between rows. A header that means the same as the first is a repeated header; rows
//! under a different header are converted to the columns and units of the first one.

mod columns;

use std::path::Path;

use crate::{Error, Result};

use super::dialect::{self, Header};
use super::format::Format;
use crate::finding::{Finding, FindingKind, LineSpans};
use crate::scan::Line;

use columns::{Columns, corresponding, names_sensor};

/// Largest number of stored lines before a header.
const MOST_LINES: usize = 64;
/// Longest line that can be a header.
const LONGEST: usize = 1 << 16;

/// Headers between rows.
#[derive(Debug, Default)]
pub(super) struct LaterHeaders {
    /// Lines of text since the last row.
    pending: Vec<(u64, Vec<u8>)>,
    /// Columns of the rows, if they are read otherwise than under the first header.
    columns: Option<Columns>,
    /// Headers that differ from the first …
    changed: LineSpans,
    /// … and the differences of the first of them.
    changes: String,
}

impl LaterHeaders {
    /// Rows are read as under the first header, and no line before the next row can be a header.
    #[inline]
    pub fn is_idle(&self) -> bool {
        self.pending.is_empty() && self.columns.is_none()
    }

    /// All headers so far mean the same as the first.
    pub fn never_changed(&self) -> bool {
        self.changed.is_empty()
    }

    /// The columns of a line of the data part; `None` if it is read as under the first header.
    /// `all_columns`: all columns are needed, not only those that are read.
    ///
    /// # Errors
    ///
    /// `header-differs` (input) if the header above cannot be converted to the first one.
    #[cold]
    pub fn columns_of(
        &mut self,
        line: &[u8],
        format: &Format,
        name: &str,
        all_columns: bool,
    ) -> Result<Option<&Columns>> {
        if !self.pending.is_empty()
            && let Some(fields) = dialect::fields_of_row(line, &format.dialect)
        {
            self.apply_header(fields, format, name, all_columns)?;
        } else if let Some(refused) = self.delimiter_error(line, format, name) {
            return Err(refused);
        }
        Ok(self.columns.as_ref())
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
        self.header(self.pending.len(), format, name)
            .is_some_and(|h| h.lines[1] == line.number)
    }

    /// The header at the end of the first `n` lines since the last row.
    fn header(&self, n: usize, first: &Format, name: &str) -> Option<Header> {
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
        names_sensor(&header, first, name).then_some(header)
    }

    /// The error for a row under a header if both have another delimiter than the rows before.
    fn delimiter_error(&self, line: &[u8], format: &Format, name: &str) -> Option<Error> {
        let (number, names) = self.pending.last()?;
        let delimiter = dialect::other_delimiter(names, line, &format.dialect)?;
        let header = dialect::header_below(&self.pending, delimiter)?;
        let why = format!("has its names separated by {}", delimiter.name());
        names_sensor(&header, format, name).then(|| refused(*number, &why, name))
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
        let mut ends = (1..=self.pending.len()).rev();
        let header = ends.find_map(|n| self.header(n, format, name));
        let lines = std::mem::take(&mut self.pending);
        let Some(header) = header else {
            return Ok(());
        };
        // Pieces of the first header, as a reset of the board leaves them, are not headers.
        let known = format.dialect.header.iter().flat_map(|h| &h.texts);
        let is_piece = |text: &[u8]| {
            let mut known = known.clone();
            known.any(|whole| whole != text && memchr::memmem::find(whole, text).is_some())
        };
        let names = lines.iter().find(|(number, _)| *number == header.lines[1]);
        let piece = names.is_some_and(|(_, text)| is_piece(text));
        if fields == format.dialect.fields && (piece || !header.fits(fields)) {
            return Ok(());
        }
        let line = header.lines[0];
        let refuse = |why: String| refused(line, &why, name);
        let metadata = lines.iter().map(|(_, text)| dialect::decode(text));
        let columns = corresponding(format, header, metadata.collect(), name).map_err(refuse)?;
        if all_columns && !columns.surplus.is_empty() {
            let names = columns.surplus.join(", ");
            return Err(refuse(format!(
                "names columns that the first one does not have: {names}"
            )));
        }
        self.columns = Some(columns).filter(|columns| !columns.is_identity());
        if let Some(columns) = &self.columns {
            if self.changed.is_empty() {
                self.changes.clone_from(&columns.changes);
            }
            self.changed.push(line);
        }
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
