//! Bytes from a board to [`Item`]s: lines of text, or frames of the firmware's binary
//! format, which have a baud rate of their own. If nothing valid arrives in one coding,
//! the other is tried: a board may have been left in its binary format, and a board that
//! restarts is back in its first format.

use super::frames::Frames;
use super::item::{Item, Kind};
use super::lines::Lines;
use super::shape::RowShape;

/// Without a valid message for this time, frames are given up, s. A board whose sensor
/// does not answer reports that once a second.
const NO_FRAME_S: f64 = 2.0;
/// The same for lines of a board that is known to send frames, s: the boot loader takes
/// up to two seconds.
const NO_LINE_S: f64 = 3.0;
/// Garbage is sent at another baud rate: bytes that arrive for this time without a valid
/// line, s …
const GARBAGE_S: f64 = 1.0;
/// … at least this many …
const GARBAGE_BYTES: usize = 200;
/// … and one in this many is not a character of text. The sketch of another author may
/// print plain text before its first row.
const ODD_ONE_IN: usize = 5;
/// Longest pause within garbage, s: the slowest board sends four frames a second.
const OFTEN_S: f64 = 0.3;
/// Silence of a board that changes its baud rate, s: bytes before it are not a frame, and
/// have no zero at their end.
const CHANGES_S: f64 = 0.05;
/// Silence before the first byte: a board that starts, so that its first line is
/// complete, s.
const START_UP_S: f64 = 0.3;

/// The coding of what a board sends.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Coding {
    /// Lines of text.
    #[default]
    Text,
    /// Frames, at a baud rate of their own.
    Frames,
}

impl Coding {
    /// The coding of a format of the firmware.
    pub fn of_format(format: u8) -> Self {
        if format == 2 {
            Coding::Frames
        } else {
            Coding::Text
        }
    }
}

/// The rows with which a recording began.
#[derive(Debug, Clone)]
pub enum Recorded {
    /// Lines of text.
    Text {
        /// What their numbers are.
        shape: Box<RowShape>,
        /// The board can send frames: the sketch of another author cannot.
        has_frames: bool,
    },
    /// Frames.
    Frames,
}

impl Recorded {
    fn coding(&self) -> Coding {
        match self {
            Recorded::Text { .. } => Coding::Text,
            Recorded::Frames => Coding::Frames,
        }
    }

    fn shape(&self) -> Option<&RowShape> {
        match self {
            Recorded::Text { shape, .. } => Some(shape),
            Recorded::Frames => None,
        }
    }
}

/// Decodes bytes, in one coding at a time.
#[derive(Debug, Clone, Default)]
pub struct Wire {
    /// A port is open.
    pub open: bool,
    /// The coding at the moment.
    pub coding: Coding,
    lines: Lines,
    frames: Frames,
    /// The port is being set to the baud rate of this coding.
    target: Option<Coding>,
    /// The rows of the recording; none before it begins.
    recorded: Option<Recorded>,
    /// A valid message has arrived since the baud rate was set.
    pub understood: bool,
    /// Time from the opening to the first byte, s.
    silence_s: Option<f64>,
    /// Time of the last valid message, or of setting the baud rate, s.
    last_valid_s: f64,
    /// Bytes since then, and how many of them are not text.
    bytes: usize,
    odd: usize,
    /// Time of the last bytes, or of opening the port, s.
    pub last_bytes_s: f64,
    /// Number of invalid lines before the first valid message, and the first of them.
    invalid: Option<(u64, String)>,
}

impl Wire {
    /// A port was opened, at the baud rate of text.
    pub fn opened(&mut self, now_s: f64) {
        self.open = true;
        self.last_bytes_s = now_s;
        self.listen(now_s, Coding::Text);
    }

    /// Starts to decode; an incomplete message is dropped.
    fn listen(&mut self, now_s: f64, coding: Coding) {
        self.coding = coding;
        self.target = None;
        self.lines = Lines::default();
        self.frames.cut();
        self.understood = false;
        self.silence_s = None;
        (self.last_valid_s, self.bytes, self.odd) = (now_s, 0, 0);
    }

    /// The port was closed: the message that has begun is incomplete.
    pub fn lost(&mut self) -> Option<Item> {
        self.open = false;
        let item = match self.coding {
            Coding::Text => self.lines.cut(),
            Coding::Frames => self.frames.cut(),
        }?;
        self.admit(self.last_bytes_s, item)
    }

    /// Whether the port was open before the first line began.
    pub fn heard_its_start(&self) -> bool {
        self.silence_s.is_some_and(|s| s >= START_UP_S)
    }

