//! Text format of a recording: delimiter, header, first data line. Determined from the beginning
//! of the file.

use std::borrow::Cow;
use std::cmp::Ordering;

use crate::scan::{parse_field, parse_field_decimal_comma};

use super::date::parse_date;
use super::names::{Quantity, understand};
use super::row::{Delimiter, RowDefect, is_missing_value, quoted_end};
use super::units::is_unit;

/// Number of lines that are examined.
const LINES: usize = 400;

/// Text format of a file.
#[derive(Debug, Clone)]
pub struct Dialect {
    /// Separator of the fields.
    pub delimiter: Delimiter,
    /// `1,5` means 1.5.
    pub decimal_comma: bool,
    /// Number of fields in a data row.
    pub fields: usize,
    /// The header; `None` if the file begins with data.
    pub header: Option<Header>,
    /// Line number, from 1, of the first data row.
    pub first_data_line: u64,
    /// Lines before the data that are not the header, without blank lines.
    pub metadata: Vec<String>,
    /// Number of consecutive blank lines that occur regularly between rows and are no breaks; 0
    /// if blank lines are breaks.
    pub regular_blanks: u64,
    /// A line of text directly before the data that does not fit them as a header: its line
    /// number and its number of names.
    pub misfit: Option<(u64, usize)>,
    /// Values of the first data rows, NaN if empty or text.
    pub sample: Vec<Vec<f64>>,
}

impl Dialect {
    /// Of rows that do not come from a file, without a header or with the `names` of one; `sample`
    /// as the field.
    #[must_use]
    pub fn of_columns(
        delimiter: Delimiter,
        fields: usize,
        names: Option<Vec<String>>,
        sample: Vec<Vec<f64>>,
    ) -> Self {
        Dialect {
            delimiter,
            decimal_comma: false,
            fields,
            header: names.map(Header::of_names),
            first_data_line: 1,
            metadata: Vec::new(),
            regular_blanks: 0,
            misfit: None,
            sample,
        }
    }

    /// The numbers of a line that is a row in a strict sense: every field is a finite number.
    ///
    /// # Errors
    ///
    /// Why it is not.
    pub fn numbers(&self, line: &[u8]) -> Result<Vec<f64>, RowDefect> {
        let fields = split(line, self.delimiter);
        match fields.len().cmp(&self.fields) {
            Ordering::Less => return Err(RowDefect::TooFewFields),
            Ordering::Greater => return Err(RowDefect::TooManyFields),
            Ordering::Equal => {}
        }
        let number = |(i, field): (usize, &Cow<'_, [u8]>)| {
            let comma = self.decimal_comma.then(|| parse_field_decimal_comma(field));
            let value = comma.flatten().or_else(|| parse_field(field));
            let finite = value.filter(|value| value.is_finite());
            finite.ok_or(RowDefect::NotANumber(i))
        };
        fields.iter().enumerate().map(number).collect()
    }

    /// The last line of the header, if it is in the file.
    pub fn header_line(&self) -> Option<u64> {
        let line = self.header.as_ref()?.lines[1];
        (line > 0).then_some(line)
    }

