//! Lines to batches.

use std::io::{self, BufRead};

use super::batch::{Batch, Reason, word_code};
use super::dialect::{Dialect, fields, is_blank, is_comment};
use super::format::{Format, Layout};
use super::header::{Header, OTHER_COLUMNS, Same};
use super::lines::Lines;
use super::number::parse_cell;
use super::words::Sentences;
use crate::board::BoardSettings;
use crate::error::{Error, Kind};

/// Rows of a batch.
pub const BATCH_ROWS: usize = 65_536;

/// A column with so many words may hold numbers wrapped in words.
pub(crate) const MANY_WORDS: u8 = 32;

impl Format {
    /// Reads a text from its first line on in batches of [`BATCH_ROWS`](crate::BATCH_ROWS).
    pub fn batches<R: BufRead>(&self, bytes: R) -> Batches<'_, R> {
        Batches::new(self, bytes)
    }
}

/// Iterates over the batches of a text; made by [`Format::batches`].
pub struct Batches<'a, R> {
    format: &'a Format,
    lines: Lines<R>,
    /// Lines read.
    count: usize,
    batch: Batch,
    /// Words of each column, in order of appearance.
    words: Vec<Vec<String>>,
    values: Vec<Option<f64>>,
    /// Blank lines since the last row.
    blanks: usize,
    has_break: bool,
    has_header: bool,
    /// Line and width of a header since the last row.
    torn_header: Option<(usize, usize)>,
    /// Place of the last line within its row.
    place: Option<usize>,
    error: Option<io::Error>,
    is_done: bool,
}

/// Marks rows that are written under other columns.
pub(crate) fn header_differs(line: usize, why: &'static str) -> io::Error {
    io::Error::other(Error::from(Kind::HeaderDiffers(line, why)))
}

impl<'a, R: BufRead> Batches<'a, R> {
    pub(crate) fn new(format: &'a Format, bytes: R) -> Self {
        let fields = format.columns.len();
        Batches {
            format,
            lines: Lines::new(bytes, format.line_end),
            count: 0,
            batch: Batch::new(fields),
            words: vec![Vec::new(); fields],
            values: Vec::with_capacity(fields),
            blanks: 0,
            has_break: false,
            has_header: false,
            torn_header: None,
            place: None,
            error: None,
            is_done: false,
        }
    }

    /// Reads on until a batch is full and a new row would begin.
    fn read_batch(&mut self) -> io::Result<Option<Batch>> {
        while self.error.is_none() {
            let (line, had_nul) = match self.lines.next() {
                Ok(Some(line)) => line,
                Ok(None) => break,
                // What was read before the error is a batch of its own.
                Err(e) => {
                    self.error = Some(e);
                    break;
                }
            };
            self.count += 1;
            if had_nul {
                self.batch.nul_lines.push(self.count as u64);
            }
            let parser = RowParser {
                format: self.format,
                line_number: self.count,
                batch: &mut self.batch,
                words: &mut self.words,
                values: &mut self.values,
                blanks: &mut self.blanks,
                has_break: &mut self.has_break,
                has_header: &mut self.has_header,
                torn_header: &mut self.torn_header,
                place: &mut self.place,
            };
            if let Err(e) = parser.read(&line) {
                self.error = Some(e);
                break;
            }
            // The lines of a row that has begun belong to its batch.
            let is_whole = matches!(self.format.layout, Layout::Table(_))
                || self
                    .place
                    .is_none_or(|p| self.format.layout.last_place() == p);
            if self.batch.rows() >= BATCH_ROWS && is_whole {
                return Ok(Some(self.finish_batch()));
            }
        }
        let is_empty = self.batch.rows() == 0 && self.batch.aside.total() == 0;
        if !is_empty {
            return Ok(Some(self.finish_batch()));
        }
        self.is_done = true;
        self.error.take().map_or(Ok(None), Err)
    }

    fn finish_batch(&mut self) -> Batch {
        let mut batch = std::mem::replace(&mut self.batch, Batch::new(self.format.columns.len()));
        let rows = batch.rows();
        batch
            .texts
            .iter_mut()
            .filter(|t| !t.is_empty())
            .for_each(|t| t.resize(rows, 0));
        batch.words.clone_from(&self.words);
        batch.aside.lines = self.count;
        self.place = None;
        batch
    }
}

impl<R: BufRead> Iterator for Batches<'_, R> {
    type Item = io::Result<Batch>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.is_done {
            return None;
        }
        let batch = self.read_batch();
        batch.transpose()
    }
}

/// One line on its way into the batch.
struct RowParser<'a> {
    format: &'a Format,
    line_number: usize,
    batch: &'a mut Batch,
    words: &'a mut [Vec<String>],
    values: &'a mut Vec<Option<f64>>,
    blanks: &'a mut usize,
    has_break: &'a mut bool,
    has_header: &'a mut bool,
    torn_header: &'a mut Option<(usize, usize)>,
    place: &'a mut Option<usize>,
}

