//! What is added to the lines of a board that sends no time, or whose columns the user names.

use gravical::recording::Form;

/// The column of arrival times.
const HOST_TIME: &str = "t_host_ms";
/// Between the time of arrival and a line of words, as the Arduino IDE writes it.
const ARROW: &str = " -> ";
/// Bytes of the time before it: `12:34:56.789`.
const TIME_BYTES: usize = 12;

/// Where the time of arrival stands.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stamp {
    /// The board sends a time.
    None,
    /// In a column of its own.
    Column(u8),
    /// Before a line of words.
    Words,
}

/// How lines of the board become lines of the file.
#[derive(Debug)]
pub struct Rewrite {
    stamp: Stamp,
    /// The header that the board sends.
    header: Option<Vec<u8>>,
    /// A header that is made here, for the board sends none, or the user names the columns.
    pub made_header: Option<String>,
}

impl Rewrite {
    /// For rows of this form below this header, with columns that the user names; none if they can
    /// stand in the file as they are.
    pub fn new(form: &Form, header: Option<&[u8]>, is_named: bool) -> Option<Self> {
        let stamp = match form.delimiter {
            _ if form.has_clock => Stamp::None,
            Some(delimiter) => Stamp::Column(delimiter),
            None => Stamp::Words,
        };
        let makes_header = is_named || header.is_none() && stamp != Stamp::None;
        let made_header = form.delimiter.filter(|_| makes_header).map(|delimiter| {
            let time = matches!(stamp, Stamp::Column(_)).then(|| HOST_TIME.to_owned());
            let names: Vec<String> = time.into_iter().chain(form.roles.clone()).collect();
            names.join(&char::from(delimiter).to_string())
        });
        let is_needed = stamp != Stamp::None || made_header.is_some();
        is_needed.then(|| Rewrite {
            stamp,
            header: header.map(<[u8]>::to_vec),
            made_header,
        })
    }

    /// As in a file that begins like this, which is continued.
    pub fn of_file(head: &[u8]) -> Option<Self> {
        let lines = || head.split(|b| *b == b'\n').map(<[u8]>::trim_ascii_end);
        let header = lines().find_map(|line| line.strip_prefix(HOST_TIME.as_bytes()));
        let is_stamped = |line: &[u8]| {
            line.get(TIME_BYTES..)
                .is_some_and(|rest| rest.starts_with(ARROW.as_bytes()))
        };
        let (stamp, header) = match header.and_then(<[u8]>::split_first) {
            Some((delimiter, header)) => (Stamp::Column(*delimiter), Some(header.to_vec())),
            None if lines().any(is_stamped) => (Stamp::Words, None),
            None => return None,
        };
        Some(Rewrite {
            stamp,
            header,
            made_header: None,
        })
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

    /// Whether times are those of arrival.
    pub fn stamps(&self) -> bool {
        self.stamp != Stamp::None
    }

    /// A line of the board as it stands in the file, and how many bytes of that are a stamp. It arrived
    /// `since_s` after the first row, at the time of day `day_s`.
    pub fn line(&self, line: &[u8], since_s: f64, day_s: f64) -> (Vec<u8>, usize) {
        if self.header.as_deref() == Some(line) {
            let line = match self.stamp {
                _ if self.made_header.is_some() => [b"# ", line].concat(),
                Stamp::Column(by) => [HOST_TIME.as_bytes(), &[by], line].concat(),
                _ => line.to_vec(),
            };
            return (line, 0);
        }
        let is_comment = line.starts_with(b"#");
        let stamp = match self.stamp {
            Stamp::Column(by) if !is_comment && line.split(|b| *b == by).any(begins_number) => {
                format!("{:.1}{}", 1e3 * since_s, char::from(by))
            }
            Stamp::Words if !is_comment && line.iter().any(u8::is_ascii_digit) => {
                // Cut, not rounded: no second has 60.000.
                let ms = (1e3 * day_s) as u64;
                let (h, m, s) = (ms / 3_600_000 % 24, ms / 60_000 % 60, ms / 1000 % 60);
                format!("{h:02}:{m:02}:{s:02}.{:03}{ARROW}", ms % 1000)
            }
            _ => String::new(),
        };
        ([stamp.as_bytes(), line].concat(), stamp.len())
    }
}

fn begins_number(text: &[u8]) -> bool {
    let text = String::from_utf8_lossy(text);
    let text = text.trim_start().trim_start_matches(['-', '+', '\u{2212}']);
    text.starts_with(|c: char| c.is_ascii_digit() || c == '.')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn form(delimiter: Option<u8>, has_clock: bool) -> Form {
        Form {
            has_clock,
            delimiter,
            header_line: 0,
            head_lines: 0,
            roles: ["ax", "ay", "az"].map(str::to_owned).to_vec(),
            rate_hz: None,
        }
    }

    #[test]
    fn stamps_in_a_column_or_before_words() {
        let text = |rewrite: &Rewrite, line: &str| {
            let (line, _) = rewrite.line(line.as_bytes(), 0.0102, 86_399.999_9);
            String::from_utf8(line).unwrap()
        };
        assert!(Rewrite::new(&form(Some(b','), true), Some(b"t,ax,ay,az"), false).is_none());
        assert!(Rewrite::new(&form(Some(b','), true), None, false).is_none());
        let by_column = Rewrite::new(&form(Some(b';'), false), None, false).unwrap();
        assert_eq!(by_column.made_header.as_deref(), Some("t_host_ms;ax;ay;az"));
        assert_eq!(text(&by_column, "-1;2;3"), "10.2;-1;2;3");
        assert_eq!(text(&by_column, "+1;+2;+3"), "10.2;+1;+2;+3");
        assert_eq!(text(&by_column, "# 1;2;3"), "# 1;2;3");
        let words = Rewrite::new(&form(None, false), None, false).unwrap();
        assert_eq!(text(&words, "x: 1"), "23:59:59.999 -> x: 1");
        assert_eq!(text(&words, "hello"), "hello");
        let header = b"AccX,AccY,AccZ";
        let headed = Rewrite::new(&form(Some(b','), false), Some(header), false).unwrap();
        assert_eq!(text(&headed, "AccX,AccY,AccZ"), "t_host_ms,AccX,AccY,AccZ");
        let named = Rewrite::new(&form(Some(b','), true), Some(header), true).unwrap();
        assert_eq!(named.made_header.as_deref(), Some("ax,ay,az"));
        assert_eq!(text(&named, "AccX,AccY,AccZ"), "# AccX,AccY,AccZ");
        assert_eq!(text(&named, "1,2,3"), "1,2,3");
        // Files that are continued.
        let again = Rewrite::of_file(b"# a\nt_host_ms,AccX,AccY,AccZ\n1.0,1,2,3\n").unwrap();
        assert_eq!(text(&again, "AccX,AccY,AccZ"), "t_host_ms,AccX,AccY,AccZ");
        let again = Rewrite::of_file(b"# a\n23:59:59.999 -> x: 1\n").unwrap();
        assert_eq!(again.stamp, Stamp::Words);
        assert!(Rewrite::of_file(b"# a\nt,ax,ay,az\n1,2,3,4\n").is_none());
    }
}
