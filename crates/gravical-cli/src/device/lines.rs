//! Text from a board: bytes to lines, whatever they are torn into, and lines to what
//! they are.

use super::item::{Item, Kind, Reason, Row};

/// More bytes than this without a line break are no line of a board (they have 160 at
/// most): they are handed on in pieces.
const MOST_BYTES: usize = 512;

/// Values of a row: a stamp, three of the accelerometer, the temperature, three of the
/// gyroscope.
const FIELDS: usize = 8;

/// What the line begins with in which the firmware says how it is set.
const OWN_LINE: &[u8] = b"# gravical mpu6050_logger";

/// Puts lines together. The first one may have begun before anybody listened.
#[derive(Debug, Clone, Default)]
pub struct Lines {
    partial: Vec<u8>,
    /// What came before `partial` was a line break.
    synced: bool,
}

impl Lines {
    /// Of a file: its first line begins where it begins.
    pub fn of_file() -> Self {
        Lines {
            synced: true,
            ..Lines::default()
        }
    }

    /// Takes bytes as they come; gives what the lines are that they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Item> {
        let mut items = Vec::new();
        for &byte in bytes {
            // A carriage return alone ends what is whole without it.
            let ended = byte == b'\n' || byte == b'\r' && is_whole(&self.partial);
            if !ended {
                self.partial.push(byte);
            }
            if ended || self.partial.len() >= MOST_BYTES {
                let line = std::mem::take(&mut self.partial);
                let whole = std::mem::replace(&mut self.synced, ended) && ended;
                unglue(line, whole, &mut items);
            }
        }
        items
    }

    /// The port is gone: what was begun will not be ended.
    pub fn cut(&mut self) -> Option<Item> {
        self.synced = false;
        let bytes = std::mem::take(&mut self.partial);
        (!bytes.is_empty()).then(|| Item::rejected(bytes, Reason::Half))
    }
}

/// A board that is reset in the middle of a row goes on with its own line in the same
/// one: how it is set is too good to be lost with the row.
fn unglue(mut line: Vec<u8>, whole: bool, items: &mut Vec<Item>) {
    let own = line.windows(OWN_LINE.len()).position(|w| w == OWN_LINE);
    match own.filter(|at| *at > 0) {
        Some(at) => {
            let rest = line.split_off(at);
            items.extend(item(line, false));
            items.extend(item(rest, true));
        }
        None => items.extend(item(line, whole)),
    }
}

/// The text of a line: without what an adapter makes of a wire that was at rest the wrong
/// way before, and what a board of fixed lines fills them up with.
fn text_of(line: &[u8]) -> &[u8] {
    let none = |byte: &u8| *byte == 0 || byte.is_ascii_whitespace();
    let from = line.iter().take_while(|b| none(b)).count();
    let behind = line.iter().rev().take_while(|b| none(b)).count();
    line.get(from..line.len() - behind).unwrap_or_default()
}

/// Whether a line is a row, a header or a comment as it stands.
fn is_whole(line: &[u8]) -> bool {
    let text = text_of(line);
    text.starts_with(b"#") || is_header(text) || row(text).is_ok()
}

/// Says what a line is; none where nothing is in it. `whole`: both of its ends were seen.
fn item(line: Vec<u8>, whole: bool) -> Option<Item> {
    let text = text_of(&line);
    if text.is_empty() {
        return None;
    }
    let clean = text.iter().all(|b| *b >= b' ' || *b == b'\t');
    let kind = if clean && text.starts_with(b"#") {
        // A board that starts speaks its first line into the silence.
        Kind::Comment
    } else if clean && is_header(text) {
        Kind::Header { whole }
    } else {
        let row = if whole { row(text) } else { Err(Reason::Half) };
        match row {
            Ok(row) => Kind::Row(row),
            Err(reason) => {
                let end = line.iter().rposition(|b| *b != b'\r');
                let bytes = line.get(..=end?).unwrap_or_default();
                return Some(Item::rejected(bytes.to_vec(), reason));
            }
        }
    };
    Some(Item {
        bytes: text.to_vec(),
        kind,
    })
}

/// The row in a whole line: exactly eight finite numbers, separated by commas.
fn row(text: &[u8]) -> Result<Row, Reason> {
    let number = |field: &[u8]| -> Option<f64> {
        let value: f64 = std::str::from_utf8(field.trim_ascii()).ok()?.parse().ok()?;
        value.is_finite().then_some(value)
    };
    let fields = text.split(|b| *b == b',').map(number);
    let fields: Vec<Option<f64>> = fields.collect();
    let fields = <[Option<f64>; FIELDS]>::try_from(fields).map_err(|_| Reason::FieldCount)?;
    if fields.contains(&None) {
        return Err(Reason::NotANumber);
    }
    let [stamp, values @ ..] = fields.map(Option::unwrap_or_default);
    Ok(Row {
        stamp,
        values,
        sequence: None,
    })
}

