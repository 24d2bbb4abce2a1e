//! A recording as rows with the text of their other columns, for a table that is written from them.

use std::collections::VecDeque;
use std::io::Read;
use std::path::Path;

use gravical_judge::units::POSSIBLE_C;
use gravical_judge::{self as judge, Error, LineSpans, ReadOptions, Result};

use crate::bytes::Input;
use crate::judging::cells::has_sparse_rows;
use crate::judging::clean::{add_gravity, cell_label, decode, to_celsius};
use crate::judging::findings::of_lines;
use crate::memory::Budget;
use crate::read::{Source, attach_metadata, open_source};
use crate::recording::Recording;
use crate::text::{CopiedText, Format, Ledger, LineBlocks, Parser, Reason, Rows};

/// Consecutive rows of a recording.
#[derive(Default)]
pub struct Piece {
    /// Text of the columns that are copied
    pub text: CopiedText,
    /// Line of each row, from 1
    pub lines: Vec<u32>,
    /// Whether each row is a measurement of the sensor that is read; the channels of others are NaN
    pub is_measured: Vec<bool>,
    /// Specific force in the unit of the file, less the zero offset
    pub accel: [Vec<f64>; 3],
    /// Angular rate in the unit of the file
    pub gyro: Option<[Vec<f64>; 3]>,
    /// Temperature, °C
    pub temperature_c: Option<Vec<f64>>,
    /// Rows before which the recording breaks
    pub breaks: Vec<usize>,
}

/// A recording that is judged by its first 262,144 rows, or whole, and read as [`Piece`]s.
pub struct Stream {
    /// What was judged.
    pub recording: Recording,
    /// How its lines become rows.
    pub format: Format,
    /// Text and lines of the rows by which it was judged.
    head: VecDeque<(CopiedText, Vec<u32>)>,
    rest: Option<Rest>,
    /// Blank lines between most rows.
    regular_blanks: usize,
    /// The account of the lines behind those by which it was judged.
    ledger: Ledger,
    /// Lines among them that held NUL bytes.
    nul_lines: LineSpans,
    input: Input,
}

/// The rows behind those by which a recording was judged.
type Rest = Box<dyn Iterator<Item = Result<Rows>> + Send>;

/// The rows of a text, block by block.
fn parse_blocks(text: Box<dyn Read + Send>, format: &Format, copied: &[(usize, usize)]) -> Rest {
    let mut blocks = LineBlocks::new(text, format.line_end);
    let mut parser = Parser::new(format, copied);
    let mut next_rows = move || -> Result<Option<Rows>> {
        if let Some(lines) = blocks.next(0)? {
            parser.read(&lines)?;
            return Ok(Some(parser.take_whole()));
        }
        let last = parser.take();
        Ok((last.rows() > 0 || last.ledger.total() > 0).then_some(last))
    };
    Box::new(std::iter::from_fn(move || next_rows().transpose()))
}

impl Stream {
    /// Rows by which a recording is judged that is not read whole.
    pub const HEAD_ROWS: usize = 1 << 18;
    /// The recording is read whole: its channels may be changed before they are taken.
    pub const WHOLE: usize = usize::MAX;

    /// Opens a recording and judges it by its first rows, [`HEAD_ROWS`](Self::HEAD_ROWS) or
    /// [`WHOLE`](Self::WHOLE); by all of them if a value holds for rows behind its own. `copied` says
    /// which columns keep their text; `name` is used in messages.
    ///
    /// # Errors
    ///
    /// As [`read_samples`](crate::read_samples).
    pub fn open(
        input: Input,
        name: &str,
        options: &ReadOptions,
        head_rows: usize,
        copied: impl FnOnce(&Format) -> Vec<(usize, usize)>,
    ) -> Result<Self> {
        let in_file = |e: Error| e.in_file(Path::new(name));
        Self::judge(input, name, options, head_rows, copied).map_err(in_file)
    }

    fn judge(
        mut input: Input,
        name: &str,
        options: &ReadOptions,
        head_rows: usize,
        copied: impl FnOnce(&Format) -> Vec<(usize, usize)>,
    ) -> Result<Self> {
        let budget = Budget::new(options);
        let (format, source) = open_source(&mut input, name, options)?;
        let copied = copied(&format);
        let mut rows = Rows::new(format.columns.len());
        let mut head = VecDeque::new();
        let mut rest: Option<Rest> = match source {
            Source::Text(text) if head_rows == Self::WHOLE => {
                let check = |rows| budget.check_rows(&format, rows);
                rows = format.parse_with_text(text, &copied, check)?;
                head.push_back((std::mem::take(&mut rows.text), rows.lines.clone()));
                None
            }
            Source::Text(text) => Some(parse_blocks(text, &format, &copied)),
            Source::Worn(samples) => {
                let samples = samples.with_text(&copied);
                Some(Box::new(samples.map(|rows| Ok(rows?))))
            }
        };
        let mut wanted = head_rows;
        while rows.rows() < wanted
            && let Some(source) = &mut rest
        {
            match source.next().transpose()? {
                Some(mut next) => {
                    head.push_back((std::mem::take(&mut next.text), next.lines.clone()));
                    rows.append(next);
                    budget.check_rows(&format, rows.rows())?;
                }
                None => rest = None,
            }
            // A value that holds may hold in rows behind the head.
            if rows.rows() >= wanted && has_sparse_rows(&rows.slices(&format.channels())) {
                wanted = Self::WHOLE;
            }
        }
        let regular_blanks = judge::regular_blanks(&rows.blanks, rows.rows());
        let recording = Recording::judge(&format, rows)?;
        Ok(Stream {
            recording: recording.with_name(name),
            format,
            head,
            rest,
            regular_blanks,
            ledger: Ledger::default(),
            nul_lines: LineSpans::default(),
            input,
        })
    }

