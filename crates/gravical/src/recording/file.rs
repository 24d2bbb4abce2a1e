//! A file whose rows can be read, whatever its format.

use std::io::Read;
use std::path::Path;

use crate::finding::{Finding, FindingKind};
use crate::scan::Lines;
use crate::{Error, Result};

use super::ReadOptions;
use super::dialect::terminator;
use super::format::Format;
use super::head::Head;
use super::layout;
use super::metadata;
use super::monitor::{Facts, RecordingClaims};
use super::names::Role;
use super::open::{Input, peek};
use super::row::Values;
use super::rows::{Finished, Item, Rows, Source, Text};
use super::text::{TextRows, find_format};
use super::wearable::{self, DeviceRows, Opened};

/// Rows of a file: lines of text, or samples of a binary format.
pub(crate) enum FileRows<R> {
    Text(Box<TextRows<R>>),
    Device(Box<DeviceRows<R>>),
}

/// A file whose rows can be read.
pub(crate) struct OpenFile {
    pub rows: Rows<FileRows<Box<dyn Read>>>,
    pub format: Format,
    /// Findings about the columns.
    pub findings: Vec<Finding>,
    input: Input,
}

/// Results of a file that was read to its end.
pub(crate) struct ReadFile {
    pub finished: Finished,
    /// Format of the file in words.
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
    let io = |e| Error::io(here, e);
    let reader = std::mem::replace(&mut input.reader, Box::new(std::io::empty()));
    let (magic, reader) = peek(reader, wearable::MAGIC).map_err(io)?;
    let mut findings = Vec::new();
    let claims = |format: &Format| RecordingClaims {
        metadata_rate_hz: metadata::rate_hz(&format.dialect.metadata),
        layout: format.layout.clone(),
        options: options.clone(),
    };
    let (format, length, head, rows) = match wearable::is_one(&magic) {
        true => {
            let (bytes, reader) = peek(reader, input.head_bytes).map_err(io)?;
            let whole = bytes.len() < input.head_bytes;
            let opened = Opened::of(&bytes, here)?;
            let request = layout::Request {
                columns: options.columns.as_ref(),
                sensor: options.sensor.as_deref(),
                file: name,
            };
            let format = Format {
                layout: layout::find(role, &opened.dialect, request, &mut findings)
                    .map_err(|e| e.at(here, None))?,
                description: opened.description.clone(),
                dialect: opened.dialect.clone(),
                role,
            };
            let first = opened.rows(&bytes[..], name, !whole).map_err(io)?;
            let head = Head::read(first, &claims(&format));
            let all = opened.rows(reader, name, false).map_err(io)?;
            (format, bytes.len(), head, FileRows::Device(Box::new(all)))
        }
        false => {
            let mut lines = Lines::new(reader);
            let bytes = lines.peek(input.head_bytes).map_err(io)?.to_vec();
            let whole = bytes.len() < input.head_bytes;
            let clean: Vec<u8> = bytes.iter().copied().filter(|b| *b != 0).collect();
            let format = find_format(&clean, whole, name, role, options, &mut findings)?;
            let first = Lines::new(&clean[..]).with_terminator(terminator(&clean));
            let first = TextRows::new(first, name, &format, !whole);
            let head = Head::read(first, &claims(&format));
            let lines = lines.with_terminator(terminator(&clean));
            let all = TextRows::new(lines, name, &format, false);
            (format, clean.len(), head, FileRows::Text(Box::new(all)))
        }
    };
    let facts = facts.unwrap_or_else(|| head.facts());
    let expected = head.expected(length, input.size);
    Ok(OpenFile {
        rows: Rows::new(rows, name, claims(&format), facts).expecting(expected),
        format,
        findings,
        input,
    })
}

/// Length of the complete rows of `head`, the beginning of a longer file.
pub(crate) fn complete_rows(head: &[u8]) -> usize {
    if wearable::is_one(head) {
        return wearable::complete_blocks(head);
    }
    let end = head.iter().rposition(|b| matches!(b, b'\n' | b'\r'));
    end.map_or(head.len(), |at| at + 1)
}

impl OpenFile {
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
                format!("the packed file is damaged or ends in the middle; {rows} rows could be unpacked"),
            ));
        }
        findings.extend(finished.ledger.findings());
        let mut description = self.input.unpacked.clone();
        description.push(self.format.description);
        match self.rows.source() {
            FileRows::Text(rows) => findings.extend(rows.odd_bytes(&self.input.unpacked)),
            FileRows::Device(rows) => findings.extend(rows.findings()),
        }
        Ok(ReadFile {
            finished,
            description: description.join(", "),
            sha256: self.input.sha256(),
            findings,
        })
    }
}

impl<R: Read> Source for FileRows<R> {
    #[inline]
    fn next(&mut self, values: &mut Values) -> Result<Option<Item>> {
        match self {
            FileRows::Text(rows) => rows.next(values),
            FileRows::Device(rows) => rows.next(values),
        }
    }

    #[inline]
    fn number(&self) -> u64 {
        match self {
            FileRows::Text(rows) => rows.number(),
            FileRows::Device(rows) => rows.number(),
        }
    }

    #[inline]
    fn text(&self) -> Text<'_> {
        match self {
            FileRows::Text(rows) => rows.text(),
            FileRows::Device(rows) => rows.text(),
        }
    }

    fn can_skip(&self) -> bool {
        match self {
            FileRows::Text(rows) => rows.can_skip(),
            FileRows::Device(rows) => rows.can_skip(),
        }
    }

    fn skip_to(&mut self, line: u64) -> Result<()> {
        match self {
            FileRows::Text(rows) => rows.skip_to(line),
            FileRows::Device(rows) => rows.skip_to(line),
        }
    }
}
