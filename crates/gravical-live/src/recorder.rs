//! The life of a recording: bytes of the board, keys and time in; lines for the file, commands for
//! the board and events out. It has no clock, no I/O and no threads: time is an argument, in seconds
//! on any clock that only advances.
//!
//! Every line that was received is written, as it is or, where it is no row, as `# rejected:`, except: lines
//! before a reset by opening the port, lines before the board confirms the settings that are wanted, rows in a
//! pause, and a first line whose start was not received; lines that begin with `#` are escaped. What a row is,
//! the parser of recordings decides, which reads the lines as they will stand in the file, without judging them.

mod event;
mod gaps;
mod lines;
mod settings;

use std::collections::VecDeque;

use gravical_judge::escape::shown;
use gravical_judge::{ColumnsSpec, Error, GAP_PERIODS, ReadOptions, Result};
use gravical_recording::{BoardSettings, Follow, Form, LineKind};

use crate::problem::Problem;
use gaps::{Cause, Gaps};
use lines::{Line, OtherHeader, Prefixes, Splitter};

pub use event::{Counts, End, Event, Status};
pub use gaps::Gap;
pub use settings::WantedSettings;

/// The format of a slow board is that of the rows of this time, s; and time between two attempts to
/// detect it, s.
const MAX_HELD_S: f64 = 6.0;
const RETRY_S: f64 = 0.5;
/// Time after which missing rows or unconfirmed settings are an error, s.
const NO_ROWS_S: f64 = 8.0;
/// Nothing for this time is a silence, s; for a slow board more.
const SILENCE_S: f64 = 3.0;
/// Opening a port resets the board within this time, and then it is silent for that time, s.
const RESET_S: f64 = 4.0;
const RESET_SILENCE_S: f64 = 1.5;
/// A board that was reset by opening its port takes commands after this time, s.
const COMMAND_S: f64 = 2.5;
/// Rows below a header of other columns that fit it: the board sends other columns from now on.
const MIN_OTHER_ROWS: u32 = 3;
/// A hold of three seconds has too few rows for a calibration below this rate, Hz.
const MIN_RATE_HZ: f64 = 5.0;
/// Number of last received bytes kept to explain missing rows.
const RECEIVED_BYTES: usize = 512;
/// Characters of a rejected line in a message, and of a line in place of rows.
const QUOTED: usize = 60;
/// With more than this share of characters that no text has, it is none.
const MAX_UNREADABLE: f64 = 0.1;

/// Codes of the errors that say what arrives in place of rows.
pub const NO_ROWS: [&str; 3] = ["board-silent", "board-not-text", "no-samples-from-board"];

/// What is recorded, and until when.
#[derive(Clone, Default)]
pub struct RecorderOptions {
    /// Name of the file, which may tell the sensor.
    pub name: String,
    /// Columns that the board does not name, or names otherwise.
    pub columns: Option<ColumnsSpec>,
    /// Settings that the board must have.
    pub wanted: WantedSettings,
    /// Ends after so many rows.
    pub rows: Option<u64>,
    /// Ends so many seconds after the first row, without pauses.
    pub duration_s: Option<f64>,
}

/// A port that is open.
#[derive(Default)]
struct Port {
    name: String,
    opened_s: f64,
    last_bytes_s: Option<f64>,
    /// The last bytes.
    received: Vec<u8>,
    splitter: Splitter,
    /// When the settings that are wanted were sent.
    sent_s: Option<f64>,
    is_silent: bool,
}

/// What has to be done.
#[derive(Default)]
pub struct Output {
    /// Whole lines for the file.
    pub lines: Vec<u8>,
    /// Commands for the board.
    pub commands: String,
    /// What happened.
    pub events: Vec<Event>,
}