/// Eight names. A name begins with a letter, and is not `nan`.
fn is_header(text: &[u8]) -> bool {
    let is_name = |field: &[u8]| {
        field.first().is_some_and(u8::is_ascii_alphabetic)
            && ![&b"nan"[..], b"inf", b"ovf"]
                .iter()
                .any(|word| field.eq_ignore_ascii_case(word))
    };
    let mut fields = text.split(|b| *b == b',').map(<[u8]>::trim_ascii);
    fields.clone().count() == FIELDS && fields.all(is_name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(bytes: &[u8], whole: bool) -> Option<Kind> {
        item(bytes.to_vec(), whole).map(|item| item.kind)
    }

    #[test]
    fn rows_have_exactly_eight_numbers() {
        let row = kind(b" 12, 0.1,-0.2,9.81,25.5,1e-3,.5,-1. ", true);
        let Some(Kind::Row(row)) = row else {
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
            assert_eq!(kind(text, true), Some(Kind::Rejected(reason)), "{text:?}");
        }
    }

    #[test]
    fn a_line_whose_start_was_not_seen_is_no_row() {
        assert_eq!(
            kind(b"345,1,2,3,4,5,6,7", false),
            Some(Kind::Rejected(Reason::Half))
        );
        let whole = false;
        assert_eq!(
            kind(b"# gravical mpu6050_logger 1.0", whole),
            Some(Kind::Comment)
        );
        assert_eq!(
            kind(b"t,aX (g),aY,aZ,T,gX,gY,gZ", whole),
            Some(Kind::Header { whole })
        );
    }

    #[test]
    fn lines_that_end_otherwise_or_are_filled_up_are_rows() {
        let mut lines = Lines::of_file();
        let text = b"t,ax,ay,az,T,gx,gy,gz\r1,2,3,4,5,6,7,8\r2,2,3,4,5,6,7,8\r\n\
            3,2,3,4,5,6,7,8\0\0\0\n\0\0# still\0\r4,2,3,4,5,6,7,8\r5,2,3\r4,5,6,7,8\n";
        let items: Vec<Item> = text.iter().flat_map(|b| lines.push(&[*b])).collect();
        let rows: Vec<&[u8]> = items
            .iter()
            .filter(|i| matches!(i.kind, Kind::Row(_)))
            .map(|i| &i.bytes[..])
            .collect();
        let expected: [&[u8]; 4] = [b"1", b"2", b"3", b"4"];
        assert_eq!(rows, expected.map(|n| [n, b",2,3,4,5,6,7,8"].concat()));
        let others: Vec<&Kind> = items.iter().map(|i| &i.kind).collect();
        assert!(matches!(others[0], Kind::Header { whole: true }));
        assert!(others.contains(&&Kind::Comment));
        // In the middle of a row it is a wrong byte.
        assert!(matches!(others[others.len() - 1], Kind::Rejected(_)) && items.len() == 7);
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
            assert_eq!(kind(&text, true), Some(Kind::Header { whole: true }));
        }
        assert_eq!(kind(b"  ", true), None);
        assert_eq!(kind(b"", false), None);
    }

    fn texts(items: &[Item]) -> Vec<(&str, &Kind)> {
        items
            .iter()
            .map(|item| (std::str::from_utf8(&item.bytes).unwrap(), &item.kind))
            .collect()
    }

    #[test]
    fn lines_however_they_are_torn() {
        let wire = b"9.81,1\r\n1,2\n\n3,4\r\n5,";
        let want = [
            ("9.81,1", &Kind::Rejected(Reason::Half)),
            ("1,2", &Kind::Rejected(Reason::FieldCount)),
            ("3,4", &Kind::Rejected(Reason::FieldCount)),
        ];
        for piece in 1..wire.len() {
            let mut lines = Lines::default();
            let items: Vec<Item> = wire.chunks(piece).flat_map(|c| lines.push(c)).collect();
            assert_eq!(texts(&items), want);
            let half = lines.cut().unwrap();
            assert_eq!(half, Item::rejected(b"5,".to_vec(), Reason::Half));
            assert_eq!(lines.cut(), None);
            // After a cut nobody knows where the next line began.
            let items = lines.push(b"6,7\n");
            assert_eq!(items, [Item::rejected(b"6,7".to_vec(), Reason::Half)]);
        }
    }

    #[test]
    fn noise_without_a_line_break_is_bounded() {
        let mut lines = Lines::default();
        let items = lines.push(&[b'x'; 1300]);
        let halves = [MOST_BYTES; 2].map(|n| Item::rejected(vec![b'x'; n], Reason::Half));
        assert_eq!(items, halves);
        let items = lines.push(b"\n1,2,3,4,5,6,7,8\n");
        assert_eq!(items[0].kind, Kind::Rejected(Reason::Half));
        assert!(matches!(items[1].kind, Kind::Row(_)));
    }

    #[test]
    fn the_boards_own_line_behind_a_torn_row() {
        let mut lines = Lines::default();
        let items = lines.push(
            b"# a\n5400,0.1\0# gravical mpu6050_logger 1.0\n\0\0# gravical mpu6050_logger 2\n\0\0\n1,2,3,4,5,6,7,8\n",
        );
        assert_eq!(
            texts(&items)[..4],
            [
                ("# a", &Kind::Comment),
                ("5400,0.1\0", &Kind::Rejected(Reason::Half)),
                ("# gravical mpu6050_logger 1.0", &Kind::Comment),
                ("# gravical mpu6050_logger 2", &Kind::Comment),
            ]
        );
        assert!(matches!(items[4].kind, Kind::Row(_)) && items.len() == 5);
    }
}
