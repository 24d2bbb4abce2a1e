//! How the fields of a line are parted.

use std::collections::BTreeMap;

use super::number::{parse_cell, parse_number, parse_plain};
use crate::date::parse_date;

#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(crate) struct Dialect {
    /// The byte between two fields; none where white space parts them.
    pub delimiter: Option<u8>,
    pub decimal_comma: bool,
    /// Dates have the day before the month.
    pub day_first: bool,
    pub fields: usize,
}

/// The fields of a line, without blanks and quotes around them.
pub(crate) fn fields(line: &str, delimiter: Option<u8>) -> Fields<'_> {
    Fields {
        line,
        delimiter,
        at: 0,
        span: (0, 0),
    }
}

pub(crate) struct Fields<'a> {
    line: &'a str,
    delimiter: Option<u8>,
    /// Where the next field begins: after the last one, beyond the end of the line.
    at: usize,
    /// Where the last field begins and ends, with blanks and quotes beside a delimiter.
    pub span: (usize, usize),
}

impl Fields<'_> {
    /// Goes on behind a field that ends here, and the byte that parts it from the next.
    fn step_over(&mut self, end: usize) {
        self.span = (self.at, end);
        self.at = end + 1;
    }

    /// The next field if it is a plain number, with nothing around it.
    #[inline]
    pub(crate) fn number(&mut self, point: u8) -> Option<f64> {
        let rest = self.line.as_bytes().get(self.at..)?;
        let (value, length) = parse_plain(rest, point)?;
        let ends = match (rest.get(length), self.delimiter) {
            (None, _) => true,
            (Some(byte), Some(delimiter)) => *byte == delimiter,
            (Some(byte), None) => byte.is_ascii_whitespace(),
        };
        ends.then(|| {
            self.step_over(self.at + length);
            value
        })
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let mut rest = self.line.get(self.at..)?;
        let delimiter = self.delimiter;
        if delimiter.is_none() {
            rest = rest.trim_ascii_start();
            self.at = self.line.len() - rest.len();
        }
        let mut is_quoted = false;
        let ends = |byte: u8| match delimiter {
            Some(delimiter) => {
                is_quoted ^= byte == b'"';
                byte == delimiter && !is_quoted
            }
            None => byte.is_ascii_whitespace(),
        };
        let end = rest.bytes().position(ends).unwrap_or(rest.len());
        self.step_over(self.at + end);
        // White space at the end parts nothing.
        let field = Some(&rest[..end]).filter(|f| delimiter.is_some() || !f.is_empty())?;
        Some(field.trim_ascii().trim_matches('"').trim_ascii())
    }
}

/// Whether the comma of a number may part its thousands: three digits stand behind it, and no zero alone
/// before it.
fn may_part_thousands(field: &str) -> bool {
    let parts = field.trim_start_matches(['+', '-']).split_once(',');
    parts.is_some_and(|(whole, rest)| whole != "0" && rest.len() == 3)
}

/// Whether a field is a date without a time.
fn is_day(field: &str) -> bool {
    !field.contains(':')
        && field.contains(['-', '/', '.'])
        && fast_float2::parse::<f64, _>(field).is_err()
        && parse_date(field, false).is_some()
}

/// Fields and finite numbers of a line, if it is a row.
fn count_row(line: &str, delimiter: Option<u8>, decimal_comma: bool) -> Option<(usize, usize)> {
    if is_comment(line) {
        return None;
    }
    let (mut count, mut numbers, mut texts) = (0, 0, 0);
    let is_quoted = decimal_comma && delimiter == Some(b',');
    for field in fields(line, delimiter) {
        count += 1;
        let value = parse_cell(field, decimal_comma);
        match value.filter(|_| !is_quoted || !may_part_thousands(field)) {
            // A date is one field with its time: apart they are not more than together.
            Some(_) if is_day(field) => {}
            Some(v) if v.is_finite() => numbers += 1,
            Some(_) => {}
            None => texts += 1,
        }
    }
    let is_row = numbers >= 3 || numbers >= 2 && numbers > texts;
    is_row.then_some((count, numbers))
}

impl Dialect {
    /// For tables in memory, and for numbers that were taken out of sentences.
    pub(crate) fn of_commas(fields: usize) -> Self {
        Dialect {
            delimiter: Some(b','),
            fields,
            ..Dialect::default()
        }
    }

    /// What stands between whole numbers and decimals, where nothing is quoted.
    pub(crate) fn point(self) -> u8 {
        if self.decimal_comma && self.delimiter != Some(b',') {
            b','
        } else {
            b'.'
        }
    }

    /// A field as [`parse_cell`] reads it, with the order of day and month in this file.
    pub(crate) fn parse_field(self, field: &str) -> Option<f64> {
        let mut value = parse_number(field, self.decimal_comma);
        let is_quoted = self.delimiter == Some(b',') && field.contains(',');
        if value.is_none() && is_quoted && !self.decimal_comma {
            // A comma in quotes parts thousands: `"1,010"`.
            value = parse_number(&format!("{field}."), false);
        }
        value.or_else(|| parse_date(field, self.day_first))
    }

    pub(crate) fn is_row(self, line: &str) -> bool {
        let row = count_row(line, self.delimiter, self.decimal_comma);
        row.is_some_and(|(fields, _)| fields == self.fields)
    }

    /// The delimiter and decimal sign under which most lines are rows of one width.
    pub(crate) fn sniff(lines: &[&str]) -> Option<Dialect> {
        let delimiters = [Some(b','), Some(b';'), Some(b'\t'), Some(b'|'), None];
        // Decimal commas stand in quotes where commas are delimiters.
        let candidates = [false, true].map(|decimal_comma| delimiters.map(|d| (d, decimal_comma)));
        let score = |(delimiter, decimal_comma): (Option<u8>, bool)| {
            // Rows and numbers of each width.
            let mut widths: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
            let rows = lines.iter();
            let rows = rows.filter_map(|line| count_row(line, delimiter, decimal_comma));
            for (fields, count) in rows.filter(|(fields, _)| *fields >= 3) {
                let (rows, numbers) = widths.entry(fields).or_default();
                *rows += 1;
                *numbers += count;
            }
            let widths = widths.into_iter();
            let (fields, score) = widths.max_by_key(|(fields, score)| (score.0, *fields))?;
            let dialect = Dialect {
                delimiter,
                decimal_comma,
                day_first: false,
                fields,
            };
            Some((score, dialect))
        };
        // `max_by_key` returns the last of equals.
        let scored = candidates.into_iter().flatten().rev().filter_map(score);
        let best = scored.max_by_key(|(score, _)| *score);
        best.map(|(_, dialect)| dialect)
    }
}

pub(crate) fn is_comment(line: &str) -> bool {
    matches!(line.as_bytes(), [b'#' | b'%', ..] | [b'/', b'/', ..])
}

/// The text of a comment, or the line.
pub(crate) fn uncommented(line: &str) -> &str {
    line.trim_start_matches(['#', '%', '/', ' '])
}

/// A line without a letter or digit parts blocks of rows.
pub(crate) fn is_blank(line: &str) -> bool {
    !line.bytes().any(|b| b.is_ascii_alphanumeric() || b >= 0x80)
}
