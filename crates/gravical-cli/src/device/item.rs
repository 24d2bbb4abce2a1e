//! One thing that a board sent.

use serde::Serialize;

/// One row in the board's own units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The board's clock.
    pub stamp: f64,
    /// Specific force along x, y, z; temperature; angular rate about x, y, z.
    pub values: [f64; 7],
    /// Counts the rows modulo 256, where the board does so: in its binary format.
    pub sequence: Option<u8>,
}

/// Why a line is rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// Its beginning or its end was not seen: a number in it may lack digits.
    Half,
    /// Not eight fields.
    FieldCount,
    /// A field that is no finite number.
    NotANumber,
    /// Bytes of the binary format that are no frame.
    BadFrame,
}

impl Reason {
    /// For people.
    pub fn text(self) -> &'static str {
        match self {
            Reason::Half => "its beginning or end was not seen",
            Reason::FieldCount => "not exactly 8 values",
            Reason::NotANumber => "a value that is no number",
            Reason::BadFrame => "no frame",
        }
    }
}

/// One thing that the board sent.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// As it stands in a file, without an end of line. What is rejected is as it came, or
    /// the bytes of a frame in hexadecimal.
    pub bytes: Vec<u8>,
    /// What it is.
    pub kind: Kind,
}

/// What an [`Item`] is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A sample.
    Row(Row),
    /// Eight names of columns.
    Header {
        /// Both of its ends were seen.
        whole: bool,
    },
    /// What the board says of itself, behind `#`.
    Comment,
    /// None of these.
    Rejected(Reason),
}

impl Item {
    /// What is none of the others.
    pub fn rejected(bytes: Vec<u8>, reason: Reason) -> Self {
        let kind = Kind::Rejected(reason);
        Item { bytes, kind }
    }
}
