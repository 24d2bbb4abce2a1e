//! Lines of a byte stream, read in blocks, in memory that does not grow.

use std::io::{self, ErrorKind, Read};

use memchr::memchr;

/// Further bytes of a line are dropped: such a line is not a row of numbers, and memory must not
/// grow.
pub const MAX_LINE: usize = 1 << 20;

/// Initial size of the buffer: small enough to stay in the cache between filling and scanning.
const BLOCK: usize = 256 << 10;

/// Number of `\r` that are removed: a line end that was translated twice has two.
const MOST_RETURNS: usize = 2;

const BYTE_ORDER_MARK: [u8; 3] = [0xEF, 0xBB, 0xBF];

/// One line, borrowed from [`Lines`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line<'a> {
    /// The line without terminator, without one or two `\r` at its end, without NUL
    /// bytes; at most [`MAX_LINE`] bytes, the rest is skipped.
    pub bytes: &'a [u8],
    /// Line number, from 1.
    pub number: u64,
    /// `false` for a last line without a terminator.
    pub terminated: bool,
    /// Number of NUL bytes that were removed; a crash of the logger can leave them.
    pub nul_bytes: usize,
}

/// Reads a byte stream line by line.
///
/// Lines are borrowed from the reader's buffer, so nothing is allocated per line. An UTF-8 byte
/// order mark at the very start is skipped. Empty input has no lines; a terminator at the end
/// does not start another line.
///
/// ```
/// use gravical::scan::Lines;
///
/// let mut lines = Lines::new(&b"t,ax\n0.01,9.8\r\n0.0"[..]);
/// let mut seen = Vec::new();
/// while let Some(line) = lines.next_line()? {
///     seen.push((line.number, line.bytes.to_vec(), line.terminated));
/// }
/// assert_eq!(seen[1], (2, b"0.01,9.8".to_vec(), true));
/// assert_eq!(seen[2], (3, b"0.0".to_vec(), false));
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Lines<R> {
    reader: R,
    terminator: u8,
    /// [`BLOCK`] and [`MAX_LINE`]; smaller in tests.
    block: usize,
    max_line: usize,
    buffer: Vec<u8>,
    /// Bytes read and not yet returned: `buffer[start..end]`.
    start: usize,
    end: usize,
    /// There is no NUL in the window from here on.
    nul_end: usize,
    /// NULs already removed from the line that starts the window.
    nul_bytes: usize,
    number: u64,
    /// Range of the line that was returned last.
    lent: std::ops::Range<usize>,
    at_start: bool,
    at_end: bool,
}

/// Position of the next line, before NULs are removed.
struct Found {
    /// End of its bytes in the buffer.
    end: usize,
    /// Start of the line after it.
    next: usize,
    terminated: bool,
}

impl<R: Read> Lines<R> {
    /// Lines that end with `\n` (or `\r\n`).
    pub fn new(reader: R) -> Self {
        Lines::with_sizes(reader, BLOCK, MAX_LINE)
    }

    /// `block` must be at least 4.
    fn with_sizes(reader: R, block: usize, max_line: usize) -> Self {
        Lines {
            reader,
            terminator: b'\n',
            block,
            max_line,
            buffer: vec![0; block],
            start: 0,
            end: 0,
            nul_end: 0,
            nul_bytes: 0,
            number: 0,
            lent: 0..0,
            at_start: true,
            at_end: false,
        }
    }

    /// Sets another terminator: `b'\r'` for files without `\n`. Allowed after
    /// [`peek`](Self::peek) and between lines.
    #[must_use]
    pub fn with_terminator(mut self, terminator: u8) -> Self {
        self.terminator = terminator;
        self
    }

    /// The next `n` bytes, without consuming them; fewer at the end of the input and beyond
    /// [`MAX_LINE`]. NULs are included, a byte order mark is not.
    ///
    /// # Errors
    ///
    /// Errors of the reader; nothing is lost, and the call can be repeated.
    pub fn peek(&mut self, n: usize) -> io::Result<&[u8]> {
        let n = n.min(self.max_line);
        self.skip_byte_order_mark()?;
        while self.end - self.start < n && self.fill()? > 0 {}
        let length = n.min(self.end - self.start);
        Ok(&self.buffer[self.start..self.start + length])
    }