/// One recording.
pub struct Recorder {
    options: RecorderOptions,
    /// The board has the settings that are wanted; until then its lines are dropped.
    is_set: bool,
    /// How rows are written. Until that is known lines are held.
    form: Option<Form>,
    /// When the format of few lines is tried next, s.
    next_s: f64,
    /// Why it ended.
    pub end: Option<End>,
    port: Option<Port>,
    reader: Follow,
    /// Comes before the next line of the file.
    preamble: String,
    prefixes: Prefixes,
    /// Lines that the reader has not classified, and their text that it has not got.
    waiting: VecDeque<Line>,
    unread: Vec<u8>,
    other_header: Option<OtherHeader>,
    gaps: Gaps,
    /// Lines so far.
    pub counts: Counts,
    /// Time of the first row, later by all pauses since, s.
    began_s: f64,
    paused_from_s: Option<f64>,
    /// Rows are missing, or may be.
    pub is_incomplete: bool,
    /// Some of what was received had no room.
    pub has_dropped: bool,
    output: Output,
}

impl Recorder {
    /// A recording without a port. `day_s`: time of day at the time zero, s (UTC); `before`: the beginning of the
    /// file that it continues, empty for a new one.
    ///
    /// # Errors
    ///
    /// Those of the reader for the file that is continued.
    pub fn new(options: RecorderOptions, day_s: f64, before: &[u8]) -> Result<Self> {
        let mut recorder = Recorder {
            is_set: options.wanted.commands().is_empty(),
            form: None,
            next_s: 0.0,
            end: None,
            port: None,
            reader: reader(&options, before.is_empty()),
            options,
            preamble: String::new(),
            prefixes: Prefixes::of_file(before, day_s),
            waiting: VecDeque::new(),
            unread: Vec::new(),
            other_header: None,
            gaps: Gaps::default(),
            counts: Counts::default(),
            began_s: f64::INFINITY,
            paused_from_s: None,
            is_incomplete: false,
            has_dropped: false,
            output: Output::default(),
        };
        if !before.is_empty() {
            recorder.reader.classify(before, true)?;
            recorder.form = recorder.reader.form();
            recorder.gaps.open(Cause::Continued);
        }
        Ok(recorder)
    }

    /// What has to be done since the last call.
    pub fn take(&mut self) -> Output {
        std::mem::take(&mut self.output)
    }

    /// Whether nothing has arrived for a while, or the port is lost; not in a pause.
    pub fn is_silent(&self) -> bool {
        self.paused_from_s.is_none() && self.port.as_ref().is_none_or(|port| port.is_silent)
    }

    /// Seconds since the first row, without pauses.
    pub fn elapsed_s(&self, now_s: f64) -> f64 {
        (self.paused_from_s.unwrap_or(now_s) - self.began_s).max(0.0)
    }

    /// The state of the recording; none before the first row.
    pub fn status(&self, now_s: f64) -> Option<Status> {
        (self.counts.rows > 0).then(|| Status {
            rows: self.counts.rows,
            elapsed_s: self.elapsed_s(now_s),
            paused: self.paused_from_s.is_some(),
            rejected: self.counts.rejected,
            ..Status::default()
        })
    }

    /// Adds an event to the output.
    pub fn report(&mut self, event: Event) {
        self.output.events.push(event);
    }

    // Inputs.

    /// A port was opened; `device` is the device behind it. `preamble` becomes the first line of the
    /// file.
    pub fn opened(&mut self, now_s: f64, port: &str, device: Option<String>, preamble: String) {
        if self.counts.rows == 0 {
            self.preamble = preamble;
        }
        let mut opened = Port::default();
        (opened.name, opened.opened_s) = (port.to_owned(), now_s);
        self.port = Some(opened);
        let port = port.to_owned();
        self.report(Event::Opened { port, device });
    }

    /// The port is lost; `why` is the system's message.
    pub fn lost(&mut self, why: &str) {
        self.port = None;
        if self.counts.rows > 0 {
            self.gaps.open(Cause::Unplugged);
        }
        self.drop_held(|_| false);
        let text = why.to_owned();
        self.report(Event::Lost { text });
    }

