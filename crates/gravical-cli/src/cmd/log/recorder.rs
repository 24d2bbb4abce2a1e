//! The life of a recording: bytes of the board, keys and time in; lines for the file, commands for
//! the board and events out. It has no clock and no I/O: time is an argument, in seconds on any
//! clock that only advances.

use std::mem::{Discriminant, discriminant};

use gravical::escape::shown;
use gravical::{Error, Result};

use super::event::{Counts, End, Event};
use super::gaps::Cause;
use super::lines::Splitter;
use super::pending::Pending;
use super::writing::{Line, Options, Output, Writing};
use crate::device::board::Settings;
use crate::device::trouble::{JUDGED_BYTES, NoRows};

/// Without a row for this time something is wrong, s.
const NO_ROWS_S: f64 = 8.0;
/// Nothing for this time is a silence, s; for a slow board more.
const SILENCE_S: f64 = 3.0;
/// A board that was reset by opening its port reports its settings within this time, or is told
/// them then, and so many times again, s.
const COMMAND_S: f64 = 2.5;
const MAX_COMMANDS: u32 = 4;
/// A board of ours answers a question within this time, s.
const ASK_S: f64 = 1.5;
/// Opening a port resets the board within this time, s.
const RESET_S: f64 = 4.0;

/// Where the lines go. In each state the port may be lost and found.
enum State {
    /// Their format is not known.
    Pending(Box<Pending>),
    /// They are written.
    Writing(Box<Writing>),
}

/// Settings that are wanted, and that the board has not confirmed. Until then lines are dropped.
#[derive(Clone, Copy)]
struct Setting {
    /// When they are sent, s, and how often they were.
    next_s: f64,
    sent: u32,
}

/// A port that is open.
struct Port {
    name: String,
    opened_s: f64,
    last_bytes_s: Option<f64>,
    /// The last bytes.
    received: Vec<u8>,
    splitter: Splitter,
    is_silent: bool,
    /// What was said to arrive in place of rows.
    said: Option<Discriminant<NoRows>>,
}

/// One recording.
pub struct Recorder {
    options: Options,
    state: State,
    setting: Option<Setting>,
    port: Option<Port>,
    /// It ended before a line was written.
    is_over: bool,
    error: Option<Error>,
    pub out: Output,
}

impl Recorder {
    /// A recording without a port. `before`: the beginning of the file that it continues; empty for a
    /// new one.
    ///
    /// # Errors
    ///
    /// Those of the reader for the file that is continued.
    pub fn new(options: Options, before: &[u8]) -> Result<Self> {
        let state = if before.is_empty() {
            State::Pending(Box::new(Pending::new(&options)))
        } else {
            State::Writing(Box::new(Writing::continued(&options, before)?))
        };
        let is_set = options.wanted.commands().is_empty();
        let (next_s, sent) = (COMMAND_S, 0);
        Ok(Recorder {
            options,
            state,
            setting: (!is_set).then_some(Setting { next_s, sent }),
            port: None,
            is_over: false,
            error: None,
            out: Output::default(),
        })
    }

    // Queries.

    /// The lines that are written, once their format is known.
    pub fn writing(&self) -> Option<&Writing> {
        match &self.state {
            State::Writing(writing) => Some(writing),
            State::Pending(_) => None,
        }
    }

    /// How many lines went where.
    pub fn counts(&self) -> Counts {
        self.writing().map_or(Counts::default(), |w| w.counts)
    }

    /// Why it ended.
    pub fn end(&self) -> Option<End> {
        let end = self.writing().and_then(|writing| writing.end);
        end.or(self.is_over.then_some(End::User))
    }

    /// Why it failed; once.
    pub fn take_error(&mut self) -> Option<Error> {
        self.error.take()
    }

    // Inputs.

    /// A port was opened; `device` is the device behind it. `preamble` becomes the first line of the
    /// file.
    pub fn opened(&mut self, now_s: f64, port: &str, device: Option<String>, preamble: String) {
        if self.counts().rows == 0 {
            self.out.preamble = preamble;
        }
        if let Some(setting) = &mut self.setting {
            let (next_s, sent) = (now_s + COMMAND_S, 0);
            *setting = Setting { next_s, sent };
        }
        self.port = Some(Port {
            name: port.to_owned(),
            opened_s: now_s,
            last_bytes_s: None,
            received: Vec::new(),
            splitter: Splitter::default(),
            is_silent: false,
            said: None,
        });
        let port = port.to_owned();
        self.say(Event::Opened { port, device });
    }