    /// The next line, `None` at the end of the input.
    ///
    /// # Errors
    ///
    /// Errors of the reader; nothing is lost, and the call can be repeated.
    #[inline]
    pub fn next_line(&mut self) -> io::Result<Option<Line<'_>>> {
        let found = match memchr(self.terminator, &self.buffer[self.start..self.end]) {
            // After the first line there is no byte order mark to skip.
            Some(length) if !self.at_start => Found {
                end: self.start + length,
                next: self.start + length + 1,
                terminated: true,
            },
            _ => match self.find()? {
                Some(found) => found,
                None => return Ok(None),
            },
        };
        let start = self.start;
        let mut end = found.end;
        if start < self.nul_end {
            end = self.remove_nuls(start, end);
        }
        for _ in 0..MOST_RETURNS {
            if end > start && self.buffer[end - 1] == b'\r' {
                end -= 1;
            }
        }
        self.start = found.next;
        self.number += 1;
        self.lent = start..end.min(start + self.max_line);
        Ok(Some(Line {
            bytes: &self.buffer[self.lent.clone()],
            number: self.number,
            terminated: found.terminated,
            nul_bytes: std::mem::take(&mut self.nul_bytes),
        }))
    }

    /// The bytes of the line that [`next_line`](Self::next_line) returned last; undefined after
    /// other calls.
    #[must_use]
    pub fn current(&self) -> &[u8] {
        self.buffer.get(self.lent.clone()).unwrap_or_default()
    }

    /// Reads until the window starts with a complete line.
    #[inline(never)]
    fn find(&mut self) -> io::Result<Option<Found>> {
        self.skip_byte_order_mark()?;
        let mut searched = 0;
        loop {
            let window = &self.buffer[self.start + searched..self.end];
            if let Some(length) = memchr(self.terminator, window) {
                let end = self.start + searched + length;
                return Ok(Some(Found {
                    end,
                    next: end + 1,
                    terminated: true,
                }));
            }
            searched = self.end - self.start;
            if searched >= self.max_line + self.block / 2 {
                // All of this is one line: drop the part that exceeds it.
                if self.start < self.nul_end {
                    self.end = self.remove_nuls(self.start, self.end);
                    self.nul_end = self.start;
                }
                // One byte more than a line and its `\r`s shows that the line is too long.
                self.end = self.end.min(self.start + self.max_line + 1 + MOST_RETURNS);
                searched = self.end - self.start;
            }
            if self.fill()? == 0 {
                let line_left = searched > 0 || self.nul_bytes > 0;
                return Ok(line_left.then_some(Found {
                    end: self.end,
                    next: self.end,
                    terminated: false,
                }));
            }
        }
    }

    /// Reads once and returns the number of bytes; 0 is the end of the input.
    fn fill(&mut self) -> io::Result<usize> {
        if self.at_end {
            return Ok(0);
        }
        // Move the rest to the front only if the free space is small.
        if self.start > 0
            && (self.start == self.end || self.buffer.len() - self.end < self.block / 2)
        {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.nul_end = self.nul_end.saturating_sub(self.start);
            self.start = 0;
        }
        if self.end == self.buffer.len() {
            // Room for the longest line and further reading; `find` keeps it free.
            let larger = 2 * self.buffer.len();
            self.buffer
                .resize(larger.min(self.max_line + self.block), 0);
        }
        let count = loop {
            match self.reader.read(&mut self.buffer[self.end..]) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                result => break result?,
            }
        };
        let block = self.end..self.end + count;
        self.end = block.end;
        self.at_end = count == 0;
        if memchr(0, &self.buffer[block]).is_some() {
            self.nul_end = self.end;
        }
        Ok(count)
    }

    /// Removes NULs from `start..end` and returns the new end.
    #[cold]
    fn remove_nuls(&mut self, start: usize, end: usize) -> usize {
        let mut kept = start;
        for position in start..end {
            let byte = self.buffer[position];
            self.buffer[kept] = byte;
            kept += usize::from(byte != 0);
        }
        self.nul_bytes += end - kept;
        kept
    }

    fn skip_byte_order_mark(&mut self) -> io::Result<()> {
        if !self.at_start {
            return Ok(());
        }
        while self.end - self.start < BYTE_ORDER_MARK.len() && self.fill()? > 0 {}
        if self.buffer[self.start..self.end].starts_with(&BYTE_ORDER_MARK) {
            self.start += BYTE_ORDER_MARK.len();
        }
        self.at_start = false;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
