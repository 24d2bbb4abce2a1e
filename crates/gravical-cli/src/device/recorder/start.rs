//! Until the board is known and set: what it says is waited for, asked for, and
//! corrected.

use gravical::Error;

use super::{Recorder, State};
use crate::device::board::{Settings, Wanted};
use crate::device::event::Event;
use crate::device::frames;
use crate::device::gap::Cause;
use crate::device::line::{Reason, Row};
use crate::device::recorder::Action;
use crate::device::wire::Coding;

/// A board that was reset by the opening speaks within about two seconds, s.
const ASK_AFTER_S: f64 = 2.5;
/// Between two questions or commands, s.
pub const ASK_AGAIN_S: f64 = 1.5;
/// Without a header for so long there will be none, s.
const NO_HEADER_S: f64 = 6.0;
/// Without a row for so long something is wrong, s.
const NO_ROWS_S: f64 = 8.0;
/// So often commands are sent.
const TRIES: u32 = 4;
/// Rows that are held before the start.
const HELD: usize = 5000;
/// So many of the last lines of the board are held, and the one of its settings.
const SAID: usize = 20;
/// A board that says nothing that makes sense after a command for so long does not take
/// it, s.
const NO_ANSWER_S: f64 = 15.0;
/// What the report's boards send, where none says so.
const COLUMNS: &str = "Timestamp,ax,ay,az,temp,gx,gy,gz";

/// What is known before the first row.
#[derive(Debug, Default)]
pub struct Start {
    /// How the board says that it is set.
    pub settings: Option<Settings>,
    pub columns: Option<Vec<u8>>,
    /// How the board spoke when it began.
    pub coding: Coding,
    first_command_s: Option<f64>,
    /// What has to come back after a reset.
    pub expected: Option<Wanted>,
    /// A header for which it was asked, and has not said how it is set.
    other_columns: Option<Vec<u8>>,
    opened_s: f64,
    /// When the board is asked or told next, s.
    pub next_s: f64,
    /// How often it was told.
    pub tries: u32,
    waiting_told: bool,
    held: Vec<(Vec<u8>, Row)>,
    said: Vec<String>,
    /// The last line in which the board said how it is set.
    settings_line: Option<String>,
    /// When one of them came, s.
    last_row_s: f64,
    rejected: u64,
    first_rejected: Option<String>,
}

impl Start {
    pub fn opened(&mut self, now_s: f64) {
        (self.opened_s, self.last_row_s) = (now_s, now_s);
        self.next_s = now_s + ASK_AFTER_S;
        self.tries = 0;
        self.waiting_told = false;
    }

    /// Keeps a row for the case that there is no header; the number of rows that
    /// found no room.
    pub fn hold(&mut self, now_s: f64, bytes: Vec<u8>, row: Row) -> u64 {
        self.last_row_s = now_s;
        if self.held.len() < HELD {
            self.held.push((bytes, row));
            return 0;
        }
        1
    }

    pub fn forget_held(&mut self) -> u64 {
        std::mem::take(&mut self.held).len() as u64
    }

    #[cfg(test)]
    pub fn held_rows(&self) -> u64 {
        self.held.len() as u64
    }

    pub fn said(&mut self, text: &str) {
        if Settings::parse(text).is_some() {
            self.settings_line = Some(text.to_owned());
            return;
        }
        // The same once a second needs no second line.
        self.said.retain(|line| line != text);
        if self.said.len() >= SAID {
            self.said.remove(0);
        }
        self.said.push(text.to_owned());
    }

    /// Why it does not begin: nothing came, or what came instead of rows.
    fn no_rows(&self) -> Error {
        const FIRMWARE: &str =
            "is the baud rate right (--baud), and firmware/mpu6050_logger on the board?";
        let none =
            |text: String, hint: &str| Error::device("no-samples-from-board", text).with_hint(hint);
        let said = self.said.last().or(self.settings_line.as_ref());
        match (self.held.len(), said, &self.first_rejected) {
            (0, Some(said), _) => none(
                format!("no rows came from the board; the last that it said: {said:?}"),
                "what the board says tells why: the wiring of the sensor, mostly; --wait waits without end",
            ),
            (0, None, Some(first)) => none(
                format!(
                    "{} lines came from the board, none of them of 8 numbers; the first: {first:?}",
                    self.rejected
                ),
                FIRMWARE,
            ),
            (0, None, None) => Error::device(
                "board-silent",
                "the port is open, and nothing comes from the board",
            )
            .with_hint("is it the right port (gravical ports), and firmware/mpu6050_logger on the board? --wait waits without end"),
            (rows, _, _) => none(
                format!("only {rows} rows of 8 numbers came from the board, and then no more"),
                FIRMWARE,
            ),
        }
    }

