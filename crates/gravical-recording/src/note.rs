//! What whoever uses a recording should know of it.

use std::fmt;

use crate::judge::Encoding;
use crate::text::Reason;
use crate::units::AccelUnit;

/// Something about a recording that whoever uses it should know.
#[derive(Clone, PartialEq, Debug)]
pub enum Note {
    /// Neither stamps nor head tell the rate
    NoRate,
    /// Stamps that are no dates we know; the first of them
    StampsUnread(String),
    /// Stamps off the line of their neighbours, mended
    BadStamps(usize),
    /// Rows that the clock asks for and that are not there
    MissingRows(usize),
    /// The first of so many sensors was read
    Sensors(usize),
    /// Lines or rows set aside: reason, count, line of the first
    SetAside(Reason, usize, usize),
    /// Samples that the logger says it rejected
    Rejected(usize),
    /// Cells of the channels that hold text
    Unreadable(usize),
    /// Numbers were written as unsigned
    Encoded(Encoding),
    /// Gravity contradicts the unit of the head, which comes first
    UnitContradicted(AccelUnit, Option<AccelUnit>),
    /// Neither head nor gravity show the unit
    UnitUnknown,
    /// The file ends within its compression
    CutOff,
    /// The acceleration is one from which gravity was removed
    Linear,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::NoRate => write!(f, "the rate is unknown"),
            Note::StampsUnread(first) => write!(f, "stamps like {first:?} are not understood"),
            Note::BadStamps(n) => write!(f, "{n} stamps off the line of their neighbours"),
            Note::MissingRows(n) => write!(f, "{n} rows are missing by the clock"),
            Note::Sensors(n) => write!(f, "{n} sensors take turns: the first is read"),
            Note::SetAside(reason, n, line) => {
                write!(f, "{n} lines {reason}; the first is line {line}")
            }
            Note::Rejected(n) => write!(f, "{n} samples rejected by the logger"),
            Note::Unreadable(n) => write!(f, "{n} cells of the channels hold text"),
            Note::Encoded(encoding) => write!(f, "{encoding}"),
            Note::UnitContradicted(claim, Some(unit)) => {
                write!(
                    f,
                    "the head says {}, gravity says {}",
                    claim.name(),
                    unit.name()
                )
            }
            Note::UnitContradicted(claim, None) => {
                write!(f, "the head says {}, gravity does not", claim.name())
            }
            Note::UnitUnknown => write!(f, "the unit of the accelerometer is unknown"),
            Note::CutOff => write!(f, "the file ends within its compressed data"),
            Note::Linear => write!(f, "gravity was removed from this acceleration"),
        }
    }
}