    /// The port is lost; `why` is the system's message.
    pub fn lost(&mut self, now_s: f64, why: &str) {
        let port = self.port.take();
        let half = port.map_or(Vec::new(), |mut port| port.splitter.cut());
        match &mut self.state {
            // No line counts yet.
            _ if self.setting.is_some() => {}
            State::Writing(writing) => {
                let done = writing.reject(now_s, &half, &mut self.out);
                writing.gaps.open(Cause::Unplugged);
                self.check(done);
            }
            // Lines of another start of the board.
            State::Pending(_) => self.drop_pending("before the port was lost"),
        }
        let text = why.to_owned();
        self.say(Event::Lost { text });
    }

    /// Bytes of the board.
    pub fn bytes(&mut self, now_s: f64, bytes: &[u8]) {
        let Some(port) = &mut self.port else { return };
        let last_bytes_s = port.last_bytes_s.replace(now_s);
        let silence_s = last_bytes_s.map_or(0.0, |last_s| now_s - last_s);
        port.is_silent = false;
        port.received.extend_from_slice(bytes);
        let old = port.received.len().saturating_sub(JUDGED_BYTES);
        port.received.drain(..old);
        let lines = port.splitter.push(bytes);
        if now_s - port.opened_s < RESET_S
            && let State::Pending(pending) = &mut self.state
            && pending.ends_in_reset(silence_s)
        {
            self.drop_pending("before it was reset by opening the port");
        }
        for (line, is_whole) in lines {
            self.line(now_s, line, is_whole);
        }
    }

    /// The space bar.
    pub fn toggle_pause(&mut self, now_s: f64) {
        if let State::Writing(writing) = &mut self.state {
            let done = writing.toggle_pause(now_s, &mut self.out);
            self.check(done);
        }
    }

    /// Time passes.
    pub fn tick(&mut self, now_s: f64) {
        if self.error.is_some() || self.end().is_some() {
            return;
        }
        let is_heard = self.port.as_ref().is_some_and(|p| p.last_bytes_s.is_some());
        if self.setting.is_some_and(|s| is_heard && now_s >= s.next_s) {
            self.send_settings(now_s);
        }
        self.begin(now_s, false);
        if let State::Writing(writing) = &mut self.state {
            writing.tick(now_s, &mut self.out);
        }
        self.diagnose(now_s);
        self.notice_silence(now_s);
    }

    /// Reports what is reported once a second.
    pub fn report_rejected(&mut self) {
        if let State::Writing(writing) = &mut self.state {
            writing.report_rejected(&mut self.out);
        }
    }

    /// The recording ends: what has begun is closed.
    pub fn finish(&mut self, now_s: f64) {
        if self.error.is_none() {
            self.begin(now_s, true);
        }
        self.is_over = true;
        if let State::Writing(writing) = &mut self.state {
            writing.finish(now_s, &mut self.out);
        }
    }

    /// Tells an event.
    pub fn say(&mut self, event: Event) {
        self.out.events.push(event);
    }