    pub fn rejected(&mut self, bytes: &[u8]) {
        self.rejected += 1;
        self.first_rejected
            .get_or_insert_with(|| String::from_utf8_lossy(bytes).chars().take(60).collect());
    }
}

impl Recorder {
    fn goal(&self) -> Wanted {
        self.start.expected.unwrap_or(self.options.wanted)
    }

    /// The board said how it is set.
    pub(super) fn settings_are(&mut self, now_s: f64, settings: Settings) {
        let goal = self.goal();
        let second = match self.wire.coding() {
            Coding::Text => 1e3,
            Coding::Frames => 1e6,
        };
        self.stamps.steps_are(Some(second / settings.rate_hz));
        if !self.is_started() {
            self.start.settings = Some(settings);
        }
        if goal.is_met_by(&settings) {
            self.start.tries = 0;
            self.start.first_command_s = None;
            self.start.other_columns = None;
            if self.state == State::Restoring {
                self.state = State::Recording;
            }
            if self.state == State::Starting && self.wire.coding() == Coding::Frames {
                // There is no header between frames.
                self.start.columns = Some(frames::COLUMNS.into());
                self.start_if_ready(now_s);
            }
        } else {
            if self.is_started() {
                self.state = State::Restoring;
                self.open_gap(now_s, Cause::Settings);
            }
            if self.start.tries == 0 {
                self.command(now_s);
            }
        }
    }

    /// Sends what is wanted.
    fn command(&mut self, now_s: f64) {
        let commands = self.goal().commands();
        self.start.tries += 1;
        self.start.next_s = now_s + ASK_AGAIN_S;
        self.start.first_command_s.get_or_insert(now_s);
        let text = String::from_utf8_lossy(&commands).trim().replace('\n', " ");
        self.tell(Event::Commands { text });
        self.actions.push(Action::Send(commands));
        if let Some(format) = self.goal().format {
            self.speak(Coding::of_format(format));
        }
    }

    pub(super) fn header(&mut self, now_s: f64, bytes: Vec<u8>, whole: bool) {
        let text = bytes.trim_ascii();
        let known = self.start.columns.as_deref() == Some(text);
        let starts_up = self.state == State::Starting && self.ear.heard_its_start();
        if !whole && !known && !starts_up && !begins_with_time(text) {
            self.bad(bytes, Reason::Half);
        } else if self.state == State::Starting {
            self.start.columns = Some(text.to_vec());
            self.start_if_ready(now_s);
        } else if self.state != State::Recording || known || self.failed {
            // While it is being set it may say what it likes.
        } else if self.start.expected.is_some() && !self.spoke {
            self.start.other_columns = Some(text.to_vec());
            self.open_gap(now_s, Cause::Settings);
            self.ask_again(now_s);
        } else {
            self.fail(columns_changed(text));
        }
    }

    fn start_if_ready(&mut self, now_s: f64) {
        let wanted = self.options.wanted;
        let set = wanted.is_empty()
            || (self.start.settings).is_some_and(|settings| wanted.is_met_by(&settings));
        if set && self.start.columns.is_some() {
            // Rows before the header are of another clock, or of other settings.
            self.account.before_start += self.start.forget_held();
            self.begin(now_s);
        }
    }

    /// The head of the file; from here on rows are stored.
    fn begin(&mut self, now_s: f64) {
        let coding = self.wire.coding();
        let columns = self
            .start
            .columns
            .get_or_insert_with(|| match coding {
                Coding::Text => COLUMNS.into(),
                Coding::Frames => frames::COLUMNS.into(),
            })
            .clone();
        if let Some(header) = &self.options.continues
            && *header != columns
        {
            self.fail(
                Error::device(
                    "columns-changed",
                    format!(
                        "the file has the columns {}, the board sends {}",
                        String::from_utf8_lossy(header),
                        String::from_utf8_lossy(&columns)
                    ),
                )
                .with_hint("record into another file, or set the board as it was: --format"),
            );
            return;
        }
        self.state = State::Recording;
        self.start.coding = coding;
        self.started_s = Some(now_s);
        (self.last_row_s, self.last_status_s, self.last_bytes_s) = (now_s, now_s, now_s);
        self.start.expected = self.start.settings.as_ref().map(Wanted::exactly);
        self.start.tries = 0;
        let mut head = String::new();
        for line in &self.options.preamble {
            head.push_str(&format!("# {line}\n"));
        }
        for line in self.start.said.iter().chain(&self.start.settings_line) {
            head.push_str(&format!("{line}\n"));
        }
        if self.options.continues.is_some() {
            self.open_gap(now_s, Cause::Continued);
            self.comments = head.into_bytes();
            self.resumed = true;
        } else {
            if let Some(settings) = &self.start.settings {
                head.push_str(&format!("# rate: {:.2} Hz\n", settings.rate_hz));
            }
            self.keep.mark(head.into_bytes());
            self.keep.mark([&columns[..], b"\n"].concat());
        }
        let columns = String::from_utf8_lossy(&columns).into_owned();
        self.tell(Event::Started { columns });
    }

