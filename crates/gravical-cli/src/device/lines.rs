//! Text from a board: bytes to lines, however they are split, and lines to messages.

use super::item::{Item, Kind, Reason, Row};
use super::shape::{RowShape, check_row, header_names};

/// A longer line is not a row of a board (32 numbers of 15 digits): it is passed on in
/// pieces.
const MOST_BYTES: usize = 512;

/// Beginning of the line with which the firmware reports its settings.
const OWN_LINE: &[u8] = b"# gravical mpu6050_logger";

/// Splits bytes into lines. The beginning of the first one may not have been received.
#[derive(Debug, Clone, Default)]
pub struct Lines {
    partial: Vec<u8>,
    /// `partial` begins behind a line break.
    synced: bool,
}

impl Lines {
    /// Of a file: its first line is complete.
    pub fn of_file() -> Self {
        Lines {
            synced: true,
            ..Lines::default()
        }
    }

    /// Takes bytes as they arrive; returns the messages that they complete. Without a
    /// `shape` every line of numbers is a row.
    pub fn push(&mut self, bytes: &[u8], shape: Option<&RowShape>) -> Vec<Item> {
        let mut items = Vec::new();
        for &byte in bytes {
            // A carriage return alone ends a line that is complete without it.
            let ended = byte == b'\n' || byte == b'\r' && is_complete(&self.partial, shape);
            if !ended {
                self.partial.push(byte);
            }
            if ended || self.partial.len() >= MOST_BYTES {
                let line = std::mem::take(&mut self.partial);
                let whole = std::mem::replace(&mut self.synced, ended) && ended;
                split_at_own_line(line, whole, shape, &mut items);
            }
        }
        items
    }

    /// The port was closed: the line that has begun is incomplete.
    pub fn cut(&mut self) -> Option<Item> {
        self.synced = false;
        let bytes = std::mem::take(&mut self.partial);
        (!bytes.is_empty()).then(|| Item::rejected(bytes, Reason::Half))
    }
}

/// A board that is reset in the middle of a row continues the line with its settings,
/// which must not be lost with the row.
fn split_at_own_line(
    mut line: Vec<u8>,
    whole: bool,
    shape: Option<&RowShape>,
    items: &mut Vec<Item>,
) {
    let own = line.windows(OWN_LINE.len()).position(|w| w == OWN_LINE);
    match own.filter(|at| *at > 0) {
        Some(at) => {
            let rest = line.split_off(at);
            items.extend(item(line, false, shape));
            items.extend(item(rest, true, shape));
        }
        None => items.extend(item(line, whole, shape)),
    }
}

/// The text of a line, without NUL bytes and white space at its ends: an idle line with
/// the wrong polarity, or a board that fills lines up to a fixed length.
fn text_of(line: &[u8]) -> &[u8] {
    let is_empty = |byte: &u8| *byte == 0 || byte.is_ascii_whitespace();
    let from = line.iter().take_while(|b| is_empty(b)).count();
    let behind = line.iter().rev().take_while(|b| is_empty(b)).count();
    line.get(from..line.len() - behind).unwrap_or_default()
}

/// Whether a line is a row, a header or a comment as it is.
fn is_complete(line: &[u8], shape: Option<&RowShape>) -> bool {
    let text = text_of(line);
    text.starts_with(b"#") || row(text, shape).is_ok() || header_names(text).is_some()
}

/// The row in a line; its columns are known only with a `shape`.
fn row(text: &[u8], shape: Option<&RowShape>) -> Result<(Vec<u8>, Row), Reason> {
    match shape {
        Some(shape) => shape.row(text),
        None => check_row(text).map(|()| (text.to_vec(), Row::default())),
    }
}

