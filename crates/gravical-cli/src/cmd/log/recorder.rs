//! The life of a recording: bytes of the board, keys and time in; lines for the file, commands for
//! the board and events out. It has no clock and no I/O: time is an argument, in seconds on any
//! clock that only advances. The reader of recordings decides what a row is: it reads the lines as
//! they will stand in the file.

use std::collections::VecDeque;

use gravical::escape::shown;
use gravical::recording::{ColumnsSpec, Follow, LineKind, ReadOptions};
use gravical::{Error, Result};

use super::Args;
use super::event::{Counts, End, Event};
use super::gap::{Cause, GAP_STEPS, Gaps};
use super::lines::{Line, Prefixes, Splitter};
use crate::device::board::Settings;
use crate::device::serial::{JUDGED_BYTES, no_rows};

/// The last rows are judged: so many, up to twice as many.
const JUDGED_ROWS: usize = 10_000;
/// The format of a slow board is that of the rows of this time, s; and time between two attempts to
/// detect it, s.
const MAX_HELD_S: f64 = 6.0;
const RETRY_S: f64 = 0.5;
/// Without a row, and without settings that were sent, for this time something is wrong, s.
const NO_ROWS_S: f64 = 8.0;
/// Nothing for this time is a silence, s; for a slow board more.
const SILENCE_S: f64 = 3.0;
/// Opening a port resets the board within this time, and then it is silent for that time, s.
const RESET_S: f64 = 4.0;
const RESET_SILENCE_S: f64 = 1.5;
/// A board that was reset by opening its port takes commands after this time, s.
const COMMAND_S: f64 = 2.5;
/// Characters of a rejected line in a message.
const QUOTED: usize = 60;

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
    /// What was said to arrive in place of rows.
    said: Option<String>,
}

/// One recording.
pub struct Recorder {
    pub args: Args,
    /// Time of day at the time zero, s (UTC).
    day_s: f64,
    /// The board has the settings that are wanted; until then its lines are dropped.
    is_set: bool,
    /// Lines are written; until the reader knows their format they are held.
    is_writing: bool,
    /// When the format of few lines is tried next, s.
    next_s: f64,
    /// Why it ended.
    pub end: Option<End>,
    port: Option<Port>,
    pub reader: Follow,
    /// Comes before the next line of the file.
    preamble: String,
    prefixes: Prefixes,
    /// Lines that the reader has not judged.
    waiting: VecDeque<Line>,
    gaps: Gaps,
    pub counts: Counts,
    /// Time of the first row, later by all pauses since, s.
    began_s: f64,
    paused_from_s: Option<f64>,
    /// Rows are missing, or may be.
    pub is_incomplete: bool,
    /// What has to be done: whole lines for the file, commands for the board, what is told.
    pub text: Vec<u8>,
    pub commands: String,
    pub events: Vec<Event>,
}

impl Recorder {
    /// A recording without a port. `before`: the beginning of the file that it continues; empty for a
    /// new one.
    ///
    /// # Errors
    ///
    /// Those of the reader for the file that is continued.
    pub fn new(args: Args, day_s: f64, before: &[u8]) -> Result<Self> {
        let columns = args.board.columns.clone().filter(|_| before.is_empty());
        let mut reader = reader(&args, columns);
        let mut gaps = Gaps::default();
        if !before.is_empty() {
            reader.push(before)?;
            reader.settle()?;
            gaps.open(Cause::Continued);
        }
        Ok(Recorder {
            is_set: args.board.wanted.commands().is_empty(),
            is_writing: reader.form().is_some(),
            next_s: 0.0,
            args,
            day_s,
            end: None,
            port: None,
            reader,
            preamble: String::new(),
            prefixes: Prefixes::of_file(before, day_s),
            waiting: VecDeque::new(),
            gaps,
            counts: Counts::default(),
            began_s: f64::INFINITY,
            paused_from_s: None,
            is_incomplete: false,
            text: Vec::new(),
            commands: String::new(),
            events: Vec::new(),
        })
    }