    // Lines.

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
        if self.setting.is_some() || self.error.is_some() {
            return;
        }
        // Of numbers whose beginning was not received the first may lack digits.
        let is_half = !is_whole && !line.iter().any(u8::is_ascii_alphabetic);
        let done = match &mut self.state {
            State::Writing(writing) if is_half => writing.reject(now_s, &line, &mut self.out),
            State::Writing(writing) => writing.line(now_s, &line, &mut self.out),
            State::Pending(_) if is_half => Ok(()),
            State::Pending(pending) => pending.push(Line::plain(now_s, line)),
        };
        self.check(done);
    }

    /// The format may be known, so that writing begins. `is_last`: nothing follows.
    fn begin(&mut self, now_s: f64, is_last: bool) {
        let State::Pending(pending) = &mut self.state else {
            return;
        };
        let is_late = is_last || self.port.as_ref().is_some_and(|p| p.is_due(now_s));
        let Some(form) = pending.form(now_s, is_late) else {
            return;
        };
        let commands = &mut self.out.commands;
        if form.header_line == 0 && form.delimiter.is_some() && !is_last {
            // A board that names no columns is asked for its settings.
            let until_s = *pending.asked_until_s.get_or_insert_with(|| {
                commands.push_str("?\n");
                now_s + ASK_S
            });
            if now_s < until_s {
                return;
            }
        }
        let lines = std::mem::take(&mut pending.lines);
        match Writing::begun(&self.options, &form, lines, &mut self.out) {
            Ok(writing) => self.state = State::Writing(Box::new(writing)),
            Err(error) => self.fail(error),
        }
    }

    /// The reader may refuse a line.
    fn check(&mut self, read: Result<()>) {
        let Err(error) = read else { return };
        if let State::Pending(pending) = &mut self.state {
            **pending = Pending::new(&self.options);
            return self.say_no_rows();
        }
        let (code, what, set) = if error.code() == "header-differs" {
            let what = "the board sends rows of other columns or units than before";
            let set = ", or set the board as it was: --format, --range";
            ("columns-changed", what, set)
        } else {
            ("unreadable-rows", "the rows cannot be read any more", "")
        };
        let text = format!("{what} ({}): the recording ends", error.message());
        let hint = "the rows up to here are in the file; record the rest into another one";
        self.fail(Error::device(code, text).with_hint(format!("{hint}{set}")));
    }

    fn fail(&mut self, error: Error) {
        self.error.get_or_insert(error);
    }

    /// Lines whose format is not known are dropped, and that is said.
    fn drop_pending(&mut self, when: &str) {
        if let State::Pending(pending) = &mut self.state {
            let lines = pending.lines.len();
            **pending = Pending::new(&self.options);
            if lines > 0 {
                let text = format!("{lines} lines that the board sent {when} are not recorded");
                self.say(Event::Warning { text });
            }
        }
    }

    // Without rows.

    /// After a while without a row it is said what arrives instead.
    fn diagnose(&mut self, now_s: f64) {
        let has_rows = match &self.state {
            State::Writing(writing) => writing.counts.rows > 0,
            State::Pending(pending) => pending.is_known(),
        };
        let is_due = self.port.as_ref().is_some_and(|port| {
            // Settings that are not confirmed have their own end.
            port.is_due(now_s) && (self.setting.is_none() || port.last_bytes_s.is_none())
        });
        if is_due && !has_rows {
            self.say_no_rows();
        }
    }

    fn say_no_rows(&mut self) {
        let Some(port) = &mut self.port else { return };
        let why = NoRows::of(&port.received);
        let error = why.error(&port.name);
        let hint = error.hint().unwrap_or_default().to_owned();
        if !self.options.wait {
            self.fail(error.with_hint(format!("{hint}; --wait waits without end")));
        } else if port.said.replace(discriminant(&why)) != Some(discriminant(&why)) {
            let text = error.message().to_owned();
            self.say(Event::NoRows { text, hint });
        }
    }

    /// A board that has sent rows is silent: some may be missing.
    fn notice_silence(&mut self, now_s: f64) {
        if let State::Writing(writing) = &mut self.state
            && let Some(port) = &mut self.port
            && !port.is_silent
        {
            let duration_s = now_s - port.last_bytes_s.unwrap_or(port.opened_s);
            if duration_s >= writing.silence_s(SILENCE_S) {
                port.is_silent = true;
                writing.gaps.open(Cause::Silent);
                self.say(Event::Silent { duration_s });
            }
        }
    }

    // Settings.

    fn settings_are(&mut self, now_s: f64, settings: &Settings) {
        let is_met = self.options.wanted.is_met_by(settings);
        match (self.setting, &mut self.state) {
            (Some(_), _) if is_met => {
                self.setting = None;
                // Rows are waited for from now on.
                if let Some(port) = &mut self.port {
                    port.opened_s = now_s;
                }
            }
            (Some(Setting { sent: 0, .. }), _) => self.send_settings(now_s),
            (Some(_), _) => {}
            // Rows before are of another start, or have no header.
            (None, State::Pending(pending)) => {
                let mut lines = std::mem::take(&mut pending.lines);
                lines.retain(|line| line.text.starts_with(b"#"));
                **pending = Pending::new(&self.options);
                let done = lines.into_iter().try_for_each(|line| pending.push(line));
                self.check(done);
            }
            (None, State::Writing(_)) if !is_met => self.say(Event::Warning {
                text: "the board was reset and has other settings than those asked for".to_owned(),
            }),
            (None, State::Writing(_)) => {}
        }
    }

    /// Sends the settings that are wanted, unless that was in vain too often.
    fn send_settings(&mut self, now_s: f64) {
        let sent = self.setting.map_or(0, |setting| setting.sent);
        if sent >= MAX_COMMANDS {
            let text = "the board does not report the settings that were sent to it";
            let hint = "upload firmware/mpu6050_logger to the board, or leave the settings out";
            return self.fail(Error::device("settings-refused", text).with_hint(hint));
        }
        self.out.commands += &self.options.wanted.commands();
        let (next_s, sent) = (now_s + COMMAND_S, sent + 1);
        self.setting = Some(Setting { next_s, sent });
    }
}

