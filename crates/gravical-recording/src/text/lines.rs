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
    /// Whether there are NUL bytes in the lines, and the last line without them.
    has_nul: bool,
    cleaned: String,
}

impl<R: BufRead> Lines<R> {
    pub(crate) fn new(reader: R, line_end: u8) -> Self {
        Lines {
            reader,
            line_end,
            text: String::new(),
            at: 0,
            rest: Vec::new(),
            has_nul: false,
            cleaned: String::new(),
        }
    }

    /// Goes on with another reader.
    pub(crate) fn set_reader(&mut self, reader: R) {
        self.reader = reader;
    }

    /// The next line, without its end and blanks behind it, and whether NUL bytes were removed.
    pub(crate) fn next(&mut self) -> io::Result<Option<(&str, bool)>> {
        if self.at >= self.text.len() {
            self.fill()?;
        }
        let text = &self.text[self.at..];
        if text.is_empty() {
            return Ok(None);
        }
        let end = memchr(self.line_end, text.as_bytes()).unwrap_or(text.len());
        self.at += end + 1;
        let line = &text[..end];
        if self.has_nul && memchr(0, line.as_bytes()).is_some() {
            self.cleaned = line.replace('\0', "");
            return Ok(Some((trim_end(&self.cleaned), true)));
        }
        Ok(Some((trim_end(line), false)))
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
        self.has_nul = memchr(0, &bytes).is_some();
        self.text = String::from_utf8(bytes)
            .unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned());
        Ok(())
    }
}

/// Without blanks and carriage returns, but with the delimiter that a tab may be.
pub(crate) fn trim_end(line: &str) -> &str {
    line.trim_end_matches(['\r', ' '])
}
