//! The life of a recording: bytes of the board, keys and time in; lines for the file, commands for
//! the board and events out. It has no clock and no I/O: time is an argument, in seconds on any
//! clock that only advances.
//!
//! The reader of recordings decides what a row is: it reads the lines as they will stand in the
//! file. Until it knows their format, after about a second, they are held.

use std::collections::VecDeque;
use std::ops::Range;

use gravical::Error;
use gravical::escape::shown;
use gravical::recording::following::Following;
use gravical::recording::{ColumnsSpec, ReadOptions};

use super::event::{Cause, Counts, End, Event, Gap};
use super::lines::{Clock, Splitter, Step};
use super::rewrite::Rewrite;
use crate::device::board::{Settings, Wanted};

/// The last rows are judged: so many, up to twice as many.
const JUDGED_ROWS: usize = 10_000;
/// Without a row for this time something is wrong, s.
const NO_ROWS_S: f64 = 8.0;
/// After this time the format of a slow board is detected from the lines that are there, s.
const HOLD_S: f64 = 6.0;
/// Nothing for this time, and for so many usual steps, is a silence, s.
const SILENCE_S: f64 = 3.0;
const SILENT_STEPS: f64 = 4.5;
/// At the end the same after this time, s.
const SILENT_END_S: f64 = 1.0;
/// Fewer rows than this are no gap: the reader counts them as missing.
const MIN_MISSING: u64 = 4;
/// A board that was reset by opening its port reports its settings within this time, or is told
/// them then, and so many times again, s.
const COMMAND_S: f64 = 2.5;
const MAX_COMMANDS: u32 = 4;
/// A board that names no columns is asked for its settings: one of ours answers within this time, s.
const ASK_S: f64 = 1.5;
/// A board that opening the port resets is silent for this time, within that after the opening, s.
const RESET_SILENCE_S: f64 = 1.0;
const RESET_S: f64 = 4.0;
/// What the reader sees where rows are missing that the file names otherwise.
const BREAK: &[u8] = b"# gap:";
const SKETCH: &str = "is the baud rate right (--baud), and does the sketch print rows of numbers (firmware/mpu6050_logger does)? --wait waits without end";

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
    /// A silent board is waited for without end.
    pub wait: bool,
    /// The first line of the recording.
    pub preamble: String,
    /// Lines of the file that is continued; empty for a new one.
    pub before: Vec<u8>,
    /// Time of day at the time zero, s (UTC).
    pub day_s: f64,
}

/// What has to be done.
#[derive(Default)]
pub struct Output {
    /// Whole lines for the file.
    pub text: Vec<u8>,
    /// Commands for the board.
    pub commands: String,
    pub events: Vec<Event>,
}

/// The state of a recording. In each the port may be lost and found.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// The board is set as wanted, and has to confirm it.
    Setting { next_s: f64, commands: u32 },
    /// Lines are held: their format is not known.
    Holding,
    /// Lines are written.
    Writing,
    /// All that was asked for is there, or the recording failed.
    Over,
}

/// A line that the reader has not judged yet.
struct Line {
    at_s: f64,
    /// As it was received; none for a line that is made here.
    received: Option<Vec<u8>>,
    /// As it stands in the file; none for a break that is of the reader alone.
    text: Option<Vec<u8>>,
}

impl Line {
    /// A line that is made here; none: a break.
    fn made(at_s: f64, text: Option<Vec<u8>>) -> Self {
        let received = None;
        Line {
            at_s,
            received,
            text,
        }
    }
}

/// What has happened so far.
#[derive(Default)]
pub struct Run {
    pub counts: Counts,
    /// Rows that arrived, stored or not.
    pub arrived: u64,
    /// Rows are missing, or may be.
    pub is_incomplete: bool,
    /// Why it ended, and whether no row had arrived for a while.
    pub ended: Option<End>,
    pub ends_in_gap: bool,
    /// Why it failed.
    pub fatal: Option<Error>,
    splitter: Splitter,
    clock: Clock,
    waiting: VecDeque<Line>,
    /// Lines that the reader has judged, so that the next is the first that waits.
    judged: usize,
    /// The answer to our question is waited for until then, s.
    asked_until_s: Option<f64>,
    /// Rows from before the reset by opening the port were dropped.
    has_reset: bool,
    /// Lines at the last attempt to detect the format early, and rows that were wanted.
    tried: (usize, usize),
    is_open: bool,
    opened_s: f64,
    last_bytes_s: Option<f64>,
    is_silent: bool,
    first_row_s: Option<f64>,
    /// The time zero of stamps that are added.
    stamps_from_s: Option<f64>,
    last_row_s: f64,
    paused_from_s: Option<f64>,
    paused_s: f64,
    /// Lines of the reader that are not stored; the last span is open during a pause.
    pauses: Vec<Range<usize>>,
    /// Rows are missing since the last one, and the clock may have restarted.
    gap: Option<Cause>,
    has_restarted: bool,
    /// Since the last row; since they were reported, and the first of those.
    rejected_since_row: u64,
    unreported: u64,
    first_rejected: String,
}

