//! Bytes of the board to lines, and what is put before a line in the file: nothing, the time of arrival
//! where the board sends no time, a mark where the user names the columns.

use gravical::recording::Form;

/// A longer line is no row of a board: it is passed on in pieces.
const MAX_LINE: usize = 4096;
/// Beginning of the line with which our firmware reports its settings.
const OWN_LINE: &[u8] = b"# gravical mpu6050_logger";
/// The column of arrival times.
const HOST_TIME: &str = "t_host_ms";
/// Between the time of arrival and a line of words, as the Arduino IDE writes it.
const ARROW: &str = " -> ";
/// Bytes of the time before it: `12:34:56.789`.
const TIME_BYTES: usize = 12;

/// Splits bytes into lines.
#[derive(Default)]
pub struct Splitter {
    partial: Vec<u8>,
    /// `partial` begins behind the end of a line.
    is_synced: bool,
}

impl Splitter {
    /// The lines that these bytes complete, without their ends, and whether their beginning was
    /// received.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<(Vec<u8>, bool)> {
        let mut lines = Vec::new();
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            self.partial.extend_from_slice(piece);
            let is_end = piece.ends_with(b"\n");
            if !is_end && self.partial.len() < MAX_LINE {
                break;
            }
            let mut line = std::mem::take(&mut self.partial);
            line.truncate(line.strip_suffix(b"\n").unwrap_or(&line).len());
            line.truncate(line.strip_suffix(b"\r").unwrap_or(&line).len());
            let is_whole = std::mem::replace(&mut self.is_synced, is_end);
            // A board that is reset in a row continues the line with its settings.
            let own = line.windows(OWN_LINE.len()).position(|w| w == OWN_LINE);
            if let Some(at) = own.filter(|at| *at > 0) {
                let settings = line.split_off(at);
                lines.extend([(line, false), (settings, true)]);
            } else {
                lines.push((line, is_whole));
            }
        }
        lines
    }

    /// The line that has begun, and stays incomplete.
    pub fn cut(self) -> Vec<u8> {
        self.partial
    }
}

/// A line of the board, without its end.
pub struct Line {
    pub at_s: f64,
    /// What stands before it in the file.
    pub prefix: String,
    pub text: Vec<u8>,
}

impl Line {
    pub fn plain(at_s: f64, text: impl Into<Vec<u8>>) -> Self {
        Line {
            at_s,
            prefix: String::new(),
            text: text.into(),
        }
    }

    pub fn is_comment(&self) -> bool {
        self.text.starts_with(b"#")
    }

    /// The line as it stands in the file.
    pub fn in_file(&self) -> Vec<u8> {
        [self.prefix.as_bytes(), &self.text, b"\n"].concat()
    }
}

/// Where the time of arrival stands.
#[derive(Clone, Copy, PartialEq, Default)]
enum Stamp {
    /// Nowhere: the board sends a time.
    #[default]
    None,
    /// In a first column; what parts it from the next.
    Column(u8),
    /// Before lines of words.
    Words,
}

/// What is put before the lines of a board.
#[derive(Default)]
pub struct Prefixes {
    stamp: Stamp,
    /// The header that the board sends.
    header: Option<Vec<u8>>,
    /// A header that is made here, for the board sends none, or the user names the columns.
    pub made_header: Option<String>,
}

impl Prefixes {
    /// For rows of this form below this header, with columns that the user names.
    pub fn new(form: &Form, header: Option<&Line>, is_named: bool) -> Self {
        let stamp = match form.delimiter {
            _ if form.has_clock => Stamp::None,
            Some(delimiter) => Stamp::Column(delimiter),
            None => Stamp::Words,
        };
        let makes_header = is_named || header.is_none() && stamp != Stamp::None;
        let made_header = form.delimiter.filter(|_| makes_header).map(|delimiter| {
            let time = (!form.has_clock).then(|| HOST_TIME.to_owned());
            let names: Vec<String> = time.into_iter().chain(form.roles.clone()).collect();
            names.join(&char::from(delimiter).to_string())
        });
        Prefixes {
            stamp,
            header: header.map(|line| line.text.clone()),
            made_header,
        }
    }

    /// As in a file that begins like this, which is continued.
    pub fn of_file(head: &[u8]) -> Self {
        let lines = || head.split(|b| *b == b'\n').map(<[u8]>::trim_ascii_end);
        let header = lines().find_map(|line| line.strip_prefix(HOST_TIME.as_bytes()));
        let is_stamped = |line: &[u8]| {
            line.get(TIME_BYTES..)
                .is_some_and(|l| l.starts_with(ARROW.as_bytes()))
        };
        let (stamp, header) = match header.and_then(<[u8]>::split_first) {
            Some((delimiter, header)) => (Stamp::Column(*delimiter), Some(header.to_vec())),
            None if lines().any(is_stamped) => (Stamp::Words, None),
            None => (Stamp::None, None),
        };
        Prefixes {
            stamp,
            header,
            made_header: None,
        }
    }

