//! Lines of a stream.

use std::io::{self, ErrorKind, Read};

use memchr::{memchr, memrchr};

/// Bytes that are read at once.
const READ_BYTES: usize = 1 << 18;
/// Bytes of a line that are kept: what is longer is not text.
const MAX_LINE_BYTES: usize = 1 << 20;

/// A stream as blocks of whole lines.
pub(crate) struct LineBlocks<R> {
    reader: R,
    line_end: u8,
    bytes: Vec<u8>,
    /// The rest of the line that is being read is not kept.
    skips: bool,
}

impl<R: Read> LineBlocks<R> {
    pub(crate) fn new(reader: R, line_end: u8) -> Self {
        LineBlocks {
            reader,
            line_end,
            bytes: Vec::new(),
            skips: false,
        }
    }

    /// The lines that the next reads complete; `None` at the end.
    pub(crate) fn next(&mut self) -> io::Result<Option<Vec<u8>>> {
        self.next_of(0)
    }

    /// The same with so many bytes or more, as far as there are.
    pub(crate) fn next_of(&mut self, min_bytes: usize) -> io::Result<Option<Vec<u8>>> {
        self.bytes.reserve(min_bytes);
        let mut searched = 0;
        loop {
            if self.skips {
                let end = memchr(self.line_end, &self.bytes);
                self.skips = end.is_none();
                self.bytes
                    .drain(..end.map_or(self.bytes.len(), |end| end + 1));
                searched = 0;
            }
            let length = self.bytes.len();
            if length >= min_bytes
                && let Some(end) = memrchr(self.line_end, &self.bytes[searched..])
            {
                let rest = self.bytes.split_off(searched + end + 1);
                return Ok(Some(std::mem::replace(&mut self.bytes, rest)));
            }
            if length >= min_bytes {
                searched = length;
                if length >= min_bytes + MAX_LINE_BYTES {
                    self.skips = true;
                    return Ok(Some(std::mem::take(&mut self.bytes)));
                }
            }
            self.bytes.resize(length + READ_BYTES, 0);
            let read = match self.reader.read(&mut self.bytes[length..]) {
                Err(e) if e.kind() == ErrorKind::Interrupted => 0,
                Err(e) => return Err(e),
                Ok(0) => {
                    self.bytes.truncate(length);
                    let last = std::mem::take(&mut self.bytes);
                    return Ok(Some(last).filter(|last| !last.is_empty()));
                }
                Ok(read) => read,
            };
            self.bytes.truncate(length + read);
        }
    }
}

/// Without blanks and carriage returns, but with the delimiter that a tab may be; without a semicolon
/// that ends the line and delimits nothing else.
pub(crate) fn trim_end(line: &str) -> &str {
    let line = line.trim_end_matches(['\r', ' ']);
    let rest = line.strip_suffix(';');
    rest.filter(|rest| !rest.contains(';')).unwrap_or(line)
}