    /// A recording begins.
    pub fn record(&mut self, rows: Recorded) {
        self.recorded = Some(rows);
    }

    /// What the rows of text in the recording are; none for frames.
    pub fn shape(&self) -> Option<&RowShape> {
        self.recorded.as_ref().and_then(Recorded::shape)
    }

    /// The board sends another coding than at the beginning of the recording.
    pub fn has_changed(&self) -> bool {
        let recorded = self.recorded.as_ref();
        recorded.is_some_and(|rows| rows.coding() != self.coding)
    }

    /// The board restarted: the next stamp is of another clock.
    pub fn restart_clock(&mut self) {
        self.frames.restart_clock();
    }

    /// Whether the port has to be set to the baud rate of `coding`, and is not being set
    /// yet.
    pub fn turns_to(&mut self, coding: Coding) -> bool {
        let turns = coding != self.coding && self.target.is_none();
        if turns {
            self.target = Some(coding);
        }
        turns
    }

    /// The port has that baud rate; returns whether a change was under way.
    pub fn turned(&mut self, now_s: f64) -> bool {
        let target = self.target.take();
        if let Some(coding) = target {
            self.listen(now_s, coding);
        }
        target.is_some()
    }

    /// Takes bytes as they arrive; returns the messages that they complete, without those
    /// that were received at a wrong baud rate.
    pub fn push(&mut self, now_s: f64, bytes: &[u8]) -> Vec<Item> {
        self.silence_s.get_or_insert(now_s - self.last_valid_s);
        let odd = |b: &&u8| !(b.is_ascii_graphic() || b.is_ascii_whitespace());
        self.odd += bytes.iter().filter(odd).count();
        self.bytes += bytes.len();
        let pause_s = now_s - std::mem::replace(&mut self.last_bytes_s, now_s);
        let items = match self.coding {
            Coding::Text => {
                let shape = self.recorded.as_ref().and_then(Recorded::shape);
                self.lines.push(bytes, shape)
            }
            Coding::Frames => {
                if !self.understood && pause_s >= CHANGES_S {
                    self.frames.cut();
                }
                self.frames.push(bytes)
            }
        };
        let admitted = items.into_iter();
        admitted
            .filter_map(|item| self.admit(now_s, item))
            .collect()
    }

    /// Passes on every valid message, and invalid ones that were received at the right baud
    /// rate.
    fn admit(&mut self, now_s: f64, item: Item) -> Option<Item> {
        if !matches!(item.kind, Kind::Rejected(_)) {
            self.understood = true;
            (self.last_valid_s, self.bytes, self.odd) = (now_s, 0, 0);
            return Some(item);
        }
        if self.has_changed() {
            // The board will be set back to the other coding.
            return None;
        }
        if self.understood {
            return Some(item);
        }
        if self.coding == Coding::Frames {
            // The first frame may lack its beginning.
            return None;
        }
        let first = || {
            String::from_utf8_lossy(&item.bytes)
                .chars()
                .take(60)
                .collect()
        };
        self.invalid.get_or_insert_with(|| (0, first())).0 += 1;
        (self.recorded.is_some() || self.is_plain()).then_some(item)
    }

    /// The bytes since the last valid message, or since the opening, are text.
    fn is_plain(&self) -> bool {
        self.odd * ODD_ONE_IN < self.bytes
    }

    /// Number of invalid lines before the first valid message, and the first of them.
    pub fn invalid(&self) -> Option<(u64, &str)> {
        self.invalid.as_ref().map(|(n, first)| (*n, first.as_str()))
    }

    /// The other coding, if nothing valid arrives in this one.
    pub fn other_coding(&self, now_s: f64) -> Option<Coding> {
        let nothing_s = now_s - self.last_valid_s;
        let garbage = nothing_s >= GARBAGE_S
            && self.bytes >= GARBAGE_BYTES
            && !self.is_plain()
            && now_s - self.last_bytes_s < OFTEN_S;
        let gives_up = match (self.coding, &self.recorded) {
            (Coding::Frames, _) => return (nothing_s >= NO_FRAME_S).then_some(Coding::Text),
            (Coding::Text, Some(Recorded::Text { has_frames, .. })) => garbage && *has_frames,
            (Coding::Text, Some(Recorded::Frames)) => garbage || nothing_s >= NO_LINE_S,
            (Coding::Text, None) => garbage,
        };
        gives_up.then_some(Coding::Frames)
    }
}
