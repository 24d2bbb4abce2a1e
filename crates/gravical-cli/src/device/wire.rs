//! What comes from a board, as lines or as frames: bytes to [`Item`]s.

use super::frames::Frames;
use super::line::{Kind, Reason, Row, classify};
use super::lines::{Framer, Line};

/// What the line begins with in which the firmware says how it is set.
const OWN_LINE: &str = "# gravical mpu6050_logger";

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
    Header {
        /// The line.
        bytes: Vec<u8>,
        /// Both of its ends were seen.
        whole: bool,
    },
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
                lines
                    .into_iter()
                    .flat_map(unglued)
                    .filter_map(item)
                    .collect()
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

/// A board that is reset in the middle of a row goes on with its own line in the same
/// one: how it is set is too good to be lost with the row.
fn unglued(mut line: Line) -> Vec<Line> {
    let own = OWN_LINE.as_bytes();
    match line.bytes.windows(own.len()).position(|part| part == own) {
        Some(at) if at > 0 => {
            let rest = Line {
                bytes: line.bytes.split_off(at),
                whole: true,
            };
            line.whole = false;
            vec![line, rest]
        }
        _ => vec![line],
    }
}

fn item(line: Line) -> Option<Item> {
    // What an adapter makes of a wire that was at rest the wrong way before.
    let zeros = line.bytes.iter().take_while(|byte| **byte == 0).count();
    let bytes = line.bytes.get(zeros..).unwrap_or_default().to_vec();
    let whole = line.whole;
    let clean = Line { bytes, whole };
    let kind = classify(&clean);
    let bytes = clean.bytes;
    Some(match kind {
        Kind::Row(row) => Item::Row { bytes, row },
        Kind::Comment => Item::Comment(bytes),
        Kind::Header => Item::Header { bytes, whole },
        Kind::Blank => return None,
        Kind::Rejected(reason) => Item::Bad {
            bytes: line.bytes,
            reason,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boards_own_line_behind_a_torn_row() {
        let mut wire = Wire::default();
        let items = wire.push(
            b"# a\n5400,0.1\0# gravical mpu6050_logger 1.0\n\0\0# gravical mpu6050_logger 2\n\0\0\n1,2,3,4,5,6,7,8\n",
        );
        let [Item::Comment(_), Item::Bad { bytes, reason }, rest @ ..] = items.as_slice() else {
            panic!("{items:?}")
        };
        assert_eq!((&bytes[..], *reason), (&b"5400,0.1\0"[..], Reason::Half));
        let own = |text: &str| Item::Comment(text.into());
        assert_eq!(rest[0], own("# gravical mpu6050_logger 1.0"));
        assert_eq!(rest[1], own("# gravical mpu6050_logger 2"));
        assert!(matches!(rest[2], Item::Row { .. }) && rest.len() == 3);
    }
}
