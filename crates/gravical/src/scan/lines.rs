//! Lines of a byte stream, read in blocks, with flat memory.

use std::io::{self, ErrorKind, Read};

use memchr::memchr;

/// Bytes of a line beyond this many are dropped: such a line is no row of
/// numbers, and memory has to stay flat.
pub const MAX_LINE: usize = 1 << 20;

/// What the buffer starts with: small enough to stay in the cache between
/// filling and scanning.
const BLOCK: usize = 256 << 10;

const BYTE_ORDER_MARK: [u8; 3] = [0xEF, 0xBB, 0xBF];

/// One line, as [`Lines::next_line`] lends it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line<'a> {
    /// The line without terminator, without one `\r` at its end, without NUL
    /// bytes; at most [`MAX_LINE`] bytes.
    pub bytes: &'a [u8],
    /// Counted from 1.
    pub number: u64,
    /// `false` for a last line that the input ends without a terminator.
    pub terminated: bool,
    /// How many NUL bytes were removed, as a crash of the logger leaves them.
    pub nul_bytes: usize,
    /// The line was longer than [`MAX_LINE`]; the rest of it was skipped.
    pub truncated: bool,
}

/// Reads a byte stream line by line.
///
/// Lines are lent from the reader's own buffer, so nothing is allocated per
/// line. An UTF-8 byte order mark at the very start is skipped. Empty input has
/// no lines; a terminator at the end starts no further one.
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
    /// [`BLOCK`] and [`MAX_LINE`]; the tests have smaller ones.
    block: usize,
    max_line: usize,
    buffer: Vec<u8>,
    /// What was read and not yet handed out: `buffer[start..end]`.
    start: usize,
    end: usize,
    /// There is no NUL in the window from here on.
    nul_end: usize,
    /// NULs already removed from the line that starts the window.
    nul_bytes: usize,
    number: u64,
    bytes_read: u64,
    at_start: bool,
    at_end: bool,
}

