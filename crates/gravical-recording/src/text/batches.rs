//! Lines to batches.

use std::cmp::Ordering;
use std::io::{self, BufRead};

use memchr::memchr;

use super::batch::{Batch, Reason};
use super::dialect::{Dialect, fields, is_blank, is_comment, uncommented};
use super::format::Format;
use super::header::Header;
use super::lines::{Lines, trim_end};
use super::number::parse_cell;
use super::words::Sentences;
use crate::board::BoardSettings;
use crate::error::Error;

/// Rows of a batch: its columns fit a cache, and their memory is used again instead of being given back.
pub const BATCH_ROWS: usize = 16_384;

/// A column with so many words may hold numbers wrapped in words.
pub(crate) const MANY_WORDS: u8 = 32;

impl Format {
    /// Reads a text from its first line on in batches of 16,384 rows.
    pub fn batches<R: BufRead>(&self, bytes: R) -> Batches<R> {
        let fields = self.columns.len();
        Batches {
            lines: Lines::new(bytes, self.line_end),
            parser: RowParser {
                format: self.clone(),
                batch: Batch::new(fields),
                slots: vec![String::new(); fields],
                ..RowParser::default()
            },
        }
    }
}

/// Iterates over the batches of a text; made by [`Format::batches`].
pub struct Batches<R> {
    lines: Lines<R>,
    parser: RowParser,
}

/// Lines on their way into a batch.
#[derive(Default)]
struct RowParser {
    format: Format,
    /// Lines read.
    line_number: usize,
    batch: Batch,
    /// Blank lines since the last row.
    blanks: usize,
    has_break: bool,
    has_header: bool,
    /// Place of the last line within its row.
    place: Option<usize>,
    /// Columns whose text is kept, each piece from the first to the last.
    copied: Vec<(usize, usize)>,
    /// Where the fields of the row begin and end.
    spans: Vec<(usize, usize)>,
    /// Text of the numbers of the row that is being read from sentences.
    slots: Vec<String>,
}

/// What to do about rows that cannot be read with those before them.
pub fn split_hint(line: u64) -> String {
    format!("split the file before line {line} and read the parts separately")
}

/// Marks rows that are written under other columns.
fn header_differs(line: usize, why: &str) -> io::Error {
    let error = Error::input("header-differs", format!("the header in line {line} {why}"))
        .at_line(line)
        .with_hint(split_hint(line as u64));
    io::Error::other(error)
}

impl<R: BufRead> Batches<R> {
    /// Keeps the text of columns in [`Batch::text`], in pieces from one column to another.
    pub fn with_text(mut self, pieces: &[(usize, usize)]) -> Self {
        self.parser.copied = pieces.to_vec();
        self.parser.batch.text.pieces = pieces.len();
        self
    }

    /// Reads on until a batch is full and a new row would begin.
    pub(crate) fn read_batch(&mut self) -> io::Result<Option<Batch>> {
        while let Some(line) = self.lines.next()? {
            self.parser.read(line)?;
            if self.parser.is_full() {
                return Ok(Some(self.parser.finish_batch()));
            }
        }
        let batch = &self.parser.batch;
        let has_lines = batch.rows() > 0 || batch.ledger.total() > 0;
        Ok(has_lines.then(|| self.parser.finish_batch()))
    }

    /// Goes on with the next whole lines of a text that grows, once those before are read.
    pub(crate) fn feed(&mut self, lines: R) {
        self.lines.reader = lines;
    }

    /// The first batch, or what of it is before an error: that is told when the rows are read.
    pub(crate) fn first(mut self) -> Batch {
        let batch = self.read_batch().ok().flatten();
        batch.unwrap_or_else(|| self.parser.finish_batch())
    }
}

impl<R: BufRead> Iterator for Batches<R> {
    type Item = io::Result<Batch>;

    fn next(&mut self) -> Option<Self::Item> {
        self.read_batch().transpose()
    }
}

impl RowParser {
    /// Whether the batch has its rows; the lines of a row that has begun belong to it.
    fn is_full(&self) -> bool {
        let (rows, sentences) = (self.batch.rows(), self.format.sentences.as_ref());
        let is_whole = || self.place == sentences.map(Sentences::last_place);
        rows >= BATCH_ROWS && (rows >= 2 * BATCH_ROWS || is_whole())
    }

    /// The batch; the next one has room for as many rows.
    fn finish_batch(&mut self) -> Batch {
        self.push_slots();
        let next = Batch::new(self.batch.columns.len());
        let mut batch = std::mem::replace(&mut self.batch, next);
        let (next, rows) = (&mut self.batch, batch.rows());
        for (column, last) in next.columns.iter_mut().zip(&batch.columns) {
            column.reserve_exact(last.len());
        }
        next.lines.reserve_exact(rows);
        next.words.clone_from(&batch.words);
        next.text = batch.text.emptied();
        let texts = batch.texts.iter_mut().filter(|t| !t.is_empty());
        texts.for_each(|t| t.resize(rows, 0));
        batch.ledger.lines = self.line_number;
        batch
    }

    fn read(&mut self, line: &str) -> io::Result<()> {
        self.line_number += 1;
        let cleaned = memchr(0, line.as_bytes()).map(|_| line.replace('\0', ""));
        if cleaned.is_some() {
            self.batch.nul_lines.push(self.line_number as u64);
        }
        let line = trim_end(cleaned.as_deref().unwrap_or(line));
        if let Some(reason) = self.read_row(line)? {
            self.batch.ledger.add(reason, self.line_number, line);
        }
        Ok(())
    }

