//! What one line from a board is.

use serde::Serialize;

use super::lines::Line;

/// Values of a row: a stamp, three of the accelerometer, the temperature, three of the
/// gyroscope.
pub const FIELDS: usize = 8;

/// One row in the board's own units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The board's clock.
    pub stamp: f64,
    /// Specific force along x, y, z; temperature; angular rate about x, y, z.
    pub values: [f64; FIELDS - 1],
    /// Counts the rows modulo 256, where the board does so: in its binary format.
    pub sequence: Option<u8>,
}

/// What a line is.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// Exactly eight numbers.
    Row(Row),
    /// Eight names.
    Header,
    /// What the board says of itself, behind `#`.
    Comment,
    /// Nothing in it.
    Blank,
    /// None of these.
    Rejected(Reason),
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

/// Says what `line` is.
pub fn classify(line: &Line) -> Kind {
    let text = line.bytes.trim_ascii();
    if text.is_empty() {
        return Kind::Blank;
    }
    let clean = text.iter().all(|b| *b >= b' ' || *b == b'\t');
    // A board that starts speaks its first line into the silence.
    if clean && text.starts_with(b"#") {
        return Kind::Comment;
    }
    let fields: Vec<&[u8]> = text.split(|b| *b == b',').map(<[u8]>::trim_ascii).collect();
    if clean && fields.len() == FIELDS && fields.iter().all(|f| is_name(f)) {
        return Kind::Header;
    }
    if !line.whole {
        return Kind::Rejected(Reason::Half);
    }
    let Ok(fields) = <[&[u8]; FIELDS]>::try_from(fields) else {
        return Kind::Rejected(Reason::FieldCount);
    };
    match fields.map(number) {
        [
            Some(stamp),
            Some(a),
            Some(b),
            Some(c),
            Some(t),
            Some(d),
            Some(e),
            Some(f),
        ] => Kind::Row(Row {
            stamp,
            values: [a, b, c, t, d, e, f],
            sequence: None,
        }),
        _ => Kind::Rejected(Reason::NotANumber),
    }
}

fn number(field: &[u8]) -> Option<f64> {
    let value: f64 = std::str::from_utf8(field).ok()?.parse().ok()?;
    value.is_finite().then_some(value)
}

/// A name begins with a letter, and is not `nan`.
fn is_name(field: &[u8]) -> bool {
    field.first().is_some_and(u8::is_ascii_alphabetic)
        && ![&b"nan"[..], b"inf", b"ovf"]
            .iter()
            .any(|word| field.eq_ignore_ascii_case(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(bytes: &[u8], whole: bool) -> Kind {
        classify(&Line {
            bytes: bytes.to_vec(),
            whole,
        })
    }

    #[test]
    fn rows_have_exactly_eight_numbers() {
        let row = kind(b" 12, 0.1,-0.2,9.81,25.5,1e-3,.5,-1. ", true);
        let Kind::Row(row) = row else {
            panic!("{row:?}")
        };
        assert_eq!(
            (row.stamp, row.values[2], row.values[6]),
            (12.0, 9.81, -1.0)
        );
        for (text, reason) in [
            (&b"1,2,3,4,5,6,7"[..], Reason::FieldCount),
            (b"1,2,3,4,5,6,7,8,9", Reason::FieldCount),
            (b"1,2,3,4,5,6,7,8,", Reason::FieldCount),
            (b"1,2,3,4,5,6,7,", Reason::NotANumber),
            (b"1,2,3,nan,5,6,7,8", Reason::NotANumber),
            (b"1,2,3,1e999,5,6,7,8", Reason::NotANumber),
            (b"nan,nan,nan,nan,nan,nan,nan,nan", Reason::NotANumber),
            (b"1,2,3,4\xff,5,6,7,8", Reason::NotANumber),
            (b"1,2,3,4.1.2,5,6,7,8", Reason::NotANumber),
            (b"\x00\x01garbage", Reason::FieldCount),
            (b"# \x00 half a comment", Reason::FieldCount),
        ] {
            assert_eq!(kind(text, true), Kind::Rejected(reason), "{text:?}");
        }
    }

    #[test]
    fn a_line_whose_start_was_not_seen_is_no_row() {
        assert_eq!(
            kind(b"345,1,2,3,4,5,6,7", false),
            Kind::Rejected(Reason::Half)
        );
        assert_eq!(kind(b"# gravical mpu6050_logger 1.0", false), Kind::Comment);
        assert_eq!(kind(b"t,aX (g),aY,aZ,T,gX,gY,gZ", false), Kind::Header);
    }

    #[test]
    fn headers_comments_and_nothing() {
        // The degree sign in UTF-8, and in Latin-1.
        for degree in [&b"\xc2\xb0"[..], b"\xb0"] {
            let text = [
                &b"Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX ("[..],
                degree,
                b"/s),gY,gZ",
            ]
            .concat();
            assert_eq!(kind(&text, true), Kind::Header);
        }
        assert_eq!(kind(b"  ", true), Kind::Blank);
        assert_eq!(kind(b"", false), Kind::Blank);
    }
}