/// Where the next line was found, before it is cleaned and lent.
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

    /// `block` is at least 4.
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
            bytes_read: 0,
            at_start: true,
            at_end: false,
        }
    }

    /// Lines that end with another byte: `b'\r'` for files that have no `\n` at
    /// all. May be set after [`peek`](Self::peek) and between lines.
    #[must_use]
    pub fn with_terminator(mut self, terminator: u8) -> Self {
        self.terminator = terminator;
        self
    }

    /// Bytes taken from the reader so far, a byte order mark and what still
    /// waits in the buffer included.
    #[must_use]
    pub fn bytes_read(&self) -> u64 {
        self.bytes_read
    }

    /// The next `n` bytes, which stay unread; fewer at the end of the input and
    /// beyond [`MAX_LINE`]. NULs are still among them, a byte order mark is not.
    ///
    /// # Errors
    ///
    /// What the reader reports; nothing is lost, and the call may be repeated.
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
    /// What the reader reports; nothing is lost, and the call may be repeated.
    #[inline]
    pub fn next_line(&mut self) -> io::Result<Option<Line<'_>>> {
        let found = match memchr(self.terminator, &self.buffer[self.start..self.end]) {
            // Nothing to be skipped is left in front of the second line.
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
        if end > start && self.buffer[end - 1] == b'\r' {
            end -= 1;
        }
        let truncated = end - start > self.max_line;
        self.start = found.next;
        self.number += 1;
        Ok(Some(Line {
            bytes: &self.buffer[start..end.min(start + self.max_line)],
            number: self.number,
            terminated: found.terminated,
            nul_bytes: std::mem::take(&mut self.nul_bytes),
            truncated,
        }))
    }

    /// Reads until the window starts with a whole line.
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
                // All of this is one line: what is not part of it makes room.
                if self.start < self.nul_end {
                    self.end = self.remove_nuls(self.start, self.end);
                    self.nul_end = self.start;
                }
                // One byte more than a line and its `\r` tell that it is longer.
                self.end = self.end.min(self.start + self.max_line + 2);
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

    /// Reads once, gives the number of bytes; 0 is the end of the input.
    fn fill(&mut self) -> io::Result<usize> {
        if self.at_end {
            return Ok(0);
        }
        // What is left moves down only when the read would be a small one.
        if self.start > 0
            && (self.start == self.end || self.buffer.len() - self.end < self.block / 2)
        {
            self.buffer.copy_within(self.start..self.end, 0);
            self.end -= self.start;
            self.nul_end = self.nul_end.saturating_sub(self.start);
            self.start = 0;
        }
        if self.end == self.buffer.len() {
            // At most the longest line and room to read on; `find` keeps it free.
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
        self.bytes_read += count as u64;
        self.at_end = count == 0;
        if memchr(0, &self.buffer[block]).is_some() {
            self.nul_end = self.end;
        }
        Ok(count)
    }

    /// Moves the other bytes of `start..end` together, gives their new end.
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
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[derive(Debug, Clone, PartialEq)]
    struct Owned {
        bytes: Vec<u8>,
        number: u64,
        terminated: bool,
        nul_bytes: usize,
        truncated: bool,
    }

    impl From<Line<'_>> for Owned {
        fn from(line: Line<'_>) -> Self {
            Owned {
                bytes: line.bytes.to_vec(),
                number: line.number,
                terminated: line.terminated,
                nul_bytes: line.nul_bytes,
                truncated: line.truncated,
            }
        }
    }

    /// Gives the bytes in reads of the given sizes, in turn; 0 fails once.
    struct Pieces<'a> {
        input: &'a [u8],
        sizes: &'a [usize],
        turn: usize,
        failed: bool,
    }

    impl<'a> Pieces<'a> {
        fn new(input: &'a [u8], sizes: &'a [usize]) -> Self {
            Pieces {
                input,
                sizes,
                turn: 0,
                failed: false,
            }
        }
    }

    impl Read for Pieces<'_> {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            let size = self.sizes[self.turn % self.sizes.len()];
            self.turn += 1;
            if size == 0 && !self.failed {
                self.failed = true;
                let kind = [ErrorKind::Interrupted, ErrorKind::TimedOut][self.turn % 2];
                return Err(kind.into());
            }
            self.failed = false;
            let count = size.max(1).min(out.len()).min(self.input.len());
            let (head, rest) = self.input.split_at(count);
            out[..count].copy_from_slice(head);
            self.input = rest;
            Ok(count)
        }
    }

    fn collect<R: Read>(mut lines: Lines<R>) -> Vec<Owned> {
        let mut all = Vec::new();
        loop {
            match lines.next_line() {
                Ok(Some(line)) => all.push(line.into()),
                Ok(None) => return all,
                Err(error) => assert_eq!(error.kind(), ErrorKind::TimedOut),
            }
        }
    }

    /// The same from the whole input at once.
    fn expected(input: &[u8], terminator: u8, max_line: usize) -> Vec<Owned> {
        let input = input.strip_prefix(&BYTE_ORDER_MARK).unwrap_or(input);
        let mut parts: Vec<&[u8]> = input.split(|&byte| byte == terminator).collect();
        let last = parts.len() - 1;
        if parts[last].is_empty() {
            parts.pop();
        }
        let clean = |(index, part): (usize, &&[u8])| {
            let mut bytes: Vec<u8> = part.iter().copied().filter(|&byte| byte != 0).collect();
            let nul_bytes = part.len() - bytes.len();
            if bytes.last() == Some(&b'\r') {
                bytes.pop();
            }
            let truncated = bytes.len() > max_line;
            bytes.truncate(max_line);
            Owned {
                bytes,
                number: index as u64 + 1,
                terminated: index < last,
                nul_bytes,
                truncated,
            }
        };
        parts.iter().enumerate().map(clean).collect()
    }

    fn texts(input: &[u8]) -> Vec<String> {
        let all = collect(Lines::new(input));
        let text = |line: Owned| String::from_utf8(line.bytes).unwrap();
        all.into_iter().map(text).collect()
    }

    #[test]
    fn line_ends() {
        assert!(texts(b"").is_empty());
        assert!(texts(b"\xEF\xBB\xBF").is_empty());
        assert_eq!(texts(b"\n\n\n"), ["", "", ""]);
        assert_eq!(texts(b"a\nb\n"), ["a", "b"]);
        assert_eq!(texts(b"a\r\nb"), ["a", "b"]);
        assert_eq!(texts(b"\xEF\xBB\xBFa\r\r\n\rb\r"), ["a\r", "\rb"]);
        let by_cr = collect(Lines::new(&b"a\r\rb"[..]).with_terminator(b'\r'));
        assert_eq!(by_cr, expected(b"a\r\rb", b'\r', MAX_LINE));
        assert_eq!(by_cr.len(), 3);
        assert!(by_cr[1].terminated && !by_cr[2].terminated);
    }

    #[test]
    fn nul_bytes_are_removed_and_counted_per_line() {
        let all = collect(Lines::new(&b"1,\0\0x\n3,4\r\0\n\0\0\0"[..]));
        let seen: Vec<_> = all.iter().map(|l| (&l.bytes[..], l.nul_bytes)).collect();
        assert_eq!(seen, [(&b"1,x"[..], 2), (b"3,4", 1), (b"", 3)]);
        assert!(!all[2].terminated);
    }

    #[test]
    fn long_lines_at_the_real_sizes() {
        for (length, end, truncated) in [
            (MAX_LINE, "\n", false),
            (MAX_LINE, "\r\n", false),
            (MAX_LINE, "", false),
            (MAX_LINE + 1, "\n", true),
            (MAX_LINE + 1, "\r\n", true),
            (MAX_LINE + 2, "", true),
            (5 * MAX_LINE + 17, "\n", true),
            (5 * MAX_LINE + 17, "\r", true),
        ] {
            let input = format!("first\n{}{end}", "x".repeat(length));
            let input = input + if end.ends_with('\n') { "last" } else { "" };
            let mut lines = Lines::new(Pieces::new(input.as_bytes(), &[100_000, 7]));
            let mut all: Vec<Owned> = Vec::new();
            while let Some(line) = lines.next_line().unwrap() {
                all.push(line.into());
            }
            assert_eq!(all, expected(input.as_bytes(), b'\n', MAX_LINE));
            assert_eq!(all[1].truncated, truncated, "{length} {end:?}");
            assert!(lines.buffer.len() <= MAX_LINE + BLOCK);
            assert_eq!(lines.bytes_read(), input.len() as u64);
        }
    }

    #[test]
    fn a_hole_of_nuls_is_no_long_line() {
        let hole = 3 * MAX_LINE;
        let input = [b"1,2".to_vec(), vec![0; hole], b",3\n4".to_vec()].concat();
        let all = collect(Lines::new(&input[..]));
        assert_eq!(all[0].bytes, b"1,2,3");
        assert_eq!((all[0].nul_bytes, all[0].truncated), (hole, false));
        assert_eq!(all[1].bytes, b"4");
    }

    #[test]
    fn peek_leaves_everything_unread() {
        let input = "t,ax\n".repeat(300_000);
        let marked = [&BYTE_ORDER_MARK, input.as_bytes()].concat();
        let mut lines = Lines::new(&marked[..]);
        assert_eq!(lines.peek(0).unwrap(), b"");
        assert_eq!(lines.peek(4).unwrap(), b"t,ax");
        assert_eq!(lines.peek(600_000).unwrap(), &input.as_bytes()[..600_000]);
        assert_eq!(lines.peek(usize::MAX).unwrap().len(), MAX_LINE);
        assert_eq!(lines.next_line().unwrap().unwrap().number, 1);
        assert_eq!(lines.peek(2).unwrap(), b"t,");
        assert_eq!(collect(lines).len(), 299_999);
        assert_eq!(Lines::new(&b"ab"[..]).peek(10).unwrap(), b"ab");
    }

    fn inputs() -> impl Strategy<Value = Vec<u8>> {
        let byte = prop_oneof![
            6 => Just(b'x'), 2 => Just(b','), 3 => Just(b'\n'), 2 => Just(b'\r'), 2 => Just(0),
            1 => any::<u8>(),
        ];
        let body = proptest::collection::vec(byte, 0..300);
        (any::<bool>(), body).prop_map(|(mark, body)| {
            let mark = if mark { &BYTE_ORDER_MARK[..] } else { &[] };
            [mark, &body].concat()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// However the input is cut into reads, wherever blocks end, and when
        /// reads fail in between, the lines are the same.
        #[test]
        fn the_cuts_do_not_show(
            input in inputs(),
            sizes in proptest::collection::vec(0_usize..20, 1..8),
            block in 4_usize..40,
            max_line in 1_usize..60,
            cr: bool,
        ) {
            let terminator = if cr { b'\r' } else { b'\n' };
            let lines = Lines::with_sizes(Pieces::new(&input, &sizes), block, max_line);
            let all = collect(lines.with_terminator(terminator));
            prop_assert_eq!(all, expected(&input, terminator, max_line));
        }

        #[test]
        fn peeking_does_not_show(
            input in inputs(),
            size in 1_usize..20,
            block in 4_usize..40,
            peeks in proptest::collection::vec(0_usize..80, 1..8),
        ) {
            let sizes = [size];
            let mut lines = Lines::with_sizes(Pieces::new(&input, &sizes), block, 50);
            let mut rest = input.strip_prefix(&BYTE_ORDER_MARK).unwrap_or(&input);
            let mut all: Vec<Owned> = Vec::new();
            for peek in peeks.iter().cycle() {
                let peek = *peek.min(&50).min(&rest.len());
                prop_assert_eq!(lines.peek(peek).unwrap(), &rest[..peek]);
                let Some(line) = lines.next_line().unwrap() else { break };
                all.push(line.into());
                let end = rest.iter().position(|&byte| byte == b'\n');
                rest = end.map_or(&[], |end| &rest[end + 1..]);
            }
            prop_assert_eq!(all, expected(&input, b'\n', 50));
            prop_assert_eq!(lines.bytes_read(), input.len() as u64);
        }
    }
}