    /// Bytes that were received had no room, and are lost.
    ///
    /// # Errors
    ///
    /// As [`bytes`](Self::bytes).
    pub fn overflow(&mut self, bytes: u64) -> Result<()> {
        if let Some(port) = &mut self.port {
            port.splitter = Splitter::default();
        }
        let classified = self.classify(false);
        self.gaps.overflow(bytes);
        self.has_dropped = true;
        classified
    }

    /// Bytes of the board; none: time passes.
    ///
    /// # Errors
    ///
    /// Those that end the recording: the board sends other columns than before. What it sends in place of rows
    /// ([`NO_ROWS`]): the recording goes on if the caller does.
    pub fn bytes(&mut self, now_s: f64, bytes: &[u8]) -> Result<()> {
        if let Some(port) = self.port.as_mut().filter(|_| !bytes.is_empty()) {
            let last_s = port.last_bytes_s.replace(now_s).unwrap_or(now_s);
            port.is_silent = false;
            port.received.extend_from_slice(bytes);
            let old = port.received.len().saturating_sub(RECEIVED_BYTES);
            port.received.drain(..old);
            let lines = port.splitter.push(bytes);
            if now_s - last_s >= RESET_SILENCE_S && now_s - port.opened_s < RESET_S {
                let begins_head = |byte: &u8| byte.is_ascii_alphabetic() || *byte == b'#';
                self.drop_held(|line| line.text.first().is_some_and(begins_head));
            }
            for (line, is_whole) in lines {
                self.line(now_s, line, is_whole);
            }
            self.classify(false)?;
        }
        self.tick(now_s)
    }

    /// The space bar. Three blank lines stand for a pause.
    ///
    /// # Errors
    ///
    /// As [`bytes`](Self::bytes).
    pub fn toggle_pause(&mut self, now_s: f64) -> Result<()> {
        if self.counts.rows == 0 || self.end.is_some() {
            return Ok(());
        }
        let Some(from_s) = self.paused_from_s.take() else {
            self.paused_from_s = Some(now_s);
            self.report(Event::Paused);
            return Ok(());
        };
        self.began_s += now_s - from_s;
        self.gaps.resume(now_s, self.port.is_some());
        self.report(Event::Resumed);
        (0..3).for_each(|_| self.add(Line::plain(now_s, "")));
        self.classify(false)
    }

    fn tick(&mut self, now_s: f64) -> Result<()> {
        if !self.is_set {
            return self.set(now_s);
        }
        if self.form.is_some() {
            self.notice_silence(now_s);
            self.end_at(now_s);
        } else if now_s >= self.next_s {
            // Of a slow board what is held is taken as it is, after a while.
            let held_s = self.waiting.front().map_or(0.0, |line| now_s - line.at_s);
            if self.is_due(now_s) || held_s >= MAX_HELD_S {
                self.next_s = now_s + RETRY_S;
                self.classify(true)?;
            }
        }
        if self.counts.rows == 0 && self.is_due(now_s) {
            return self.no_rows();
        }
        Ok(())
    }

    /// The user ends it: what is held is written.
    ///
    /// # Errors
    ///
    /// As [`bytes`](Self::bytes).
    pub fn finish(&mut self, now_s: f64) -> Result<()> {
        self.classify(true)?;
        self.end_at(now_s);
        if self.form.is_some() && self.end.is_none() {
            self.refute_header();
            // A row of which lines are missing.
            while let Some(line) = self.waiting.pop_front() {
                self.put(&line, LineKind::Other);
            }
            if let Some(gap) = self.gaps.at_end(now_s) {
                self.name_gap(gap);
            }
        }
        self.end.get_or_insert(End::User);
        Ok(())
    }

    // Lines.

    /// A line of the board, without its end.
    fn line(&mut self, now_s: f64, text: Vec<u8>, is_whole: bool) {
        if text.starts_with(b"#") {
            let text = String::from_utf8_lossy(&text);
            let shown = shown(&text).into_owned();
            self.report(Event::Board { text: shown });
            if let Some(settings) = BoardSettings::parse(&text) {
                self.settings_are(now_s, &settings);
            }
        } else if self.paused_from_s.is_some() {
            return;
        }
        if self.end.is_some() || !self.is_set {
            return;
        }
        // The first number of a line whose start was not received may lack digits.
        if is_whole || text.iter().any(u8::is_ascii_alphabetic) {
            let (at_s, prefix) = (now_s, self.prefixes.before(&text, now_s));
            self.add(Line { at_s, prefix, text });
        } else if self.form.is_some() {
            self.reject(&text);
        }
    }

