//! Lines of a stream.

use std::borrow::Cow;
use std::io::{self, BufRead};

use memchr::memchr;

/// Bytes of a line that are kept: what is longer is no text.
const MAX_LINE_BYTES: usize = 1 << 20;

pub(crate) struct Lines<R> {
    reader: R,
    line_end: u8,
    buffer: Vec<u8>,
    /// Where the next line begins in `buffer`.
    at: usize,
    is_done: bool,
}

impl<R: BufRead> Lines<R> {
    pub(crate) fn new(reader: R, line_end: u8) -> Self {
        Lines {
            reader,
            line_end,
            buffer: Vec::new(),
            at: 0,
            is_done: false,
        }
    }

    /// The next line, without its end and blanks before it, and whether NUL bytes were removed.
    pub(crate) fn next(&mut self) -> io::Result<Option<(Cow<'_, str>, bool)>> {
        let mut searched = self.at;
        let (start, end) = loop {
            if let Some(n) = memchr(self.line_end, &self.buffer[searched..]) {
                let start = self.at;
                self.at = searched + n + 1;
                break (start, searched + n);
            }
            if self.is_done {
                let start = self.at;
                self.at = self.buffer.len();
                if start == self.at {
                    return Ok(None);
                }
                break (start, self.at);
            }
            self.buffer.drain(..self.at);
            self.at = 0;
            self.buffer.truncate(MAX_LINE_BYTES);
            searched = self.buffer.len();
            self.fill()?;
        };
        let bytes = &self.buffer[start..end];
        if memchr(0, bytes).is_some() {
            let text: Vec<u8> = bytes.iter().copied().filter(|b| *b != 0).collect();
            let line = trim_end(&String::from_utf8_lossy(&text)).to_owned();
            return Ok(Some((Cow::Owned(line), true)));
        }
        let line = match std::str::from_utf8(bytes) {
            Ok(line) => Cow::Borrowed(trim_end(line)),
            Err(_) => Cow::Owned(trim_end(&String::from_utf8_lossy(bytes)).to_owned()),
        };
        Ok(Some((line, false)))
    }

    fn fill(&mut self) -> io::Result<()> {
        let chunk = self.reader.fill_buf()?;
        let n = chunk.len();
        self.is_done = n == 0;
        self.buffer.extend_from_slice(chunk);
        self.reader.consume(n);
        Ok(())
    }
}

/// Without blanks and carriage returns, but with the delimiter that a tab may be.
pub(crate) fn trim_end(line: &str) -> &str {
    line.trim_end_matches(['\r', ' '])
}
