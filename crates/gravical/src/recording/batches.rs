//! A recording of any size: judged by its first rows, read batch by batch.

use std::collections::VecDeque;
use std::io::{self, BufRead};
use std::path::Path;

use gravical_recording as new;
use gravical_recording::{Batch, CopiedText, Format, Later, Readings, Role, bytes, cwa, open_text};

use super::ledger::Ledger;
use super::open::{Input, peek};
use super::reading::{ledger, of_judged, refused};
use super::text_options::text_options;
use super::{ReadOptions, Recording, foreign};
use crate::finding::{Finding, FindingKind};
use crate::{Error, Result};

/// Batches by which a recording is judged: 262,144 rows.
const HEAD_BATCHES: usize = 4;
/// Blank lines count as breaks if they are no more than this share of the rows.
const BREAKS_PER_ROW: f64 = 0.05;

/// Rows of a recording, with the text of the columns that are copied.
pub(crate) struct Rows {
    /// Text of the columns that are copied
    pub text: CopiedText,
    /// Line of each row, from 1
    pub lines: Vec<u32>,
    /// Rows before which there is a break
    pub breaks: Vec<usize>,
    /// Channels as they are read
    pub readings: Readings,
    /// Time since the first row, s, if it is wanted; none where the recording has no clock
    pub time_s: Option<Vec<f64>>,
    /// Stamps as they are written, if times are wanted and one column holds them
    pub stamps: Option<Vec<f64>>,
}

/// A recording that is read batch by batch.
pub(crate) struct BatchReader {
    /// What the first rows are judged to be; their channels are dropped once they are read
    pub recording: Recording,
    pub format: Format,
    wants_time: bool,
    /// The only column of time stamps.
    stamps: Option<usize>,
    name: String,
    /// Rows by which it was judged, and the lines of those that are measurements.
    held: VecDeque<Batch>,
    head_lines: Vec<u32>,
    batches: Batches,
    later: Later,
    /// Lines without a row; and these with the rows that are no measurements, as far as they were
    /// judged with the first ones.
    aside: new::Aside,
    judged_aside: new::Aside,
    rows: usize,
    input: Input,
    /// Findings about later rows.
    findings: Vec<Finding>,
}

type Batches = Box<dyn Iterator<Item = io::Result<Batch>>>;

impl BatchReader {
    /// Opens a recording and judges its first rows. `copied` says which columns keep their text,
    /// `wants_time` whether times of the rows are wanted; `name` is used in messages.
    ///
    /// # Errors
    ///
    /// As [`read`](super::read).
    pub fn open(
        mut input: Input,
        name: &str,
        options: &ReadOptions,
        wants_time: bool,
        copied: impl FnOnce(&Format) -> Vec<(usize, usize)>,
    ) -> Result<Self> {
        options.validate()?;
        let here = Path::new(name);
        let io = |e| Error::io(here, e);
        let reader = std::mem::replace(&mut input.reader, Box::new(io::empty()));
        let (magic, reader) = peek(reader, cwa::MAGIC_BYTES).map_err(io)?;
        let read = text_options(options, false);
        let (start, format, mut batches): (_, _, Batches);
        if cwa::is_one(&magic) {
            let samples;
            start = Vec::new();
            (format, samples) = cwa::open(reader, &read).map_err(|e| refused(e, &start, here))?;
            batches = Box::new(samples.with_text(&copied(&format)));
        } else {
            let mut text = bytes::utf8(reader).map_err(io)?;
            start = text.fill_buf().map_err(io)?.to_vec();
            foreign::refuse_calibration(&start, here)?;
            let file = here.file_name().unwrap_or_default().to_string_lossy();
            let opened = open_text(text, &file, &read).map_err(|e| refused(e, &start, here))?;
            format = opened.0;
            batches = Box::new(format.batches(opened.1).with_text(&copied(&format)));
        }
        let (mut head, mut held) = (Batch::default(), VecDeque::new());
        let is_time = |c: &usize| format.columns[*c].role == Role::Time;
        let mut times = (0..format.columns.len()).filter(is_time);
        let stamps = times
            .next()
            .filter(|_| wants_time && times.next().is_none());
        while held.len() < HEAD_BATCHES
            && let Some(batch) = batches.next()
        {
            let mut batch = batch.map_err(|e| unreadable(e, &start, here))?;
            held.push_back(Batch {
                text: std::mem::take(&mut batch.text),
                lines: batch.lines.clone(),
                columns: stamps
                    .map(|c| batch.columns[c].clone())
                    .into_iter()
                    .collect(),
                ..Batch::default()
            });
            head.append(batch);
        }
        let (aside, rows) = (head.aside.clone(), head.rows());
        let (judged, later) = Later::judge(&format, head).map_err(|e| refused(e, &start, here))?;
        let head_lines = judged.lines.clone();
        let judged_aside = judged.aside.clone();
        Ok(BatchReader {
            recording: of_judged(judged, name),
            format,
            wants_time,
            stamps,
            name: name.to_owned(),
            held,
            head_lines,
            batches,
            later,
            aside,
            judged_aside,
            rows,
            input,
            findings: Vec::new(),
        })
    }