    /// The next rows; `None` after the last. Rows behind those by which the recording was judged are
    /// read as these were, and not judged.
    ///
    /// # Errors
    ///
    /// Errors of reading; `header-differs`.
    pub fn next_piece(&mut self) -> Result<Option<Piece>> {
        if let Some((text, lines)) = self.head.pop_front() {
            return Ok(Some(self.judged_piece(text, lines)));
        }
        let Some(rest) = &mut self.rest else {
            return Ok(None);
        };
        let rows = rest.next().transpose();
        let rows = rows.map_err(|e| e.in_file(Path::new(&self.recording.name)))?;
        Ok(rows.map(|rows| self.unjudged_piece(rows)))
    }

    /// Rows by which the recording was judged; its own are those that are measurements.
    fn judged_piece(&self, text: CopiedText, lines: Vec<u32>) -> Piece {
        let recording = &self.recording;
        let first = lines.first().copied().unwrap_or_default();
        let next = recording.lines.partition_point(|line| *line < first);
        let mut own = (next..).zip(&recording.lines[next..]).peekable();
        let row = |line: &u32| Some(own.next_if(|(_, own)| *own == line)?.0);
        let rows: Vec<Option<usize>> = lines.iter().map(row).collect();
        let is_break = |row: usize| recording.breaks.binary_search(&row).is_ok();
        let channel = |values: &Vec<f64>| -> Vec<f64> {
            let cell = |row: &Option<usize>| row.map_or(f64::NAN, |row| values[row]);
            rows.iter().map(cell).collect()
        };
        Piece {
            text,
            is_measured: rows.iter().map(Option::is_some).collect(),
            accel: recording.accel.each_ref().map(channel),
            gyro: recording.gyro.as_ref().map(|g| g.each_ref().map(channel)),
            temperature_c: recording.temperature_c.as_ref().map(channel),
            breaks: (0..rows.len())
                .filter(|row| rows[*row].is_some_and(is_break))
                .collect(),
            lines,
        }
    }

    /// Rows behind those by which the recording was judged, read alike.
    fn unjudged_piece(&mut self, mut rows: Rows) -> Piece {
        let (format, read_as) = (&self.format, &self.recording.read_as);
        add_gravity(format, &mut rows);
        let sensor = format.sensor.zip(read_as.sensor.as_ref());
        let channels = rows.slices(&format.channels());
        let may_be_zero = format.columns[format.accel[0]].is_linear;
        let why_not = |row: usize| {
            let is_other =
                |(column, label): (usize, &String)| cell_label(&rows, column, row) != *label;
            let is_zero = || !may_be_zero && channels.iter().all(|c| c[row] == 0.0);
            let other = sensor.is_some_and(is_other).then_some(Reason::OtherSensor);
            other.or_else(|| is_zero().then_some(Reason::Zeros))
        };
        let reasons: Vec<Option<Reason>> = (0..rows.rows()).map(why_not).collect();
        for (reason, line) in reasons.iter().zip(&rows.lines) {
            if let Some(reason) = reason {
                rows.ledger.add(*reason, *line as usize, "");
            }
        }
        let is_measured: Vec<bool> = reasons.iter().map(Option::is_none).collect();
        if let Some(encoding) = read_as.encoding {
            decode(format, &mut rows, encoding);
        }
        let offset = format.options.zero_offset.unwrap_or(0.0);
        let mut channel = |column: usize, offset: f64| {
            let mut values = std::mem::take(&mut rows.columns[column]);
            for (value, is_measured) in values.iter_mut().zip(&is_measured) {
                let measured = Some(*value - offset).filter(|_| *is_measured);
                *value = measured.unwrap_or(f64::NAN);
            }
            values
        };
        let accel = format.accel.map(|c| channel(c, offset));
        let gyro = format.gyro.map(|g| g.map(|c| channel(c, 0.0)));
        let temperature_c = read_as.thermometer.map(|column| {
            let mut values = channel(column, 0.0);
            to_celsius(format, column, &mut values);
            let impossible = values.iter_mut().filter(|t| !POSSIBLE_C.contains(*t));
            impossible.for_each(|t| *t = f64::NAN);
            values
        });
        let blanks = rows.blanks.iter().filter(|b| b.1 > self.regular_blanks);
        let mut breaks = std::mem::take(&mut rows.breaks);
        breaks.extend(blanks.map(|b| b.0).chain(rows.headers.iter().copied()));
        breaks.sort_unstable();
        breaks.dedup();
        self.ledger.append(std::mem::take(&mut rows.ledger));
        self.nul_lines.append(&rows.nul_lines);
        Piece {
            text: rows.text,
            lines: rows.lines,
            is_measured,
            accel,
            gyro,
            temperature_c,
            breaks,
        }
    }

    /// The recording with the account of all lines; to be called after the last piece.
    pub fn finish(mut self) -> Recording {
        let first_line = self.recording.ledger.lines + 1;
        let mut findings = of_lines(&self.ledger, &self.nul_lines, false);
        for finding in &mut findings {
            finding.message = format!("from line {first_line} on: {}", finding.message);
            finding.file = Some(self.recording.name.clone());
        }
        self.recording.findings.extend(findings);
        let ledger = &mut self.recording.ledger;
        ledger.append(self.ledger);
        // Rows that are not measurements are rows of the table.
        ledger.reasons.retain(|reason, _| !reason.is_of_row());
        attach_metadata(&mut self.recording, &self.input);
        self.recording
    }
}
