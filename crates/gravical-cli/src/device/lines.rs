//! Text from a board: bytes to lines, however they are split, and lines to messages.

use super::item::{Item, Kind, Reason, Row};
use super::shape::{RowShape, check_row, header_names};

/// A longer line is not a row of a board (32 numbers of 15 digits): it is passed on in
/// pieces.
const MOST_BYTES: usize = 512;

/// Beginning of the line with which the firmware reports its settings.
const OWN_LINE: &[u8] = b"# gravical mpu6050_logger";

/// Splits bytes into lines. The beginning of the first one may not have been received.
#[derive(Debug, Clone, Default)]
pub struct Lines {
    partial: Vec<u8>,
    /// `partial` begins behind a line break.
    synced: bool,
}

impl Lines {
    /// Of a file: its first line is complete.
    pub fn of_file() -> Self {
        Lines {
            synced: true,
            ..Lines::default()
        }
    }

    /// Takes bytes as they arrive; returns the messages that they complete. Without a
    /// `shape` every line of numbers is a row.
    pub fn push(&mut self, bytes: &[u8], shape: Option<&RowShape>) -> Vec<Item> {
        let mut items = Vec::new();
        for &byte in bytes {
            // A carriage return alone ends a line that is complete without it.
            let ended = byte == b'\n' || byte == b'\r' && is_complete(&self.partial, shape);
            if !ended {
                self.partial.push(byte);
            }
            if ended || self.partial.len() >= MOST_BYTES {
                let line = std::mem::take(&mut self.partial);
                let whole = std::mem::replace(&mut self.synced, ended) && ended;
                split_at_own_line(line, whole, shape, &mut items);
            }
        }
        items
    }

    /// The port was closed: the line that has begun is incomplete.
    pub fn cut(&mut self) -> Option<Item> {
        self.synced = false;
        let bytes = std::mem::take(&mut self.partial);
        (!bytes.is_empty()).then(|| Item::rejected(bytes, Reason::Half))
    }
}

/// A board that is reset in the middle of a row continues the line with its settings,
/// which must not be lost with the row.
fn split_at_own_line(
    mut line: Vec<u8>,
    whole: bool,
    shape: Option<&RowShape>,
    items: &mut Vec<Item>,
) {
    let own = line.windows(OWN_LINE.len()).position(|w| w == OWN_LINE);
    match own.filter(|at| *at > 0) {
        Some(at) => {
            let rest = line.split_off(at);
            items.extend(item(line, false, shape));
            items.extend(item(rest, true, shape));
        }
        None => items.extend(item(line, whole, shape)),
    }
}

/// The text of a line, without NUL bytes and white space at its ends: an idle line with
/// the wrong polarity, or a board that fills lines up to a fixed length.
fn text_of(line: &[u8]) -> &[u8] {
    let is_empty = |byte: &u8| *byte == 0 || byte.is_ascii_whitespace();
    let from = line.iter().take_while(|b| is_empty(b)).count();
    let behind = line.iter().rev().take_while(|b| is_empty(b)).count();
    line.get(from..line.len() - behind).unwrap_or_default()
}

/// Whether a line is a row, a header or a comment as it is.
fn is_complete(line: &[u8], shape: Option<&RowShape>) -> bool {
    let text = text_of(line);
    text.starts_with(b"#") || row(text, shape).is_ok() || header_names(text).is_some()
}

/// The row in a line; its columns are known only with a `shape`.
fn row(text: &[u8], shape: Option<&RowShape>) -> Result<(Vec<u8>, Row), Reason> {
    match shape {
        Some(shape) => shape.row(text),
        None => check_row(text).map(|()| (text.to_vec(), Row::default())),
    }
}

/// The message in a line; none in an empty one. `whole`: both of its ends were received.
fn item(line: Vec<u8>, whole: bool, shape: Option<&RowShape>) -> Option<Item> {
    let text = text_of(&line);
    if text.is_empty() {
        return None;
    }
    let is_text = text.iter().all(|b| *b >= b' ' || *b == b'\t');
    let message = |bytes: &[u8], kind| {
        let bytes = bytes.to_vec();
        Some(Item { bytes, kind })
    };
    // The first line of a board that starts follows a silence, not a line break.
    if is_text && text.starts_with(b"#") {
        return message(text, Kind::Comment);
    }
    let reason = match row(text, shape) {
        Ok((bytes, row)) if whole => {
            return message(&bytes, Kind::Row(row));
        }
        Ok(_) => Reason::Half,
        Err(_) if is_text && header_names(text).is_some() => {
            return message(text, Kind::Header { whole });
        }
        Err(_) if !whole => Reason::Half,
        Err(reason) => reason,
    };
    let end = line.iter().rposition(|b| *b != b'\r')?;
    let bytes = line.get(..=end).unwrap_or_default();
    Some(Item::rejected(bytes.to_vec(), reason))
}
