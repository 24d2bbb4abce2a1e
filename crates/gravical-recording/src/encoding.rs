//! Text in the encodings that loggers and spreadsheets write, as UTF-8: UTF-16 and Windows-1252.

use std::io::{self, Read};

use crate::bytes::read_head;

/// Bytes that decide on the encoding.
const HEAD_BYTES: usize = 65_536;
/// Bytes that are read at once.
const PIECE_BYTES: usize = 1 << 14;

/// What 0x80 to 0x9f are in Windows-1252 (WHATWG, Encoding Standard, index windows-1252).
const WINDOWS_1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž', '\u{8f}',
    '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

#[derive(Debug, Clone, Copy)]
enum Encoding {
    Utf8,
    /// With the bytes of a unit in this order.
    Utf16(fn([u8; 2]) -> u16),
    Windows1252,
}

/// The text of a recording as UTF-8 without a byte order mark.
///
/// The encoding is that of the byte order mark, else UTF-16 if
/// every other byte of the head is zero, else UTF-8 if most of what is not ASCII in the head is
/// valid, else Windows-1252. Bytes that the encoding does not know become U+FFFD.
///
/// # Errors
///
/// What reading the head returns.
pub fn utf8(mut reader: impl Read + Send + 'static) -> io::Result<Box<dyn Read + Send>> {
    let head = read_head(&mut reader, HEAD_BYTES)?;
    let little = Encoding::Utf16(u16::from_le_bytes);
    let big = Encoding::Utf16(u16::from_be_bytes);
    let (encoding, mark) = match &head[..] {
        [0xef, 0xbb, 0xbf, ..] => (Encoding::Utf8, 3),
        [0xff, 0xfe, ..] => (little, 2),
        [0xfe, 0xff, ..] => (big, 2),
        head if has_zeros(head, 1) => (little, 0),
        head if has_zeros(head, 0) => (big, 0),
        head => (of_bytes(head), 0),
    };
    let mut head = io::Cursor::new(head);
    head.set_position(mark);
    let text = head.chain(reader);
    Ok(match encoding {
        Encoding::Utf8 => Box::new(text),
        _ => Box::new(Decoder {
            inner: text,
            encoding,
            rest: Vec::new(),
            decoded: io::Cursor::default(),
        }),
    })
}

/// Of a text without zeros and without a mark.
fn of_bytes(head: &[u8]) -> Encoding {
    // The head may end within a character.
    let text = String::from_utf8_lossy(head);
    let text = text.strip_suffix('\u{fffd}').unwrap_or(&text);
    let invalid = text.chars().filter(|c| *c == '\u{fffd}').count();
    let foreign = text.chars().filter(|c| !c.is_ascii()).count();
    if 2 * invalid > foreign {
        Encoding::Windows1252
    } else {
        Encoding::Utf8
    }
}

/// Whether most of every second byte of the first 64, from `first` on, are zero.
fn has_zeros(head: &[u8], first: usize) -> bool {
    let every_second = head.iter().skip(first).step_by(2).take(32);
    let zeros = every_second.clone().filter(|b| **b == 0).count();
    every_second.len() >= 8 && 10 * zeros > 6 * every_second.len()
}

/// Reads text of an encoding as UTF-8.
struct Decoder<R> {
    inner: R,
    encoding: Encoding,
    /// Bytes of a character whose others are still to come.
    rest: Vec<u8>,
    decoded: io::Cursor<Vec<u8>>,
}

impl<R: Read> Decoder<R> {
    /// Decodes one more piece; false at the end.
    fn decode(&mut self) -> io::Result<bool> {
        let mut bytes = std::mem::take(&mut self.rest);
        let before = bytes.len();
        let piece = self.inner.by_ref().take(PIECE_BYTES as u64);
        let is_end = { piece }.read_to_end(&mut bytes)? == 0;
        if is_end && before == 0 {
            return Ok(false);
        }
        let text: String = match self.encoding {
            Encoding::Utf16(unit) => {
                let units = bytes.chunks_exact(2).map(|two| unit([two[0], two[1]]));
                let mut units: Vec<u16> = units.collect();
                // Half a unit, and the first of a pair, wait for what follows.
                let is_half_pair = units.last().is_some_and(|u| (0xd800..0xdc00).contains(u));
                if is_half_pair && !is_end {
                    units.pop();
                }
                let whole = if is_end { bytes.len() } else { 2 * units.len() };
                self.rest = bytes.split_off(whole);
                let mut text = String::from_utf16_lossy(&units);
                text.extend((bytes.len() % 2 == 1).then_some('\u{fffd}'));
                text
            }
            _ => bytes
                .iter()
                .map(|byte| match byte {
                    0x80..0xa0 => WINDOWS_1252[usize::from(byte - 0x80)],
                    byte => char::from(*byte),
                })
                .collect(),
        };
        self.decoded = io::Cursor::new(text.into_bytes());
        Ok(true)
    }
}

impl<R: Read> Read for Decoder<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.decoded.read(buffer)? {
                0 if !buffer.is_empty() && self.decode()? => {}
                read => return Ok(read),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: Vec<u8>) -> String {
        let mut text = String::new();
        utf8(io::Cursor::new(bytes))
            .unwrap()
            .read_to_string(&mut text)
            .unwrap();
        text
    }

    #[test]
    fn text_is_read_in_any_of_its_encodings() {
        // Longer than a piece, with characters of two units at every place.
        let text = "t;a_x in m/s² – „Größe“ 😀\n".repeat(2000);
        let units =
            |bytes: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(bytes).collect::<Vec<u8>>();
        let (little, big) = (units(u16::to_le_bytes), units(u16::to_be_bytes));
        for (bytes, mark) in [(little, [0xff, 0xfe]), (big, [0xfe, 0xff])] {
            assert!(read([&mark[..], &bytes].concat()) == text);
            assert!(read(bytes.clone()) == text);
            // Cut off in the middle of a character.
            let cut = read([&mark[..], &bytes[..101]].concat());
            assert!(cut.ends_with('\u{fffd}'), "{cut}");
        }
        assert!(read([&b"\xef\xbb\xbf"[..], text.as_bytes()].concat()) == text);
        assert!(read(text.clone().into_bytes()) == text);
        let western = b"Gr\xf6\xdfe in m/s\xb2 \x96 10 \x80\n".repeat(1000);
        assert!(read(western) == "Größe in m/s² – 10 €\n".repeat(1000));
    }
}