/// One recording.
pub struct Recorder {
    options: Options,
    phase: Phase,
    /// Reads the rows.
    pub reader: Following,
    rewrite: Option<Rewrite>,
    pub run: Run,
    out: Output,
}

impl Recorder {
    /// A recording without a port.
    ///
    /// # Errors
    ///
    /// Those of the reader for the file that is continued.
    pub fn new(options: Options) -> Result<Self, Error> {
        let mut recorder = Recorder {
            phase: Phase::Setting {
                next_s: COMMAND_S,
                commands: 0,
            },
            reader: reader(&options.name, None),
            rewrite: Rewrite::of_file(&options.before),
            run: Run::default(),
            out: Output::default(),
            options,
        };
        if recorder.options.before.is_empty() {
            recorder.reader = recorder.raw_reader();
        } else {
            recorder.reader.push(&recorder.options.before)?;
            recorder.reader.settle(1)?;
            recorder.run.judged = recorder.reader.take_lines().count;
            recorder.run.gap = Some(Cause::Continued);
        }
        if recorder.options.wanted.commands().is_empty() {
            recorder.phase = recorder.after_setting();
        }
        Ok(recorder)
    }

    /// A reader of lines as they are received.
    fn raw_reader(&self) -> Following {
        reader(&self.options.name, self.options.columns.clone())
    }

    fn after_setting(&self) -> Phase {
        if self.options.before.is_empty() {
            Phase::Holding
        } else {
            Phase::Writing
        }
    }

    // Queries.

    /// What has to be done since the last call.
    pub fn take(&mut self) -> Output {
        std::mem::take(&mut self.out)
    }

    pub fn is_paused(&self) -> bool {
        self.run.paused_from_s.is_some()
    }

    /// Whether a line of the reader, from 1, arrived outside of pauses.
    pub fn is_stored(&self, line: usize) -> bool {
        !self.run.pauses.iter().any(|pause| pause.contains(&line))
    }

    /// Seconds since the first row, without pauses.
    pub fn elapsed_s(&self, now_s: f64) -> f64 {
        let Some(first_s) = self.run.first_row_s else {
            return 0.0;
        };
        let paused_s =
            self.run.paused_s + self.run.paused_from_s.map_or(0.0, |from_s| now_s - from_s);
        (now_s - first_s - paused_s).max(0.0)
    }

    // Inputs.

    /// A port was opened; `device` is the device behind it.
    pub fn opened(&mut self, now_s: f64, port: &str, device: Option<String>) {
        self.run.splitter = Splitter::default();
        (self.run.is_open, self.run.opened_s, self.run.last_bytes_s) = (true, now_s, None);
        (self.run.asked_until_s, self.run.has_reset) = (None, false);
        if let Phase::Setting { .. } = self.phase {
            self.phase = Phase::Setting {
                next_s: now_s + COMMAND_S,
                commands: 0,
            };
        }
        let port = port.to_owned();
        self.say(Event::Opened { port, device });
    }

    /// The port is lost; `why` is the system's message.
    pub fn lost(&mut self, now_s: f64, why: &str) {
        self.run.is_open = false;
        let half = self.run.splitter.cut();
        match self.phase {
            Phase::Writing => {
                if !half.is_empty() {
                    self.reject_half(now_s, &half);
                }
                self.run.gap.get_or_insert(Cause::Unplugged);
            }
            // Lines of another start of the board.
            Phase::Holding => self.drop_held("before the port was lost"),
            Phase::Setting { .. } | Phase::Over => {}
        }
        let text = why.to_owned();
        self.say(Event::Lost { text });
    }

    /// Bytes of the board.
    pub fn bytes(&mut self, now_s: f64, bytes: &[u8]) {
        let silence_s = now_s - self.run.last_bytes_s.unwrap_or(now_s);
        if silence_s >= self.reset_silence_s() && now_s - self.run.opened_s < RESET_S {
            self.forget_rows_before_reset();
        }
        (self.run.last_bytes_s, self.run.is_silent) = (Some(now_s), false);
        for (line, is_whole) in self.run.splitter.push(bytes) {
            self.line(now_s, line, is_whole);
        }
    }

