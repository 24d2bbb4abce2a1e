//! Lines of a stream.

use std::io::{self, BufRead, Read};

use memchr::memchr;

/// Bytes of a line that are kept: what is longer is no text.
const MAX_LINE_BYTES: usize = 1 << 20;

pub(crate) struct Lines<R> {
    reader: R,
    line_end: u8,
    bytes: Vec<u8>,
    /// The line without NUL bytes, and without bytes that are no UTF-8.
    cleaned: String,
}

impl<R: BufRead> Lines<R> {
    pub(crate) fn new(reader: R, line_end: u8) -> Self {
        Lines {
            reader,
            line_end,
            bytes: Vec::new(),
            cleaned: String::new(),
        }
    }

    /// Goes on with another reader.
    pub(crate) fn set_reader(&mut self, reader: R) {
        self.reader = reader;
    }

    /// The next line, without its end and blanks behind it, and whether NUL bytes were removed.
    pub(crate) fn next(&mut self) -> io::Result<Option<(&str, bool)>> {
        self.bytes.clear();
        let mut kept = self.reader.by_ref().take(MAX_LINE_BYTES as u64);
        if kept.read_until(self.line_end, &mut self.bytes)? == 0 {
            return Ok(None);
        }
        if self.bytes.len() == MAX_LINE_BYTES && !self.bytes.ends_with(&[self.line_end]) {
            self.reader.skip_until(self.line_end)?;
        }
        let line = self.bytes.strip_suffix(&[self.line_end]);
        let line = line.unwrap_or(&self.bytes);
        let has_nul = memchr(0, line).is_some();
        if !has_nul && let Ok(line) = std::str::from_utf8(line) {
            return Ok(Some((trim_end(line), false)));
        }
        self.cleaned = String::from_utf8_lossy(line).replace('\0', "");
        Ok(Some((trim_end(&self.cleaned), has_nul)))
    }
}

/// Without blanks and carriage returns, but with the delimiter that a tab may be.
pub(crate) fn trim_end(line: &str) -> &str {
    line.trim_end_matches(['\r', ' '])
}
