//! Lines before their format is known. It is that of about a second of rows; the reader of
//! recordings detects it.

use gravical::Result;
use gravical::recording::{Follow, Form};

use super::gaps::GAP_STEPS;
use super::writing::{Line, Options, reader};

/// After this time the format of a slow board is detected from the lines that are there, s.
const PENDING_S: f64 = 6.0;
/// A board that opening the port resets is silent for this time, or for a gap, s.
const RESET_SILENCE_S: f64 = 1.0;

/// Lines whose format is not known.
pub struct Pending {
    pub lines: Vec<Line>,
    reader: Follow,
    /// Lines at the last attempt to detect the format early.
    tried: usize,
    /// The answer to a question is waited for until then, s.
    pub asked_until_s: Option<f64>,
}

impl Pending {
    /// Without a line.
    pub fn new(options: &Options) -> Self {
        Pending {
            lines: Vec::new(),
            reader: reader(&options.name, options.columns.clone()),
            tried: 0,
            asked_until_s: None,
        }
    }

    /// Takes a line.
    ///
    /// # Errors
    ///
    /// Those of the reader, once enough lines show that they are no recording.
    pub fn push(&mut self, line: Line) -> Result<()> {
        let text = [&line.text[..], b"\n"].concat();
        self.lines.push(line);
        self.reader.push(&text).map(drop)
    }

    /// The format, once it is known. `is_late`: the lines so far have to do.
    pub fn form(&mut self, now_s: f64, is_late: bool) -> Option<Form> {
        let is_slow = now_s - self.lines.first()?.at_s >= PENDING_S;
        if (is_late || is_slow) && self.tried != self.lines.len() {
            self.tried = self.lines.len();
            // They are no recording yet.
            let _ = self.reader.settle(1);
        }
        self.reader.form()
    }

    /// Whether the format is known.
    pub fn is_known(&self) -> bool {
        self.reader.form().is_some()
    }

    /// Whether a board that was silent for so long was reset by opening its port: the rows before lack
    /// a header, and the silence is longer than the steps of a slow board.
    pub fn ends_in_reset(&mut self, silence_s: f64) -> bool {
        let [Some(first), Some(last)] = [self.lines.first(), self.lines.last()] else {
            return false;
        };
        let steps = self.lines.len() - 1;
        let usual_s = (last.at_s - first.at_s) / steps as f64;
        if steps == 0 || silence_s < RESET_SILENCE_S.max(GAP_STEPS * usual_s) {
            return false;
        }
        let is_read = self.reader.settle(1).is_ok();
        is_read && self.reader.form().is_some_and(|f| f.header_line == 0)
    }
}
