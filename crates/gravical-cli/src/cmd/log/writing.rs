//! Lines whose format is known: which of them are rows, where rows are missing, and what a pause
//! leaves out. The reader of recordings decides what a row is: it reads the lines as they stand in
//! the file.

use std::collections::VecDeque;

use gravical::Result;
use gravical::escape::shown;
use gravical::recording::{ColumnsSpec, ReadOptions};
use gravical::recording::{Follow, Form};

use super::event::{Counts, End, Event};
use super::gaps::{Cause, GAP_STEPS, Gap, Gaps};
use super::rewrite::Rewrite;
use crate::device::board::Wanted;

/// The last rows are judged: so many, up to twice as many.
const JUDGED_ROWS: usize = 10_000;
/// At the end nothing for this time is a silence, s; of a slow board for a gap.
const SILENT_END_S: f64 = 1.0;
/// Characters of a rejected line in a message.
const QUOTED: usize = 60;

/// What is wanted of a recording.
#[derive(Default)]
pub struct Options {
    /// Name of the file, for messages.
    pub name: String,
    pub wanted: Wanted,
    pub columns: Option<ColumnsSpec>,
    /// The recording ends after so many rows.
    pub rows: Option<u64>,
    /// It ends this long after the first row, s, without pauses.
    pub duration_s: Option<f64>,
    /// Rows are waited for without end.
    pub wait: bool,
    /// Time of day at the time zero, s (UTC).
    pub day_s: f64,
}

/// What has to be done.
#[derive(Default)]
pub struct Output {
    /// Comes before the next line for the file.
    pub preamble: String,
    /// Whole lines for the file.
    pub text: Vec<u8>,
    /// Commands for the board.
    pub commands: String,
    pub events: Vec<Event>,
}

impl Output {
    /// A line for the file, without its end.
    fn line(&mut self, line: &[u8]) {
        let preamble = std::mem::take(&mut self.preamble);
        self.text
            .extend([preamble.as_bytes(), line, b"\n"].concat());
    }
}

/// A line without its end, and when it arrived.
pub struct Line {
    pub at_s: f64,
    pub text: Vec<u8>,
    /// Bytes at its beginning that the board did not send.
    stamp: usize,
}

impl Line {
    /// A line without a stamp.
    pub fn plain(at_s: f64, text: Vec<u8>) -> Self {
        let stamp = 0;
        Line { at_s, text, stamp }
    }
}

/// Lines that go into the file.
pub struct Writing {
    pub reader: Follow,
    rewrite: Option<Rewrite>,
    /// The time zero of stamps that are added, s; none before the first line.
    stamps_from_s: Option<f64>,
    day_s: f64,
    max_rows: Option<u64>,
    duration_s: f64,
    waiting: VecDeque<Line>,
    /// Lines that the reader has judged, so that the next is the first that waits.
    pub judged: usize,
    pub gaps: Gaps,
    pub counts: Counts,
    /// Time of the first stored row, later by all pauses since, s.
    began_s: Option<f64>,
    paused_from_s: Option<f64>,
    /// Lines of the reader at which a pause begins, or ends.
    pauses: Vec<usize>,
    /// The first line that was rejected since they were reported.
    first_rejected: Option<String>,
    /// Rows are missing, or may be.
    pub is_incomplete: bool,
    /// No row had arrived for a while at the end.
    pub ends_in_gap: bool,
    /// All that was asked for is there.
    pub end: Option<End>,
}

impl Writing {
    fn new(options: &Options, reader: Follow, rewrite: Option<Rewrite>) -> Self {
        Writing {
            reader,
            rewrite,
            stamps_from_s: None,
            day_s: options.day_s,
            max_rows: options.rows,
            duration_s: options.duration_s.unwrap_or(f64::INFINITY),
            waiting: VecDeque::new(),
            judged: 0,
            gaps: Gaps::default(),
            counts: Counts::default(),
            began_s: None,
            paused_from_s: None,
            pauses: Vec::new(),
            first_rejected: None,
            is_incomplete: false,
            ends_in_gap: false,
            end: None,
        }
    }

    /// Continues a file that begins like this.
    ///
    /// # Errors
    ///
    /// Those of the reader: it is no recording.
    pub fn continued(options: &Options, before: &[u8]) -> Result<Self> {
        let mut reader = reader(&options.name, None);
        reader.push(before)?;
        reader.settle(1)?;
        let mut writing = Writing::new(options, reader, Rewrite::of_file(before));
        writing.judged = writing.reader.take_lines().count;
        writing.gaps.open(Cause::Continued);
        Ok(writing)
    }

