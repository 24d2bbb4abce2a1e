//! What comes from a board, as lines or as frames: bytes to [`Item`]s.

use super::frames::Frames;
use super::line::{Kind, Reason, Row, classify};
use super::lines::{Framer, Line};

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

    /// The one that it is not.
    pub fn other(self) -> Self {
        match self {
            Coding::Text => Coding::Frames,
            Coding::Frames => Coding::Text,
        }
    }
}

/// One thing that the board sent. `bytes` are a line of text without its end.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// A sample.
    Row {
        /// As it stands in the file.
        bytes: Vec<u8>,
        /// What it says.
        row: Row,
    },
    /// Names of columns.
    Header(Vec<u8>),
    /// A line behind `#`.
    Comment(Vec<u8>),
    /// None of these.
    Bad {
        /// What it was; bytes of a frame in hexadecimal.
        bytes: Vec<u8>,
        /// Why.
        reason: Reason,
    },
}

/// Decodes what comes, in one coding at a time.
#[derive(Debug, Clone, Default)]
pub struct Wire {
    coding: Coding,
    lines: Framer,
    frames: Frames,
}

impl Wire {
    /// How it is decoded.
    pub fn coding(&self) -> Coding {
        self.coding
    }

    /// From here on it is decoded so; what was begun is forgotten.
    pub fn switch(&mut self, coding: Coding) {
        self.coding = coding;
        self.lines = Framer::default();
        self.frames.cut();
    }

    /// The board started anew: the next stamp is one of another clock.
    pub fn clock_anew(&mut self) {
        self.frames.clock_anew();
    }

    /// Takes bytes as they come; gives what they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Item> {
        match self.coding {
            Coding::Text => {
                let lines = self.lines.push(bytes);
                lines.into_iter().filter_map(item).collect()
            }
            Coding::Frames => self.frames.push(bytes),
        }
    }

    /// The port is gone: what was begun will not be ended.
    pub fn cut(&mut self) -> Option<Item> {
        match self.coding {
            Coding::Text => self.lines.cut().map(|line| Item::Bad {
                bytes: line.bytes,
                reason: Reason::Half,
            }),
            Coding::Frames => self.frames.cut(),
        }
    }
}

fn item(line: Line) -> Option<Item> {
    Some(match classify(&line) {
        Kind::Row(row) => Item::Row {
            bytes: line.bytes,
            row,
        },
        Kind::Comment => Item::Comment(line.bytes),
        Kind::Header => Item::Header(line.bytes),
        Kind::Blank => return None,
        Kind::Rejected(reason) => Item::Bad {
            bytes: line.bytes,
            reason,
        },
    })
}
