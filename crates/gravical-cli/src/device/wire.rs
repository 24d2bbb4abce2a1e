//! What comes from a board: bytes to [`Item`]s, as lines of text or as the frames of the
//! firmware's binary format, which have a rate of their own. Where nothing that makes
//! sense comes as one of them, the other is to be tried: a board may have been left in
//! its binary format, and one that starts anew is back in its first format.

use super::frames::Frames;
use super::item::{Item, Kind};
use super::lines::Lines;

/// Without anything that makes sense for so long, frames are given up, s. A board whose
/// sensor does not answer says so once a second.
const NO_FRAME_S: f64 = 2.0;
/// The same for lines of a board that is known to send frames, s: the boot loader takes
/// up to two seconds.
const NO_LINE_S: f64 = 3.0;
/// Bytes that come all the time and are no line for so long, s …
const GARBAGE_S: f64 = 1.0;
/// … so many of them …
const GARBAGE_BYTES: usize = 200;
/// … and one in so many no character of a text: another rate. A sketch of somebody else
/// may well say in plain text what it does before it sends rows.
const ODD_ONE_IN: usize = 5;
/// They come at least so often, s: the slowest board sends four frames a second.
const OFTEN_S: f64 = 0.3;
/// Silence of a board that changes its rate, s: what came before it was no frame, and
/// has no zero at its end.
const CHANGES_S: f64 = 0.05;
/// Silence before the first byte: a board that starts up, and no rest of a line, s.
const START_UP_S: f64 = 0.3;

/// How the board speaks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Coding {
    /// Lines.
    #[default]
    Text,
    /// Frames, at a rate of their own.
    Frames,
}

impl Coding {
    /// That of a format of the firmware.
    pub fn of_format(format: u8) -> Self {
        if format == 2 {
            Coding::Frames
        } else {
            Coding::Text
        }
    }
}

/// Decodes what comes, in one coding at a time.
#[derive(Debug, Clone, Default)]
pub struct Wire {
    /// A port is open.
    pub open: bool,
    /// How it is decoded.
    pub coding: Coding,
    lines: Lines,
    frames: Frames,
    /// The port is being set to the rate of it.
    target: Option<Coding>,
    /// How the recording is coded that has begun, and whether its board may change that: a
    /// sketch of somebody else has no frames.
    recorded: Option<(Coding, bool)>,
    /// Something made sense since the port has its rate.
    pub understood: bool,
    /// From the opening to the first byte, s.
    silence_s: Option<f64>,
    /// When something last made sense, or else the rate was set, s.
    sense_s: f64,
    /// Bytes since then, and how many of them are in no text.
    bytes: usize,
    odd: usize,
    /// When the last bytes came, or else the port was opened, s.
    pub last_bytes_s: f64,
    /// Lines before anything made sense, and the first of them.
    nonsense: Option<(u64, String)>,
}

impl Wire {
    /// A port was opened, at the rate of text.
    pub fn opened(&mut self, now_s: f64) {
        self.open = true;
        self.last_bytes_s = now_s;
        self.listen(now_s, Coding::Text);
    }

    /// What was begun is forgotten.
    fn listen(&mut self, now_s: f64, coding: Coding) {
        self.coding = coding;
        self.target = None;
        self.lines = Lines::default();
        self.frames.cut();
        self.understood = false;
        self.silence_s = None;
        (self.sense_s, self.bytes, self.odd) = (now_s, 0, 0);
    }

    /// The port is gone: what was begun will not be ended.
    pub fn lost(&mut self) -> Option<Item> {
        self.open = false;
        let item = match self.coding {
            Coding::Text => self.lines.cut(),
            Coding::Frames => self.frames.cut(),
        }?;
        self.admit(self.last_bytes_s, item)
    }

    /// Whether the first line began when it was listened already.
    pub fn heard_its_start(&self) -> bool {
        self.silence_s.is_some_and(|s| s >= START_UP_S)
    }

    /// A recording begins in this coding.
    pub fn record(&mut self, changes: bool) {
        self.recorded = Some((self.coding, changes || self.coding == Coding::Frames));
    }

    /// The board started anew: the next stamp is one of another clock.
    pub fn clock_anew(&mut self) {
        self.frames.clock_anew();
    }

    /// Whether the port has to be set to the rate of `coding`, and is not being set yet.
    pub fn turns_to(&mut self, coding: Coding) -> bool {
        let turns = coding != self.coding && self.target.is_none();
        if turns {
            self.target = Some(coding);
        }
        turns
    }

    /// The port has that rate; whether it was waited for.
    pub fn turned(&mut self, now_s: f64) -> bool {
        let target = self.target.take();
        if let Some(coding) = target {
            self.listen(now_s, coding);
        }
        target.is_some()
    }

    /// Takes bytes as they come; gives what they complete, but for what was heard at a
    /// wrong rate.
    pub fn push(&mut self, now_s: f64, bytes: &[u8]) -> Vec<Item> {
        self.silence_s.get_or_insert(now_s - self.sense_s);
        let odd = |b: &&u8| !(b.is_ascii_graphic() || b.is_ascii_whitespace());
        self.odd += bytes.iter().filter(odd).count();
        self.bytes += bytes.len();
        let pause_s = now_s - std::mem::replace(&mut self.last_bytes_s, now_s);
        let items = match self.coding {
            Coding::Text => self.lines.push(bytes),
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

    /// All that makes sense, and of the rest what was said at the right rate.
    fn admit(&mut self, now_s: f64, item: Item) -> Option<Item> {
        if !matches!(item.kind, Kind::Rejected(_)) {
            self.understood = true;
            (self.sense_s, self.bytes, self.odd) = (now_s, 0, 0);
            return Some(item);
        }
        if let Some((coding, _)) = self.recorded
            && coding != self.coding
        {
            // It will be heard at the other rate.
            return None;
        }
        if self.understood {
            return Some(item);
        }
        if self.coding == Coding::Frames {
            // Whoever begins to listen in the middle waits for a zero.
            return None;
        }
        let first = || {
            String::from_utf8_lossy(&item.bytes)
                .chars()
                .take(60)
                .collect()
        };
        self.nonsense.get_or_insert_with(|| (0, first())).0 += 1;
        (self.recorded.is_some() || self.is_plain()).then_some(item)
    }

    /// What came since something made sense, or since the opening, is text.
    fn is_plain(&self) -> bool {
        self.odd * ODD_ONE_IN < self.bytes
    }

    /// How many lines came before anything made sense, and the first of them.
    pub fn nonsense(&self) -> Option<(u64, &str)> {
        self.nonsense
            .as_ref()
            .map(|(n, first)| (*n, first.as_str()))
    }

    /// Where nothing makes sense, the other coding.
    pub fn elsewhere(&self, now_s: f64) -> Option<Coding> {
        let nothing_s = now_s - self.sense_s;
        let garbage = nothing_s >= GARBAGE_S
            && self.bytes >= GARBAGE_BYTES
            && !self.is_plain()
            && now_s - self.last_bytes_s < OFTEN_S;
        match (self.coding, self.recorded) {
            (Coding::Frames, _) => (nothing_s >= NO_FRAME_S).then_some(Coding::Text),
            (Coding::Text, Some((_, false))) => None,
            (Coding::Text, Some((Coding::Frames, _))) => {
                (garbage || nothing_s >= NO_LINE_S).then_some(Coding::Frames)
            }
            (Coding::Text, _) => garbage.then_some(Coding::Frames),
        }
    }
}
