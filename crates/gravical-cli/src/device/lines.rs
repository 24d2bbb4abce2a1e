//! Bytes to lines, whatever they are torn into.

/// More bytes than this without a line break are no line of a board (they have 160 at
/// most): they are handed on in pieces.
pub const MOST_BYTES: usize = 512;

/// One line, without its end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// What stands in it, verbatim but for the line break.
    pub bytes: Vec<u8>,
    /// Both of its ends were seen: what came before it was a line break.
    pub whole: bool,
}

/// Puts lines together. The first one may have begun before anybody listened.
#[derive(Debug, Clone, Default)]
pub struct Framer {
    partial: Vec<u8>,
    synced: bool,
}

impl Framer {
    /// Takes bytes as they come; gives the lines that they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Line> {
        let mut lines = Vec::new();
        for &byte in bytes {
            if byte == b'\n' {
                lines.push(self.take(true));
            } else {
                self.partial.push(byte);
                if self.partial.len() >= MOST_BYTES {
                    lines.push(self.take(false));
                }
            }
        }
        lines
    }

    /// The port is gone: what was begun will not be ended.
    pub fn cut(&mut self) -> Option<Line> {
        let line = self.take(false);
        (!line.bytes.is_empty()).then_some(line)
    }

    /// `ended`: by a line break.
    fn take(&mut self, ended: bool) -> Line {
        let mut bytes = std::mem::take(&mut self.partial);
        while bytes.last() == Some(&b'\r') {
            bytes.pop();
        }
        let whole = self.synced && ended;
        self.synced = ended;
        Line { bytes, whole }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(lines: &[Line]) -> Vec<(String, bool)> {
        lines
            .iter()
            .map(|l| (String::from_utf8_lossy(&l.bytes).into_owned(), l.whole))
            .collect()
    }

    #[test]
    fn lines_however_they_are_torn() {
        let wire = b"9.81,1\r\n1,2\n\n3,4\r\n5,";
        let want = [("9.81,1", false), ("1,2", true), ("", true), ("3,4", true)];
        for piece in 1..wire.len() {
            let mut framer = Framer::default();
            let lines: Vec<Line> = wire.chunks(piece).flat_map(|c| framer.push(c)).collect();
            let got = texts(&lines);
            assert!(
                got.iter().map(|(t, w)| (t.as_str(), *w)).eq(want),
                "{got:?}"
            );
            let half = framer.cut().unwrap();
            assert_eq!((half.bytes.as_slice(), half.whole), (&b"5,"[..], false));
            assert_eq!(framer.cut(), None);
            // After a cut nobody knows where the next line began.
            assert!(!framer.push(b"6,7\n")[0].whole);
        }
    }

    #[test]
    fn noise_without_a_line_break_is_bounded() {
        let mut framer = Framer::default();
        let lines = framer.push(&[b'x'; 1300]);
        assert_eq!(lines.len(), 2);
        assert!(
            lines
                .iter()
                .all(|l| !l.whole && l.bytes.len() == MOST_BYTES)
        );
        let lines = framer.push(b"\n1,2\n");
        assert_eq!(texts(&lines)[1], ("1,2".to_owned(), true));
        assert!(!lines[0].whole);
    }
}
