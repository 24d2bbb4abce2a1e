//! How a text recording is written: delimiter, header, where the data begin.
//! Found from the head of the file.

use crate::scan::{parse_field, parse_field_decimal_comma};

use super::row::{Delimiter, parse_date, quoted_end};

/// How many lines of the head are looked at.
const LINES: usize = 400;

/// The way a file is written.
#[derive(Debug, Clone)]
pub struct Dialect {
    /// What stands between the fields.
    pub delimiter: Delimiter,
    /// `1,5` is one and a half.
    pub decimal_comma: bool,
    /// Fields of a data row.
    pub fields: usize,
    /// The header: its line number (the last one, of two) and one name a
    /// field; none when the data begin without.
    pub header: Option<Header>,
    /// Line number, from 1, of the first data row.
    pub first_data_line: u64,
    /// Lines before the header that look like `key, value`.
    pub metadata: Vec<(String, String)>,
    /// Values of the first data rows, NaN where empty or text.
    pub sample: Vec<Vec<f64>>,
}

impl Dialect {
    /// For people: `comma separated, header in line 1`.
    #[must_use]
    pub fn description(&self) -> String {
        let header = match &self.header {
            Some(h) if h.lines[0] != h.lines[1] => {
                format!("header in lines {} and {}", h.lines[0], h.lines[1])
            }
            Some(h) => format!("header in line {}", h.lines[0]),
            None => "no header".to_owned(),
        };
        let comma = if self.decimal_comma {
            ", decimal comma"
        } else {
            ""
        };
        format!("{} separated{comma}, {header}", self.delimiter.name())
    }
}

/// The line that names the columns.
#[derive(Debug, Clone)]
pub struct Header {
    /// First and last line number (two when there are two header rows).
    pub lines: [u64; 2],
    /// Column names; of two rows `upper.lower`.
    pub names: Vec<String>,
    /// The last header line as it stands, trimmed, to know it again.
    pub text: Vec<u8>,
}

/// What one cell of the head looks like.
#[derive(Clone, Copy, PartialEq)]
enum Cell {
    Number(f64),
    Empty,
    Text,
}

struct HeadLine<'a> {
    number: u64,
    text: &'a [u8],
}

/// Looks at the head of a file. `whole` says that the head is all there is.
/// None when nothing in it looks like rows of numbers.
#[must_use]
pub fn sniff(head: &[u8], whole: bool, min_columns: usize) -> Option<Dialect> {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let end = terminator(head);
    let mut lines: Vec<HeadLine<'_>> = head
        .split(|&b| b == end)
        .enumerate()
        .map(|(i, text)| HeadLine {
            number: i as u64 + 1,
            text: text.trim_ascii_end(),
        })
        .collect();
    if !whole || lines.last().is_some_and(|l| l.text.is_empty()) {
        lines.pop();
    }
    // Metadata can be long; the data are what repeats, so look from the end
    // too when there is more than is looked at.
    let shown = &lines[..lines.len().min(LINES)];
    let best = candidates(shown, min_columns).or_else(|| candidates(&lines, min_columns))?;
    Some(finish(best, &lines))
}

/// `\r` for the few files that end their lines so, else `\n`.
#[must_use]
pub fn terminator(head: &[u8]) -> u8 {
    if memchr::memchr(b'\n', head).is_none() && memchr::memchr(b'\r', head).is_some() {
        b'\r'
    } else {
        b'\n'
    }
}

struct Candidate {
    delimiter: Delimiter,
    decimal_comma: bool,
    fields: usize,
    rows: usize,
}

