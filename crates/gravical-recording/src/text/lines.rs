//! Lines of a stream.

use std::io::{self, BufRead, ErrorKind};

use memchr::{memchr, memrchr};

/// Bytes of a line that are kept: what is longer is no text.
const MAX_LINE_BYTES: usize = 1 << 20;

pub(crate) struct Lines<R> {
    pub(super) reader: R,
    line_end: u8,
    /// Whole lines, and where the next begins; bytes that are no UTF-8 are replaced.
    text: String,
    at: usize,
    /// The beginning of the line behind them.
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

    /// The next line, without its end.
    pub(crate) fn next(&mut self) -> io::Result<Option<&str>> {
        if self.at >= self.text.len() {
            self.fill()?;
            if self.text.is_empty() {
                return Ok(None);
            }
        }
        let rest = &self.text[self.at..];
        let line = memchr(self.line_end, rest.as_bytes()).map_or(rest, |end| &rest[..end]);
        self.at += line.len() + 1;
        Ok(Some(line))
    }

    /// Reads on to the end of a line, or of the stream.
    fn fill(&mut self) -> io::Result<()> {
        let mut bytes = std::mem::take(&mut self.text).into_bytes();
        bytes.clear();
        self.at = 0;
        bytes.append(&mut self.rest);
        loop {
            let piece = match self.reader.fill_buf() {
                Err(e) if e.kind() == ErrorKind::Interrupted => continue,
                piece => piece?,
            };
            let (read, end) = (piece.len(), memrchr(self.line_end, piece));
            bytes.extend_from_slice(piece);
            self.reader.consume(read);
            if let Some(end) = end {
                let whole = bytes.len() - read + end + 1;
                self.rest.extend_from_slice(&bytes[whole..]);
                bytes.truncate(whole);
            } else if bytes.len() >= MAX_LINE_BYTES {
                bytes.truncate(MAX_LINE_BYTES);
                self.reader.skip_until(self.line_end)?;
            } else if read > 0 {
                continue;
            }
            break;
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
