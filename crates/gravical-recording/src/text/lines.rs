//! Lines of a stream.

use std::io::{self, BufRead, BufReader, Read};

use memchr::memrchr;

/// Bytes that are read at once.
const READ_BYTES: usize = 1 << 18;
/// Bytes of a line that are kept: what is longer is not text.
const MAX_LINE_BYTES: u64 = 1 << 20;

/// A stream as blocks of whole lines.
pub(crate) struct LineBlocks<R> {
    reader: BufReader<R>,
    line_end: u8,
}

impl<R: Read> LineBlocks<R> {
    pub(crate) fn new(reader: R, line_end: u8) -> Self {
        let reader = BufReader::with_capacity(READ_BYTES, reader);
        LineBlocks { reader, line_end }
    }

    /// The lines that the next reads complete, of so many bytes or more, as far as there are; `None` at
    /// the end.
    pub(crate) fn next(&mut self, min_bytes: usize) -> io::Result<Option<Vec<u8>>> {
        let mut lines = Vec::with_capacity(min_bytes);
        let reader = self.reader.by_ref();
        reader.take(min_bytes as u64).read_to_end(&mut lines)?;
        let mut line = reader.take(MAX_LINE_BYTES);
        line.read_until(self.line_end, &mut lines)?;
        if line.limit() == 0 && lines.last() != Some(&self.line_end) {
            self.reader.skip_until(self.line_end)?;
            lines.push(self.line_end);
        }
        let buffered = self.reader.buffer();
        let end = memrchr(self.line_end, buffered).map_or(0, |at| at + 1);
        lines.extend_from_slice(&buffered[..end]);
        self.reader.consume(end);
        Ok(Some(lines).filter(|lines| !lines.is_empty()))
    }
}

/// Without blanks and carriage returns, but with the delimiter that a tab may be; without a semicolon
/// that ends the line and delimits nothing else.
pub(crate) fn trim_end(line: &str) -> &str {
    let line = line.trim_end_matches(['\r', ' ']);
    let rest = line.strip_suffix(';');
    rest.filter(|rest| !rest.contains(';')).unwrap_or(line)
}