    /// Begins a file with the lines that were held.
    ///
    /// # Errors
    ///
    /// Those of the reader.
    pub fn begun(
        options: &Options,
        form: &Form,
        mut head: Vec<Line>,
        out: &mut Output,
    ) -> Result<Self> {
        let header = form.header_line.checked_sub(1);
        let sent_header = header.and_then(|at| head.get(at));
        let sent_header = sent_header.map(|line| &line.text[..]);
        let rewrite = Rewrite::new(form, sent_header, options.columns.is_some());
        // In the file columns that the user names have a header.
        let columns = options.columns.clone().filter(|_| rewrite.is_none());
        let mut writing = Writing::new(options, reader(&options.name, columns), rewrite);
        let rows = head.split_off(form.head_lines.min(head.len()));
        let first_s = rows.first().map_or(0.0, |line| line.at_s);
        for (at, line) in head.into_iter().enumerate() {
            let text = match &writing.rewrite {
                Some(rewrite) if Some(at) == header => rewrite.line(&line.text, 0.0, 0.0).0,
                _ => line.text,
            };
            writing.feed(Line::plain(line.at_s, text))?;
        }
        if let Some(rewrite) = &writing.rewrite {
            out.preamble += &rewrite.notes();
            if let Some(header) = rewrite.made_header.clone() {
                writing.feed(Line::plain(first_s, header.into_bytes()))?;
            }
        }
        for line in rows {
            let line = writing.stamped(line.at_s, &line.text);
            writing.feed(line)?;
        }
        writing.reader.settle(1)?;
        writing.write_judged(out);
        Ok(writing)
    }

    // Queries.

    pub fn is_paused(&self) -> bool {
        self.paused_from_s.is_some()
    }

    /// Whether a line of the reader, from 1, arrived outside of pauses.
    pub fn is_stored(&self, line: usize) -> bool {
        self.pauses.partition_point(|at| *at <= line) % 2 == 0
    }

    /// Seconds since the first row, without pauses.
    pub fn elapsed_s(&self, now_s: f64) -> f64 {
        let began_s = self.began_s.unwrap_or(f64::INFINITY);
        (self.paused_from_s.unwrap_or(now_s) - began_s).max(0.0)
    }

    /// A silence takes `min_s`, or for a slow board more, s.
    pub fn silence_s(&self, min_s: f64) -> f64 {
        min_s.max(GAP_STEPS / self.rate_hz().unwrap_or(1.0))
    }

    fn rate_hz(&self) -> Option<f64> {
        self.reader.form()?.rate_hz
    }

    // Inputs.

    /// A line of the board, without its end.
    ///
    /// # Errors
    ///
    /// The reader refuses it: the board sends other rows than before.
    pub fn line(&mut self, at_s: f64, line: &[u8], out: &mut Output) -> Result<()> {
        let line = self.stamped(at_s, line);
        self.add(line, out)
    }

    /// A part of a line: of numbers the first or the last may lack digits.
    ///
    /// # Errors
    ///
    /// Those of the reader.
    pub fn reject(&mut self, at_s: f64, line: &[u8], out: &mut Output) -> Result<()> {
        if self.is_paused() || line.trim_ascii().is_empty() {
            return Ok(());
        }
        let text = self.count_rejected(line);
        self.add(Line::plain(at_s, text), out)
    }

    /// The space bar. Three blank lines stand for a pause.
    ///
    /// # Errors
    ///
    /// Those of the reader.
    pub fn toggle_pause(&mut self, now_s: f64, out: &mut Output) -> Result<()> {
        if self.counts.rows == 0 || self.end.is_some() {
            return Ok(());
        }
        self.pauses.push(self.judged + self.waiting.len() + 1);
        let Some(from_s) = self.paused_from_s.take() else {
            self.paused_from_s = Some(now_s);
            out.events.push(Event::Paused);
            return Ok(());
        };
        self.began_s = self.began_s.map(|began_s| began_s + now_s - from_s);
        out.events.push(Event::Resumed);
        (0..3).try_for_each(|_| self.add(Line::plain(now_s, Vec::new()), out))
    }

    /// Time passes: the recording may be long enough.
    pub fn tick(&mut self, now_s: f64, out: &mut Output) {
        if self.end.is_none() && self.elapsed_s(now_s) >= self.duration_s {
            self.write_last_gap(now_s, out);
            self.end = Some(End::Duration);
        }
    }

    /// The user ends it.
    pub fn finish(&mut self, now_s: f64, out: &mut Output) {
        self.write_last_gap(now_s, out);
        self.report_rejected(out);
        self.end.get_or_insert(End::User);
    }

    /// Reports the lines that were rejected since the last time.
    pub fn report_rejected(&mut self, out: &mut Output) {
        if let Some(first) = self.first_rejected.take() {
            let count = self.counts.rejected;
            out.events.push(Event::Rejected { count, first });
        }
    }