    /// What the file says of it, in lines that begin with `#`.
    pub fn notes(&self) -> String {
        let mut notes = String::new();
        if self.made_header.is_some() {
            notes += "# the columns are named by gravical log\n";
        }
        if let Stamp::Column(_) = self.stamp {
            notes += &format!(
                "# {HOST_TIME}: the board sends no time; this is the time of arrival at the computer, ms since the first row\n"
            );
        }
        notes
    }

    /// Whether the file has other columns than the board sends, or names them.
    pub fn change_columns(&self) -> bool {
        self.stamps() || self.made_header.is_some()
    }

    /// Whether times are those of arrival.
    pub fn stamps(&self) -> bool {
        self.stamp != Stamp::None
    }

    /// What stands before a line that arrived `since_s` after the first, at the time of day `day_s`.
    pub fn before(&self, line: &[u8], since_s: f64, day_s: f64) -> String {
        let is_header = self.header.as_deref() == Some(line);
        if is_header && self.made_header.is_some() {
            return "# ".to_owned();
        }
        let is_number = |field: &[u8]| {
            let first = field.trim_ascii_start().first();
            first.is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(b))
        };
        match self.stamp {
            Stamp::Column(by) if is_header => format!("{HOST_TIME}{}", char::from(by)),
            _ if is_header || line.is_empty() || line.starts_with(b"#") => String::new(),
            Stamp::Column(by) if line.split(|b| *b == by).any(is_number) => {
                format!("{:.1}{}", 1e3 * since_s, char::from(by))
            }
            Stamp::Words => {
                // Cut, not rounded: no second has 60.000.
                let ms = (1e3 * day_s) as u64;
                let (h, m, s) = (ms / 3_600_000 % 24, ms / 60_000 % 60, ms / 1000 % 60);
                format!("{h:02}:{m:02}:{s:02}.{:03}{ARROW}", ms % 1000)
            }
            _ => String::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_in_any_pieces() {
        let text = b"9,1\r\n2,3\n\r\n1,0# gravical mpu6050_logger 1.2\n8";
        let expected: [(&[u8], bool); 5] = [
            (b"9,1", false),
            (b"2,3", true),
            (b"", true),
            (b"1,0", false),
            (b"# gravical mpu6050_logger 1.2", true),
        ];
        for piece in [1, 5, 1000] {
            let mut splitter = Splitter::default();
            let lines = text.chunks(piece).flat_map(|bytes| splitter.push(bytes));
            let lines: Vec<_> = lines.collect();
            let lines: Vec<_> = lines.iter().map(|(l, whole)| (&l[..], *whole)).collect();
            assert_eq!(lines, expected);
            assert_eq!(splitter.cut(), b"8");
        }
        let mut splitter = Splitter::default();
        let pieces = (0..100).flat_map(|_| splitter.push(&[b'x'; 100]));
        assert_eq!(pieces.count(), 2);
    }

    #[test]
    fn stamps_in_a_column_or_before_words() {
        let form = |delimiter: Option<u8>, has_clock: bool| Form {
            has_clock,
            delimiter,
            header_line: 0,
            head_lines: 0,
            roles: ["ax", "ay", "az"].map(str::to_owned).to_vec(),
            rate_hz: None,
        };
        let before = |prefixes: &Prefixes, line: &str| {
            prefixes.before(line.as_bytes(), 0.0102, 86_399.999_9)
        };
        let header = Line::plain(0.0, "AccX,AccY,AccZ");
        let clock = Prefixes::new(&form(Some(b','), true), None, false);
        assert!(clock.made_header.is_none() && before(&clock, "1,2,3").is_empty());
        let by_column = Prefixes::new(&form(Some(b';'), false), None, false);
        assert_eq!(by_column.made_header.as_deref(), Some("t_host_ms;ax;ay;az"));
        assert_eq!(before(&by_column, "+1;+2;+3"), "10.2;");
        assert_eq!(before(&by_column, "# 1;2;3"), "");
        let words = Prefixes::new(&form(None, false), None, false);
        assert_eq!(before(&words, "x: 1"), "23:59:59.999 -> ");
        let headed = Prefixes::new(&form(Some(b','), false), Some(&header), false);
        let named = Prefixes::new(&form(Some(b','), true), Some(&header), true);
        assert_eq!(before(&named, "AccX,AccY,AccZ"), "# ");
        assert_eq!(named.made_header.as_deref(), Some("ax,ay,az"));
        // A file that is continued.
        let again = Prefixes::of_file(b"# a\nt_host_ms,AccX,AccY,AccZ\n1.0,1,2,3\n");
        for prefixes in [headed, again] {
            assert_eq!(before(&prefixes, "AccX,AccY,AccZ"), "t_host_ms,");
            assert_eq!(before(&prefixes, "AccX,AccY,Temp"), "");
        }
        assert!(Prefixes::of_file(b"# a\n23:59:59.999 -> x: 1\n").stamp == Stamp::Words);
        assert!(!Prefixes::of_file(b"# a\nt,ax,ay,az\n1,2,3,4\n").stamps());
    }
}
