//! A recording that grows.

use std::path::Path;

use gravical_judge::{self as judge, Error, ReadOptions, Result, Role};
use memchr::{memchr, memchr2, memrchr, memrchr2};

use crate::memory::Budget;
use crate::problem::Problem;
use crate::recording::Recording;
use crate::text::{Format, Heading, Parser, Reason, Rows, sniff};

/// The format is looked for each time that so many lines more are there.
const LOOK_LINES: usize = 50;
/// Rows of at least this time are needed for it, s; without a clock so many.
const MIN_S: f64 = 1.0;
const MIN_ROWS: usize = 100;
/// Without a format after so many lines there is none.
const MAX_LINES: usize = 800;
/// Rows before the new ones with which these are judged.
const TAIL_ROWS: usize = 1024;
/// After so many lines that are no part of a row, its last lines do not come any more.
const MAX_FOREIGN_LINES: usize = 100;
/// No row is longer.
const MAX_ROW_BYTES: usize = 1 << 20;

/// A row of a recording that grows. Values are in the unit of the recording.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sample {
    /// Its number, from 0
    pub row: usize,
    /// Line in which it begins, from 1
    pub line: u32,
    /// Time since the first row, s; NaN without a clock
    pub time_s: f64,
    /// Whether it does not continue the row before
    pub is_break: bool,
    /// Specific force, less the zero offset; NaN where the cell is empty
    pub accel: [f64; 3],
    /// Angular rate; NaN without a gyroscope
    pub gyro: [f64; 3],
    /// Temperature, °C; NaN without a thermometer
    pub temperature_c: f64,
}

/// What a line of a recording that grows is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum LineKind {
    /// A row begins; its stamp as it stands there, NaN without one
    Row(f64),
    /// Text that is neither row, header nor comment
    Rejected,
    /// A header of other columns, or a line of the board with other settings
    OtherHeader,
    /// A header, a comment, a blank line, or a line that continues a row
    Other,
}

/// How the rows of a recording that grows are written, for a logger that adds to them.
#[derive(Clone, PartialEq, Debug)]
pub struct Form {
    /// Some column is a clock
    pub has_clock: bool,
    /// What separates the columns; `None` for numbers wrapped in words
    pub delimiter: Option<u8>,
    /// Line that names the columns, from 1; 0 without one
    pub header_line: usize,
    /// Lines above the first row
    pub head_lines: usize,
    /// Names of the columns by what they hold: `ax`; `c7` for an unknown one
    pub roles: Vec<String>,
    /// Rows per second by the first rows
    pub rate_hz: Option<f64>,
}

/// Reads a recording while it grows: the format is that of the first second or more, the rows that
/// follow are read alike, and all that are held can be judged at any time.
pub struct Follow {
    name: String,
    options: ReadOptions,
    max_rows: usize,
    budget: Budget,
    /// Bytes that wait: for the format, or for the end of a row.
    bytes: Vec<u8>,
    /// Lines among them before the format is known.
    lines: usize,
    opened: Option<Opened>,
}

struct Opened {
    parser: Parser,
    format: Format,
    rows: Rows,
    /// Rows that were returned.
    returned: usize,
    /// Line of the last row that was judged.
    last_line: u32,
    /// Line and time, s, of the last one that has a time.
    anchor: (u32, f64),
    /// The first time stamp, s.
    start_s: f64,
    /// Blank lines stand between rows without being breaks.
    writes_blanks: bool,
    /// The one column of time, unless it holds steps.
    clock: Option<usize>,
    rate_hz: Option<f64>,
    /// Lines that [`Follow::classify`] has not returned, and how many were read so far.
    lines: Vec<LineKind>,
    line_count: usize,
}

impl Follow {
    /// Holds the last rows, `max_rows` or up to twice as many, for [`recording`](Self::recording);
    /// `name` is used in messages, and may tell the sensor.
    pub fn new(name: &str, options: ReadOptions, max_rows: usize) -> Self {
        Follow {
            name: name.to_owned(),
            budget: Budget::new(&options),
            options,
            max_rows,
            bytes: Vec::new(),
            lines: 0,
            opened: None,
        }
    }

    /// Takes the next bytes and returns the rows that they complete; none before the format is
    /// known.
    ///
    /// # Errors
    ///
    /// Those of reading, once enough lines show that it is no recording; a header of other columns.
    pub fn push(&mut self, bytes: &[u8]) -> Result<Vec<Sample>> {
        let read = self.read_samples(bytes);
        read.map_err(|e| e.in_file(Path::new(&self.name)))
    }

