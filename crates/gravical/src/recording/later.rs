//! Headers between rows. A header with the names of the first one is a repeated header; one with
//! other columns is an error: the file has to be cut there.

use std::path::Path;

use crate::{Error, Result};

use super::board::BoardSettings;
use super::dialect::{self, Header};
use super::format::Format;
use super::layout::understand_all;
use super::names::Quantity;
use crate::scan::Line;

/// Largest number of stored lines before a header.
const MOST_LINES: usize = 64;
/// Longest line that can be a header.
const LONGEST: usize = 1 << 16;

/// Headers between rows.
#[derive(Debug, Default)]
pub(super) struct LaterHeaders {
    /// Lines of text since the last row.
    pending: Vec<(u64, Vec<u8>)>,
}

impl LaterHeaders {
    /// No line before the next row can be a header.
    #[inline]
    pub fn is_idle(&self) -> bool {
        self.pending.is_empty()
    }

    /// Checks a line of the data part against the lines since the last row.
    ///
    /// # Errors
    ///
    /// `header-differs` (input) if it is a row under a header with other columns than the first.
    #[cold]
    pub fn check(&mut self, line: &[u8], format: &Format, name: &str) -> Result<()> {
        match dialect::fields_of_row(line, &format.dialect) {
            Some(fields) => self.check_header(fields, format, name),
            None => self.delimiter_error(line, format, name).map_or(Ok(()), Err),
        }
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

    /// Checks the header among the lines since the last row; `fields`: of the next row.
    fn check_header(&mut self, fields: usize, format: &Format, name: &str) -> Result<()> {
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
        let metadata: Vec<String> = lines
            .iter()
            .map(|(_, text)| dialect::decode(text))
            .collect();
        let before = BoardSettings::last(&format.dialect.metadata);
        let refuse = |why: &str| Err(refused(header.lines[0], why, name));
        match (before, BoardSettings::last(&metadata)) {
            (Some(before), Some(now)) if !before.has_units_of(&now) => {
                refuse("follows a line of the board with another range or format")
            }
            _ if !names_the_same(&header, format, name) => {
                refuse("has other columns than the first")
            }
            _ => Ok(()),
        }
    }
}

/// True for a header of the sensor that is read, with any other columns; `file`: name of the file.
fn names_sensor(header: &Header, first: &Format, file: &str) -> bool {
    let columns = understand_all(header, file);
    let named = (0..3).all(|i| {
        columns
            .iter()
            .any(|(_, c)| c.quantity == Quantity::Accel(i))
    });
    let known = first.dialect.header.as_ref().is_some_and(|known| {
        let shared = |n: &&String| !n.is_empty() && known.names.contains(*n);
        2 * header.names.iter().filter(shared).count() > header.names.len()
    });
    named || known
}

/// True for the names and units of the first header; where there is none, for names of the columns
/// as they are read.
fn names_the_same(header: &Header, first: &Format, file: &str) -> bool {
    if let Some(known) = &first.dialect.header {
        let units = header.units.is_empty() || header.units == known.units;
        return header.names == known.names && units;
    }
    let columns = understand_all(header, file);
    let mut read = first.layout.fields.iter();
    read.all(|(quantity, field)| {
        let mut named = columns.iter();
        named.any(|(at, column)| at == field && column.quantity == *quantity)
    })
}

fn refused(line: u64, why: &str, name: &str) -> Error {
    Error::input("header-differs", format!("the header in line {line} {why}"))
        .at(Path::new(name), Some(line))
        .with_hint(format!(
            "cut the file before line {line} and read the parts separately"
        ))
}
