//! Lines to rows.

use std::borrow::Cow;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::io::Read;
use std::num::NonZero;
use std::sync::{Mutex, mpsc};
use std::thread;

use gravical_judge::Error;
use memchr::{memchr, memchr_iter};

use super::dialect::{Dialect, fields, is_blank, is_comment, uncommented};
use super::format::Format;
use super::header::Header;
use super::lines::{LineBlocks, trim_end};
use super::number::parse_cell;
use super::rows::{CopiedText, Reason, Rows, mark};
use super::words::{Heading, LinePattern};
use crate::board::BoardSettings;
use crate::problem::Problem;

/// A column with so many words may hold numbers wrapped in words.
pub(crate) const MANY_WORDS: u8 = 32;

/// Text that a thread parses at once, bytes: its columns stay in memory that is used again.
const BLOCK_BYTES: usize = 1 << 18;

/// Rows that wait for the last lines of the last one: where these stay away, rows go on without.
const MAX_WAITING: usize = 1 << 14;

impl Format {
    /// The rows of a text, from its first line to its last.
    ///
    /// # Errors
    ///
    /// Errors of reading; `header-differs` for a header of other columns in the middle.
    pub fn parse(&self, text: impl Read + Send) -> Result<Rows, Error> {
        self.parse_with_text(text, &[], |_| Ok(()))
    }