    /// The space bar.
    pub fn toggle_pause(&mut self, now_s: f64) {
        if self.phase != Phase::Writing || self.run.counts.rows == 0 {
            return;
        }
        let next = self.run.judged + self.run.waiting.len() + 1;
        let is_resumed = self.is_paused();
        if let Some(from_s) = self.run.paused_from_s.take() {
            self.run.paused_s += now_s - from_s;
            if let Some(pause) = self.run.pauses.last_mut() {
                pause.end = next;
            }
            self.say(Event::Resumed);
        } else {
            self.run.paused_from_s = Some(now_s);
            self.run.pauses.push(next..usize::MAX);
            self.say(Event::Paused);
        }
        for _ in 0..3 {
            self.read(Line::made(now_s, is_resumed.then(Vec::new)));
        }
    }

    /// Time passes.
    pub fn tick(&mut self, now_s: f64) {
        if let Phase::Setting { next_s, commands } = self.phase
            && self.run.last_bytes_s.is_some()
            && now_s >= next_s
        {
            self.command(now_s, commands);
        }
        let duration_s = self.options.duration_s.unwrap_or(f64::INFINITY);
        if self.phase == Phase::Holding {
            let first_s = self.run.waiting.front().map_or(now_s, |line| line.at_s);
            let rows = match self.options.rows {
                _ if now_s - first_s >= HOLD_S.min(duration_s) => 1,
                Some(rows) => usize::try_from(rows).unwrap_or(usize::MAX),
                None => usize::MAX,
            };
            self.settle(rows, now_s);
        }
        let writes = self.phase == Phase::Writing;
        if writes && self.elapsed_s(now_s) >= duration_s {
            self.write_last_gap(now_s);
            self.complete(End::Duration);
        }
        let is_set = match self.phase {
            Phase::Setting { .. } => self.run.last_bytes_s.is_none(),
            phase => phase != Phase::Over,
        };
        let is_due = now_s - self.run.opened_s >= NO_ROWS_S && self.run.first_row_s.is_none();
        if is_due && is_set && self.run.is_open && !self.options.wait {
            self.settle(1, now_s);
            if self.phase == Phase::Writing || self.reader.form().is_none() {
                self.fail_without_rows();
            }
        }
        let silence_s = now_s - self.run.last_bytes_s.unwrap_or(self.run.opened_s);
        if writes
            && self.run.is_open
            && silence_s >= self.silence_s(SILENCE_S)
            && !self.run.is_silent
        {
            self.run.is_silent = true;
            self.run.gap.get_or_insert(Cause::Silent);
            self.say(Event::Silent {
                duration_s: silence_s,
            });
        }
    }

    /// Reports what is reported once a second.
    pub fn report_rejected(&mut self) {
        if self.run.unreported > 0 {
            let count = std::mem::take(&mut self.run.unreported);
            let first = std::mem::take(&mut self.run.first_rejected);
            self.say(Event::Rejected { count, first });
        }
    }

    /// The recording ends: what has begun is closed.
    pub fn finish(&mut self, now_s: f64) {
        self.run.asked_until_s = Some(now_s);
        self.settle(1, now_s);
        if self.phase == Phase::Writing {
            self.write_last_gap(now_s);
        }
        self.report_rejected();
        self.complete(End::User);
    }

    /// Names the gap at the end: one that is open, or a silence.
    fn write_last_gap(&mut self, now_s: f64) {
        let duration_s = now_s - self.run.last_row_s;
        let is_silent = duration_s > self.silence_s(SILENT_END_S);
        let cause = self.run.gap.take().or(is_silent.then_some(Cause::Silent));
        if let Some(cause) = cause.filter(|_| self.run.counts.rows > 0 && !self.is_paused()) {
            self.run.ends_in_gap = true;
            self.write_gap(Gap {
                cause,
                rows: None,
                duration_s,
                clock_restarts: false,
                until_end: true,
            });
        }
    }

    // Lines.

    fn say(&mut self, event: Event) {
        self.out.events.push(event);
    }