    // Lines.

    fn stamped(&mut self, at_s: f64, line: &[u8]) -> Line {
        let from_s = *self.stamps_from_s.get_or_insert(at_s);
        let (text, stamp) = match &self.rewrite {
            Some(rewrite) => rewrite.line(line, at_s - from_s, self.day_s + at_s),
            None => (line.to_vec(), 0),
        };
        Line { at_s, text, stamp }
    }

    fn add(&mut self, line: Line, out: &mut Output) -> Result<()> {
        self.feed(line)?;
        self.write_judged(out);
        Ok(())
    }

    fn feed(&mut self, line: Line) -> Result<()> {
        let text = [&line.text[..], b"\n"].concat();
        self.waiting.push_back(line);
        self.reader.push(&text).map(drop)
    }

    /// Writes what the reader has judged.
    fn write_judged(&mut self, out: &mut Output) {
        let mut read = self.reader.take_lines();
        read.rejected.sort_unstable();
        let mut rows = read.rows.iter().peekable();
        while self.judged < read.count
            && self.end.is_none()
            && let Some(line) = self.waiting.pop_front()
        {
            self.judged += 1;
            let number = self.judged as u32;
            let is_stored = self.is_stored(self.judged);
            if let Some((_, stamp)) = rows.next_if(|row| row.0 == number) {
                self.row(&line, *stamp, is_stored, out);
            } else if is_stored && read.rejected.binary_search(&number).is_ok() {
                let text = self.count_rejected(&line.text[line.stamp..]);
                out.line(&text);
            } else if is_stored {
                out.line(&line.text);
            }
        }
        // The last row may have more lines than one.
        if self.has_all_rows() {
            self.end.get_or_insert(End::Rows);
        }
    }

    fn row(&mut self, line: &Line, stamp: f64, is_stored: bool, out: &mut Output) {
        // Times of arrival do not tell what is missing.
        let is_stamped = self.rewrite.as_ref().is_some_and(Rewrite::stamps);
        let stamp = if is_stamped { f64::NAN } else { stamp };
        let rate_hz = self.rate_hz();
        let gap = self.gaps.before_row(line.at_s, stamp, is_stored, rate_hz);
        if !is_stored {
            return;
        }
        self.began_s.get_or_insert(line.at_s);
        if self.has_all_rows() {
            self.end = Some(End::Rows);
        } else if self.elapsed_s(line.at_s) > self.duration_s {
            self.end = Some(End::Duration);
        }
        if self.end.is_some() {
            return;
        }
        if self.counts.rows == 0 {
            let roles = self.reader.form().map(|form| form.roles);
            let columns = roles.unwrap_or_default().join(",");
            out.events.push(Event::Started { columns });
        }
        if let Some(gap) = gap {
            self.write_gap(gap, out);
        }
        self.counts.rows += 1;
        out.line(&line.text);
    }

    fn has_all_rows(&self) -> bool {
        self.max_rows == Some(self.counts.rows)
    }

    /// Counts a line as rejected; returns what stands in the file for it.
    fn count_rejected(&mut self, line: &[u8]) -> Vec<u8> {
        let text = String::from_utf8_lossy(line);
        let text = shown(text.trim());
        self.counts.rejected += 1;
        self.gaps.reject();
        let quoted = || text.chars().take(QUOTED).collect();
        self.first_rejected.get_or_insert_with(quoted);
        format!("# rejected: {text}").into_bytes()
    }

    fn write_gap(&mut self, gap: Gap, out: &mut Output) {
        out.line(gap.line().as_bytes());
        self.counts.gaps += 1;
        let missing = gap.rows.unwrap_or(0);
        self.counts.missing = self.counts.missing.saturating_add(missing);
        self.is_incomplete |= gap.rows != Some(0) && gap.cause != Cause::Continued;
        out.events.push(Event::Gap(gap));
    }

    fn write_last_gap(&mut self, now_s: f64, out: &mut Output) {
        let is_in_recording = self.counts.rows > 0 && !self.is_paused() && self.end.is_none();
        let gap = self.gaps.at_end(now_s, self.silence_s(SILENT_END_S));
        if let Some(gap) = gap.filter(|_| is_in_recording) {
            self.ends_in_gap = true;
            self.write_gap(gap, out);
        }
    }
}

/// A reader of the file with this name.
pub fn reader(name: &str, columns: Option<ColumnsSpec>) -> Follow {
    let options = ReadOptions {
        columns,
        ..ReadOptions::default()
    };
    Follow::new(name, options, JUDGED_ROWS).noting_lines()
}