    /// Nothing is recorded: what is missing is asked for, in the end given up.
    pub(super) fn wait_for_the_board(&mut self, now_s: f64) {
        let waited_s = now_s - self.start.opened_s;
        if !self.start.waiting_told && self.state == State::Starting {
            self.start.waiting_told = true;
            self.tell(Event::Waiting {
                text: "the board (opening its port resets it: about two seconds of silence)"
                    .to_owned(),
            });
        }
        if self.failed {
            return;
        }
        let unmet = match (&self.start.settings, self.state) {
            (Some(settings), State::Starting) => !self.goal().is_met_by(settings),
            (None, State::Starting) => !self.goal().is_empty(),
            _ => true,
        };
        let silent = self.start.settings.is_none() && self.start.held.is_empty();
        if !unmet || silent {
            self.without_header(now_s, waited_s);
        }
        if self.failed || now_s < self.start.next_s || self.state == State::Recording {
            return;
        }
        // At a rate at which nothing makes sense nothing is understood either.
        let unsure = !self.ear.good || (self.wire.coding() == Coding::Frames && !self.ear.asked);
        let no_answer = self.state == State::Starting
            && (self.start.first_command_s).is_some_and(|since_s| now_s - since_s >= NO_ANSWER_S);
        if unmet && (self.start.tries >= TRIES || no_answer) {
            let error = match self.start.other_columns.take() {
                Some(columns) => columns_changed(&columns),
                None => settings_refused(self.start.settings.is_some()),
            };
            self.fail(error);
        } else if unmet && !silent && !unsure {
            self.command(now_s);
        } else {
            self.ask(now_s);
        }
    }

    fn without_header(&mut self, now_s: f64, waited_s: f64) {
        if waited_s >= NO_HEADER_S && self.start.held.len() >= 5 {
            self.start.said(match self.wire.coding() {
                Coding::Text => "# the board named no columns: taken as the usual ones",
                Coding::Frames => "# the board did not say how it is set: the range is not known",
            });
            self.begin(now_s);
            for (bytes, row) in std::mem::take(&mut self.start.held) {
                if self.is_started() {
                    // They were counted when they came.
                    self.account.received -= 1;
                    self.row(now_s, bytes, row);
                } else {
                    self.account.before_start += 1;
                }
            }
        } else if waited_s >= NO_ROWS_S && !self.options.wait {
            // A slow board needs longer than others to show what it sends.
            if now_s - self.start.last_row_s >= NO_ROWS_S {
                self.fail(self.start.no_rows());
            }
        }
    }
}

/// Whether the first name is one of those that a stamp has, and no rest of one:
/// `stamp (ms)` is not.
fn begins_with_time(header: &[u8]) -> bool {
    let ends = |b: &u8| !b.is_ascii_alphanumeric();
    let word = header.trim_ascii_start().split(ends).next();
    [&b"timestamp"[..], b"time", b"t", b"millis", b"micros"]
        .iter()
        .any(|name| word.is_some_and(|word| word.eq_ignore_ascii_case(name)))
}

fn columns_changed(columns: &[u8]) -> Error {
    let columns = String::from_utf8_lossy(columns);
    Error::device(
        "columns-changed",
        format!("the board sends other columns now: {columns}"),
    )
    .with_hint("what was recorded is in the file; record the rest into another one")
}

fn settings_refused(speaks: bool) -> Error {
    Error::device(
        "settings-refused",
        if speaks {
            "the board does not take the settings: what it says after them is another one"
        } else {
            "the board does not say how it is set: it is not known whether it took the settings"
        },
    )
    .with_hint("put firmware/mpu6050_logger onto the board, or leave the settings out")
}