    fn read_samples(&mut self, bytes: &[u8]) -> Result<Vec<Sample>> {
        let mut samples = self.take(bytes, false)?;
        if let Some(opened) = &mut self.opened {
            let text = opened.complete_rows(&mut self.bytes);
            samples.append(&mut opened.read(&text, self.max_rows)?);
            opened.lines.clear();
        }
        self.check_size()?;
        Ok(samples)
    }

    /// Takes the next bytes and says of each line what it is, for a logger; of no line before the
    /// format is known. Rows are not judged. `is_last`: the format is that of the lines so far.
    ///
    /// # Errors
    ///
    /// Those of reading while the format is not known.
    pub fn classify(&mut self, bytes: &[u8], is_last: bool) -> Result<Vec<LineKind>> {
        let read = self.read_lines(bytes, is_last);
        read.map_err(|e| e.in_file(Path::new(&self.name)))
    }

    fn read_lines(&mut self, bytes: &[u8], is_last: bool) -> Result<Vec<LineKind>> {
        self.take(bytes, true)?;
        if self.opened.is_none() && is_last {
            self.open(true, true)?;
        }
        let Some(opened) = &mut self.opened else {
            return Ok(Vec::new());
        };
        let text = opened.complete_rows(&mut self.bytes);
        opened.parse(&text);
        opened.crop(self.max_rows);
        Ok(std::mem::take(&mut opened.lines))
    }

    /// Adds the bytes to those that wait. Returns the first samples, once the format is known.
    /// `reads_on`: also behind a header of other columns.
    fn take(&mut self, bytes: &[u8], reads_on: bool) -> Result<Vec<Sample>> {
        let mut samples = Vec::new();
        let mut rest = bytes;
        while self.opened.is_none()
            && let Some(end) = line_end(rest)
        {
            self.bytes.extend_from_slice(&rest[..=end]);
            rest = &rest[end + 1..];
            self.lines += 1;
            if self.lines.is_multiple_of(LOOK_LINES) {
                let is_last = self.lines >= MAX_LINES;
                match self.open(is_last, reads_on) {
                    Err(error) if is_last => return Err(error),
                    first => samples = first.ok().flatten().unwrap_or_default(),
                }
            }
        }
        self.bytes.extend_from_slice(rest);
        Ok(samples)
    }

    fn check_size(&self) -> Result<()> {
        if let Some(opened) = &self.opened {
            self.budget.check_rows(&opened.format, opened.rows.rows())?;
        }
        // What never ends a line is no text.
        let from = memrchr2(b'\n', b'\r', &self.bytes).map_or(0, |at| at + 1);
        match self.bytes.len() - from {
            ..=MAX_ROW_BYTES => Ok(()),
            _ => Err(Problem::LongRow.error()),
        }
    }

    /// Detects the format from the lines so far; `None` if these are too few, unless they are the last.
    fn open(&mut self, is_last: bool, reads_on: bool) -> Result<Option<Vec<Sample>>> {
        let head = String::from_utf8_lossy(&self.bytes).replace('\0', "");
        let file = Path::new(&self.name).file_name().unwrap_or_default();
        let format = sniff(&head, &file.to_string_lossy(), &self.options)?;
        let mut parser = Parser::new(&format, &[]);
        let whole = complete_rows(&format, Heading::default(), &self.bytes);
        let others = if reads_on {
            parser.read_on(&self.bytes[..whole])
        } else {
            parser.read(&self.bytes[..whole]).map(|()| Vec::new())?
        };
        let rows = parser.take();
        let recording = Recording::judge(&format, rows.clone())?;
        if !is_last && !is_enough(&recording) {
            return Ok(None);
        }
        let holds_stamps = |column: &usize| !judge::holds_steps(&rows.columns[*column]);
        let opened = self.opened.insert(Opened {
            clock: format.only_clock().filter(holds_stamps),
            parser,
            format,
            writes_blanks: !rows.blanks.is_empty() && recording.breaks.is_empty(),
            rows: Rows::default(),
            returned: 0,
            last_line: 0,
            anchor: (0, 0.0),
            start_s: recording.clock.start_s.unwrap_or(f64::NAN),
            rate_hz: recording.clock.rate_hz(),
            lines: Vec::new(),
            line_count: 0,
        });
        self.bytes.drain(..whole);
        opened.note_lines(&rows, &others);
        opened.rows = rows;
        Ok(Some(opened.samples(&recording)))
    }