    /// Reads a row, or says why the line is none. A header of other columns ends the reading.
    fn read_row(&mut self, line: &str) -> io::Result<Option<Reason>> {
        if self.line_number == self.format.header_line {
            return Ok(Some(Reason::Header));
        }
        if self.line_number <= self.format.head_lines {
            return Ok(Some(Reason::Metadata));
        }
        if is_blank(line) {
            self.blanks += 1;
            return Ok(Some(Reason::Blank));
        }
        if is_comment(line) {
            return self.read_comment(line).map(Some);
        }
        if self.format.sentences.is_some() {
            return Ok(self.read_sentence(line));
        }
        let dialect = self.format.dialect;
        let reason = self.read_fields(line, dialect);
        match reason.and_then(|_| Header::is_repeated(line, dialect, &self.format)) {
            None => Ok(reason),
            Some(true) => {
                self.has_header = true;
                Ok(Some(Reason::RepeatedHeader))
            }
            Some(false) => {
                let why = "has other columns, or another delimiter, than the first";
                Err(header_differs(self.line_number, why))
            }
        }
    }

    /// `# gap: …` and `# rejected: …` as our logger writes them, and the settings of our board.
    fn read_comment(&mut self, line: &str) -> io::Result<Reason> {
        let text = uncommented(line);
        if text.starts_with("gap:") {
            self.has_break = true;
            return Ok(Reason::NamedGap);
        }
        if text.starts_with("rejected:") {
            return Ok(Reason::Rejected);
        }
        if let (Some(before), Some(now)) = (self.format.board, BoardSettings::parse(line))
            && !before.has_units_of(&now)
        {
            let why = "follows a line of the board with another range or format";
            return Err(header_differs(self.line_number, why));
        }
        Ok(Reason::Comment)
    }

    fn read_fields(&mut self, line: &str, dialect: Dialect) -> Option<Reason> {
        let row = self.batch.rows();
        self.spans.clear();
        let (mut count, mut has_number, mut texts) = (0, false, Vec::new());
        let last_copied = self.copied.last().map_or(0, |piece| piece.1 + 1);
        let (mut cells, point) = (fields(line, dialect.delimiter), dialect.point());
        let mut columns = self.batch.columns.iter_mut().zip(&self.format.is_read);
        loop {
            let mut column = columns.next().filter(|(_, is_read)| **is_read);
            if let Some((column, _)) = &mut column
                && let Some(value) = cells.number(point)
            {
                has_number = true;
                column.push(value);
            } else if let Some(field) = cells.next() {
                if let Some((column, _)) = column {
                    let value = dialect.parse_field(field);
                    has_number |= value.is_some_and(f64::is_finite);
                    if value.is_none() {
                        texts.push((count, field));
                    }
                    column.push(value.unwrap_or(f64::NAN));
                }
            } else {
                break;
            }
            if count < last_copied {
                self.spans.push(cells.span);
            }
            count += 1;
        }
        let reason = match count.cmp(&dialect.fields) {
            Ordering::Less => Some(Reason::TornLine),
            Ordering::Greater => Some(Reason::TooManyFields),
            Ordering::Equal => (!has_number).then_some(Reason::NotANumber),
        };
        if reason.is_some() {
            self.batch.columns.iter_mut().for_each(|c| c.truncate(row));
            return reason;
        }
        self.begin_row();
        for (first, last) in &self.copied {
            let (from, to) = (self.spans[*first].0, self.spans[*last].1);
            self.batch.text.push(&line.as_bytes()[from..to]);
        }
        for (column, word) in texts {
            self.batch.texts[column].resize(row, 0);
            self.batch.push_word(column, word);
        }
        None
    }

    fn read_sentence(&mut self, line: &str) -> Option<Reason> {
        let sentences = self.format.sentences.as_ref();
        let Some(sentence) = sentences.and_then(|s| s.parse(line)) else {
            return Some(Reason::NotANumber);
        };
        let begins = self.place.is_none_or(|last| sentence.place <= last);
        if begins {
            self.push_slots();
            self.begin_row();
            let columns = self.batch.columns.iter_mut();
            columns.for_each(|column| column.push(f64::NAN));
        } else {
            self.blanks = 0;
        }
        self.place = Some(sentence.place);
        for (slot, number) in sentence.numbers {
            let cell = self.batch.columns[slot].last_mut();
            if let (Some(cell), Some(value)) = (cell, parse_cell(&number, false)) {
                *cell = value;
            }
            self.slots[slot] = number;
        }
        (!begins).then_some(Reason::Continuation)
    }

    fn begin_row(&mut self) {
        let row = self.batch.rows();
        if std::mem::take(&mut self.has_break) {
            self.batch.breaks.push(row);
        }
        if std::mem::take(&mut self.has_header) {
            self.batch.headers.push(row);
        }
        let blanks = std::mem::take(&mut self.blanks);
        if blanks > 0 {
            self.batch.blanks.push((row, blanks));
        }
        let line = u32::try_from(self.line_number).unwrap_or(u32::MAX);
        self.batch.lines.push(line);
    }

    /// Copies the numbers of a row that was wrapped in words, if one has begun.
    fn push_slots(&mut self) {
        if self.place.take().is_none() {
            return;
        }
        for (first, last) in &self.copied {
            let text = self.slots[*first..=*last].join(",");
            self.batch.text.push(text.as_bytes());
        }
        self.slots.iter_mut().for_each(String::clear);
    }
}