    /// For messages: `comma separated, header in line 1`.
    #[must_use]
    pub fn description(&self) -> String {
        let header = match &self.header {
            Some(h) if h.lines[0] == 0 => "columns of GENEActiv".to_owned(),
            Some(h) if h.lines[0] != h.lines[1] => {
                let and = if h.texts.len() == 2 { "and" } else { "to" };
                format!("header in lines {} {and} {}", h.lines[0], h.lines[1])
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

/// The lines that name the columns.
#[derive(Debug, Clone)]
pub struct Header {
    /// First and last line number; they differ if there are two rows of names, or rows of units.
    /// 0 where the names are those of a known format without a header.
    pub lines: [u64; 2],
    /// Column names; `upper.lower` if there are two rows.
    pub names: Vec<String>,
    /// Units from a row below the names, one per column; empty without such a row.
    pub units: Vec<String>,
    /// Text of its lines, trimmed, to recognise a repeated header.
    pub texts: Vec<Vec<u8>>,
}

impl Header {
    /// Names that are not those of a line of a file.
    #[must_use]
    pub fn of_names(names: Vec<String>) -> Self {
        Header {
            lines: [1, 1],
            names,
            units: Vec::new(),
            texts: Vec::new(),
        }
    }

    /// The unit below the name of a column.
    #[must_use]
    pub fn unit(&self, field: usize) -> Option<&str> {
        let unit = self.units.get(field)?;
        (!unit.is_empty()).then_some(unit)
    }
}

/// Content of one cell.
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

impl HeadLine<'_> {
    /// Empty, or only delimiters.
    fn is_blank(&self) -> bool {
        !self.text.iter().any(|b| b.is_ascii_alphanumeric())
    }
}

/// Removes spaces and carriage returns at the end; a tab there is a delimiter.
fn trim_end(mut text: &[u8]) -> &[u8] {
    while let [rest @ .., b' ' | b'\r'] = text {
        text = rest;
    }
    text
}

/// Determines the text format from the beginning of a file. `whole`: `head` is the whole file.
/// `None` if it contains no rows of numbers.
#[must_use]
pub fn sniff(head: &[u8], whole: bool, min_columns: usize) -> Option<Dialect> {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let end = terminator(head);
    let mut lines: Vec<HeadLine<'_>> = head
        .split(|&b| b == end)
        .enumerate()
        .map(|(i, text)| HeadLine {
            number: i as u64 + 1,
            text: trim_end(text),
        })
        .collect();
    if !whole || lines.last().is_some_and(|l| l.text.is_empty()) {
        lines.pop();
    }
    // Metadata can be long: if the first lines contain no data, examine all of them.
    let beginning = &lines[..lines.len().min(LINES)];
    let best = candidates(beginning, min_columns).or_else(|| candidates(&lines, min_columns))?;
    let found = finish(best, &lines);
    let earlier = found.header.as_ref().and_then(|header| {
        let before = header.lines[0].saturating_sub(1) as usize;
        earlier(&lines, before.min(lines.len()), min_columns)
    });
    Some(earlier.unwrap_or(found))
}

/// Some files contain rows of another width above the header of the most frequent rows. If those
/// rows have a header that names an accelerometer or a gyroscope, the recording begins with them.
fn earlier(lines: &[HeadLine<'_>], before: usize, min_columns: usize) -> Option<Dialect> {
    let best = candidates(lines.get(..before)?, min_columns)?;
    let found = finish(best, lines);
    let names = &found.header.as_ref()?.names;
    let named: Vec<Quantity> = names
        .iter()
        .filter_map(|n| Some(understand(n)?.quantity))
        .collect();
    let all = |of: fn(usize) -> Quantity| (0..3).all(|i| named.contains(&of(i)));
    (all(Quantity::Accel) || all(Quantity::Gyro)).then_some(found)
}

/// Line terminator: `\r` for the few files without `\n`.
#[must_use]
pub fn terminator(head: &[u8]) -> u8 {
    if memchr::memchr(b'\n', head).is_none() && memchr::memchr(b'\r', head).is_some() {
        b'\r'
    } else {
        b'\n'
    }
}

/// Delimiters that are tried, and whether numbers have a decimal comma.
const DELIMITERS: [(Delimiter, bool); 8] = [
    (Delimiter::Byte(b','), false),
    (Delimiter::Byte(b';'), false),
    (Delimiter::Byte(b'\t'), false),
    (Delimiter::Byte(b'|'), false),
    (Delimiter::Whitespace, false),
    (Delimiter::Byte(b';'), true),
    (Delimiter::Byte(b'\t'), true),
    (Delimiter::Whitespace, true),
];

struct Candidate {
    delimiter: Delimiter,
    decimal_comma: bool,
    fields: usize,
    rows: usize,
    /// Number of cells of these rows that are numbers.
    numbers: usize,
}

/// The delimiter that gives the most rows of numbers with the same number of fields, and among
/// equals the most numbers (a comma in one column of whole numbers is a decimal comma); the order
/// of [`DELIMITERS`] decides ties.
fn candidates(lines: &[HeadLine<'_>], min_columns: usize) -> Option<Candidate> {
    let mut best: Option<Candidate> = None;
    for (delimiter, decimal_comma) in DELIMITERS {
        let mut counts: Vec<(usize, usize, usize)> = Vec::new();
        for line in lines {
            let fields = split(line.text, delimiter);
            // Most delimiters do not occur: nothing has to be parsed.
            if fields.len() < min_columns {
                continue;
            }
            let cells = parsed(&fields, decimal_comma);
            if is_data(&cells, min_columns) {
                let is_number = |c: &&Cell| matches!(**c, Cell::Number(_));
                let numbers = cells.iter().filter(is_number).count();
                match counts
                    .iter_mut()
                    .find(|(fields, ..)| *fields == cells.len())
                {
                    Some((_, n, sum)) => (*n, *sum) = (*n + 1, *sum + numbers),
                    None => counts.push((cells.len(), 1, numbers)),
                }
            }
        }
        // The most frequent; among equals the one with more fields.
        let largest = counts.iter().max_by_key(|(fields, n, _)| (*n, *fields));
        let Some(&(fields, rows, numbers)) = largest else {
            continue;
        };
        // Splitting a date from a time of day gives two numbers, but only with white space.
        let is_better = |b: &Candidate| {
            rows > b.rows
                || rows == b.rows && numbers > b.numbers && delimiter != Delimiter::Whitespace
        };
        if best.as_ref().is_none_or(is_better) {
            best = Some(Candidate {
                delimiter,
                decimal_comma,
                fields,
                rows,
                numbers,
            });
        }
    }
    best
}

/// True for a data row: at least two numbers (a recorder that writes each channel when it arrives
/// leaves most cells empty) and fewer texts, or three numbers with any number of texts.
fn is_data(cells: &[Cell], min_columns: usize) -> bool {
    let numbers = cells
        .iter()
        .filter(|c| matches!(c, Cell::Number(_)))
        .count();
    let texts = cells.iter().filter(|c| **c == Cell::Text).count();
    cells.len() >= min_columns
        && (numbers >= 3 || (numbers >= 2.min(min_columns) && numbers > texts))
}

fn cells(line: &[u8], delimiter: Delimiter, decimal_comma: bool) -> Vec<Cell> {
    parsed(&split(line, delimiter), decimal_comma)
}

fn parsed(fields: &[Cow<'_, [u8]>], decimal_comma: bool) -> Vec<Cell> {
    fields
        .iter()
        .map(|field| {
            let field = field.trim_ascii();
            let inner = match field {
                [b'"', inner @ .., b'"'] => inner.trim_ascii(),
                other => other,
            };
            if inner.is_empty() || is_missing_value(inner) {
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

/// Splits a line into fields; quoted fields as in [`super::row::RowScanner`].
fn split(line: &[u8], delimiter: Delimiter) -> Vec<Cow<'_, [u8]>> {
    match delimiter {
        Delimiter::Whitespace => line
            .split(|b| *b == b' ' || *b == b'\t')
            .filter(|f| !f.is_empty())
            .map(Cow::Borrowed)
            .collect(),
        Delimiter::Byte(d) if line.contains(&b'"') => split_quoted(line, d),
        Delimiter::Byte(d) => line.split(|b| *b == d).map(Cow::Borrowed).collect(),
    }
}

fn split_quoted(line: &[u8], delimiter: u8) -> Vec<Cow<'_, [u8]>> {
    let mut fields = Vec::new();
    let mut at = 0;
    loop {
        // White space before a quote, except a tab that is the delimiter.
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
fn unquote(field: &[u8]) -> Cow<'_, [u8]> {
    let field = field.trim_ascii();
    let [b'"', inner @ .., b'"'] = field else {
        return Cow::Borrowed(field);
    };
    let mut text = Vec::with_capacity(inner.len());
    let mut bytes = inner.iter().peekable();
    while let Some(&byte) = bytes.next() {
        text.push(byte);
        if byte == b'"' {
            bytes.next_if(|next| **next == b'"');
        }
    }
    Cow::Owned(text)
}

fn finish(best: Candidate, lines: &[HeadLine<'_>]) -> Dialect {
    let cut = |text: &[u8]| cells(text, best.delimiter, best.decimal_comma);
    let row = |line: &HeadLine<'_>| {
        let fields = split(line.text, best.delimiter);
        if fields.len() != best.fields {
            return None;
        }
        let cells = parsed(&fields, best.decimal_comma);
        is_data(&cells, best.fields.min(3)).then(|| {
            cells
                .into_iter()
                .map(|c| match c {
                    Cell::Number(v) => v,
                    _ => f64::NAN,
                })
                .collect::<Vec<f64>>()
        })
    };
    let mut first = lines.iter().position(|l| row(l).is_some()).unwrap_or(0);
    let before: Vec<&HeadLine<'_>> = lines[..first].iter().filter(|l| !l.is_blank()).collect();
    let mut header = find_header(&best, &before);
    let mut metadata = Vec::new();
    if header.is_none() {
        let two: Vec<(usize, Vec<f64>)> = (first..lines.len())
            .filter_map(|i| Some((i, row(&lines[i])?)))
            .take(3)
            .collect();
        if let [(_, start), (_, rate), (data, _)] = &two[..]
            && let Some(rate_hz) = start_and_rate(start, rate)
        {
            metadata.push(format!("rate: {rate_hz} Hz"));
            first = *data;
        }
    }
    if let Some(header) = &mut header
        && header.names.len() < best.fields
    {
        // One name fewer than fields: if rows end with a delimiter, the last field is empty;
        // otherwise an index column (counting, or text) without a name is the first; otherwise
        // the last column has no name.
        let mut rows = lines[first..]
            .iter()
            .filter(|l| row(l).is_some())
            .take(LINES);
        let open_ended = rows.all(|l| cut(l.text).last() == Some(&Cell::Empty));
        let firsts: Vec<f64> = lines[first..]
            .iter()
            .filter_map(row)
            .filter_map(|cells| cells.first().copied())
            .take(LINES)
            .collect();
        let index =
            firsts.windows(2).all(|w| w[1] - w[0] == 1.0) || firsts.iter().all(|v| v.is_nan());
        let at = if index && !open_ended {
            0
        } else {
            best.fields - 1
        };
        header.names.insert(at, String::new());
        if !header.units.is_empty() {
            header.units.insert(at, String::new());
        }
    }
    let is_header = |l: &HeadLine<'_>| {
        header
            .as_ref()
            .is_some_and(|h| (h.lines[0]..=h.lines[1]).contains(&l.number))
    };
    metadata.extend(
        before
            .iter()
            .filter(|l| !is_header(l))
            .map(|l| decode(l.text)),
    );
    let misfit = match (&header, before.last()) {
        (None, Some(last)) => {
            let names = split(strip_comment(last.text), best.delimiter);
            let words = names
                .iter()
                .filter(|n| n.iter().any(u8::is_ascii_alphabetic));
            (words.count() >= 2).then_some((last.number, names.len()))
        }
        _ => None,
    };
    let sample = lines[first..].iter().filter_map(row).take(LINES).collect();
    Dialect {
        delimiter: best.delimiter,
        decimal_comma: best.decimal_comma,
        fields: best.fields,
        header,
        first_data_line: lines.get(first).map_or(1, |l| l.number),
        metadata,
        regular_blanks: regular_blanks(&lines[first..], row),
        misfit,
        sample,
    }
}

/// Smallest number of blank lines that can be regular …
const FEWEST_BLANKS: usize = 5;
/// … if they follow at most this many rows, too few for a pose.
const FEW_ROWS: usize = 20;
/// Smallest number of regular blank lines if a column continues across them as within the rows.
const FEWEST_BLANKS_OF_A_CLOCK: usize = 3;

/// Number of consecutive blank lines that occur regularly, after every k rows (a line end written
/// twice, a blank line after each transmitted block); 0 if blank lines are irregular.
fn regular_blanks(lines: &[HeadLine<'_>], row: impl Fn(&HeadLine<'_>) -> Option<Vec<f64>>) -> u64 {
    if !lines.iter().any(|l| l.is_blank()) {
        return 0;
    }
    // Rows before a run of blank lines, and the number of blank lines in it.
    let mut runs: Vec<(usize, u64)> = Vec::new();
    let mut rows = Vec::new();
    let mut blanks = 0;
    let mut since = 0;
    for line in lines {
        if line.is_blank() {
            blanks += 1;
        } else if let Some(values) = row(line) {
            if blanks > 0 {
                runs.push((since, blanks));
                (blanks, since) = (0, 0);
            }
            since += 1;
            rows.push(values);
        }
    }
    let usual = |of: fn(&(usize, u64)) -> f64| {
        let mut all: Vec<f64> = runs.iter().map(of).collect();
        let usual = crate::stats::median(&mut all)?;
        let alike = runs.iter().filter(|run| of(run) == usual).count();
        (alike * 10 >= runs.len() * 9).then_some(usual)
    };
    let (Some(every), Some(blanks)) = (usual(|run| run.0 as f64), usual(|run| run.1 as f64)) else {
        return 0;
    };
    let every = every as usize;
    let regular = if every <= FEW_ROWS {
        runs.len() >= FEWEST_BLANKS
    } else {
        runs.len() >= FEWEST_BLANKS_OF_A_CLOCK && continues_across(&rows, every)
    };
    if regular { blanks as u64 } else { 0 }
}

/// True if some column rises through all `rows` with steps at every `every`th row no longer than
/// elsewhere: the recorder did not pause there.
fn continues_across(rows: &[Vec<f64>], every: usize) -> bool {
    let fields = rows.first().map_or(0, Vec::len);
    (0..fields).any(|field| {
        let steps = rows.windows(2).map(|w| w[1][field] - w[0][field]);
        let (mut across, mut within) = (Vec::new(), Vec::new());
        for (i, step) in steps.enumerate() {
            if (i + 1) % every == 0 {
                across.push(step);
            } else {
                within.push(step);
            }
        }
        let rises = across.iter().chain(&within).all(|step| *step > 0.0);
        let longest = across.iter().copied().fold(0.0, f64::max);
        let usual = crate::stats::median(&mut within);
        rises && usual.is_some_and(|usual| longest < 1.5 * usual)
    })
}

/// Sampling rate in Hz from two rows before the samples: the start in seconds since 1970 and the
/// rate, both repeated in each column (Empatica's `ACC.csv`).
fn start_and_rate(start: &[f64], rate: &[f64]) -> Option<f64> {
    let all_are = |row: &[f64]| row.first().copied().filter(|v| row.iter().all(|o| o == v));
    let dates_s = 946_684_800.0..4_102_444_800.0;
    all_are(start).filter(|s| dates_s.contains(s))?;
    all_are(rate).filter(|r| (1.0..=10_000.0).contains(r))
}

/// The header: the last line before the data that is text, is no row of units and has as many
/// fields as the data or one fewer; with the line above it if that is a row of names too.
/// `before` contains no blank lines.
fn find_header(best: &Candidate, before: &[&HeadLine<'_>]) -> Option<Header> {
    let fields_of = |line: &HeadLine<'_>| -> Option<Vec<String>> {
        let text = strip_comment(line.text);
        // The header can have another delimiter than columns that are aligned with spaces.
        let delimiters = [best.delimiter]
            .into_iter()
            .chain([b'\t', b',', b';', b'|'].map(Delimiter::Byte));
        delimiters.into_iter().find_map(|delimiter| {
            let mut names: Vec<String> = split(text, delimiter)
                .iter()
                .map(|f| decode(f.trim_ascii()))
                .collect();
            if names.len() == best.fields + 1 && names.last().is_some_and(String::is_empty) {
                names.pop();
            }
            (names.len() == best.fields || names.len() + 1 == best.fields).then_some(names)
        })
    };
    let names_of = |line: &HeadLine<'_>| -> Option<Vec<String>> {
        let names = fields_of(line)?;
        let named = names
            .iter()
            .filter(|n| n.chars().any(char::is_alphabetic))
            .count();
        (named * 2 > names.len()).then_some(names)
    };
    let mut last = before.len().checked_sub(1)?;
    let mut units = Vec::new();
    while last > 0
        && let Some(row) = fields_of(before[last]).filter(|row| is_row_of_units(row))
        && let Some(above) = names_of(before[last - 1])
        && above.len() == row.len()
    {
        // Of several rows of units use the one with the most units.
        let unit_count = |row: &[String]| row.iter().filter(|u| is_unit(u)).count();
        if unit_count(&row) > unit_count(&units) {
            units = row;
        }
        last -= 1;
    }
    let mut names = names_of(before[last])?;
    let mut from = last;
    // Two header rows: the upper one names the sensor, the lower one the channel.
    if let Some(upper_at) = last.checked_sub(1)
        && let Some(upper) = fields_of(before[upper_at]).and_then(fill_forward)
        && upper.len() == names.len()
        && repeats(&upper)
        && repeats(&names)
    {
        names = upper
            .iter()
            .zip(&names)
            .map(|(upper, lower)| format!("{upper}.{lower}"))
            .collect();
        from = upper_at;
    }
    let lines = &before[from..];
    Some(Header {
        lines: [before[from].number, before[before.len() - 1].number],
        names,
        units,
        texts: lines.iter().map(|l| l.text.trim_ascii().to_vec()).collect(),
    })
}

/// Fills merged cells of a spreadsheet, whose name is in the first cell. `None` for a single
/// title and for cells that are not names.
fn fill_forward(mut cells: Vec<String>) -> Option<Vec<String>> {
    let named = |cell: &&String| cell.chars().any(char::is_alphabetic);
    let filled: Vec<&String> = cells.iter().filter(|c| !c.is_empty()).collect();
    if filled.len() < 2 || !filled.iter().all(named) {
        return None;
    }
    for i in 1..cells.len() {
        if cells[i].is_empty() {
            cells[i] = cells[i - 1].clone();
        }
    }
    Some(cells)
}

/// True for a row of units, or of words such as `CAL` and `raw`.
fn is_row_of_units(cells: &[String]) -> bool {
    let filled = cells.iter().filter(|c| !c.is_empty());
    let (all, of_units) = filled.fold((0, 0), |(all, of_units), cell| {
        let is = is_unit(cell) || matches!(cell.to_lowercase().as_str(), "cal" | "raw" | "uncal");
        (all + 1, of_units + usize::from(is))
    });
    all > 0 && of_units * 10 >= all * 7
}

fn repeats(names: &[String]) -> bool {
    names
        .iter()
        .enumerate()
        .any(|(i, n)| names[..i].contains(n))
}

/// A header may follow a comment sign (`# t ax ay az`).
pub(super) fn strip_comment(text: &[u8]) -> &[u8] {
    let text = text.trim_ascii();
    ["#", "%", "//"]
        .iter()
        .find_map(|sign| text.strip_prefix(sign.as_bytes()))
        .unwrap_or(text)
        .trim_ascii()
}

/// The names in a line that is a header by itself, whatever follows it, and what separates them:
/// at least three, each of which begins with a letter and is no word for a missing value. A
/// delimiter behind the last one makes no further name.
#[must_use]
pub fn names_alone(line: &[u8]) -> Option<(Delimiter, Vec<String>)> {
    let is_name = |name: &Cow<'_, [u8]>| {
        name.first().is_some_and(u8::is_ascii_alphabetic)
            && !name.iter().any(|b| matches!(b, b':' | b'='))
            && !is_missing_value(name)
    };
    let line = without_last_delimiter(line);
    let tried = DELIMITERS.into_iter().filter(|(_, comma)| !comma);
    tried.map(|(delimiter, _)| delimiter).find_map(|delimiter| {
        let names: Vec<Cow<'_, [u8]>> = split(line, delimiter)
            .into_iter()
            .map(|name| Cow::Owned(name.trim_ascii().to_vec()))
            .collect();
        let all = names.len() >= 3 && names.iter().all(is_name);
        all.then(|| (delimiter, names.iter().map(|name| decode(name)).collect()))
    })
}

/// A line without the delimiter behind its last field.
#[must_use]
pub fn without_last_delimiter(line: &[u8]) -> &[u8] {
    match line.trim_ascii_end() {
        [rest @ .., b',' | b';' | b'|'] => rest,
        _ => line,
    }
}

/// Decodes text of a header: UTF-8, otherwise Windows-1252 (for the degree sign of Latin-1).
#[must_use]
pub fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => encoding_rs::WINDOWS_1252.decode(bytes).0.into_owned(),
    }
}
