//! What is known of a board before the first row is stored, and how it is brought to the
//! settings that it has to have.

use gravical::Error;

use crate::device::board::Settings;
use crate::device::item::Row;

/// A board that was reset by the opening speaks within about two seconds, s.
pub const ASK_AFTER_S: f64 = 2.5;
/// A board that was told to speak otherwise is up again after so long, s.
pub const UP_S: f64 = 0.6;
/// Between two questions or commands, s.
const ASK_AGAIN_S: f64 = 1.5;
/// So often commands are sent.
const TRIES: u32 = 4;
/// A board that says nothing that makes sense after a command for so long does not take
/// it, s.
const NO_ANSWER_S: f64 = 15.0;
/// Rows that are held before the start.
const HELD: usize = 5000;
/// So many of the last lines of the board are held, and the one of its settings.
const SAID: usize = 20;

/// The board is asked how it is set, and told how it has to be.
#[derive(Debug, Default)]
pub struct Dialog {
    /// When it is asked or told next, s.
    next_s: f64,
    /// It was asked since the port has its rate.
    pub asked: bool,
    /// How often it was told, and when first, s.
    pub tries: u32,
    first_command_s: Option<f64>,
    /// A header of other columns, for which it was asked.
    pub other_columns: Option<Vec<u8>>,
}

impl Dialog {
    /// It begins by itself until `next_s`, or is asked then.
    pub fn from(next_s: f64) -> Self {
        Dialog {
            next_s,
            ..Dialog::default()
        }
    }

    /// Its header is another one.
    pub fn about(columns: Vec<u8>) -> Self {
        Dialog {
            other_columns: Some(columns),
            ..Dialog::default()
        }
    }

    /// The port has another rate: what was said at the one before does not count.
    pub fn turned(&mut self, now_s: f64) {
        (self.asked, self.next_s) = (false, now_s + UP_S);
    }

    pub fn is_due(&self, now_s: f64) -> bool {
        now_s >= self.next_s
    }

    pub fn ask(&mut self, now_s: f64) {
        (self.asked, self.next_s) = (true, now_s + ASK_AGAIN_S);
    }

    pub fn command(&mut self, now_s: f64) {
        self.tries += 1;
        self.next_s = now_s + ASK_AGAIN_S;
        self.first_command_s.get_or_insert(now_s);
    }

    /// It is set as it has to be.
    pub fn settled(&mut self) {
        (self.tries, self.first_command_s) = (0, None);
    }

    /// It was told often enough. In the midst of a recording, what cannot be understood is
    /// waited for without end.
    pub fn is_refused(&self, now_s: f64, recording: bool) -> bool {
        let unanswered_s = self.first_command_s.map_or(0.0, |since_s| now_s - since_s);
        self.tries >= TRIES || (!recording && unanswered_s >= NO_ANSWER_S)
    }
}

/// What is known before the first row.
#[derive(Debug, Default)]
pub struct Start {
    pub opened_s: f64,
    pub dialog: Dialog,
    /// How the board says that it is set, and the line in which it does.
    pub settings: Option<Settings>,
    settings_line: Option<String>,
    pub columns: Option<Vec<u8>>,
    /// Rows, for the case that there is no header.
    pub held: Vec<(Vec<u8>, Row)>,
    /// When one of them came, s.
    pub last_row_s: f64,
    said: Vec<String>,
}

impl Start {
    pub fn opened(&mut self, now_s: f64) {
        (self.opened_s, self.last_row_s) = (now_s, now_s);
        self.dialog = Dialog::from(now_s + ASK_AFTER_S);
    }

    /// Keeps a row; the number of rows that found no room.
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

    /// The board said `text`, and in it how it is set, or not.
    pub fn said(&mut self, text: &str, settings: Option<Settings>) {
        if settings.is_some() {
            (self.settings, self.settings_line) = (settings, Some(text.to_owned()));
            return;
        }
        // The same once a second needs no second line.
        self.said.retain(|line| line != text);
        if self.said.len() >= SAID {
            self.said.remove(0);
        }
        self.said.push(text.to_owned());
    }

    /// What the board said, for the head of the file.
    pub fn all_said(&self) -> impl Iterator<Item = &String> {
        self.said.iter().chain(&self.settings_line)
    }

    /// Why it does not begin: nothing came, or what came instead of rows.
    pub fn no_rows(&self, nonsense: Option<(u64, &str)>) -> Error {
        const FIRMWARE: &str =
            "is the baud rate right (--baud), and firmware/mpu6050_logger on the board?";
        let none =
            |text: String, hint: &str| Error::device("no-samples-from-board", text).with_hint(hint);
        let said = self.said.last().or(self.settings_line.as_ref());
        match (self.held.len(), said, nonsense) {
            (0, Some(said), _) => none(
                format!("no rows came from the board; the last that it said: {said:?}"),
                "what the board says tells why: the wiring of the sensor, mostly; --wait waits without end",
            ),
            (0, None, Some((lines, first))) => none(
                format!(
                    "{lines} lines came from the board, none of them of 8 numbers; the first: {first:?}"
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
}