    fn add(&mut self, line: Line) {
        self.unread.extend(line.in_file());
        self.waiting.push_back(line);
    }

    /// Writes the lines that the reader can classify: from the line on by which it knows their format.
    fn classify(&mut self, is_last: bool) -> Result<()> {
        let text = std::mem::take(&mut self.unread);
        let kinds = self.reader.classify(&text, is_last && self.form.is_none());
        if self.form.is_some() {
            return self.judged(kinds?);
        }
        if kinds.is_err() && !is_last {
            // So many lines without a format are no recording.
            self.drop_held(|_| false);
            return self.no_rows();
        }
        // Lines that are no recording yet may be one with those that follow.
        let form = self.reader.form();
        form.map_or(Ok(()), |form| self.begin(form))
    }

    /// Writes the lines that were held, whose format is known now.
    fn begin(&mut self, form: Form) -> Result<()> {
        let is_named = self.options.columns.is_some();
        self.prefixes.set_form(&form, is_named);
        let header = self.prefixes.header(&form);
        self.reader = reader(&self.options, header.is_none());
        for (at, mut line) in std::mem::take(&mut self.waiting).into_iter().enumerate() {
            if let Some(header) = header.as_ref().filter(|_| at == form.head_lines) {
                self.add(Line::plain(line.at_s, header.as_str()));
            }
            if at >= form.head_lines || at + 1 == form.header_line {
                line.prefix = self.prefixes.before(&line.text, line.at_s);
            }
            self.add(line);
        }
        let text = std::mem::take(&mut self.unread);
        let kinds = self.reader.classify(&text, true).map_err(|error| {
            let why = error.message().to_owned();
            Problem::Unreadable { why }.error()
        })?;
        self.form = self.reader.form();
        self.judged(kinds)?;
        if let Some(rate_hz) = self.rate_hz().filter(|rate_hz| *rate_hz < MIN_RATE_HZ) {
            let text = format!(
                "the board sends {rate_hz:.1} rows a second, too few for a calibration, which needs {MIN_RATE_HZ}, better 50: shorten the delay of its sketch, for example from delay(500) to delay(10), and upload it again"
            );
            self.report(Event::Warning { text });
        }
        Ok(())
    }

    fn judged(&mut self, kinds: Vec<LineKind>) -> Result<()> {
        for kind in kinds {
            if let Some(line) = self.waiting.pop_front() {
                self.decide(line, kind)?;
            }
        }
        Ok(())
    }

    /// Writes a line, unless it may be a header of other columns, or stands below one.
    fn decide(&mut self, line: Line, kind: LineKind) -> Result<()> {
        if let Some(header) = &mut self.other_header
            && let Some(rows) = header.rows_in(&line)
        {
            header.rows += rows;
            header.lines.push((line, kind));
            if header.rows < MIN_OTHER_ROWS {
                return Ok(());
            }
            return Err(other_columns(&header.lines[0].0));
        }
        self.refute_header();
        match kind {
            LineKind::OtherHeader if line.is_comment() => return Err(other_columns(&line)),
            LineKind::OtherHeader => self.other_header = Some(OtherHeader::new(line)),
            _ => self.put(&line, kind),
        }
        Ok(())
    }

    /// No rows fit the header: it was noise.
    fn refute_header(&mut self) {
        let header = self.other_header.take();
        for (line, kind) in header.into_iter().flat_map(|header| header.lines) {
            self.put(&line, kind);
        }
    }