    /// Whether nothing has arrived for a while, or the port is lost; not in a pause.
    pub fn is_silent(&self) -> bool {
        !self.is_paused() && self.port.as_ref().is_none_or(|port| port.is_silent)
    }

    /// Whether rows are not stored, as the user wants it.
    pub fn is_paused(&self) -> bool {
        self.paused_from_s.is_some()
    }

    /// Seconds since the first row, without pauses.
    pub fn elapsed_s(&self, now_s: f64) -> f64 {
        (self.paused_from_s.unwrap_or(now_s) - self.began_s).max(0.0)
    }

    /// Tells an event.
    pub fn say(&mut self, event: Event) {
        self.events.push(event);
    }

    // Inputs.

    /// A port was opened; `device` is the device behind it. `preamble` becomes the first line of the
    /// file.
    pub fn opened(&mut self, now_s: f64, port: &str, device: Option<String>, preamble: String) {
        if self.counts.rows == 0 {
            self.preamble = preamble;
        }
        let port = port.to_owned();
        self.port = Some(Port {
            name: port.clone(),
            opened_s: now_s,
            ..Port::default()
        });
        self.say(Event::Opened { port, device });
    }

    /// The port is lost; `why` is the system's message.
    pub fn lost(&mut self, why: &str) {
        self.port = None;
        if self.counts.rows > 0 {
            self.gaps.open(Cause::Unplugged);
        }
        self.drop_held(|_| false);
        let text = why.to_owned();
        self.say(Event::Lost { text });
    }

    /// Bytes of the board.
    ///
    /// # Errors
    ///
    /// Those that end the recording: the board sends other rows than before, or none.
    pub fn bytes(&mut self, now_s: f64, bytes: &[u8]) -> Result<()> {
        let Some(port) = &mut self.port else {
            return Ok(());
        };
        let last_s = port.last_bytes_s.replace(now_s).unwrap_or(now_s);
        port.is_silent = false;
        port.received.extend_from_slice(bytes);
        let old = port.received.len().saturating_sub(JUDGED_BYTES);
        port.received.drain(..old);
        let lines = port.splitter.push(bytes);
        if now_s - last_s >= RESET_SILENCE_S && now_s - port.opened_s < RESET_S {
            let begins_word = |line: &Line| line.text.first().is_some_and(u8::is_ascii_alphabetic);
            self.drop_held(|line| line.is_comment() || begins_word(line));
        }
        let mut lines = lines.into_iter();
        lines.try_for_each(|(line, is_whole)| self.line(now_s, line, is_whole))
    }

    /// The space bar. Three blank lines stand for a pause.
    ///
    /// # Errors
    ///
    /// Those of the reader.
    pub fn toggle_pause(&mut self, now_s: f64) -> Result<()> {
        if self.counts.rows == 0 || self.end.is_some() {
            return Ok(());
        }
        let Some(from_s) = self.paused_from_s.take() else {
            self.paused_from_s = Some(now_s);
            self.say(Event::Paused);
            return Ok(());
        };
        self.began_s += now_s - from_s;
        self.gaps.resume(now_s, self.port.is_some());
        self.say(Event::Resumed);
        (0..3).try_for_each(|_| self.add(Line::plain(now_s, "")))
    }

    /// Time passes.
    ///
    /// # Errors
    ///
    /// Those that end the recording.
    pub fn tick(&mut self, now_s: f64) -> Result<()> {
        if !self.is_set {
            return self.set(now_s);
        }
        if self.is_writing {
            self.notice_silence(now_s);
            self.end_at(now_s);
        } else {
            self.begin(now_s, false)?;
        }
        if self.counts.rows == 0 && self.is_due(now_s) {
            return self.report_no_rows();
        }
        Ok(())
    }

    /// The user ends it: what is held is written.
    ///
    /// # Errors
    ///
    /// Those of the reader.
    pub fn finish(&mut self, now_s: f64) -> Result<()> {
        self.begin(now_s, true)?;
        self.end_at(now_s);
        self.end.get_or_insert(End::User);
        Ok(())
    }