impl Port {
    /// Rows should have arrived.
    fn is_due(&self, now_s: f64) -> bool {
        now_s - self.opened_s >= NO_ROWS_S
    }
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
            let mut recorder = Recorder::new(options, b"").unwrap();
            recorder.opened(0.0, "port", None, String::new());
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
            let out = std::mem::take(&mut self.recorder.out);
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
        assert_eq!(bench.recorder.end(), Some(End::Duration));
        assert!(bench.gaps()[1].contains("no row arrived until the end"));
        assert!(bench.recorder.writing().unwrap().ends_in_gap);
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
        assert_eq!(bench.recorder.counts().rows, 170);
        assert_eq!(bench.recorder.counts().rejected, 0);
        let (_, after) = bench.text.split_once("\n\n\n\n# gap: ").unwrap();
        assert!(after.contains("restarts\n300,"), "{after}");
        let writing = bench.recorder.writing().unwrap();
        let elapsed_s = writing.elapsed_s(bench.now_s);
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
        assert_eq!(bench.recorder.counts().rows, 8);
        assert!(bench.recorder.take_error().is_none() && bench.gaps().is_empty());
    }

    #[test]
    fn what_arrives_in_place_of_rows_is_an_error_or_is_said_once() {
        let recorder = |wait| {
            let options = Options {
                wait,
                ..Options::default()
            };
            let mut recorder = Recorder::new(options, b"").unwrap();
            recorder.opened(0.0, "port", None, String::new());
            recorder.tick(7.9);
            assert!(recorder.take_error().is_none());
            recorder.tick(8.1);
            recorder
        };
        let error = recorder(false).take_error().unwrap();
        assert_eq!(error.code(), "board-silent");
        let mut waiting = recorder(true);
        waiting.tick(9.0);
        // Now it has a sketch, which prints something else.
        waiting.bytes(9.5, b"hello\nhello\n");
        waiting.tick(10.0);
        waiting.tick(11.0);
        assert!(waiting.take_error().is_none());
        let events = waiting.out.events.into_iter();
        let said: Vec<String> = events
            .filter_map(|event| match event {
                Event::NoRows { text, .. } => Some(text),
                _ => None,
            })
            .collect();
        assert!(
            said.len() == 2 && said[0].contains("nothing arrives"),
            "{said:?}"
        );
        assert!(said[1].ends_with("\"hello\""), "{said:?}");
    }

    #[test]
    fn rows_from_before_a_reset_are_dropped_and_a_board_without_a_header_is_asked() {
        const HEADER: &str = "t_ms,ax (g),ay (g),az (g)\n";
        let mut bench = Bench::new(Options::default());
        bench.recorder.drop_pending("before");
        bench.rows(20);
        bench.pass(1.8);
        bench.stamp_ms = 0;
        bench.recorder.bytes(bench.now_s, HEADER.as_bytes());
        bench.rows(150);
        assert!(bench.text.starts_with(HEADER) && bench.gaps().is_empty());
        assert_eq!(bench.recorder.counts().rows, 150);
        assert_eq!(bench.commands, "");

        let settings = "# gravical mpu6050_logger 1.2, MPU6050, accelerometer +-2 g, gyroscope +-250 deg/s, low-pass 44 Hz, rate 100.00 Hz, format 0\n";
        for answer in [true, false] {
            let mut bench = Bench::new(Options::default());
            bench.recorder.drop_pending("before");
            bench.rows(150);
            assert_eq!((&bench.commands[..], &bench.text[..]), ("?\n", ""));
            if answer {
                let lines = format!("# a note\n{settings}{HEADER}");
                bench.recorder.bytes(bench.now_s, lines.as_bytes());
            }
            bench.rows(150);
            assert_eq!(bench.text.contains(HEADER), answer);
            let rows = if answer { 150 } else { 300 };
            assert_eq!(bench.recorder.counts().rows, rows);
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
                    2 => bench
                        .recorder
                        .opened(bench.now_s, "port", None, String::new()),
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