    /// A line of the board, without its end.
    fn line(&mut self, now_s: f64, line: Vec<u8>, is_whole: bool) {
        let text = String::from_utf8_lossy(&line);
        let settings = Settings::parse(&text);
        if line.starts_with(b"#") {
            let text = shown(&text).into_owned();
            self.say(Event::Board { text });
        }
        if let Some(settings) = settings {
            self.settings_are(now_s, &settings);
        }
        if !matches!(self.phase, Phase::Holding | Phase::Writing) {
            return;
        }
        let has_letter = line.iter().any(|b| b.is_ascii_alphabetic());
        if !is_whole && !has_letter {
            // Of numbers whose beginning was not received the first may lack digits.
            return self.reject_half(now_s, &line);
        }
        let text = match &self.rewrite {
            Some(rewrite) => {
                let first_s = *self.run.stamps_from_s.get_or_insert(now_s);
                rewrite.line(&line, now_s - first_s, self.options.day_s + now_s)
            }
            None => line.clone(),
        };
        self.read(Line {
            at_s: now_s,
            received: Some(line),
            text: Some(text),
        });
    }

    fn reject_half(&mut self, at_s: f64, line: &[u8]) {
        if line.trim_ascii().is_empty() {
            return;
        }
        let text = self.count_rejected(line);
        self.read(Line::made(at_s, Some(text)));
    }

    /// Counts a line as rejected; returns what stands in the file for it.
    fn count_rejected(&mut self, line: &[u8]) -> Vec<u8> {
        let text = String::from_utf8_lossy(line);
        let text = shown(text.trim()).into_owned();
        self.run.counts.rejected += 1;
        self.run.rejected_since_row += 1;
        if self.run.unreported == 0 {
            self.run.first_rejected = text.chars().take(60).collect();
        }
        self.run.unreported += 1;
        format!("# rejected: {text}").into_bytes()
    }

    /// Passes a line to the reader, and on to the file what it has judged.
    fn read(&mut self, line: Line) {
        let at_s = line.at_s;
        let fed = self.feed(line);
        self.read_on(at_s, fed);
    }

    fn read_on(&mut self, now_s: f64, fed: Result<(), Error>) {
        let done = match self.phase {
            Phase::Holding => fed.and_then(|()| self.begin(now_s)),
            Phase::Writing => fed.map(|()| self.write_judged()),
            Phase::Setting { .. } | Phase::Over => return,
        };
        if let Err(error) = done {
            self.refused(&error);
        }
    }

    fn feed(&mut self, line: Line) -> Result<(), Error> {
        let mut text = line.text.clone().unwrap_or_else(|| BREAK.to_vec());
        text.push(b'\n');
        self.run.waiting.push_back(line);
        self.reader.push(&text).map(drop)
    }

    /// The reader refuses the last line.
    fn refused(&mut self, error: &Error) {
        if self.phase == Phase::Writing && error.code() != "header-differs" {
            let why = error.message();
            let text = format!("the rows cannot be read any more ({why}): the recording ends");
            self.fail(Error::device("unreadable-rows", text).with_hint(
                "the rows up to here are in the file; record the rest into another one",
            ));
        } else if self.phase == Phase::Writing {
            let why = error.message();
            self.fail(
                Error::device(
                    "columns-changed",
                    format!("the board sends rows of other columns or units than before ({why}): the recording ends"),
                )
                .with_hint("the rows up to here are in the file; record the rest into another one, or set the board as it was: --format, --range"),
            );
        } else if self.options.wait {
            self.forget();
        } else {
            self.fail_without_rows();
        }
    }

    /// Lines that were held are no part of the recording.
    fn forget(&mut self) {
        self.run.waiting.clear();
        (self.run.counts.rejected, self.run.unreported) = (0, 0);
        self.reader = self.raw_reader();
        self.rewrite = None;
        self.run.tried = (0, 0);
    }

    /// A board that is reset by opening its port sends some rows before, and then its header.
    fn forget_rows_before_reset(&mut self) {
        if self.phase == Phase::Holding && !self.run.has_reset {
            let is_known = self.reader.settle(1).is_ok();
            let form = self.reader.form().filter(|_| is_known);
            self.run.has_reset = form.is_some_and(|form| form.header_line == 0);
            if self.run.has_reset {
                self.drop_held("before it was reset by opening the port");
            }
        }
    }

    /// A slow board is silent between its rows: a reset takes longer than that.
    fn reset_silence_s(&self) -> f64 {
        let [Some(first), Some(last)] = [self.run.waiting.front(), self.run.waiting.back()] else {
            return f64::INFINITY;
        };
        let steps = self.run.waiting.len() - 1;
        let usual_s = (last.at_s - first.at_s) / steps as f64;
        if steps > 0 {
            RESET_SILENCE_S.max(SILENT_STEPS * usual_s)
        } else {
            f64::INFINITY
        }
    }