    // Lines.

    /// A line of the board, without its end.
    fn line(&mut self, now_s: f64, text: Vec<u8>, is_whole: bool) -> Result<()> {
        if text.starts_with(b"#") {
            let text = String::from_utf8_lossy(&text);
            let shown = shown(&text).into_owned();
            self.say(Event::Board { text: shown });
            if let Some(settings) = Settings::parse(&text) {
                self.settings_are(now_s, &settings);
            }
        } else if self.is_paused() {
            return Ok(());
        }
        if self.end.is_some() || !self.is_set {
            return Ok(());
        }
        // Of numbers whose beginning was not received the first may lack digits.
        if is_whole || text.iter().any(u8::is_ascii_alphabetic) {
            let (at_s, prefix) = (now_s, self.prefixes.before(&text, now_s));
            return self.add(Line { at_s, prefix, text });
        }
        if self.is_writing {
            self.reject(&text);
        }
        Ok(())
    }

    /// Passes a line to the reader, and writes what that has judged: from the line on by which it knows
    /// the format.
    fn add(&mut self, line: Line) -> Result<()> {
        let read = self.reader.push(&line.in_file());
        self.waiting.push_back(line);
        if self.is_writing {
            read.map_err(|error| unreadable(&error))?;
            self.write_judged();
            return Ok(());
        }
        if read.is_err() {
            // So many lines without a format are no recording.
            self.drop_held(|_| false);
            return self.report_no_rows();
        }
        self.write_held()
    }

    /// Takes what is held as it is, after a while or at the end.
    fn begin(&mut self, now_s: f64, is_last: bool) -> Result<()> {
        let held_s = self.waiting.front().map_or(0.0, |line| now_s - line.at_s);
        let is_time = now_s >= self.next_s && (self.is_due(now_s) || held_s >= MAX_HELD_S);
        if self.is_writing || !is_last && !is_time {
            return Ok(());
        }
        self.next_s = now_s + RETRY_S;
        // Lines that are no recording may be one with those that follow.
        let _ = self.reader.settle();
        self.write_held()
    }

    /// Writes the lines that were held, and those that follow, once their format is known.
    fn write_held(&mut self) -> Result<()> {
        let Some(form) = self.reader.form() else {
            return Ok(());
        };
        self.is_writing = true;
        let columns = self.args.board.columns.clone();
        self.prefixes = Prefixes::new(&form, columns.is_some(), self.day_s);
        let mut header = self.prefixes.header(&form);
        self.reader = reader(&self.args, columns.filter(|_| header.is_none()));
        for (at, mut line) in std::mem::take(&mut self.waiting).into_iter().enumerate() {
            if at == form.head_lines
                && let Some(header) = header.take()
            {
                self.add(Line::plain(line.at_s, header))?;
            }
            if at >= form.head_lines || at + 1 == form.header_line {
                line.prefix = self.prefixes.before(&line.text, line.at_s);
            }
            self.add(line)?;
        }
        self.reader.settle().map_err(|error| unreadable(&error))?;
        self.write_judged();
        Ok(())
    }

    /// Writes the lines that the reader has judged.
    fn write_judged(&mut self) {
        for kind in self.reader.lines().to_vec() {
            let Some(line) = self.waiting.pop_front() else {
                return;
            };
            if let LineKind::Row(stamp) = kind {
                self.begin_row(line.at_s, stamp);
            }
            if self.end.is_some() {
                return;
            }
            match kind {
                LineKind::Rejected => self.reject(&line.text),
                _ => self.write(&line.in_file()),
            }
        }
    }

