//! The board before the first row is stored, and how its settings are made as wanted.

use gravical::Error;

use crate::device::board::Settings;

/// A board that was reset by opening its port sends text within about two seconds, s.
pub const ASK_AFTER_S: f64 = 2.5;
/// Time between two questions or commands, s.
const ASK_AGAIN_S: f64 = 1.5;
/// Number of times that commands are sent.
const TRIES: u32 = 4;
/// A board that sends nothing valid for this time after a command refuses it, s.
const NO_ANSWER_S: f64 = 15.0;
/// Rows that are held before the start.
const MOST_HELD: usize = 5000;
/// Messages of the board that are held, besides its settings.
const MOST_MESSAGES: usize = 20;

/// Questions and commands to the board.
#[derive(Debug, Default)]
pub struct Setup {
    /// Time of the next question or command, s.
    next_s: f64,
    /// How often commands were sent, and when first, s.
    pub tries: u32,
    first_command_s: Option<f64>,
    /// A header with other columns, for which the board is asked.
    pub other_header: Option<Vec<u8>>,
}

impl Setup {
    /// The board reports its settings until `next_s`, or is asked then.
    pub fn from(next_s: f64) -> Self {
        Setup {
            next_s,
            ..Setup::default()
        }
    }

    /// The board sent another header.
    pub fn after_header(columns: Vec<u8>) -> Self {
        Setup {
            other_header: Some(columns),
            ..Setup::default()
        }
    }

    pub fn is_due(&self, now_s: f64) -> bool {
        now_s >= self.next_s
    }

    pub fn ask(&mut self, now_s: f64) {
        self.next_s = now_s + ASK_AGAIN_S;
    }

    pub fn command(&mut self, now_s: f64) {
        self.tries += 1;
        self.next_s = now_s + ASK_AGAIN_S;
        self.first_command_s.get_or_insert(now_s);
    }

    /// The board is set as wanted.
    pub fn settled(&mut self) {
        (self.tries, self.first_command_s) = (0, None);
    }

    /// Commands were sent often enough. During a recording a board that sends nothing valid
    /// is waited for without end.
    pub fn is_refused(&self, now_s: f64, recording: bool) -> bool {
        let unanswered_s = self.first_command_s.map_or(0.0, |since_s| now_s - since_s);
        self.tries >= TRIES || (!recording && unanswered_s >= NO_ANSWER_S)
    }
}

/// A row that arrived before the start.
#[derive(Debug)]
pub struct Held {
    pub at_s: f64,
    pub bytes: Vec<u8>,
}

/// What is known before the first row is stored.
#[derive(Debug, Default)]
pub struct Start {
    pub opened_s: f64,
    pub setup: Setup,
    /// The settings that the board reports, and the line in which it does.
    reported: Option<(Settings, String)>,
    /// The header.
    pub columns: Option<Vec<u8>>,
    /// A line that is the header if rows of its form follow.
    pub possible_header: Option<Vec<u8>>,
    /// Rows, for the case that there is no header.
    pub held: Vec<Held>,
    /// Time of the last of them, s.
    pub last_row_s: f64,
    messages: Vec<String>,
}

impl Start {
    pub fn opened(&mut self, now_s: f64) {
        (self.opened_s, self.last_row_s) = (now_s, now_s);
        self.setup = Setup::from(now_s + ASK_AFTER_S);
    }

    /// Holds a row; returns the number of rows for which there is no room.
    pub fn hold(&mut self, now_s: f64, bytes: Vec<u8>) -> u64 {
        self.last_row_s = now_s;
        if self.held.len() < MOST_HELD {
            let at_s = now_s;
            self.held.push(Held { at_s, bytes });
            return 0;
        }
        1
    }

    /// Drops the rows that are held; returns their number.
    pub fn drop_held(&mut self) -> u64 {
        std::mem::take(&mut self.held).len() as u64
    }

    /// The board sent the message `text`, with its settings or without.
    pub fn add_message(&mut self, text: &str, settings: Option<Settings>) {
        if let Some(settings) = settings {
            self.reported = Some((settings, text.to_owned()));
            return;
        }
        // A message may be repeated once a second.
        self.messages.retain(|line| line != text);
        if self.messages.len() >= MOST_MESSAGES {
            self.messages.remove(0);
        }
        self.messages.push(text.to_owned());
    }

    /// The settings that the board reports.
    pub fn settings(&self) -> Option<&Settings> {
        self.reported.as_ref().map(|(settings, _)| settings)
    }

    /// The messages of the board, for the head of the file.
    pub fn messages(&self) -> impl DoubleEndedIterator<Item = &String> {
        let settings = self.reported.as_ref().map(|(_, line)| line);
        self.messages.iter().chain(settings)
    }

    /// The error if the recording cannot begin: nothing arrived, or other lines than rows.
    pub fn no_rows(&self, invalid: Option<(u64, &str)>) -> Error {
        const SKETCH: &str = "is the baud rate right (--baud), and does the sketch print rows of numbers (firmware/mpu6050_logger does)?";
        let none =
            |text: String, hint: &str| Error::device("no-samples-from-board", text).with_hint(hint);
        let words = self.possible_header.as_deref().map(String::from_utf8_lossy);
        let words = words.map(|words| words.into_owned());
        let message = self.messages.last().or(self.messages().next_back());
        let last = message.or(words.as_ref());
        match (self.held.len(), last, invalid) {
            (0, Some(last), _) => none(
                format!("the board sent no rows; its last message: {last:?}"),
                "the message names the cause: usually the wiring of the sensor; --wait waits without end",
            ),
            (0, None, Some((lines, first))) => none(
                format!(
                    "the board sent {lines} lines, none of which is a row of 3 to 32 numbers; the first: {first:?}"
                ),
                SKETCH,
            ),
            (0, None, None) => Error::device(
                "board-silent",
                "the port is open, but the board sends nothing",
            )
            .with_hint("is it the right port (gravical ports), and does its sketch print rows (firmware/mpu6050_logger does)? --wait waits without end"),
            (rows, _, _) => none(
                format!("the board sent only {rows} rows, and then no more"),
                SKETCH,
            ),
        }
    }
}