    /// The next rows; `None` after the last.
    ///
    /// # Errors
    ///
    /// Errors of reading; rows that contradict those before them, with their line.
    pub fn next(&mut self) -> Result<Option<Rows>> {
        if let Some(batch) = self.held.pop_front() {
            let rows = self.judged_rows(batch);
            if self.held.is_empty() {
                self.recording.accel = Default::default();
                self.recording.gyro = None;
                self.recording.temperature_c = None;
                self.recording.time_s = None;
            }
            return Ok(Some(rows));
        }
        let Some(batch) = self.batches.next() else {
            return Ok(None);
        };
        let here = Path::new(&self.name);
        let mut batch = batch.map_err(|e| unreadable(e, &[], here))?;
        self.rows += batch.rows();
        self.judged_aside.append(batch.aside.clone());
        self.aside.append(std::mem::take(&mut batch.aside));
        self.findings
            .extend(batch.notes.drain(..).map(Finding::from));
        let time_s = if self.wants_time {
            self.later.times(&batch)
        } else {
            None
        };
        let readings = self.later.read(&mut batch).map_err(|c| {
            let line = c.line;
            Error::contradiction(c.code, c.message)
                .at(here, Some(line))
                .with_hint(split_hint(line))
        })?;
        Ok(Some(Rows {
            stamps: self.stamps.map(|c| std::mem::take(&mut batch.columns[c])),
            breaks: breaks_of(&batch),
            text: batch.text,
            lines: batch.lines,
            readings,
            time_s,
        }))
    }

    /// Rows among those by which the recording was judged.
    fn judged_rows(&self, batch: Batch) -> Rows {
        let first = batch.lines.first().copied().unwrap_or_default();
        let mut next = self.head_lines.partition_point(|line| *line < first);
        let (mut rows, mut breaks) = (Vec::with_capacity(batch.rows()), Vec::new());
        for (row, line) in batch.lines.iter().enumerate() {
            let is_row = self.head_lines.get(next) == Some(line);
            rows.push(is_row.then_some(next));
            if is_row && self.recording.breaks.binary_search(&next).is_ok() {
                breaks.push(row);
            }
            next += usize::from(is_row);
        }
        let channel = |values: &Vec<f64>| -> Vec<f64> {
            let cells = rows
                .iter()
                .map(|row| row.map_or(f64::NAN, |row| values[row]));
            cells.collect()
        };
        let recording = &self.recording;
        Rows {
            stamps: batch.columns.into_iter().next(),
            text: batch.text,
            lines: batch.lines,
            breaks,
            readings: Readings {
                accel: recording.accel.each_ref().map(channel),
                gyro: recording.gyro.as_ref().map(|g| g.each_ref().map(channel)),
                temperature_c: recording.temperature_c.as_ref().map(channel),
                is_measured: rows.iter().map(Option::is_some).collect(),
            },
            time_s: recording
                .time_s
                .as_ref()
                .filter(|_| self.wants_time)
                .map(channel),
        }
    }

    /// The recording, the account of all lines, and what was found beside the first rows; to be
    /// called after the last row. `written`: number of rows that were written, all or those that
    /// are measurements.
    pub fn finish(mut self, written: usize) -> (Recording, Ledger, Vec<Finding>) {
        let mut findings = self.findings;
        if self.input.is_cut_off() {
            let text = format!(
                "the packed file is damaged or ends in the middle; {} rows could be unpacked",
                self.rows
            );
            findings.push(Finding::new(FindingKind::TruncatedFile, text));
        }
        findings.extend(self.later.note().cloned().map(Finding::from));
        if written < self.rows {
            self.aside = self.judged_aside;
            self.aside.append(self.later.aside().clone());
        }
        (self.recording, ledger(&self.aside, written), findings)
    }
}

/// What to do about rows that cannot be read with those before them.
pub(crate) fn split_hint(line: u64) -> String {
    format!("split the file before line {line} and read the parts separately")
}

/// Rows of a batch before which there is a break.
fn breaks_of(batch: &Batch) -> Vec<usize> {
    let mut breaks: Vec<usize> = batch.breaks.iter().chain(&batch.headers).copied().collect();
    if (batch.blanks.len() as f64) <= BREAKS_PER_ROW * batch.rows() as f64 {
        breaks.extend(batch.blanks.iter().map(|b| b.0));
    }
    breaks.sort_unstable();
    breaks.dedup();
    breaks
}

/// An error of reading that may be one of the text.
fn unreadable(error: io::Error, start: &[u8], here: &Path) -> Error {
    match error.downcast::<new::Error>() {
        Ok(error) => refused(error, start, here),
        Err(error) => Error::io(here, error),
    }
}
