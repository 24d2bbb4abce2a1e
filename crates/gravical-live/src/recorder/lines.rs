//! Bytes of the board to lines, and what is put before a line in the file: nothing, the time of arrival
//! where the board sends no time, a mark where the user names the columns.

use gravical_judge::escape::shown;
use gravical_recording::{Form, LineKind};

/// A longer line is no row of a board: it is passed on in pieces.
const MAX_LINE: usize = 4096;
/// The column of arrival times.
const HOST_TIME: &str = "t_host_ms";
/// Between the time of arrival and a line of words, as the Arduino IDE writes it.
const ARROW: &str = " -> ";
/// Bytes of the time before it: `12:34:56.789`.
const TIME_BYTES: usize = 12;
/// Fields of a row at least, and of a header.
const MIN_FIELDS: usize = 3;

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
            for piece in piece.chunks(MAX_LINE) {
                self.partial.extend_from_slice(piece);
                let is_end = piece.ends_with(b"\n");
                if is_end || self.partial.len() >= MAX_LINE {
                    let mut line = std::mem::take(&mut self.partial);
                    line.truncate(line.len() - usize::from(is_end));
                    line.pop_if(|last| *last == b'\r');
                    lines.push((line, std::mem::replace(&mut self.is_synced, is_end)));
                }
            }
        }
        lines
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

    /// The line as it stands in the file. Noise in a comment is escaped: it could be taken for another
    /// encoding of the file.
    pub fn in_file(&self) -> Vec<u8> {
        if self.is_comment() {
            let text = String::from_utf8_lossy(&self.text);
            return format!("{}\n", shown(&text)).into_bytes();
        }
        [self.prefix.as_bytes(), &self.text, b"\n"].concat()
    }
}

/// A line that names other columns, unless it is noise: rows that fit it have to follow.
pub struct OtherHeader {
    delimiter: u8,
    fields: usize,
    /// Rows that fit it.
    pub rows: u32,
    /// The line itself and those below it.
    pub lines: Vec<(Line, LineKind)>,
}

impl OtherHeader {
    pub fn new(line: Line) -> Self {
        // Names may have blanks in them.
        let count = |delimiter: &u8| split(&line.text, *delimiter).count();
        let delimiter = b"\t;,".iter().copied().max_by_key(count);
        let delimiter = delimiter.filter(|delimiter| count(delimiter) > 1);
        let delimiter = delimiter.unwrap_or(b' ');
        OtherHeader {
            delimiter,
            fields: count(&delimiter),
            rows: 0,
            lines: vec![(line, LineKind::Rejected)],
        }
    }

    /// Rows of these columns in a line that fits, 0 in a comment and a blank line, which may stand between header
    /// and rows; none for any other line.
    pub fn rows_in(&self, line: &Line) -> Option<u32> {
        if line.is_comment() || line.text.is_empty() {
            return Some(0);
        }
        let is_number = |cell: &&[u8]| {
            let cell = String::from_utf8_lossy(cell).replace(',', ".");
            cell.trim().is_empty() || cell.trim().parse::<f64>().is_ok()
        };
        let cells: Vec<&[u8]> = split(&line.text, self.delimiter).collect();
        (cells.len() == self.fields && cells.iter().all(is_number)).then_some(1)
    }
}

/// Fields of a line; several blanks are one.
fn split(line: &[u8], delimiter: u8) -> impl Iterator<Item = &[u8]> {
    let cells = line.split(move |byte| *byte == delimiter);
    cells.filter(move |cell| delimiter != b' ' || !cell.is_empty())
}

/// What is put before the lines of a board.
pub struct Prefixes {
    /// The board sends a time.
    pub has_clock: bool,
    /// What parts the columns; none for lines of words.
    delimiter: Option<u8>,
    /// The user names the columns: a header of the board is a comment.
    is_named: bool,
    /// When the first line arrived, s, and the time of day at the time zero, s (UTC).
    from_s: Option<f64>,
    day_s: f64,
}

impl Prefixes {
    /// As in a file that begins like this, which is continued.
    pub fn of_file(head: &[u8], day_s: f64) -> Self {
        let head = String::from_utf8_lossy(head);
        let after_name = |line: &str| line.strip_prefix(HOST_TIME)?.bytes().next();
        let delimiter = head.lines().find_map(after_name);
        let is_arrow = |rest: &str| rest.starts_with(ARROW);
        let is_stamped = |line: &str| line.get(TIME_BYTES..).is_some_and(is_arrow);
        let has_clock = delimiter.is_none() && !head.lines().any(is_stamped);
        Prefixes {
            has_clock,
            delimiter,
            is_named: false,
            from_s: None,
            day_s,
        }
    }

    /// The format of the rows is known, and whether the user names the columns.
    pub fn set_form(&mut self, form: &Form, is_named: bool) {
        (self.has_clock, self.delimiter) = (form.has_clock, form.delimiter);
        self.is_named = is_named;
    }

    /// A header that is made here, for the board sends none, or the user names the columns.
    pub fn header(&self, form: &Form) -> Option<String> {
        let is_made = self.is_named || form.header_line == 0 && !self.has_clock;
        let delimiter = char::from(self.delimiter.filter(|_| is_made)?).to_string();
        let time = (!self.has_clock).then(|| HOST_TIME.to_owned());
        let names: Vec<String> = time.into_iter().chain(form.roles.clone()).collect();
        Some(names.join(&delimiter))
    }

    /// What stands before a line that arrived at `at_s`.
    pub fn before(&mut self, line: &[u8], at_s: f64) -> String {
        let is_unchanged = self.has_clock && !self.is_named;
        if is_unchanged || line.is_empty() || line.starts_with(b"#") {
            return String::new();
        }
        let since_s = at_s - *self.from_s.get_or_insert(at_s);
        let Some(delimiter) = self.delimiter.map(char::from) else {
            // Cut, not rounded: no second has 60.000.
            let ms = (1e3 * (self.day_s + at_s)) as u64;
            let (h, m, s) = (ms / 3_600_000 % 24, ms / 60_000 % 60, ms / 1000 % 60);
            let time = format!("{h:02}:{m:02}:{s:02}.{:03}{ARROW}", ms % 1000);
            return if self.has_clock { String::new() } else { time };
        };
        let line = String::from_utf8_lossy(line);
        let begins_number = |field: &str| {
            let first = field.trim_start().bytes().next();
            first.is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(&b))
        };
        let is_row = line.split(delimiter).any(begins_number);
        let is_header = !is_row && line.split(delimiter).count() >= MIN_FIELDS;
        match (is_row, self.has_clock) {
            (true, false) => format!("{:.1}{delimiter}", 1e3 * since_s),
            _ if is_header && self.is_named => "# ".to_owned(),
            (false, false) if is_header => format!("{HOST_TIME}{delimiter}"),
            _ => String::new(),
        }
    }
}