    /// Lines that were held are dropped, and that is said.
    fn drop_held(&mut self, when: &str) {
        let lines = self.run.waiting.len();
        if lines > 0 {
            let text = format!("{lines} lines that the board sent {when} are not recorded");
            self.say(Event::Warning { text });
        }
        self.forget();
    }

    /// Detects the format from the lines that are there, if they hold so many rows.
    fn settle(&mut self, rows: usize, now_s: f64) {
        if self.reader.form().is_some() {
            return self.read_on(now_s, Ok(()));
        }
        let lines = self.run.waiting.len();
        if self.phase != Phase::Holding || lines < rows || self.run.tried == (lines, rows) {
            return;
        }
        self.run.tried = (lines, rows);
        if self.reader.settle(rows).is_ok() {
            self.read_on(now_s, Ok(()));
        }
    }

    /// Begins to write, once the format is known.
    fn begin(&mut self, now_s: f64) -> Result<(), Error> {
        let Some(form) = self.reader.form() else {
            return Ok(());
        };
        if form.header_line == 0 && form.delimiter.is_some() {
            let until_s = self.run.asked_until_s.get_or_insert_with(|| {
                self.out.commands.push_str("?\n");
                now_s + ASK_S
            });
            if now_s < *until_s {
                return Ok(());
            }
        }
        let header = form.header_line.checked_sub(1);
        let header = header.and_then(|at| self.run.waiting.get(at)?.received.as_deref());
        let is_named = self.options.columns.is_some();
        let Some(rewrite) = Rewrite::new(&form, header, is_named) else {
            self.phase = Phase::Writing;
            self.write_judged();
            return Ok(());
        };
        // The same lines once more, as they will stand in the file.
        self.reader = reader(&self.options.name, None);
        let mut waiting = std::mem::take(&mut self.run.waiting);
        let rows = waiting.split_off(form.head_lines.min(waiting.len()));
        let first_s = rows.front().map_or(0.0, |line| line.at_s);
        self.run.stamps_from_s = Some(first_s);
        if let Some(line) = waiting.get_mut(form.header_line.wrapping_sub(1))
            && let Some(received) = &line.received
        {
            line.text = Some(rewrite.line(received, 0.0, 0.0));
        }
        let made = rewrite.made_header.as_ref().map(|h| h.clone().into_bytes());
        waiting.extend(made.map(|header| Line::made(first_s, Some(header))));
        for mut line in rows {
            if let Some(received) = &line.received {
                let day_s = self.options.day_s + line.at_s;
                line.text = Some(rewrite.line(received, line.at_s - first_s, day_s));
            }
            waiting.push_back(line);
        }
        self.options.preamble += &rewrite.notes();
        self.rewrite = Some(rewrite);
        waiting.into_iter().try_for_each(|line| self.feed(line))?;
        self.reader.settle(1)?;
        self.phase = Phase::Writing;
        self.write_judged();
        Ok(())
    }

    /// Writes what the reader has judged.
    fn write_judged(&mut self) {
        let mut lines = self.reader.take_lines();
        lines.rejected.sort_unstable();
        let mut rows = lines.rows.iter().peekable();
        while self.run.judged < lines.count
            && self.phase != Phase::Over
            && let Some(line) = self.run.waiting.pop_front()
        {
            self.run.judged += 1;
            let number = self.run.judged as u32;
            if let Some((_, stamp)) = rows.next_if(|row| row.0 == number) {
                self.row(line, *stamp);
            } else if let Some(received) = &line.received
                && lines.rejected.binary_search(&number).is_ok()
            {
                if self.is_stored(self.run.judged) {
                    let text = self.count_rejected(received);
                    self.write(Some(text));
                }
            } else {
                self.write(line.text);
            }
        }
        if self.options.rows == Some(self.run.counts.rows) {
            self.complete(End::Rows);
        }
    }

    /// A line for the file, unless it belongs to a pause.
    fn write(&mut self, line: Option<Vec<u8>>) {
        if let Some(line) = line.filter(|_| self.is_stored(self.run.judged)) {
            let preamble = std::mem::take(&mut self.options.preamble);
            self.out.text.extend_from_slice(preamble.as_bytes());
            self.out.text.extend_from_slice(&line);
            self.out.text.push(b'\n');
        }
    }