    fn put(&mut self, line: &Line, kind: LineKind) {
        if self.end.is_some() {
            return;
        }
        match kind {
            LineKind::Row(stamp) if !self.is_noise(line) => self.begin_row(line.at_s, stamp),
            LineKind::Other if line.is_comment() || !self.is_noise(line) => {}
            _ => return self.reject(&line.text),
        }
        if self.end.is_none() {
            self.write(&line.in_file());
        }
    }

    /// Whether the line has what no board sends, although it may have as many fields as a row. Words may
    /// be in another encoding, and so may be ° ² ³ µ of a unit.
    fn is_noise(&self, line: &Line) -> bool {
        let is_control = |b: &u8| b.is_ascii_control() && !b"\t\r\x1b".contains(b);
        let is_foreign = |b: &u8| !b.is_ascii() && !b"\xb0\xb2\xb3\xb5".contains(b);
        let is_in_words = self.form.as_ref().is_some_and(|f| f.delimiter.is_none());
        let is_utf8 = is_in_words || std::str::from_utf8(&line.text).is_ok();
        let text = &line.text;
        text.iter().any(is_control) || !is_utf8 && text.iter().any(is_foreign)
    }

    /// A row follows, unless it ends here.
    fn begin_row(&mut self, at_s: f64, stamp: f64) {
        self.began_s = self.began_s.min(at_s);
        self.end_at(at_s);
        if self.end.is_some() {
            return;
        }
        if self.counts.rows == 0 {
            let roles = self.form.as_ref().map(|form| form.roles.join(","));
            let columns = roles.unwrap_or_default();
            self.report(Event::Started { columns });
        }
        // Times of arrival do not tell what is missing.
        let stamp = Some(stamp).filter(|stamp| self.prefixes.has_clock && !stamp.is_nan());
        let (rate_hz, max_s) = (self.rate_hz(), self.silence_s());
        if let Some(gap) = self.gaps.before_row(at_s, stamp, rate_hz, max_s) {
            self.name_gap(gap);
        }
        self.counts.rows += 1;
    }

    fn name_gap(&mut self, gap: Gap) {
        self.write(format!("{}\n", gap.line()).as_bytes());
        self.counts.gaps += 1;
        let missing = gap.rows.unwrap_or(0);
        self.counts.missing = self.counts.missing.saturating_add(missing);
        let has_lost = gap.rows != Some(0) || gap.dropped_bytes > 0;
        self.is_incomplete |= has_lost && gap.cause != Cause::Continued;
        self.report(Event::Gap(gap));
    }

    /// Ends it once all that was asked for is there.
    fn end_at(&mut self, now_s: f64) {
        let (options, elapsed_s) = (&self.options, self.elapsed_s(now_s));
        let has_rows = options.rows == Some(self.counts.rows);
        let is_over = options.duration_s.is_some_and(|max_s| elapsed_s >= max_s);
        let duration = is_over.then_some(End::Duration);
        self.end = self.end.or(has_rows.then_some(End::Rows)).or(duration);
    }

    fn rate_hz(&self) -> Option<f64> {
        self.form.as_ref()?.rate_hz
    }

    /// Writes a whole line.
    fn write(&mut self, line: &[u8]) {
        let preamble = std::mem::take(&mut self.preamble);
        self.output.lines.extend_from_slice(preamble.as_bytes());
        self.output.lines.extend_from_slice(line);
    }

    /// Writes a line that is no row, or a part of a line.
    fn reject(&mut self, line: &[u8]) {
        let text = String::from_utf8_lossy(line);
        let text = shown(text.trim());
        if text.is_empty() {
            return;
        }
        self.gaps.rejected += 1;
        self.counts.rejected += 1;
        let count = self.counts.rejected;
        if count.is_power_of_two() {
            let line = text.chars().take(QUOTED).collect();
            self.report(Event::Rejected { count, line });
        }
        self.write(format!("# rejected: {text}\n").as_bytes());
    }

    /// Lines whose format is not known are of another start, but for those that are kept.
    fn drop_held(&mut self, keeps: impl Fn(&Line) -> bool) {
        if self.form.is_none() {
            self.reader = reader(&self.options, true);
            self.unread.clear();
            let held = std::mem::take(&mut self.waiting);
            let kept = held.into_iter().filter(keeps);
            kept.for_each(|line| self.add(line));
        }
    }

