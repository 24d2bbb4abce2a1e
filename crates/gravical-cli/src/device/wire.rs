//! Bytes from a board to [`Item`]s, of a port that is opened, lost and found.

use super::item::{Item, Kind};
use super::lines::Lines;
use super::shape::RowShape;

/// Bytes at a wrong baud rate are not text: one in this many is no character of it. The sketch of
/// another author may print plain text before its first row.
const ODD_ONE_IN: usize = 5;
/// Silence before the first byte: a board that starts, so that its first line is
/// complete, s.
const START_UP_S: f64 = 0.3;

/// Decodes bytes.
#[derive(Debug, Clone, Default)]
pub struct Wire {
    /// A port is open.
    pub open: bool,
    lines: Lines,
    /// What the rows of the recording are; none before it begins.
    shape: Option<Box<RowShape>>,
    /// A valid message has arrived since the port was opened.
    pub understood: bool,
    /// Time from the opening to the first byte, s.
    silence_s: Option<f64>,
    opened_s: f64,
    /// Bytes since the last valid message, and how many of them are not text.
    bytes: usize,
    odd: usize,
    /// Time of the last bytes, or of opening the port, s.
    pub last_bytes_s: f64,
    /// Number of invalid lines before the first valid message, and the first of them.
    invalid: Option<(u64, String)>,
}

impl Wire {
    /// A port was opened.
    pub fn opened(&mut self, now_s: f64) {
        self.open = true;
        (self.opened_s, self.last_bytes_s) = (now_s, now_s);
        self.lines = Lines::default();
        self.understood = false;
        self.silence_s = None;
        (self.bytes, self.odd) = (0, 0);
    }

    /// The port was closed: the message that has begun is incomplete.
    pub fn lost(&mut self) -> Option<Item> {
        self.open = false;
        let item = self.lines.cut()?;
        self.admit(item)
    }

    /// Whether the port was open before the first line began.
    pub fn heard_its_start(&self) -> bool {
        self.silence_s.is_some_and(|s| s >= START_UP_S)
    }

    /// A recording of such rows begins.
    pub fn record(&mut self, shape: RowShape) {
        self.shape = Some(Box::new(shape));
    }

    /// What the rows of the recording are.
    pub fn shape(&self) -> Option<&RowShape> {
        self.shape.as_deref()
    }

    /// Takes bytes as they arrive; returns the messages that they complete, without those
    /// that were received at a wrong baud rate.
    pub fn push(&mut self, now_s: f64, bytes: &[u8]) -> Vec<Item> {
        self.silence_s.get_or_insert(now_s - self.opened_s);
        let odd = |b: &&u8| !(b.is_ascii_graphic() || b.is_ascii_whitespace());
        self.odd += bytes.iter().filter(odd).count();
        self.bytes += bytes.len();
        self.last_bytes_s = now_s;
        let items = self.lines.push(bytes, self.shape.as_deref());
        let admitted = items.into_iter();
        admitted.filter_map(|item| self.admit(item)).collect()
    }

    /// Passes on every valid message, and invalid ones that were received at the right baud
    /// rate.
    fn admit(&mut self, item: Item) -> Option<Item> {
        if !matches!(item.kind, Kind::Rejected(_)) {
            self.understood = true;
            (self.bytes, self.odd) = (0, 0);
            return Some(item);
        }
        if self.understood {
            return Some(item);
        }
        let first = || {
            String::from_utf8_lossy(&item.bytes)
                .chars()
                .take(60)
                .collect()
        };
        self.invalid.get_or_insert_with(|| (0, first())).0 += 1;
        (self.shape.is_some() || self.is_plain()).then_some(item)
    }

    /// The bytes since the last valid message, or since the opening, are text.
    fn is_plain(&self) -> bool {
        self.odd * ODD_ONE_IN < self.bytes
    }

    /// Number of invalid lines before the first valid message, and the first of them.
    pub fn invalid(&self) -> Option<(u64, &str)> {
        self.invalid.as_ref().map(|(n, first)| (*n, first.as_str()))
    }
}