    fn row(&mut self, line: Line, stamp: f64) {
        self.run.arrived += 1;
        let is_stored = self.is_stored(self.run.judged);
        let step = match &self.rewrite {
            Some(rewrite) if rewrite.stamps() => Step::Unknown,
            _ => self.run.clock.next(stamp),
        };
        let gap = self.gap_before(line.at_s, step, is_stored);
        self.run.last_row_s = line.at_s;
        if !is_stored {
            return;
        }
        if self.run.counts.rows == 0 {
            self.run.first_row_s.get_or_insert(line.at_s);
        }
        let duration_s = self.options.duration_s.unwrap_or(f64::INFINITY);
        if self.options.rows == Some(self.run.counts.rows) {
            return self.complete(End::Rows);
        } else if self.elapsed_s(line.at_s) > duration_s {
            return self.complete(End::Duration);
        }
        if self.run.counts.rows == 0 {
            let roles = self.reader.form().map(|form| form.roles);
            let columns = roles.unwrap_or_default().join(",");
            self.say(Event::Started { columns });
        }
        if let Some(gap) = gap {
            self.write_gap(gap);
            // The reader learns of it, if after the row.
            let _ = self.feed(Line::made(line.at_s, None));
        }
        self.run.counts.rows += 1;
        self.write(line.text);
    }

    fn write_gap(&mut self, gap: Gap) {
        self.write(Some(gap.line().into_bytes()));
        self.run.counts.gaps += 1;
        let missing = gap.rows.unwrap_or(0);
        self.run.counts.missing = self.run.counts.missing.saturating_add(missing);
        self.run.is_incomplete |= gap.rows != Some(0) && gap.cause != Cause::Continued;
        self.say(Event::Gap(gap));
    }

    /// The gap before a row. One that is open in a pause stays so until a row is stored.
    fn gap_before(&mut self, at_s: f64, step: Step, is_stored: bool) -> Option<Gap> {
        let rejected = std::mem::take(&mut self.run.rejected_since_row);
        let missing = match step {
            // Rejected lines were rows.
            Step::Missing(rows) => Some(rows.saturating_sub(rejected)),
            Step::Restart | Step::Unknown => None,
        };
        let is_gap = missing.is_some_and(|rows| rows >= MIN_MISSING);
        match step {
            Step::Restart => {
                self.run.has_restarted = true;
                self.run.gap.get_or_insert(Cause::Reset);
            }
            _ if is_gap => {
                self.run.gap.get_or_insert(Cause::Lost);
            }
            _ if self.run.gap == Some(Cause::Silent) && missing.is_some() => self.run.gap = None,
            _ => {}
        }
        if !is_stored {
            self.run.gap = self.run.gap.filter(|_| self.run.has_restarted);
            return None;
        }
        let cause = self.run.gap.take()?;
        let clock_restarts = std::mem::take(&mut self.run.has_restarted);
        let rows = missing.filter(|_| !clock_restarts);
        let rate_hz = self.reader.form().and_then(|form| form.rate_hz);
        let by_clock = rows.zip(rate_hz).map(|(rows, hz)| (rows as f64 + 1.0) / hz);
        Some(Gap {
            cause,
            rows,
            duration_s: by_clock.unwrap_or(at_s - self.run.last_row_s),
            clock_restarts,
            until_end: false,
        })
    }

    /// The time after which it is silent: `least_s`, for a slow board more, s.
    fn silence_s(&self, least_s: f64) -> f64 {
        let rate_hz = self.reader.form().and_then(|form| form.rate_hz);
        least_s.max(SILENT_STEPS / rate_hz.unwrap_or(1.0))
    }

    // Settings.

    fn settings_are(&mut self, now_s: f64, settings: &Settings) {
        let is_met = self.options.wanted.is_met_by(settings);
        match self.phase {
            Phase::Setting { .. } if is_met => {
                self.phase = self.after_setting();
                self.run.opened_s = now_s;
            }
            Phase::Setting { commands: 0, .. } => self.command(now_s, 0),
            // Rows before are of another start, or have no header.
            Phase::Holding => {
                let held = std::mem::take(&mut self.run.waiting).into_iter();
                self.forget();
                let is_comment =
                    |l: &Line| l.received.as_ref().is_some_and(|l| l.starts_with(b"#"));
                held.filter(is_comment).for_each(|line| self.read(line));
            }
            Phase::Writing if !is_met => self.say(Event::Warning {
                text: "the board was reset and has other settings than those asked for".to_owned(),
            }),
            _ => {}
        }
    }

    /// Sends the settings that are wanted, which `sent` times was in vain.
    fn command(&mut self, now_s: f64, sent: u32) {
        if sent >= MAX_COMMANDS {
            let error = Error::device(
                "settings-refused",
                "the board does not report the settings that were sent to it",
            );
            return self.fail(error.with_hint(
                "upload firmware/mpu6050_logger to the board, or leave the settings out",
            ));
        }
        self.out.commands.push_str(&self.options.wanted.commands());
        self.phase = Phase::Setting {
            next_s: now_s + COMMAND_S,
            commands: sent + 1,
        };
    }