    /// A row follows, unless it ends here.
    fn begin_row(&mut self, at_s: f64, stamp: f64) {
        self.began_s = self.began_s.min(at_s);
        self.end_at(at_s);
        if self.end.is_some() {
            return;
        }
        if self.counts.rows == 0 {
            let roles = self.reader.form().map(|form| form.roles);
            let columns = roles.unwrap_or_default().join(",");
            self.say(Event::Started { columns });
        }
        // Times of arrival do not tell what is missing.
        let stamp = Some(stamp).filter(|stamp| self.prefixes.has_clock && !stamp.is_nan());
        let (rate_hz, max_s) = (self.rate_hz(), self.silence_s());
        if let Some(gap) = self.gaps.before_row(at_s, stamp, rate_hz, max_s) {
            self.write(format!("{}\n", gap.line()).as_bytes());
            self.counts.gaps += 1;
            let missing = gap.rows.unwrap_or(0);
            self.counts.missing = self.counts.missing.saturating_add(missing);
            self.is_incomplete |= gap.rows != Some(0) && gap.cause != Cause::Continued;
            self.say(Event::Gap(gap));
        }
        self.counts.rows += 1;
    }

    /// Ends it once all that was asked for is there.
    fn end_at(&mut self, now_s: f64) {
        let elapsed_s = self.elapsed_s(now_s);
        if self.args.rows == Some(self.counts.rows) {
            self.end.get_or_insert(End::Rows);
        } else if self.args.duration.is_some_and(|max_s| elapsed_s >= max_s) {
            self.end.get_or_insert(End::Duration);
        }
    }

    fn rate_hz(&self) -> Option<f64> {
        self.reader.form()?.rate_hz
    }

    /// Writes a whole line.
    fn write(&mut self, line: &[u8]) {
        let preamble = std::mem::take(&mut self.preamble);
        self.text.extend_from_slice(preamble.as_bytes());
        self.text.extend_from_slice(line);
    }

    /// Writes a line that is no row, or a part of a line.
    fn reject(&mut self, line: &[u8]) {
        let text = String::from_utf8_lossy(line);
        let text = shown(text.trim());
        if text.is_empty() {
            return;
        }
        self.counts.rejected += 1;
        self.gaps.rejected += 1;
        let count = self.counts.rejected;
        if count.is_power_of_two() {
            let line = text.chars().take(QUOTED).collect();
            self.say(Event::Rejected { count, line });
        }
        self.write(format!("# rejected: {text}\n").as_bytes());
    }

    /// Lines whose format is not known are of another start, but for those that are kept.
    fn drop_held(&mut self, keeps: impl Fn(&Line) -> bool) {
        if !self.is_writing {
            self.waiting.retain(keeps);
            self.reader = reader(&self.args, self.args.board.columns.clone());
            for line in &self.waiting {
                // Too few to be no recording.
                let _ = self.reader.push(&line.in_file());
            }
        }
    }

    // Without rows.

    /// Rows should have arrived.
    fn is_due(&self, now_s: f64) -> bool {
        let port = self.port.as_ref();
        port.is_some_and(|port| now_s - port.opened_s >= NO_ROWS_S)
    }

    /// After a while without a row it is said what arrives instead.
    fn report_no_rows(&mut self) -> Result<()> {
        let Some(port) = &mut self.port else {
            return Ok(());
        };
        let error = no_rows(&port.name, &port.received);
        let hint = error.hint().unwrap_or_default().to_owned();
        if !self.args.board.wait {
            return Err(error.with_hint(format!("{hint}; --wait waits without end")));
        }
        if port.said.as_ref() != Some(&hint) {
            let text = format!("{}; {hint}", error.message());
            port.said = Some(hint);
            self.say(Event::Warning { text });
        }
        Ok(())
    }

    /// Nothing for this time is a silence, s.
    fn silence_s(&self) -> f64 {
        SILENCE_S.max(GAP_STEPS / self.rate_hz().unwrap_or(1.0))
    }

    /// A board that has sent rows is silent: some may be missing.
    fn notice_silence(&mut self, now_s: f64) {
        let max_s = self.silence_s();
        if let Some(port) = self.port.as_mut().filter(|port| !port.is_silent) {
            let duration_s = now_s - port.last_bytes_s.unwrap_or(port.opened_s);
            port.is_silent = duration_s >= max_s;
            if port.is_silent {
                self.say(Event::Silent { duration_s });
            }
        }
    }

    // Settings.