    /// Detects the format from the lines so far: because the recording ends, or its sensor is slow.
    ///
    /// # Errors
    ///
    /// Those of reading: so far the lines are no recording.
    pub fn settle(&mut self) -> Result<Vec<Sample>> {
        if self.opened.is_some() {
            return Ok(Vec::new());
        }
        let first = self.open(true, false).map(Option::unwrap_or_default);
        first.map_err(|e| e.in_file(Path::new(&self.name)))
    }

    /// How the rows are written, once that is known.
    pub fn form(&self) -> Option<Form> {
        let opened = self.opened.as_ref()?;
        let format = &opened.format;
        let is_clock = |role| matches!(role, Role::Time | Role::Step);
        let columns = 0..format.columns.len();
        Some(Form {
            has_clock: format.columns.iter().any(|c| is_clock(c.role)),
            delimiter: match format.sentences {
                Some(_) => None,
                None => format.dialect.delimiter.or(Some(b' ')),
            },
            header_line: format.header_line,
            head_lines: format.head_lines,
            roles: columns.map(|c| format.role(c).name(c)).collect(),
            rate_hz: opened.rate_hz,
        })
    }

    /// The board says that it sends calibrated values.
    pub fn is_calibrated_by_board(&self) -> bool {
        let opened = self.opened.as_ref();
        opened.is_some_and(|opened| opened.format.is_calibrated_by_board())
    }

    /// The rows that are held up to this line, judged as a file; `None` before the format is known.
    ///
    /// # Errors
    ///
    /// Those of [`Recording::judge`].
    pub fn recording(&self, last_line: u32) -> Option<Result<Recording>> {
        let opened = self.opened.as_ref()?;
        let mut rows = opened.rows.clone();
        rows.crop(0..rows.lines.partition_point(|line| *line <= last_line));
        let judged = Recording::judge(&opened.format, rows);
        let in_file = |e: Error| e.in_file(Path::new(&self.name));
        Some(judged.map(|r| r.with_name(&self.name)).map_err(in_file))
    }
}

/// Whether the format can be told by so many rows.
fn is_enough(recording: &Recording) -> bool {
    let min_rows = match recording.clock.rate_hz() {
        Some(rate_hz) if recording.time_s.is_some() => (MIN_S * rate_hz).ceil() as usize,
        _ => MIN_ROWS,
    };
    recording.rows() >= min_rows
}

/// Where a line ends; of `\r` alone only once it is known that no `\n` follows.
fn line_end(bytes: &[u8]) -> Option<usize> {
    let end = memchr2(b'\n', b'\r', bytes)?;
    match (bytes[end], bytes.get(end + 1)) {
        (b'\r', Some(b'\n')) => Some(end + 1),
        (b'\r', None) => None,
        _ => Some(end),
    }
}

/// Bytes up to the end of the last whole row, below the heading of those before.
fn complete_rows(format: &Format, mut heading: Heading, bytes: &[u8]) -> usize {
    let end = memrchr(format.line_end, bytes).map_or(0, |at| at + 1);
    let Some(sentences) = &format.sentences else {
        return end;
    };
    // Where the last row begins, and the place of its last line, if others of its lines are missing.
    let (mut begun, mut at, mut foreign_lines) = (None, 0, 0);
    while at < end {
        let next = memchr(format.line_end, &bytes[at..end]).map_or(end, |n| at + n + 1);
        let line = String::from_utf8_lossy(&bytes[at..next]);
        foreign_lines += 1;
        if foreign_lines > MAX_FOREIGN_LINES {
            begun = None;
        }
        if let Some(sentence) = sentences.parse(line.trim_end(), &mut heading) {
            foreign_lines = 0;
            let place = sentence.place;
            let from = begun
                .filter(|(_, before)| place > *before)
                .map_or(at, |b| b.0);
            begun = (place < sentences.last_place()).then_some((from, place));
        }
        at = next;
    }
    begun.map_or(end, |b| b.0)
}

impl Opened {
    /// Takes the bytes up to the end of the last complete row.
    fn complete_rows(&self, bytes: &mut Vec<u8>) -> Vec<u8> {
        let whole = complete_rows(&self.format, self.parser.heading.clone(), bytes);
        bytes.drain(..whole).collect()
    }

