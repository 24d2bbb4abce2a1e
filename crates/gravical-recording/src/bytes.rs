//! A path or standard input, plain or gzip, in any encoding, as UTF-8.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};
use encoding_rs_io::DecodeReaderBytesBuilder;
use flate2::bufread::MultiGzDecoder;

/// Bytes that decide on the encoding.
const HEAD_BYTES: usize = 65_536;

/// Opens a recording; `-` is standard input.
///
/// # Errors
///
/// What opening and reading the head of the file return.
pub fn open(path: &Path) -> io::Result<Box<dyn BufRead>> {
    if path == Path::new("-") {
        utf8(io::stdin().lock())
    } else {
        utf8(File::open(path)?)
    }
}

/// The text of a recording as UTF-8 without a byte order mark.
///
/// Gzip is told by its magic number. The encoding is that of the byte order mark, else UTF-16 if
/// every other byte of the head is zero, else UTF-8 if most of what is not ASCII in the head is
/// valid, else Windows-1252. Bytes that the encoding does not know become U+FFFD.
///
/// # Errors
///
/// What reading the head returns.
pub fn utf8(reader: impl Read + 'static) -> io::Result<Box<dyn BufRead>> {
    let mut file = BufReader::with_capacity(HEAD_BYTES, reader);
    if !file.fill_buf()?.starts_with(&[0x1f, 0x8b]) {
        return decode(file);
    }
    decode(MultiGzDecoder::new(file))
}

fn decode(mut reader: impl Read + 'static) -> io::Result<Box<dyn BufRead>> {
    let head = read_head(&mut reader, HEAD_BYTES)?;
    let encoding = encoding(&head);
    if encoding == UTF_8 && Encoding::for_bom(&head).is_none() {
        let text = io::Cursor::new(head).chain(reader);
        return Ok(Box::new(BufReader::with_capacity(HEAD_BYTES, text)));
    }
    let decoder = DecodeReaderBytesBuilder::new()
        .encoding(Some(encoding))
        .bom_override(true)
        .strip_bom(true)
        .build(io::Cursor::new(head).chain(reader));
    Ok(Box::new(BufReader::with_capacity(HEAD_BYTES, decoder)))
}

/// The first bytes of a stream. Data that ends within its compression yields what it holds.
///
/// # Errors
///
/// What reading returns.
pub fn read_head(reader: &mut impl Read, bytes: usize) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    match reader.take(bytes as u64).read_to_end(&mut head) {
        Err(e) if e.kind() != io::ErrorKind::UnexpectedEof || head.is_empty() => Err(e),
        _ => Ok(head),
    }
}

fn encoding(head: &[u8]) -> &'static Encoding {
    if zero_share(head.iter().skip(1)) > 0.6 {
        return UTF_16LE;
    }
    if zero_share(head.iter()) > 0.6 {
        return UTF_16BE;
    }
    // The head may end within a character.
    let text = String::from_utf8_lossy(head);
    let text = text.strip_suffix('\u{fffd}').unwrap_or(&text);
    let invalid = text.chars().filter(|c| *c == '\u{fffd}').count();
    let foreign = text.chars().filter(|c| !c.is_ascii()).count();
    if 2 * invalid > foreign {
        WINDOWS_1252
    } else {
        UTF_8
    }
}

/// Share of zeros among every second byte of the first 64.
fn zero_share<'a>(bytes: impl Iterator<Item = &'a u8>) -> f64 {
    let every_second: Vec<u8> = bytes.step_by(2).take(32).copied().collect();
    let zeros = every_second.iter().filter(|b| **b == 0).count();
    if every_second.len() < 8 {
        0.0
    } else {
        zeros as f64 / every_second.len() as f64
    }
}