impl RowParser<'_> {
    fn read(mut self, line: &str) -> io::Result<()> {
        if self.line_number <= self.format.head_lines {
            let is_header = self.line_number == self.format.header_line;
            let reason = if is_header {
                Reason::Header
            } else {
                Reason::Metadata
            };
            self.set_aside(reason, line);
            return Ok(());
        }
        if is_blank(line) {
            *self.blanks += 1;
            self.set_aside(Reason::Blank, line);
            return Ok(());
        }
        if is_comment(line) {
            return self.read_comment(line);
        }
        match &self.format.layout {
            Layout::Table(dialect) => self.read_fields(line, *dialect),
            Layout::Sentences(sentences) => {
                self.read_sentence(line, sentences);
                Ok(())
            }
        }
    }

    fn set_aside(&mut self, reason: Reason, line: &str) {
        self.batch.aside.add(reason, self.line_number, line);
    }

    /// `# gap: …` and `# rejected: 3`, as our logger writes them, and the settings of our board.
    fn read_comment(&mut self, line: &str) -> io::Result<()> {
        let text = line.trim_start_matches(['#', '%', '/', ' ']);
        let mut reason = Reason::Comment;
        if text.starts_with("gap:") {
            *self.has_break = true;
            reason = Reason::NamedGap;
        } else if let Some(rest) = text.strip_prefix("rejected:") {
            let count = rest.split_whitespace().next().and_then(|n| n.parse().ok());
            self.batch.rejected += count.unwrap_or(1);
        } else if let (Some(before), Some(now)) = (self.format.board, BoardSettings::parse(line))
            && !before.has_units_of(&now)
        {
            let why = "follows a line of the board with another range or format";
            return Err(header_differs(self.line_number, why));
        }
        self.set_aside(reason, line);
        Ok(())
    }

    /// Sets a line aside that is no row. A header of other columns ends the reading.
    fn set_aside_or_refuse(&mut self, reason: Reason, line: &str) -> io::Result<()> {
        let reason = match Header::compare(line, self.format) {
            None => reason,
            Some(Same::Yes) => {
                *self.has_header = true;
                *self.torn_header = match &self.format.layout {
                    Layout::Table(d) => Some((self.line_number, fields(line, d.delimiter).count())),
                    Layout::Sentences(_) => None,
                };
                Reason::RepeatedHeader
            }
            Some(Same::No(why)) => return Err(header_differs(self.line_number, why)),
        };
        self.set_aside(reason, line);
        Ok(())
    }

    fn read_fields(mut self, line: &str, dialect: Dialect) -> io::Result<()> {
        self.values.clear();
        let mut has_text = false;
        let mut cells = fields(line, dialect.delimiter);
        loop {
            let is_read = self.format.is_read.get(self.values.len()).copied();
            let cell = if is_read == Some(true) {
                cells.next_cell(dialect)
            } else {
                cells.next().map(|_| Some(f64::NAN))
            };
            let Some(value) = cell else { break };
            has_text |= value.is_none();
            self.values.push(value);
        }
        // Rows that fit a header that seemed torn.
        if let Some((header, width)) = *self.torn_header
            && self.values.len() != dialect.fields
            && self.values.len() == width
            && self.values.iter().flatten().count() > width / 2
        {
            return Err(header_differs(header, OTHER_COLUMNS));
        }
        if self.values.len() < dialect.fields {
            return self.set_aside_or_refuse(Reason::TornLine, line);
        }
        if self.values.len() > dialect.fields {
            return self.set_aside_or_refuse(Reason::TooManyFields, line);
        }
        if !self.values.iter().flatten().any(|v| v.is_finite()) {
            return self.set_aside_or_refuse(Reason::NotANumber, line);
        }
        *self.torn_header = None;
        self.begin_row();
        for (c, value) in self
            .values
            .iter()
            .enumerate()
            .filter(|(c, _)| self.format.is_read[*c])
        {
            self.batch.columns[c].push(value.unwrap_or(f64::NAN));
        }
        if has_text {
            for (c, field) in fields(line, dialect.delimiter).enumerate() {
                if self.values[c].is_none() {
                    self.push_word(c, field);
                }
            }
        }
        Ok(())
    }

    fn push_word(&mut self, column: usize, word: &str) {
        let code = word_code(&mut self.words[column], word);
        let texts = &mut self.batch.texts[column];
        texts.resize(self.batch.lines.len() - 1, 0);
        texts.push(code);
    }

    fn read_sentence(mut self, line: &str, sentences: &Sentences) {
        let line = sentences.normalise(line);
        let Some(sentence) = sentences.parse(&line) else {
            return self.set_aside(Reason::NotANumber, &line);
        };
        if self.place.is_none_or(|last| sentence.place <= last) {
            self.begin_row();
            let columns = self.batch.columns.iter_mut().zip(&self.format.is_read);
            columns
                .filter(|(_, is_read)| **is_read)
                .for_each(|(c, _)| c.push(f64::NAN));
        } else {
            *self.blanks = 0;
            self.set_aside(Reason::Continuation, &line);
        }
        *self.place = Some(sentence.place);
        for (k, number) in sentence.numbers.iter().enumerate() {
            let cell = self.batch.columns[sentence.first_slot + k].last_mut();
            if let (Some(cell), Some(value)) = (cell, parse_cell(number, false)) {
                *cell = value;
            }
        }
    }

    fn begin_row(&mut self) {
        let row = self.batch.rows();
        if std::mem::take(self.has_break) {
            self.batch.breaks.push(row);
        }
        if std::mem::take(self.has_header) {
            self.batch.headers.push(row);
        }
        let blanks = std::mem::take(self.blanks);
        if blanks > 0 {
            self.batch.blanks.push((row, blanks));
        }
        self.batch
            .lines
            .push(u32::try_from(self.line_number).unwrap_or(u32::MAX));
    }
}