    fn settings_are(&mut self, now_s: f64, settings: &Settings) {
        let is_met = self.args.board.wanted.is_met_by(settings);
        if !self.is_set {
            self.is_set = is_met;
            // Rows are waited for from now on.
            if let Some(port) = self.port.as_mut().filter(|_| is_met) {
                port.opened_s = now_s;
            }
        } else if !self.is_writing {
            // Rows before are of another start, or have no header.
            self.drop_held(Line::is_comment);
        } else if !is_met {
            let text = "the board was reset and has other settings than those asked for";
            let text = text.to_owned();
            self.say(Event::Warning { text });
        }
    }

    /// Sends the settings that are wanted, once; that they are in vain is an error.
    fn set(&mut self, now_s: f64) -> Result<()> {
        let is_due = self.is_due(now_s);
        let Some(port) = &mut self.port else {
            return Ok(());
        };
        match port.sent_s {
            _ if port.received.is_empty() && is_due => self.report_no_rows(),
            None if !port.received.is_empty() && now_s - port.opened_s >= COMMAND_S => {
                port.sent_s = Some(now_s);
                self.commands += &self.args.board.wanted.commands();
                Ok(())
            }
            Some(sent_s) if now_s - sent_s >= NO_ROWS_S => {
                let text = "the board does not report the settings that were sent to it";
                let hint = "upload firmware/mpu6050_logger to the board, or leave the settings out";
                Err(Error::device("settings-refused", text).with_hint(hint))
            }
            _ => Ok(()),
        }
    }
}

/// A reader of the file.
fn reader(args: &Args, columns: Option<ColumnsSpec>) -> Follow {
    let options = ReadOptions {
        columns,
        ..ReadOptions::default()
    };
    Follow::new(&args.file().display().to_string(), options, JUDGED_ROWS)
}

/// The error of rows that cannot be read as those before.
fn unreadable(error: &Error) -> Error {
    let (code, what) = match error.code() {
        "header-differs" => (
            "columns-changed",
            "the board sends rows of other columns or units than before",
        ),
        _ => ("unreadable-rows", "the rows cannot be read any more"),
    };
    let text = format!("{what} ({}): the recording ends", error.message());
    Error::device(code, text).with_hint(
        "the rows up to here are in the file; record the rest into another one, or set the board as it was (--format, --range)",
    )
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
        fn new(args: Args) -> Self {
            let mut recorder = Recorder::new(args, 0.0, b"").unwrap();
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
            self.recorder.tick(self.now_s).unwrap();
            let text = std::mem::take(&mut self.recorder.text);
            self.text += std::str::from_utf8(&text).unwrap();
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
        let mut bench = Bench::new(Args {
            duration: Some(20.0),
            ..Args::default()
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
    fn rows_from_before_a_reset_are_dropped() {
        const HEADER: &str = "t_ms,ax (g),ay (g),az (g)\n";
        const SETTINGS: &str = "# gravical mpu6050_logger 1.2, MPU6050, accelerometer +-2 g, gyroscope +-250 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 0\n";
        // It is silent, or it says who it is.
        for (silence_s, lines) in [(1.8, ""), (0.1, SETTINGS)] {
            let mut bench = Bench::new(Args::default());
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
            let mut bench = Bench::new(Args::default());
            bench.recorder.bytes(0.0, start.as_bytes()).unwrap();
            bench.rows(130);
            for _ in 0..3000 {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                match random >> 58 {
                    0 => drop(bench.recorder.toggle_pause(bench.now_s)),
                    1 => bench.recorder.lost("why"),
                    2 => bench
                        .recorder
                        .opened(bench.now_s, "port", None, String::new()),
                    n => {
                        let piece = pieces[n as usize % pieces.len()];
                        let _ = bench.recorder.bytes(bench.now_s, piece.as_bytes());
                    }
                }
                bench.pass(0.01);
            }
            bench.recorder.finish(bench.now_s).unwrap();
            bench.pass(0.0);
            assert!(bench.text.is_empty() || bench.text.ends_with('\n'));
        }
    }
}