    // Ends.

    fn complete(&mut self, why: End) {
        if self.phase != Phase::Over {
            self.phase = Phase::Over;
            self.run.ended = Some(why);
        }
    }

    fn fail(&mut self, error: Error) {
        self.run.fatal.get_or_insert(error);
        self.phase = Phase::Over;
    }

    fn fail_without_rows(&mut self) {
        let none = |text: String| Error::device("no-samples-from-board", text).with_hint(SKETCH);
        let lines = self.run.waiting.len();
        let last = self.run.waiting.back();
        let last = last.and_then(|line| line.received.as_deref());
        let last = String::from_utf8_lossy(last.unwrap_or_default());
        let last: String = last.chars().take(80).collect();
        let error = match self.run.last_bytes_s {
            None => {
                let text = "the port is open, but the board sends nothing";
                Error::device("board-silent", text).with_hint("is it the right port (gravical ports), and does its sketch print rows (firmware/mpu6050_logger does)? --wait waits without end")
            }
            Some(_) if lines == 0 => none("the board sent no row".to_owned()),
            Some(_) => {
                let why = self.reader.settle(1).err();
                let why = why.map_or("no rows".to_owned(), |e| e.message().to_owned());
                none(format!(
                    "the board sent {lines} lines, which are no recording ({why}); the last: {last:?}"
                ))
            }
        };
        self.fail(error);
    }
}

