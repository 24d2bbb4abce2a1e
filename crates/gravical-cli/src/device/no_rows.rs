//! What arrives at a port that is open and gives no row.

use gravical::Error;
use gravical::escape::shown;

/// The last bytes that arrived are judged: so many.
pub const JUDGED_BYTES: usize = 512;
/// Characters of the line that is quoted.
const QUOTED: usize = 80;
/// With more than this share of characters that no text has, it is none.
const MAX_UNREADABLE: f64 = 0.1;

/// What arrives in place of rows.
#[derive(Debug, Clone, PartialEq)]
pub enum NoRows {
    /// Nothing.
    Nothing,
    /// Text; its last line.
    Text(String),
    /// Bytes that are no text, as of another baud rate.
    Garbage,
}

impl NoRows {
    /// Judges the last bytes that arrived.
    pub fn of(bytes: &[u8]) -> Self {
        let text = String::from_utf8_lossy(bytes);
        let is_unreadable = |c: &char| {
            *c == char::REPLACEMENT_CHARACTER
                || c.is_control() && !matches!(c, '\r' | '\n' | '\t' | '\u{1b}')
        };
        let unreadable = text.chars().filter(is_unreadable).count();
        if bytes.is_empty() {
            NoRows::Nothing
        } else if unreadable as f64 > MAX_UNREADABLE * text.chars().count() as f64 {
            NoRows::Garbage
        } else {
            // What follows the last end of a line is a part of one.
            let whole = text.rfind(['\r', '\n']).map_or(&*text, |end| &text[..end]);
            let line = whole.trim_end().rsplit(['\r', '\n']).next();
            let line = shown(line.unwrap_or_default().trim()).into_owned();
            NoRows::Text(line.chars().take(QUOTED).collect())
        }
    }

    /// The error that it is where rows are not waited for.
    pub fn error(&self, port: &str) -> Error {
        let (code, text, hint) = match self {
            NoRows::Nothing => (
                "board-silent",
                format!("{port} is open, but nothing arrives: does the board have a sketch?"),
                "is it the right port (gravical ports), and does its sketch print rows (firmware/mpu6050_logger does)?",
            ),
            NoRows::Text(line) => (
                "no-samples-from-board",
                format!("{port} sends text that is no row of a sensor: {line:?}"),
                "a row has at least three numbers, as firmware/mpu6050_logger prints them; --columns names what they are",
            ),
            NoRows::Garbage => (
                "no-samples-from-board",
                format!("what {port} sends is no text: the baud rate of the board is another one, or it has no sketch"),
                "give the baud rate of the sketch: --baud 9600 or 57600, for example",
            ),
        };
        Error::device(code, text).with_hint(hint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_text_and_garbage() {
        let is = |bytes: &[u8]| NoRows::of(bytes);
        let text = |line: &str| NoRows::Text(line.to_owned());
        assert_eq!(is(b""), NoRows::Nothing);
        assert_eq!(is(b"Hello\r\nI blink!\r\n\r\nhal"), text("I blink!"));
        assert_eq!(is(b"no end"), text("no end"));
        assert_eq!(is(b"\n"), text(""));
        // A byte that is hurt.
        assert_eq!(is(b"\xffone two three\n"), text("\u{fffd}one two three"));
        // 115200 baud read at 9600.
        assert_eq!(is(b"\x00\xf8\x80\xfe\x1c\n"), NoRows::Garbage);
    }
}