    // Without rows.

    /// Rows should have arrived.
    fn is_due(&self, now_s: f64) -> bool {
        let port = self.port.as_ref();
        port.is_some_and(|port| now_s - port.opened_s >= NO_ROWS_S)
    }

    /// After a while without a row: what arrives instead.
    fn no_rows(&self) -> Result<()> {
        let port = self.port.as_ref();
        port.map_or(Ok(()), |port| Err(no_rows(&port.name, &port.received)))
    }

    /// Nothing for this time is a silence, s.
    fn silence_s(&self) -> f64 {
        SILENCE_S.max(GAP_PERIODS / self.rate_hz().unwrap_or(1.0))
    }

    /// A board that has sent rows is silent: some may be missing.
    fn notice_silence(&mut self, now_s: f64) {
        let max_s = self.silence_s();
        if let Some(port) = self.port.as_mut().filter(|port| !port.is_silent) {
            let duration_s = now_s - port.last_bytes_s.unwrap_or(port.opened_s);
            port.is_silent = duration_s >= max_s;
            if port.is_silent {
                self.report(Event::Silent { duration_s });
            }
        }
    }

    // Settings.

    fn settings_are(&mut self, now_s: f64, settings: &BoardSettings) {
        let is_met = self.options.wanted.is_met_by(settings);
        if !self.is_set {
            self.is_set = is_met;
            // Rows are waited for from now on.
            if let Some(port) = self.port.as_mut().filter(|_| is_met) {
                port.opened_s = now_s;
            }
        } else if self.form.is_none() {
            // Rows before are of another start, or have no header.
            self.drop_held(Line::is_comment);
        } else if !is_met {
            let text = "the board was reset and has other settings than those asked for".to_owned();
            self.report(Event::Warning { text });
        }
    }

    /// Sends the settings that are wanted, once; that they are in vain is an error.
    fn set(&mut self, now_s: f64) -> Result<()> {
        let is_due = self.is_due(now_s);
        let Some(port) = &mut self.port else {
            return Ok(());
        };
        match port.sent_s {
            _ if port.received.is_empty() && is_due => self.no_rows(),
            None if !port.received.is_empty() && now_s - port.opened_s >= COMMAND_S => {
                port.sent_s = Some(now_s);
                self.output.commands += &self.options.wanted.commands();
                Ok(())
            }
            Some(sent_s) if now_s - sent_s >= NO_ROWS_S => Err(Problem::NoSettings.error()),
            _ => Ok(()),
        }
    }
}

/// A reader of the file, which holds no rows. Behind a header of the names that the user gives it needs no
/// names.
fn reader(recorder: &RecorderOptions, is_named: bool) -> Follow {
    let options = ReadOptions {
        columns: recorder.columns.clone().filter(|_| is_named),
        ..ReadOptions::default()
    };
    Follow::new(&recorder.name, options, 0)
}

/// Why the last bytes of `port` are no rows.
fn no_rows(port: &str, bytes: &[u8]) -> Error {
    let port = port.to_owned();
    if bytes.is_empty() {
        return Problem::BoardSilent { port }.error();
    }
    let text = String::from_utf8_lossy(bytes);
    let is_control = |c: &char| c.is_control() && !"\r\n\t\u{1b}".contains(*c);
    let is_unreadable = |c: &char| *c == char::REPLACEMENT_CHARACTER || is_control(c);
    let unreadable = text.chars().filter(is_unreadable).count();
    if unreadable as f64 > MAX_UNREADABLE * text.chars().count() as f64 {
        return Problem::NoText { port }.error().advise("baud", "");
    }
    // What follows the last end of a line is a part of one.
    let whole = text.rfind(['\r', '\n']).map_or(&*text, |end| &text[..end]);
    let line = whole.trim_end().rsplit(['\r', '\n']).next();
    let line = quoted(line.unwrap_or_default().trim());
    let error = Problem::NoSensor { port, line }.error();
    error.advise("columns", "")
}

