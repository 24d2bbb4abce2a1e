use super::*;
use proptest::prelude::*;

#[derive(Debug, Clone, PartialEq)]
struct Owned {
    bytes: Vec<u8>,
    number: u64,
    terminated: bool,
    nul_bytes: usize,
}

impl From<Line<'_>> for Owned {
    fn from(line: Line<'_>) -> Self {
        Owned {
            bytes: line.bytes.to_vec(),
            number: line.number,
            terminated: line.terminated,
            nul_bytes: line.nul_bytes,
        }
    }
}

/// Delivers the bytes in reads of the given sizes; a size of 0 fails once.
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

/// The expected lines, from the whole input at once.
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
        for _ in 0..2 {
            bytes.pop_if(|last| *last == b'\r');
        }
        bytes.truncate(max_line);
        Owned {
            bytes,
            number: index as u64 + 1,
            terminated: index < last,
            nul_bytes,
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
    assert_eq!(texts(b"\xEF\xBB\xBFa\r\r\r\n\rb\r\r\n"), ["a\r", "\rb"]);
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
fn long_lines_are_truncated() {
    for (length, end) in [
        (MAX_LINE, "\n"),
        (MAX_LINE, "\r\n"),
        (MAX_LINE, ""),
        (MAX_LINE + 1, "\n"),
        (MAX_LINE + 1, "\r\n"),
        (MAX_LINE + 2, ""),
        (5 * MAX_LINE + 17, "\n"),
        (5 * MAX_LINE + 17, "\r"),
    ] {
        let input = format!("first\n{}{end}", "x".repeat(length));
        let input = input + if end.ends_with('\n') { "last" } else { "" };
        let mut lines = Lines::new(Pieces::new(input.as_bytes(), &[100_000, 7]));
        let mut all: Vec<Owned> = Vec::new();
        while let Some(line) = lines.next_line().unwrap() {
            all.push(line.into());
        }
        assert_eq!(all, expected(input.as_bytes(), b'\n', MAX_LINE));
        assert!(lines.buffer.len() <= MAX_LINE + BLOCK);
    }
}

#[test]
fn a_run_of_nuls_is_not_a_long_line() {
    let hole = 3 * MAX_LINE;
    let input = [b"1,2".to_vec(), vec![0; hole], b",3\n4".to_vec()].concat();
    let all = collect(Lines::new(&input[..]));
    assert_eq!(all[0].bytes, b"1,2,3");
    assert_eq!(all[0].nul_bytes, hole);
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
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The lines do not depend on the sizes of reads and blocks, or on failing reads.
    #[test]
    fn lines_do_not_depend_on_read_sizes(
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
    fn peeking_does_not_change_the_lines(
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
    }
}