/// The message in a line; none in an empty one. `whole`: both of its ends were received.
fn item(line: Vec<u8>, whole: bool, shape: Option<&RowShape>) -> Option<Item> {
    let text = text_of(&line);
    if text.is_empty() {
        return None;
    }
    let is_text = text.iter().all(|b| *b >= b' ' || *b == b'\t');
    let message = |bytes: &[u8], kind| {
        let bytes = bytes.to_vec();
        Some(Item { bytes, kind })
    };
    // The first line of a board that starts follows a silence, not a line break.
    if is_text && text.starts_with(b"#") {
        return message(text, Kind::Comment);
    }
    let reason = match row(text, shape) {
        Ok((bytes, row)) if whole => {
            return message(&bytes, Kind::Row(row));
        }
        Ok(_) => Reason::Half,
        Err(_) if is_text && header_names(text).is_some() => {
            return message(text, Kind::Header { whole });
        }
        Err(_) if !whole => Reason::Half,
        Err(reason) => reason,
    };
    let end = line.iter().rposition(|b| *b != b'\r')?;
    let bytes = line.get(..=end).unwrap_or_default();
    Some(Item::rejected(bytes.to_vec(), reason))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &[u8] = b"t,ax,ay,az,temp,gx,gy,gz";

    fn eight() -> RowShape {
        RowShape::of_header(HEADER, None).unwrap().unwrap()
    }

    fn kind(bytes: &[u8], whole: bool) -> Option<Kind> {
        item(bytes.to_vec(), whole, Some(&eight())).map(|item| item.kind)
    }

    #[test]
    fn rows_have_as_many_numbers_as_their_header_has_names() {
        let row = kind(b" 12, 0.1,-0.2,9.81,25.5,1e-3,.5,-1. ", true);
        let Some(Kind::Row(row)) = row else {
            panic!("{row:?}")
        };
        assert_eq!((row.stamp, row.accel.unwrap()[2]), (Some(12.0), 9.81));
        assert_eq!(row.temperature, Some(25.5));
        for (text, reason) in [
            (&b"1,2,3,4,5,6,7"[..], Reason::FieldCount),
            (b"1,2,3,4,5,6,7,8,9", Reason::FieldCount),
            (b"1,2,3,4,5,6,7,8,9,", Reason::FieldCount),
            (b"1,2,3,4,5,6,,8", Reason::NotANumber),
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
    fn a_line_without_its_beginning_is_rejected() {
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
    fn line_ends_and_padding_do_not_matter() {
        let mut lines = Lines::of_file();
        let text = b"t,ax,ay,az,temp,gx,gy,gz\r1,2,3,4,5,6,7,8\r2,2,3,4,5,6,7,8\r\n\
            3,2,3,4,5,6,7,8\0\0\0\n\0\0# still\0\r4,2,3,4,5,6,7,8\r5,2,3\r4,5,6,7,8\n";
        let shape = eight();
        let push = |b| lines.push(&[b], Some(&shape));
        let items: Vec<Item> = text.iter().copied().flat_map(push).collect();
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
        // In the middle of a row a carriage return is a wrong byte.
        assert!(matches!(others[others.len() - 1], Kind::Rejected(_)) && items.len() == 7);
    }

    #[test]
    fn headers_in_any_encoding_and_empty_lines() {
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
    fn lines_arrive_in_pieces() {
        let wire = b"9.81,1\r\n1,2\n\n3,4\r\n5,";
        let want = [
            ("9.81,1", &Kind::Rejected(Reason::Half)),
            ("1,2", &Kind::Rejected(Reason::FieldCount)),
            ("3,4", &Kind::Rejected(Reason::FieldCount)),
        ];
        for piece in 1..wire.len() {
            let mut lines = Lines::default();
            let items: Vec<Item> = wire
                .chunks(piece)
                .flat_map(|c| lines.push(c, None))
                .collect();
            assert_eq!(texts(&items), want);
            let half = lines.cut().unwrap();
            assert_eq!(half, Item::rejected(b"5,".to_vec(), Reason::Half));
            assert_eq!(lines.cut(), None);
            // After a cut it is not known where the next line begins.
            let items = lines.push(b"6,7\n", None);
            assert_eq!(items, [Item::rejected(b"6,7".to_vec(), Reason::Half)]);
        }
    }

    #[test]
    fn noise_without_a_line_break_is_bounded() {
        let mut lines = Lines::default();
        let items = lines.push(&[b'x'; 1300], None);
        let halves = [MOST_BYTES; 2].map(|n| Item::rejected(vec![b'x'; n], Reason::Half));
        assert_eq!(items, halves);
        let items = lines.push(b"\n1,2,3,4,5,6,7,8\n", None);
        assert_eq!(items[0].kind, Kind::Rejected(Reason::Half));
        assert!(matches!(items[1].kind, Kind::Row(_)));
    }

    #[test]
    fn the_settings_line_behind_a_torn_row_is_found() {
        let mut lines = Lines::default();
        let items = lines.push(
            b"# a\n5400,0.1\0# gravical mpu6050_logger 1.0\n\0\0# gravical mpu6050_logger 2\n\0\0\n1,2,3,4,5,6,7,8\n",
            None,
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
