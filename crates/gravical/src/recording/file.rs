//! A text file whose rows can be read.

use std::io::Read;
use std::path::Path;

use crate::scan::Lines;
use crate::{Error, Result};

use super::ReadOptions;
use super::dialect::terminator;
use super::format::Format;
use super::head::Head;
use super::metadata;
use super::monitor::RecordingClaims;
use super::open::Input;
use super::rows::Rows;
use super::text::{TextRows, find_format};

/// A file whose rows can be read.
pub(crate) struct OpenFile {
    pub rows: Rows<TextRows<Box<dyn Read>>>,
    pub format: Format,
}

/// Opens `input`, determines its format and columns, and evaluates the first rows. `name` is used
/// in messages.
///
/// # Errors
///
/// `empty-file`, `no-rows`, `no-accelerometer`, `columns-unknown` …; errors of
/// reading.
pub(crate) fn open_rows(input: Input, name: &str, options: &ReadOptions) -> Result<OpenFile> {
    let mut lines = Lines::new(input.reader);
    let bytes = lines.peek(input.head_bytes);
    let bytes = bytes.map_err(|e| Error::io(Path::new(name), e))?.to_vec();
    let whole = bytes.len() < input.head_bytes;
    let clean: Vec<u8> = bytes.iter().copied().filter(|b| *b != 0).collect();
    let format = find_format(&clean, whole, name, options)?;
    let first = Lines::new(&clean[..]).with_terminator(terminator(&clean));
    let first = TextRows::new(first, name, &format, !whole);
    let claims = RecordingClaims {
        metadata_rate_hz: metadata::rate_hz(&format.dialect.metadata),
        layout: format.layout.clone(),
        options: options.clone(),
    };
    let facts = Head::read(first, &claims).facts();
    let lines = lines.with_terminator(terminator(&clean));
    let rows = TextRows::new(lines, name, &format, false);
    Ok(OpenFile {
        rows: Rows::new(rows, claims, facts),
        format,
    })
}
