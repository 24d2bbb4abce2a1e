//! How the fields of a line are parted.

use std::collections::BTreeMap;

use memchr::memchr;

use super::number::{finite, parse_cell, parse_short};
use crate::date::parse_date;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Delimiter {
    Byte(u8),
    Whitespace,
}

impl Delimiter {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Delimiter::Byte(b',') => "comma",
            Delimiter::Byte(b';') => "semicolon",
            Delimiter::Byte(b'\t') => "tab",
            Delimiter::Byte(_) => "bar",
            Delimiter::Whitespace => "white space",
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Dialect {
    pub delimiter: Delimiter,
    pub decimal_comma: bool,
    /// Dates have the day before the month.
    pub day_first: bool,
    pub fields: usize,
}

/// The fields of a line, without blanks and quotes around them.
pub(crate) fn fields(line: &str, delimiter: Delimiter) -> Fields<'_> {
    Fields {
        rest: Some(line),
        delimiter,
        has_quotes: None,
        length: 0,
    }
}

pub(crate) struct Fields<'a> {
    rest: Option<&'a str>,
    delimiter: Delimiter,
    /// Whether the rest has quotes, once that was looked for.
    has_quotes: Option<bool>,
    /// Bytes of the last field with the blanks and quotes around it.
    length: usize,
}

impl Fields<'_> {
    /// Where the last field of the line begins and ends, with blanks and quotes beside a delimiter.
    pub(crate) fn last_span(&self, line: &str) -> (usize, usize) {
        let end = self.rest.map_or(line.len(), |rest| {
            let is_parted_by_byte = matches!(self.delimiter, Delimiter::Byte(_));
            line.len() - rest.len() - usize::from(is_parted_by_byte)
        });
        (end - self.length, end)
    }

    /// The next field as [`parse_cell`] reads it; mostly a number that ends at the delimiter.
    #[inline]
    pub(crate) fn next_cell(&mut self, dialect: Dialect) -> Option<Option<f64>> {
        if let Delimiter::Byte(delimiter) = self.delimiter
            && let Some(rest) = self.rest
            && let Some((value, n)) = parse_short(rest.as_bytes())
            && rest.as_bytes().get(n).is_none_or(|b| *b == delimiter)
        {
            self.rest = rest.get(n + 1..);
            self.length = n;
            return Some(Some(value));
        }
        self.next_other_cell(dialect)
    }

    /// The next field, if it is no short number.
    #[inline(never)]
    fn next_other_cell(&mut self, dialect: Dialect) -> Option<Option<f64>> {
        if let Delimiter::Byte(delimiter) = self.delimiter
            && let Some(rest) = self.rest
            && let Ok((value, n)) = fast_float2::parse_partial(rest)
            && rest.as_bytes().get(n).is_none_or(|b| *b == delimiter)
        {
            self.rest = rest.get(n + 1..);
            self.length = n;
            return Some(Some(finite(value)));
        }
        let field = self.next()?;
        let value = parse_cell(field, dialect.decimal_comma);
        if dialect.day_first && value.is_some() && field.contains(':') {
            return Some(parse_date(field, true).or(value));
        }
        Some(value)
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let rest = self.rest?;
        match self.delimiter {
            Delimiter::Whitespace => {
                let rest = rest.trim_ascii_start();
                let end = rest.bytes().position(|b| b.is_ascii_whitespace());
                self.rest = end.map(|end| &rest[end..]);
                self.length = end.unwrap_or(rest.len());
                Some(&rest[..self.length]).filter(|f| !f.is_empty())
            }
            Delimiter::Byte(delimiter) => {
                let has_quotes = *self
                    .has_quotes
                    .get_or_insert_with(|| memchr(b'"', rest.as_bytes()).is_some());
                let end = if has_quotes {
                    let mut quoted = false;
                    rest.bytes().position(|b| {
                        quoted ^= b == b'"';
                        b == delimiter && !quoted
                    })
                } else {
                    rest.bytes().position(|b| b == delimiter)
                };
                self.rest = end.map(|end| &rest[end + 1..]);
                self.length = end.unwrap_or(rest.len());
                let field = trim(&rest[..self.length]);
                Some(if has_quotes {
                    trim(field.trim_matches('"'))
                } else {
                    field
                })
            }
        }
    }
}

/// Without blanks, and without the NUL bytes that a torn write leaves.
fn trim(field: &str) -> &str {
    let is_edge = |b: &u8| b.is_ascii_whitespace() || *b == 0;
    let bytes = field.as_bytes();
    if bytes.first().is_some_and(is_edge) || bytes.last().is_some_and(is_edge) {
        field.trim_matches(|c: char| c.is_ascii_whitespace() || c == '\0')
    } else {
        field
    }
}

/// Counts of fields, finite numbers and texts of a line.
#[derive(Default)]
struct Tally {
    fields: usize,
    numbers: usize,
    texts: usize,
}

impl Tally {
    fn count(line: &str, delimiter: Delimiter, decimal_comma: bool) -> Self {
        let mut tally = Tally::default();
        for field in fields(line, delimiter) {
            tally.fields += 1;
            match parse_cell(field, decimal_comma) {
                Some(v) if v.is_finite() => tally.numbers += 1,
                Some(_) => {}
                None => tally.texts += 1,
            }
        }
        tally
    }

    fn is_row(&self) -> bool {
        self.numbers >= 3 || self.numbers >= 2 && self.numbers > self.texts
    }
}

impl Dialect {
    pub(crate) fn is_row(self, line: &str) -> bool {
        let tally = Tally::count(line, self.delimiter, self.decimal_comma);
        tally.fields == self.fields && tally.is_row() && !is_comment(line)
    }

    /// The delimiter and decimal sign under which most lines are rows of one width.
    pub(crate) fn sniff(lines: &[&str]) -> Option<Dialect> {
        const CANDIDATES: [(Delimiter, bool); 8] = [
            (Delimiter::Byte(b','), false),
            (Delimiter::Byte(b';'), false),
            (Delimiter::Byte(b'\t'), false),
            (Delimiter::Byte(b'|'), false),
            (Delimiter::Whitespace, false),
            (Delimiter::Byte(b';'), true),
            (Delimiter::Byte(b'\t'), true),
            (Delimiter::Whitespace, true),
        ];
        let mut best: Option<((usize, usize), Dialect)> = None;
        for (delimiter, decimal_comma) in CANDIDATES {
            // Rows and numbers of each width.
            let mut widths: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
            for line in lines.iter().filter(|l| !is_comment(l)) {
                let tally = Tally::count(line, delimiter, decimal_comma);
                if tally.fields >= 3 && tally.is_row() {
                    let entry = widths.entry(tally.fields).or_default();
                    entry.0 += 1;
                    entry.1 += tally.numbers;
                }
            }
            let widest = widths
                .into_iter()
                .max_by_key(|(fields, score)| (score.0, *fields));
            let Some((fields, score)) = widest else {
                continue;
            };
            if best.is_none_or(|(best_score, _)| score > best_score) {
                best = Some((
                    score,
                    Dialect {
                        delimiter,
                        decimal_comma,
                        day_first: false,
                        fields,
                    },
                ));
            }
        }
        best.map(|b| b.1)
    }
}

pub(crate) fn is_comment(line: &str) -> bool {
    line.starts_with(['#', '%']) || line.starts_with("//")
}

/// A line without a letter or digit parts blocks of rows.
pub(crate) fn is_blank(line: &str) -> bool {
    !line.bytes().any(|b| b.is_ascii_alphanumeric() || b >= 0x80)
}