    /// Reads lines, also behind a header of other columns.
    fn parse(&mut self, text: &[u8]) {
        let others = self.parser.read_on(text);
        let new = self.parser.take();
        self.note_lines(&new, &others);
        self.rows.append(new);
    }

    /// Holds the last rows only.
    fn crop(&mut self, max_rows: usize) {
        if self.rows.rows() / 2 > max_rows {
            self.rows.crop(self.rows.rows() - max_rows..usize::MAX);
        }
    }

    fn note_lines(&mut self, batch: &Rows, others: &[usize]) {
        let before = self.line_count - self.lines.len();
        self.line_count = self.line_count.max(batch.ledger.lines);
        self.lines.resize(self.line_count - before, LineKind::Other);
        let mut note = |line: u64, kind: LineKind| {
            let at = (line as usize).checked_sub(before + 1);
            if let Some(noted) = at.and_then(|at| self.lines.get_mut(at)) {
                *noted = kind;
            }
        };
        for line in others {
            note(*line as u64, LineKind::OtherHeader);
        }
        for (row, line) in batch.lines.iter().enumerate() {
            let stamp = self.clock.map_or(f64::NAN, |c| batch.columns[c][row]);
            note(u64::from(*line), LineKind::Row(stamp));
        }
        let no_rows = [Reason::TornLine, Reason::TooManyFields, Reason::NotANumber];
        for lines in no_rows.iter().filter_map(|r| batch.ledger.reasons.get(r)) {
            for [from, to] in lines.lines.ranges() {
                (*from..=*to).for_each(|line| note(line, LineKind::Rejected));
            }
        }
    }

    fn read(&mut self, text: &[u8], max_rows: usize) -> Result<Vec<Sample>> {
        let read = self.parser.read(text);
        let new = self.parser.take();
        self.note_lines(&new, &[]);
        let has_new = new.rows() > 0;
        self.rows.append(new);
        let known = self
            .rows
            .lines
            .partition_point(|line| *line <= self.last_line);
        let mut tail = self
            .rows
            .slice(known.saturating_sub(TAIL_ROWS)..self.rows.rows());
        if self.writes_blanks {
            tail.blanks.clear();
        }
        let judged = has_new.then(|| Recording::judge_so_far(&self.format, tail));
        let samples = match judged {
            Some(Ok(Some(tail))) => self.samples(&tail),
            // Rows of which none is a measurement so far are judged with those that follow.
            None | Some(Ok(None)) => Vec::new(),
            // Of others the whole recording says why they are none of the samples.
            Some(Err(_)) => {
                self.last_line = self.rows.lines.last().copied().unwrap_or_default();
                Vec::new()
            }
        };
        self.crop(max_rows);
        read.map(|()| samples)
    }

    /// The rows of a recording behind the last one.
    fn samples(&mut self, recording: &Recording) -> Vec<Sample> {
        let is_known = |line: &u32| *line <= self.last_line;
        let first = recording.lines.partition_point(is_known);
        let (anchor, anchor_s) = self.anchor;
        let known = recording.lines.binary_search(&anchor);
        let known_s = known.map_or(f64::NAN, |row| value(&recording.time_s, row));
        let since_start_s = recording.clock.start_s.unwrap_or(f64::NAN) - self.start_s;
        let shift_s = Some(anchor_s - known_s).filter(|s| s.is_finite());
        let shift_s = shift_s.unwrap_or(since_start_s);
        let gyro = recording.gyro.as_ref();
        let sample = |row: usize| Sample {
            row: self.returned + row - first,
            line: recording.lines[row],
            time_s: value(&recording.time_s, row) + shift_s,
            is_break: recording.breaks.binary_search(&row).is_ok(),
            accel: recording.accel_at(row),
            gyro: gyro.map_or([f64::NAN; 3], |axes| axes.each_ref().map(|c| c[row])),
            temperature_c: value(&recording.temperature_c, row),
        };
        let samples: Vec<Sample> = (first..recording.rows()).map(sample).collect();
        self.returned += samples.len();
        self.last_line = samples.last().map_or(self.last_line, |last| last.line);
        if let Some(last) = samples.iter().rfind(|s| s.time_s.is_finite()) {
            self.anchor = (last.line, last.time_s);
        }
        samples
    }
}

fn value(channel: &Option<Vec<f64>>, row: usize) -> f64 {
    channel.as_ref().map_or(f64::NAN, |c| c[row])
}