fn other_columns(line: &Line) -> Error {
    let line = quoted(&String::from_utf8_lossy(&line.text));
    let error = Problem::OtherColumns { line }.error();
    error.advise("format", "").advise("range", "")
}

fn quoted(text: &str) -> String {
    shown(text).chars().take(QUOTED).collect()
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
    }

    impl Bench {
        fn new(options: RecorderOptions) -> Self {
            let mut recorder = Recorder::new(options, 0.0, b"").unwrap();
            recorder.opened(0.0, "port", None, String::new());
            recorder.bytes(0.0, b"\nt_ms,ax,ay,az\n").unwrap();
            Bench {
                recorder,
                now_s: 0.0,
                stamp_ms: 0,
                text: String::new(),
            }
        }

        fn pass(&mut self, s: f64) {
            self.now_s += s;
            self.recorder.bytes(self.now_s, b"").unwrap();
            let output = self.recorder.take();
            self.text += &String::from_utf8_lossy(&output.lines);
        }

        fn rows(&mut self, rows: u32) {
            for _ in 0..rows {
                let noise = self.stamp_ms * 7919 % 61;
                let row = format!("{},0.{noise:02},-0.1,9.8{noise:02}\n", self.stamp_ms);
                self.stamp_ms += 10;
                self.recorder.bytes(self.now_s, row.as_bytes()).unwrap();
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
        let mut bench = Bench::new(RecorderOptions {
            duration_s: Some(20.0),
            ..RecorderOptions::default()
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
        // The port is lost in a pause, and comes back after it.
        bench.recorder.toggle_pause(bench.now_s).unwrap();
        bench.recorder.lost("why");
        bench.pass(2.0);
        bench.recorder.toggle_pause(bench.now_s).unwrap();
        bench.pass(5.0);
        let recorder = &mut bench.recorder;
        recorder.opened(bench.now_s, "port", None, String::new());
        bench.rows(50);
        let unplugged = "unplugged: an unknown number of rows is missing, 5.0 s";
        assert_eq!(bench.gaps(), [missing, unplugged]);
        bench.pass(4.0);
        bench.pass(20.0);
        assert_eq!(bench.recorder.end, Some(End::Duration));
        assert!(bench.recorder.is_silent());
    }

    #[test]
    fn bytes_without_room_are_a_gap_also_at_the_end() {
        let mut bench = Bench::new(RecorderOptions::default());
        bench.rows(150);
        bench.recorder.overflow(5000).unwrap();
        bench.stamp_ms += 1000;
        // The first line lacks its beginning.
        bench.recorder.bytes(bench.now_s, b"0.1,9.8\n").unwrap();
        bench.rows(50);
        bench.recorder.overflow(70).unwrap();
        bench.recorder.finish(bench.now_s + 0.5).unwrap();
        bench.pass(0.5);
        let cause = "the board sent faster than the computer could write";
        let first = format!("{cause}: 99 rows are missing, 5000 bytes were dropped, 1.0 s");
        let last =
            format!("{cause}: an unknown number of rows is missing, 70 bytes were dropped, 0.5 s");
        assert_eq!(bench.gaps(), [first, last]);
        assert!(bench.recorder.is_incomplete && bench.recorder.has_dropped);
    }

    /// A header counts only when rows that fit it follow.
    #[test]
    fn other_columns_end_it_and_a_header_without_rows_is_rejected() {
        let mut bench = Bench::new(RecorderOptions::default());
        bench.rows(150);
        let alone = b"t_ms,ax,ay,az,gx,gy,gz\n# a comment\n";
        bench.recorder.bytes(bench.now_s, alone).unwrap();
        bench.rows(2);
        let rejected = "# rejected: t_ms,ax,ay,az,gx,gy,gz\n# a comment\n1500,";
        assert!(bench.text.contains(rejected), "{}", bench.text);
        // Other columns, also with several words each, and the same in another unit.
        for header in [
            "t (ms),a x (g),a y (g),a z (g),b",
            "t_ms\tax\tay\taz\tgx",
            "t_ms,ax (g),ay (g),az (g)",
        ] {
            let delimiter = if header.contains(',') { "," } else { "\t" };
            let fields = header.split(delimiter).count();
            let row = vec!["1.5"; fields].join(delimiter);
            let lines = format!("{header}\n{row}\n\n{row}\n{row}\n");
            let mut bench = Bench::new(RecorderOptions::default());
            bench.rows(150);
            let error = bench.recorder.bytes(bench.now_s, lines.as_bytes());
            assert_eq!(error.unwrap_err().code(), "columns-changed", "{header}");
        }
    }

    #[test]
    fn rows_from_before_a_reset_are_dropped() {
        const HEADER: &str = "t_ms,ax (g),ay (g),az (g)\n";
        const SETTINGS: &str = "# gravical mpu6050_logger 1.2, MPU6050, accelerometer +-2 g, gyroscope +-250 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 0\n";
        // It is silent, or it says who it is.
        for (silence_s, lines) in [(1.8, ""), (0.1, SETTINGS)] {
            let mut bench = Bench::new(RecorderOptions::default());
            bench.recorder.drop_held(|_| false);
            bench.rows(20);
            bench.pass(silence_s);
            bench.stamp_ms = 0;
            let lines = format!("{lines}{HEADER}");
            bench.recorder.bytes(bench.now_s, lines.as_bytes()).unwrap();
            bench.rows(150);
            assert!(bench.text.starts_with(&lines) && bench.gaps().is_empty());
            assert_eq!(bench.recorder.counts.rows, 150);
        }
    }

    /// Whatever arrives: what is written are whole lines, the reader of the file finds as many rows as are
    /// counted, and rejects none.
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
            "t,ax,ay,az,gx\n",
            "t;ax;ay;az\n",
            "1,2,3,4,5\n",
            "# gap: unlikely\n",
        ];
        let starts = ["", "t,ax,ay,az\n", "ax;ay;az\n"].iter().cycle();
        for (seed, start) in (1_u64..60).zip(starts) {
            let mut random = seed;
            let mut bench = Bench::new(RecorderOptions::default());
            bench.recorder.bytes(0.0, start.as_bytes()).unwrap();
            bench.rows(130);
            let mut done = Ok(());
            for _ in 0..500 {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                let now_s = bench.now_s;
                let recorder = &mut bench.recorder;
                done = match random >> 58 {
                    0 => recorder.toggle_pause(now_s),
                    1 => {
                        recorder.lost("why");
                        recorder.opened(now_s, "port", None, String::new());
                        Ok(())
                    }
                    2 => recorder.overflow(random >> 50),
                    3..8 => recorder.bytes(now_s, &random.to_le_bytes()),
                    n => recorder.bytes(now_s, pieces[n as usize % pieces.len()].as_bytes()),
                };
                bench.pass(0.01);
                // As other columns do.
                if done.is_err() {
                    break;
                }
            }
            if done.is_ok() {
                done = bench.recorder.finish(bench.now_s);
                assert!(done.is_ok() || bench.recorder.counts.rows == 0);
            }
            let lines = bench.recorder.take().lines;
            let text = bench.text + &String::from_utf8_lossy(&lines);
            assert!(text.is_empty() || text.ends_with('\n'));
            // Noise alone is no recording.
            if bench.recorder.counts.rows < 130 {
                continue;
            }
            let mut reader = reader(&RecorderOptions::default(), false);
            let kinds = reader.classify(text.as_bytes(), true);
            let kinds = kinds.unwrap_or_else(|e| panic!("{e}: {seed}\n{text}"));
            let is_row = |kind: &&LineKind| matches!(kind, LineKind::Row(_));
            let rows = kinds.iter().filter(is_row).count();
            assert_eq!(rows as u64, bench.recorder.counts.rows, "{seed}\n{text}");
            assert!(!kinds.contains(&LineKind::Rejected), "{seed}\n{text}");
        }
    }
}