    /// The same with the text of columns in [`Rows::text`], in pieces from one column to another.
    /// Blocks of lines are parsed by all cores; `check` is asked each time that there are so many rows.
    ///
    /// # Errors
    ///
    /// As [`parse`](Self::parse), and what `check` says.
    pub fn parse_with_text(
        &self,
        text: impl Read + Send,
        copied: &[(usize, usize)],
        check: impl Fn(usize) -> Result<(), Error>,
    ) -> Result<Rows, Error> {
        let mut whole = Parser::new(self, copied);
        let mut blocks = LineBlocks::new(text, self.line_end);
        let mut is_end = false;
        // What is short is not worth a thread, and the lines of a row in sentences stay together.
        while !is_end && (self.sentences.is_some() || whole.line_number == 0) {
            match blocks.next(BLOCK_BYTES)? {
                Some(lines) => whole.read(&lines)?,
                None => is_end = true,
            }
            check(whole.rows())?;
        }
        if is_end {
            return Ok(whole.take());
        }
        // The next block, its number, and the lines before it.
        let source = Mutex::new((blocks, 0, whole.line_number));
        let next = || -> Option<Result<Block, Error>> {
            let mut source = source.lock().ok()?;
            let (blocks, number, lines_before) = &mut *source;
            let lines = match blocks.next(BLOCK_BYTES).transpose()? {
                Ok(lines) => lines,
                Err(error) => return Some(Err(error.into())),
            };
            let mut parser = Parser::new(self, copied);
            parser.line_number = *lines_before;
            *lines_before += memchr_iter(self.line_end, &lines).count();
            *number += 1;
            let number = *number - 1;
            Some(Ok(Block {
                number,
                parser,
                lines,
            }))
        };
        // A fault in a block is one only if those before it have none.
        let parse = |block: Result<Block, Error>| {
            block.map(|mut block| {
                let read = block.parser.read(&block.lines);
                (block.number, read.map(|()| block.parser))
            })
        };
        let finish = |mut whole: Parser| {
            let mut rows = whole.take();
            rows.columns.iter_mut().for_each(Vec::shrink_to_fit);
            Ok(rows)
        };
        // A browser has no threads.
        let cores = thread::available_parallelism().map_or(1, NonZero::get);
        if cores == 1 {
            while let Some(block) = next() {
                whole.append(parse(block)?.1?);
                check(whole.rows())?;
            }
            return finish(whole);
        }
        let (send, parsed) = mpsc::sync_channel(cores);
        thread::scope(|scope| {
            for _ in 0..cores {
                let (send, next) = (send.clone(), &next);
                scope.spawn(move || {
                    while let Some(block) = next() {
                        let parsed = parse(block);
                        // Nobody receives any longer once a block has failed.
                        if send.send(parsed).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(send);
            let (mut waiting, mut due) = (BTreeMap::new(), 0);
            for block in parsed {
                let (number, parser) = block?;
                waiting.insert(number, parser);
                while let Some(parser) = waiting.remove(&due) {
                    whole.append(parser?);
                    check(whole.rows())?;
                    due += 1;
                }
            }
            finish(whole)
        })
    }
}

/// Lines that a thread parses.
struct Block {
    number: usize,
    parser: Parser,
    lines: Vec<u8>,
}

/// Lines on their way into rows.
#[derive(Default)]
pub(crate) struct Parser {
    format: Format,
    /// Lines read.
    line_number: usize,
    rows: Rows,
    /// Place of the last line within its row.
    place: Option<usize>,
    /// Of the lines read.
    pub heading: Heading,
    /// Columns whose text is kept, each piece from the first to the last.
    copied: Vec<(usize, usize)>,
    /// Where the fields of the row begin and end.
    spans: Vec<(usize, usize)>,
    /// Text of the numbers of the row that is being read from sentences.
    slots: Vec<String>,
}

impl Parser {
    /// From the first line of a text on; `copied`: the columns whose text is kept.
    pub(crate) fn new(format: &Format, copied: &[(usize, usize)]) -> Self {
        let fields = format.columns.len();
        let mut rows = Rows::new(fields);
        rows.text = CopiedText::new(copied.len());
        Parser {
            format: format.clone(),
            rows,
            slots: vec![String::new(); fields],
            copied: copied.to_vec(),
            ..Parser::default()
        }
    }

    /// Reads whole lines.
    ///
    /// # Errors
    ///
    /// `header-differs`; the rows before are read.
    pub(crate) fn read(&mut self, text: &[u8]) -> Result<(), Error> {
        // Looking for what is not UTF-8 takes ten times as long as finding that all is.
        let valid = std::str::from_utf8(text).map(Cow::Borrowed);
        let text = valid.unwrap_or_else(|_| String::from_utf8_lossy(text));
        for line in text.split_terminator(char::from(self.format.line_end)) {
            self.read_line(line)?;
        }
        Ok(())
    }

    /// Reads whole lines, also behind a header of other columns. Returns the numbers of such lines.
    pub(crate) fn read_on(&mut self, text: &[u8]) -> Vec<usize> {
        let mut others = Vec::new();
        let text = String::from_utf8_lossy(text);
        for line in text.split_terminator(char::from(self.format.line_end)) {
            if self.read_line(line).is_err() {
                others.push(self.line_number);
            }
        }
        others
    }

    /// Rows read and not taken.
    pub(crate) fn rows(&self) -> usize {
        self.rows.rows()
    }

    /// The rows that were read; the lines of a row that has begun belong to it.
    pub(crate) fn take(&mut self) -> Rows {
        self.push_slots();
        let mut next = Rows::new(self.rows.columns.len());
        next.text = CopiedText::new(self.copied.len());
        self.rows.take_marks(&mut next);
        let mut rows = std::mem::replace(&mut self.rows, next);
        let count = rows.rows();
        let texts = rows.texts.iter_mut().filter(|t| !t.is_empty());
        texts.for_each(|t| t.resize(count, 0));
        rows.ledger.lines = self.line_number;
        rows
    }

    /// The same without a row of which lines are missing, unless the others are many.
    pub(crate) fn take_whole(&mut self) -> Rows {
        let last = self.format.sentences.as_ref().map(LinePattern::last_place);
        if self.place == last || self.rows() > MAX_WAITING {
            return self.take();
        }
        Rows::new(self.format.columns.len())
    }

    /// Adds the rows of the lines that follow.
    fn append(&mut self, later: Parser) {
        self.line_number = later.line_number;
        self.rows.append(later.rows);
    }

    fn read_line(&mut self, line: &str) -> Result<(), Error> {
        self.line_number += 1;
        let cleaned = memchr(0, line.as_bytes()).map(|_| line.replace('\0', ""));
        if cleaned.is_some() {
            self.rows.nul_lines.push(self.line_number as u64);
        }
        let line = trim_end(cleaned.as_deref().unwrap_or(line));
        if let Some(reason) = self.read_row(line)? {
            self.rows.ledger.add(reason, self.line_number, line);
        }
        Ok(())
    }

    /// Reads a row, or says why the line is not one. A header of other columns ends the reading.
    fn read_row(&mut self, line: &str) -> Result<Option<Reason>, Error> {
        if self.line_number == self.format.header_line {
            return Ok(Some(Reason::Header));
        }
        if self.line_number <= self.format.head_lines {
            let sentences = self.format.sentences.as_ref();
            sentences.and_then(|s| s.parse(line, &mut self.heading));
            return Ok(Some(Reason::Metadata));
        }
        if is_blank(line) {
            self.rows.add_blanks(self.rows(), 1);
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
                mark(&mut self.rows.headers, self.rows.lines.len());
                Ok(Some(Reason::RepeatedHeader))
            }
            Some(false) => {
                let line = self.line_number;
                Err(Problem::OtherHeader { line }.error().at_line(line))
            }
        }
    }

    /// `# gap: …` and `# rejected: …` as our logger writes them, and the settings of our board.
    fn read_comment(&mut self, line: &str) -> Result<Reason, Error> {
        let text = uncommented(line);
        if text.starts_with("gap:") {
            mark(&mut self.rows.breaks, self.rows.lines.len());
            return Ok(Reason::NamedGap);
        }
        if text.starts_with("rejected:") {
            return Ok(Reason::Rejected);
        }
        if let (Some(before), Some(now)) = (self.format.board, BoardSettings::parse(line))
            && !before.has_units_of(&now)
        {
            let line = self.line_number;
            return Err(Problem::OtherSettings { line }.error().at_line(line));
        }
        Ok(Reason::Comment)
    }

    fn read_fields(&mut self, line: &str, dialect: Dialect) -> Option<Reason> {
        let row = self.rows.rows();
        self.spans.clear();
        let (mut count, mut has_number, mut texts) = (0, false, Vec::new());
        let last_copied = self.copied.last().map_or(0, |piece| piece.1 + 1);
        let (mut cells, point) = (fields(line, dialect.delimiter), dialect.point());
        let mut columns = self.rows.columns.iter_mut().zip(&self.format.is_read);
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
            if count > dialect.fields {
                break;
            }
        }
        let reason = match count.cmp(&dialect.fields) {
            Ordering::Less => Some(Reason::TornLine),
            Ordering::Greater => Some(Reason::TooManyFields),
            Ordering::Equal => (!has_number).then_some(Reason::NotANumber),
        };
        if reason.is_some() {
            self.rows.columns.iter_mut().for_each(|c| c.truncate(row));
            return reason;
        }
        self.begin_row();
        for (first, last) in &self.copied {
            let (from, to) = (self.spans[*first].0, self.spans[*last].1);
            self.rows.text.push(&line.as_bytes()[from..to]);
        }
        for (column, word) in texts {
            self.rows.texts[column].resize(row, 0);
            self.rows.push_word(column, word);
        }
        None
    }

    fn read_sentence(&mut self, line: &str) -> Option<Reason> {
        let sentences = self.format.sentences.as_ref()?;
        let Some(sentence) = sentences.parse(line, &mut self.heading) else {
            return Some(if sentences.has_headings {
                Reason::Continuation
            } else {
                Reason::NotANumber
            });
        };
        let begins = self.place.is_none_or(|last| sentence.place <= last);
        if begins {
            self.push_slots();
            self.begin_row();
            let columns = self.rows.columns.iter_mut();
            columns.for_each(|column| column.push(f64::NAN));
        } else {
            let row = self.rows();
            self.rows.blanks.pop_if(|(before, _)| *before == row);
        }
        self.place = Some(sentence.place);
        for (slot, number) in sentence.numbers {
            let cell = self.rows.columns[slot].last_mut();
            if let (Some(cell), Some(value)) = (cell, parse_cell(&number, false)) {
                *cell = value;
            }
            self.slots[slot] = number;
        }
        (!begins).then_some(Reason::Continuation)
    }

    fn begin_row(&mut self) {
        let line = u32::try_from(self.line_number).unwrap_or(u32::MAX);
        self.rows.lines.push(line);
    }

    /// Copies the numbers of a row that was wrapped in words, if one has begun.
    fn push_slots(&mut self) {
        if self.place.take().is_none() {
            return;
        }
        for (first, last) in &self.copied {
            let text = self.slots[*first..=*last].join(",");
            self.rows.text.push(text.as_bytes());
        }
        self.slots.iter_mut().for_each(String::clear);
    }
}
