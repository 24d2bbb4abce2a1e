//! One message of a board.

use serde::Serialize;

/// Numbers of a row: fewer are messages of a sketch, more are no IMU.
pub const FIELDS: std::ops::RangeInclusive<usize> = 3..=32;

/// A row in the board's own units, as far as its columns are known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Row {
    /// Time by the board's clock.
    pub stamp: Option<f64>,
    /// Specific force along x, y, z.
    pub accel: Option<[f64; 3]>,
    /// Temperature of the sensor.
    pub temperature: Option<f64>,
}

/// Why a line is rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// Its beginning or end was not received: a number in it may lack digits.
    Half,
    /// Another number of values than a row has, or other names.
    FieldCount,
    /// A value that is not a finite number.
    NotANumber,
}

impl Reason {
    /// For messages.
    pub fn text(self) -> &'static str {
        match self {
            Reason::Half => "its beginning or end was not received",
            Reason::FieldCount => "not the values of a row",
            Reason::NotANumber => "a value is not a number",
        }
    }
}

/// One message of a board.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// The line for the file, without a line end. A rejected line is as it arrived.
    pub bytes: Vec<u8>,
    /// What it is.
    pub kind: Kind,
}

/// The kind of an [`Item`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A sample.
    Row(Row),
    /// Names of columns.
    Header {
        /// Both of its ends were received.
        whole: bool,
    },
    /// A message that begins with `#`.
    Comment,
    /// None of these.
    Rejected(Reason),
}

impl Item {
    /// A line that is rejected.
    pub fn rejected(bytes: Vec<u8>, reason: Reason) -> Self {
        let kind = Kind::Rejected(reason);
        Item { bytes, kind }
    }
}