/// The way of cutting that gives the most rows of numbers with the same
/// number of fields; the order decides ties.
fn candidates(lines: &[HeadLine<'_>], min_columns: usize) -> Option<Candidate> {
    let ways = [
        (Delimiter::Byte(b','), false),
        (Delimiter::Byte(b';'), false),
        (Delimiter::Byte(b'\t'), false),
        (Delimiter::Byte(b'|'), false),
        (Delimiter::Whitespace, false),
        (Delimiter::Byte(b';'), true),
        (Delimiter::Byte(b'\t'), true),
        (Delimiter::Whitespace, true),
    ];
    let mut best: Option<Candidate> = None;
    for (delimiter, decimal_comma) in ways {
        let mut counts: Vec<(usize, usize)> = Vec::new();
        for line in lines {
            let cells = cells(line.text, delimiter, decimal_comma);
            if is_data(&cells, min_columns) {
                match counts.iter_mut().find(|(fields, _)| *fields == cells.len()) {
                    Some((_, n)) => *n += 1,
                    None => counts.push((cells.len(), 1)),
                }
            }
        }
        // The most frequent; of equals the one with more fields.
        let Some(&(fields, rows)) = counts.iter().max_by_key(|(fields, n)| (*n, *fields)) else {
            continue;
        };
        if best.as_ref().is_none_or(|b| rows > b.rows) {
            best = Some(Candidate {
                delimiter,
                decimal_comma,
                fields,
                rows,
            });
        }
    }
    best
}

/// A row of a recording: numbers, at most two texts (a label, a date), and at
/// least two numbers (a recorder that writes each channel when it arrives
/// leaves most cells empty).
fn is_data(cells: &[Cell], min_columns: usize) -> bool {
    let numbers = cells
        .iter()
        .filter(|c| matches!(c, Cell::Number(_)))
        .count();
    let texts = cells.iter().filter(|c| **c == Cell::Text).count();
    cells.len() >= min_columns && numbers >= 2.min(min_columns) && texts <= 2 && numbers > texts
}

fn cells(line: &[u8], delimiter: Delimiter, decimal_comma: bool) -> Vec<Cell> {
    split(line, delimiter)
        .into_iter()
        .map(|field| {
            let field = field.trim_ascii();
            if field.is_empty() || field.eq_ignore_ascii_case(b"nan") || field == b"\"\"" {
                return Cell::Empty;
            }
            let number = if decimal_comma {
                parse_field_decimal_comma(field).or_else(|| parse_field(field))
            } else {
                parse_field(field)
            };
            match number.or_else(|| parse_date(field)) {
                Some(value) => Cell::Number(value),
                None => Cell::Text,
            }
        })
        .collect()
}

/// Cuts a line; quoted fields as the scanner of the rows cuts them.
fn split(line: &[u8], delimiter: Delimiter) -> Vec<Vec<u8>> {
    match delimiter {
        Delimiter::Whitespace => line
            .split(|b| *b == b' ' || *b == b'\t')
            .filter(|f| !f.is_empty())
            .map(<[u8]>::to_vec)
            .collect(),
        Delimiter::Byte(d) if line.contains(&b'"') => split_quoted(line, d),
        Delimiter::Byte(d) => line.split(|b| *b == d).map(<[u8]>::to_vec).collect(),
    }
}

fn split_quoted(line: &[u8], delimiter: u8) -> Vec<Vec<u8>> {
    let mut fields = Vec::new();
    let mut at = 0;
    loop {
        // White space in front of a quote, but not a delimiter that is a tab.
        let space = |b: &&u8| matches!(**b, b' ' | b'\t') && **b != delimiter;
        at += line[at..].iter().take_while(space).count();
        let end = match line.get(at) {
            Some(b'"') => quoted_end(line, at, delimiter),
            _ => memchr::memchr(delimiter, &line[at..]).map_or(line.len(), |n| at + n),
        };
        fields.push(unquote(&line[at..end]));
        if end == line.len() {
            return fields;
        }
        at = end + 1;
    }
}

/// A field without its quotes; `""` inside them is one quote.
fn unquote(field: &[u8]) -> Vec<u8> {
    let field = field.trim_ascii();
    let [b'"', inner @ .., b'"'] = field else {
        return field.to_vec();
    };
    let mut text = Vec::with_capacity(inner.len());
    let mut bytes = inner.iter().peekable();
    while let Some(&byte) = bytes.next() {
        text.push(byte);
        if byte == b'"' {
            bytes.next_if(|next| **next == b'"');
        }
    }
    text
}

fn finish(best: Candidate, lines: &[HeadLine<'_>]) -> Dialect {
    let cut = |text: &[u8]| cells(text, best.delimiter, best.decimal_comma);
    let is_row = |line: &HeadLine<'_>| {
        let cells = cut(line.text);
        cells.len() == best.fields && is_data(&cells, best.fields.min(3))
    };
    let first = lines.iter().position(is_row).unwrap_or(0);
    let mut header = find_header(&best, &lines[..first]);
    let open_ended = || {
        let rows = lines[first..].iter().filter(|l| is_row(l)).take(LINES);
        rows.into_iter()
            .all(|l| cut(l.text).last() == Some(&Cell::Empty))
    };
    if let Some(header) = &mut header
        && header.names.len() < best.fields
    {
        // One name less than fields: rows that end with a delimiter have an
        // empty last one, else the first is an index without a name.
        let at = if open_ended() { best.fields - 1 } else { 0 };
        header.names.insert(at, String::new());
    }
    let before = header.as_ref().map_or(first, |h| {
        lines
            .iter()
            .position(|l| l.number == h.lines[0])
            .unwrap_or(first)
    });
    let metadata = lines[..before]
        .iter()
        .filter_map(|l| key_value(l.text))
        .collect();
    let sample = lines[first..]
        .iter()
        .filter(|l| is_row(l))
        .take(LINES)
        .map(|l| {
            cut(l.text)
                .into_iter()
                .map(|c| match c {
                    Cell::Number(v) => v,
                    _ => f64::NAN,
                })
                .collect()
        })
        .collect();
    Dialect {
        delimiter: best.delimiter,
        decimal_comma: best.decimal_comma,
        fields: best.fields,
        header,
        first_data_line: lines.get(first).map_or(1, |l| l.number),
        metadata,
        sample,
    }
}

/// The last line before the data that has as many fields as they, or one less,
/// and is text; with the line above it when that is a header row too.
fn find_header(best: &Candidate, before: &[HeadLine<'_>]) -> Option<Header> {
    let names_of = |line: &HeadLine<'_>| -> Option<Vec<String>> {
        let text = strip_comment(line.text);
        let names: Vec<String> = split(text, best.delimiter)
            .iter()
            .map(|f| decode(f.trim_ascii()))
            .collect();
        let named = names
            .iter()
            .filter(|n| n.chars().any(char::is_alphabetic))
            .count();
        let fits = names.len() == best.fields || names.len() + 1 == best.fields;
        (fits && named * 2 > names.len()).then_some(names)
    };
    let last = before.iter().rposition(|l| !l.text.is_empty())?;
    let mut names = names_of(&before[last])?;
    let mut lines = [before[last].number; 2];
    // Two header rows: the upper names the sensor, the lower the channel.
    if let Some(upper_at) = last.checked_sub(1)
        && let Some(upper) = names_of(&before[upper_at])
        && upper.len() == names.len()
        && repeats(&upper)
        && repeats(&names)
    {
        names = upper
            .iter()
            .zip(&names)
            .map(|(upper, lower)| format!("{upper}.{lower}"))
            .collect();
        lines[0] = before[upper_at].number;
    }
    Some(Header {
        lines,
        names,
        text: before[last].text.to_vec(),
    })
}

fn repeats(names: &[String]) -> bool {
    names
        .iter()
        .enumerate()
        .any(|(i, n)| names[..i].contains(n))
}

/// A header behind a comment sign (`# t ax ay az`) is a header.
fn strip_comment(text: &[u8]) -> &[u8] {
    let text = text.trim_ascii();
    ["#", "%", "//"]
        .iter()
        .find_map(|sign| text.strip_prefix(sign.as_bytes()))
        .unwrap_or(text)
        .trim_ascii()
}

/// Text of a header: UTF-8, else Windows-1252 (Latin-1's degree sign).
#[must_use]
pub fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => encoding_rs::WINDOWS_1252.decode(bytes).0.into_owned(),
    }
}

/// `Fs,100` or `# rate: 100` → ("fs", "100").
fn key_value(text: &[u8]) -> Option<(String, String)> {
    let text = decode(strip_comment(text));
    let (key, value) = text.split_once([',', ';', ':', '=', '\t'])?;
    let (key, value) = (key.trim().to_lowercase(), value.trim());
    (!key.is_empty() && !value.is_empty()).then(|| (key, value.to_owned()))
}

#[cfg(test)]
mod tests;