/// A reader of the file with this name.
fn reader(name: &str, columns: Option<ColumnsSpec>) -> Following {
    let options = ReadOptions {
        columns,
        ..ReadOptions::default()
    };
    Following::new(name, &options, JUDGED_ROWS).noting_lines()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A recorder and what it has written; every row takes 10 ms by the clock of the test.
    struct Bench {
        recorder: Recorder,
        now_s: f64,
        stamp_ms: u32,
        text: String,
        commands: String,
    }

    impl Bench {
        fn new(options: Options) -> Self {
            let mut recorder = Recorder::new(options).unwrap();
            recorder.opened(0.0, "port", None);
            recorder.bytes(0.0, b"\nt_ms,ax,ay,az\n");
            Bench {
                recorder,
                now_s: 0.0,
                stamp_ms: 0,
                text: String::new(),
                commands: String::new(),
            }
        }

        fn pass(&mut self, s: f64) {
            self.now_s += s;
            self.recorder.tick(self.now_s);
            let out = self.recorder.take();
            self.text += std::str::from_utf8(&out.text).unwrap();
            self.commands += &out.commands;
        }

        fn rows(&mut self, rows: u32) {
            for _ in 0..rows {
                let noise = self.stamp_ms * 7919 % 61;
                let row = format!("{},0.{noise:02},-0.1,9.8{noise:02}\n", self.stamp_ms);
                self.stamp_ms += 10;
                self.recorder.bytes(self.now_s, row.as_bytes());
                self.pass(0.01);
            }
        }

        fn gaps(&self) -> Vec<&str> {
            let lines = self.text.lines();
            lines.filter_map(|l| l.strip_prefix("# gap: ")).collect()
        }
    }

    #[test]
    fn a_silence_is_a_gap_if_rows_are_missing_and_a_duration_ends_in_it() {
        let mut bench = Bench::new(Options {
            duration_s: Some(20.0),
            ..Options::default()
        });
        bench.rows(150);
        bench.pass(4.0);
        // The clock of the board stood still.
        bench.rows(50);
        assert!(bench.gaps().is_empty());
        bench.pass(4.0);
        bench.stamp_ms += 4000;
        bench.rows(50);
        let missing = "the board sent nothing: 400 rows are missing, 4.0 s";
        assert_eq!(bench.gaps(), [missing]);
        bench.pass(4.0);
        bench.pass(20.0);
        assert_eq!(bench.recorder.run.ended, Some(End::Duration));
        assert!(bench.gaps()[1].contains("no row arrived until the end"));
        assert!(bench.recorder.run.ends_in_gap);
    }

    #[test]
    fn a_reset_in_a_pause_is_named_and_its_rows_are_not_stored() {
        let mut bench = Bench::new(Options::default());
        bench.rows(150);
        bench.recorder.toggle_pause(bench.now_s);
        bench.rows(30);
        bench.stamp_ms = 0;
        bench.recorder.bytes(bench.now_s, b"torn\n");
        bench.rows(30);
        bench.recorder.toggle_pause(bench.now_s);
        bench.rows(20);
        assert_eq!(bench.recorder.run.counts.rows, 170);
        assert_eq!(bench.recorder.run.counts.rejected, 0);
        let (_, after) = bench.text.split_once("\n\n\n\n# gap: ").unwrap();
        assert!(after.contains("restarts\n300,"), "{after}");
        let elapsed_s = bench.recorder.elapsed_s(bench.now_s);
        assert!((elapsed_s - 1.7).abs() < 1e-6, "{elapsed_s}");
    }

    #[test]
    fn rows_of_a_slow_board_are_written_before_a_second_of_a_hundred_rows() {
        let mut bench = Bench::new(Options::default());
        for _ in 0..8 {
            bench.rows(1);
            bench.stamp_ms += 990;
            bench.pass(0.99);
        }
        assert_eq!(bench.recorder.run.counts.rows, 8);
        assert!(bench.recorder.run.fatal.is_none() && bench.gaps().is_empty());
    }

    #[test]
    fn a_silent_board_is_an_error_unless_it_is_waited_for() {
        for wait in [false, true] {
            let mut recorder = Recorder::new(Options {
                wait,
                ..Options::default()
            });
            let recorder = recorder.as_mut().unwrap();
            recorder.opened(0.0, "port", None);
            recorder.tick(7.9);
            assert!(recorder.run.fatal.is_none());
            recorder.tick(8.1);
            let code = recorder.run.fatal.take().map(|e| e.code());
            assert_eq!(code, (!wait).then_some("board-silent"));
        }
    }

    #[test]
    fn rows_from_before_a_reset_are_dropped_and_a_board_without_a_header_is_asked() {
        const HEADER: &str = "t_ms,ax (g),ay (g),az (g)\n";
        let mut bench = Bench::new(Options::default());
        bench.recorder.forget();
        bench.rows(20);
        bench.pass(1.8);
        bench.stamp_ms = 0;
        bench.recorder.bytes(bench.now_s, HEADER.as_bytes());
        bench.rows(150);
        assert!(bench.text.starts_with(HEADER) && bench.gaps().is_empty());
        assert_eq!(bench.recorder.run.counts.rows, 150);
        assert_eq!(bench.commands, "");

        let settings = "# gravical mpu6050_logger 1.2, MPU6050, accelerometer +-2 g, gyroscope +-250 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 0\n";
        for answer in [true, false] {
            let mut bench = Bench::new(Options::default());
            bench.recorder.forget();
            bench.rows(150);
            assert_eq!((&bench.commands[..], &bench.text[..]), ("?\n", ""));
            if answer {
                let lines = format!("# a note\n{settings}{HEADER}");
                bench.recorder.bytes(bench.now_s, lines.as_bytes());
            }
            bench.rows(150);
            assert_eq!(bench.text.contains(HEADER), answer);
            let rows = if answer { 150 } else { 300 };
            assert_eq!(bench.recorder.run.counts.rows, rows);
            assert_eq!(bench.commands, "?\n");
        }
    }

    /// Whatever arrives: what is written are whole lines, and rows are as many as are counted.
    #[test]
    fn nothing_makes_it_panic() {
        let pieces = [
            "1,2,3,4\n",
            "-5,0.1,0.2,9.8\r\n",
            "1e308,1,2,9.7\n",
            "-1e308,1,2,9.7\n",
            ",,,\n",
            "\n",
            "t,ax,ay,az\n",
            "\u{1b}#\u{0}",
            "# gravical mpu6050_logger",
            "x: 1 y: 2 z: 9\n",
            "nan,",
            "\r",
        ];
        let mut random = 1_u64;
        for start in ["", "t,ax,ay,az\n", "ax;ay;az\n"] {
            let mut bench = Bench::new(Options::default());
            bench.recorder.bytes(0.0, start.as_bytes());
            bench.rows(130);
            for _ in 0..3000 {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                match random >> 58 {
                    0 => bench.recorder.toggle_pause(bench.now_s),
                    1 => bench.recorder.lost(bench.now_s, "why"),
                    2 => bench.recorder.opened(bench.now_s, "port", None),
                    n => {
                        let piece = pieces[n as usize % pieces.len()];
                        bench.recorder.bytes(bench.now_s, piece.as_bytes());
                    }
                }
                bench.pass(0.01);
            }
            bench.recorder.finish(bench.now_s);
            bench.pass(0.0);
            assert!(bench.text.is_empty() || bench.text.ends_with('\n'));
        }
    }
}
