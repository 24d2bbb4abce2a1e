//! Lines of a stream.

use std::io::{self, BufRead};

use memchr::{memchr, memrchr};

/// Bytes of a line that are kept: what is longer is no text.
const MAX_LINE_BYTES: usize = 1 << 20;

pub(crate) struct Lines<R> {
    reader: R,
    line_end: u8,
    /// Whole lines, and where the next one begins in them.
    text: String,
    at: usize,
    /// Beginning of the line after them.
    rest: Vec<u8>,
}

impl<R: BufRead> Lines<R> {
    pub(crate) fn new(reader: R, line_end: u8) -> Self {
        Lines {
            reader,
            line_end,
            text: String::new(),
            at: 0,
            rest: Vec::new(),
        }
    }

    /// The next line, without its end and blanks behind it.
    pub(crate) fn next(&mut self) -> io::Result<Option<&str>> {
        if self.at >= self.text.len() {
            self.fill()?;
        }
        let text = &self.text[self.at..];
        if text.is_empty() {
            return Ok(None);
        }
        let end = memchr(self.line_end, text.as_bytes()).unwrap_or(text.len());
        self.at += end + 1;
        Ok(Some(trim_end(&text[..end])))
    }

    /// Reads on until there is a whole line, or to the end.
    fn fill(&mut self) -> io::Result<()> {
        let mut bytes = std::mem::take(&mut self.text).into_bytes();
        bytes.clear();
        self.at = 0;
        loop {
            let chunk = self.reader.fill_buf()?;
            let length = chunk.len();
            let whole = memrchr(self.line_end, chunk).map_or(0, |n| n + 1);
            if whole > 0 || length == 0 {
                bytes.append(&mut self.rest);
                bytes.extend_from_slice(&chunk[..whole]);
            }
            self.rest.extend_from_slice(&chunk[whole..]);
            self.reader.consume(length);
            if whole > 0 || length == 0 {
                break;
            }
            self.rest.truncate(MAX_LINE_BYTES);
        }
        self.text = String::from_utf8(bytes)
            .unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned());
        Ok(())
    }
}

/// Without blanks and carriage returns, but with the delimiter that a tab may be.
pub(crate) fn trim_end(line: &str) -> &str {
    line.trim_end_matches(['\r', ' '])
}
