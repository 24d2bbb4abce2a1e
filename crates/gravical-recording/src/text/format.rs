//! What the head of a file says.

use std::io::BufRead;

use super::batch::Batch;
use super::batches::{Batches, MANY_WORDS};
use super::dialect::{Delimiter, Dialect, fields, is_blank};
use super::lines::trim_end;
use super::names::{Column, Role, stated_rate_hz};
use super::roles;
use super::words::Sentences;
use crate::error::{Error, Kind};
use crate::text::number::parse_cell;
use crate::units::{AccelUnit, GyroUnit, is_unit};

/// Lines by which the dialect is told.
const DIALECT_LINES: usize = 400;

#[derive(Clone, Debug)]
pub(crate) enum Layout {
    Table(Dialect),
    Sentences(Sentences),
}

impl Layout {
    /// Place of the last line of a row.
    pub(crate) fn last_place(&self) -> usize {
        match self {
            Layout::Table(_) => 0,
            Layout::Sentences(sentences) => sentences.last_place(),
        }
    }
}

/// What the head of a file says: dialect, roles of columns, claims of units and clock.
#[derive(Clone, Debug)]
pub struct Format {
    pub(crate) layout: Layout,
    pub(crate) line_end: u8,
    pub(crate) head_lines: usize,
    /// Columns that are parsed.
    pub(crate) is_read: Vec<bool>,
    /// Lines above the rows.
    pub(crate) metadata: Vec<String>,
    /// Names of the columns; empty without a header
    pub names: Vec<String>,
    /// What each column holds
    pub columns: Vec<Column>,
    /// Columns of the accelerometer, x, y, z
    pub accel: [usize; 3],
    /// Columns of the gyroscope
    pub gyro: Option<[usize; 3]>,
    /// Column that tells several sensors apart whose rows take turns, and their number
    pub sensor: Option<(usize, usize)>,
    /// Rate that the head states
    pub rate_hz: Option<f64>,
}

/// Reads the head of a file, as UTF-8; the name of the file may tell the sensor.
///
/// # Errors
///
/// There is no table of samples, its columns are not understood, there is no accelerometer, or the
/// file holds counts per epoch.
pub fn sniff(head: &str, file_name: &str) -> Result<Format, Error> {
    let line_end = if head.contains('\n') { b'\n' } else { b'\r' };
    let lines: Vec<&str> = head.split(char::from(line_end)).map(trim_end).collect();
    let table = Format::table(&lines, line_end)
        .ok_or_else(|| Kind::NoTable.into())
        .and_then(|format| format.with_roles(head, file_name));
    match &table {
        Ok((_, is_wordy)) if !is_wordy => {}
        Err(e) if !e.may_be_words() => {}
        _ => {
            let words = Format::sentences(&lines, line_end);
            if let Some(Ok((format, _))) = words.map(|f| f.with_roles(head, file_name)) {
                return Ok(format);
            }
        }
    }
    table.map(|(format, _)| format)
}

impl Format {
    /// Reads a text from its first line on in batches of [`BATCH_ROWS`](crate::BATCH_ROWS).
    pub fn batches<R: BufRead>(&self, bytes: R) -> Batches<'_, R> {
        Batches::new(self, bytes)
    }

    fn new(layout: Layout, line_end: u8, names: Vec<String>, fields: usize) -> Self {
        let column = |c: usize| Column::from_name(names.get(c).map_or("", String::as_str));
        Format {
            layout,
            line_end,
            head_lines: 0,
            is_read: vec![true; fields],
            metadata: Vec::new(),
            columns: (0..fields).map(column).collect(),
            names,
            accel: [0; 3],
            gyro: None,
            sensor: None,
            rate_hz: None,
        }
    }

    fn with_head(mut self, lines: &[&str], head_lines: usize, first_row: &[&str]) -> Self {
        self.head_lines = head_lines;
        self.metadata = lines[..head_lines]
            .iter()
            .map(|l| (*l).to_owned())
            .collect();
        self.rate_hz = stated_rate_hz(&self.metadata);
        for (column, cell) in self.columns.iter_mut().zip(first_row) {
            column.is_dated = cell.contains(':');
        }
        self
    }

    fn table(lines: &[&str], line_end: u8) -> Option<Self> {
        let head = &lines[..lines.len().min(DIALECT_LINES)];
        let dialect = Dialect::sniff(head).or_else(|| Dialect::sniff(lines))?;
        let head_lines = lines.iter().position(|l| dialect.is_row(l))?;
        let above: Vec<&str> = lines[..head_lines]
            .iter()
            .copied()
            .filter(|l| !is_blank(l))
            .collect();
        let header = Header::parse(&above, &lines[head_lines..], dialect);
        let mut format = Format::new(
            Layout::Table(dialect),
            line_end,
            header.names,
            dialect.fields,
        );
        for (column, unit) in format.columns.iter_mut().zip(&header.units) {
            // `S_Timestamp_CAL` is not in seconds if the row of units says ms.
            if column.unit.is_empty() || is_unit(unit) {
                column.unit = unit.to_lowercase();
            }
        }
        let first_row: Vec<&str> = fields(lines[head_lines], dialect.delimiter).collect();
        Some(format.with_head(lines, head_lines, &first_row))
    }

    fn sentences(lines: &[&str], line_end: u8) -> Option<Self> {
        let sentences = Sentences::sniff(lines)?;
        let is_first = |l: &str| sentences.parse(&sentences.normalise(l)).is_some();
        let head_lines = lines.iter().position(|l| is_first(l))?;
        let names = sentences.names(lines);
        let fields = sentences.slots;
        let mut first_row = vec![String::new(); fields];
        for line in lines[head_lines..].iter().take(1 + sentences.last_place()) {
            let line = sentences.normalise(line);
            let Some(sentence) = sentences.parse(&line) else {
                continue;
            };
            for (k, number) in sentence.numbers.iter().enumerate() {
                first_row[sentence.first_slot + k] = (*number).to_owned();
            }
        }
        let names = if names.iter().all(String::is_empty) {
            Vec::new()
        } else {
            names
        };
        let format = Format::new(Layout::Sentences(sentences), line_end, names, fields);
        let first_row: Vec<&str> = first_row.iter().map(String::as_str).collect();
        Some(format.with_head(lines, head_lines, &first_row))
    }

    /// Assigns roles by names and by the rows of the head. True if a column of text always
    /// differs: perhaps numbers wrapped in words.
    fn with_roles(mut self, head: &str, file_name: &str) -> Result<(Self, bool), Error> {
        if counts_epochs(&self.metadata) {
            return Err(Kind::EpochsOfCounts.into());
        }
        let sample = self.batches(head.as_bytes()).next().transpose();
        let mut sample = sample.ok().flatten().ok_or(Kind::NoTable)?;
        if let Some(rate_hz) = start_and_rate(&sample) {
            self.rate_hz = Some(rate_hz);
            self.head_lines = sample.lines[1] as usize;
            let sample_again = self.batches(head.as_bytes()).next().transpose();
            sample = sample_again.ok().flatten().ok_or(Kind::NoTable)?;
        }
        let is_wordy = sample.texts.iter().any(|t| t.contains(&MANY_WORDS));
        roles::assign(&mut self, &sample, file_name)?;
        self.is_read = (0..self.columns.len()).map(|c| self.asks_for(c)).collect();
        Ok((self, is_wordy))
    }

    fn asks_for(&self, column: usize) -> bool {
        self.is_axis(column)
            || self.sensor.is_some_and(|s| s.0 == column)
            || matches!(
                self.columns[column].role,
                Role::Time | Role::Step | Role::Temperature | Role::Label
            )
            || matches!(self.layout, Layout::Sentences(_))
    }

    /// Columns of accelerometer and gyroscope.
    pub(crate) fn channels(&self) -> Vec<usize> {
        self.accel
            .into_iter()
            .chain(self.gyro.into_iter().flatten())
            .collect()
    }

    pub(crate) fn is_axis(&self, column: usize) -> bool {
        self.accel.contains(&column) || self.gyro.is_some_and(|g| g.contains(&column))
    }
}

/// Names and units of the columns, from the lines above the rows.
struct Header {
    names: Vec<String>,
    units: Vec<String>,
}

impl Header {
    fn parse(above: &[&str], rows: &[&str], dialect: Dialect) -> Self {
        let parts = |i: usize| header_fields(above[i], dialect);
        let mut end = above.len();
        let mut units = Vec::new();
        while end > 1
            && let Some(row) = parts(end - 1).filter(|f| is_row_of_units(f))
            && parts(end - 2).is_some()
        {
            let has_unit =
                |u: &String| AccelUnit::parse(u).is_some() || GyroUnit::parse(u).is_some();
            if row.iter().any(has_unit) {
                units = row;
            }
            end -= 1;
        }
        let has_letter = |n: &&String| n.chars().any(char::is_alphabetic);
        let is_named = |f: &Vec<String>| f.iter().filter(has_letter).count() * 2 > f.len();
        let names = end
            .checked_sub(1)
            .and_then(parts)
            .filter(is_named)
            .unwrap_or_default();
        let mut header = Header { names, units };
        if end > 1
            && let Some(upper) = parts(end - 2)
        {
            header.join(&upper);
        }
        header.fill_up(rows, dialect);
        header
    }

    /// A header of two rows: sensor above, axis below, each more than once.
    fn join(&mut self, upper: &[String]) {
        let repeats = |f: &[String]| f.iter().enumerate().any(|(i, n)| f[..i].contains(n));
        if upper.len() == self.names.len() && repeats(upper) && repeats(&self.names) {
            for (name, upper) in self.names.iter_mut().zip(upper) {
                *name = format!("{upper}.{name}");
            }
        }
    }

    /// A header one name short: an index without a name, or a delimiter at the end of the rows.
    fn fill_up(&mut self, rows: &[&str], dialect: Dialect) {
        if self.names.is_empty() || self.names.len() >= dialect.fields {
            return;
        }
        let mut is_open = true;
        let mut index = Vec::new();
        for row in rows
            .iter()
            .filter(|l| dialect.is_row(l))
            .take(DIALECT_LINES)
        {
            let cells: Vec<&str> = fields(row, dialect.delimiter).collect();
            is_open &= cells.last().is_some_and(|f| f.is_empty());
            index.extend(parse_cell(cells[0], dialect.decimal_comma));
        }
        let is_index = !is_open && roles::is_counter(&index);
        self.names
            .insert(if is_index { 0 } else { dialect.fields - 1 }, String::new());
    }
}

/// The fields of a line of the header, which may have another delimiter than the rows.
fn header_fields(line: &str, dialect: Dialect) -> Option<Vec<String>> {
    let text = line.trim_start_matches(['#', '%', '/', ' ']);
    let delimiters = [
        dialect.delimiter,
        Delimiter::Byte(b'\t'),
        Delimiter::Byte(b','),
        Delimiter::Byte(b';'),
    ];
    for delimiter in delimiters {
        let mut parts: Vec<String> = fields(text, delimiter).map(str::to_owned).collect();
        if parts.len() == dialect.fields + 1 {
            parts.pop_if(|last| last.is_empty());
        }
        let is_own = delimiter == dialect.delimiter;
        let is_one_short = is_own && parts.len() + 1 == dialect.fields;
        if parts.len() == dialect.fields || is_one_short {
            return Some(parts).filter(|p| !is_prose(p, delimiter));
        }
    }
    // Names with blanks in them, set apart by two.
    let parts = text.split("  ").map(str::trim).filter(|f| !f.is_empty());
    let parts: Vec<String> = parts.map(str::to_owned).collect();
    (parts.len() == dialect.fields).then_some(parts)
}

/// Words of a sentence: `calibrating, keep it still...`.
fn is_prose(parts: &[String], delimiter: Delimiter) -> bool {
    delimiter == Delimiter::Whitespace && parts.iter().any(|p| p.ends_with([',', '.', '!', '?']))
}

fn is_row_of_units(parts: &[String]) -> bool {
    const OTHERS: [&str; 8] = ["CAL", "mV", "kPa", "n/a", "uT", "uS", "kOhms", "local_flux"];
    let is_known = |u: &&String| {
        u.is_empty() || is_unit(u) || OTHERS.contains(&u.as_str()) || *u == "no_units"
    };
    parts.iter().filter(is_known).count() * 10 >= parts.len() * 7
}

/// Counts per epoch are no acceleration: `Epoch Period (hh:mm:ss) 00:00:15`.
fn counts_epochs(metadata: &[String]) -> bool {
    metadata
        .iter()
        .filter(|l| l.to_lowercase().contains("epoch"))
        .any(|line| {
            let words = line
                .split([' ', ',', ';', '\t'])
                .filter(|w| w.contains(':'));
            words.filter_map(|w| parse_cell(w, false)).any(|s| s > 0.0)
        })
}

/// Empatica: the start in all columns, then the rate in all columns. Returns the rate in Hz.
fn start_and_rate(sample: &Batch) -> Option<f64> {
    let common = |row: usize| {
        let first = sample.columns.first()?.get(row)?;
        sample
            .columns
            .iter()
            .all(|c| c.get(row) == Some(first))
            .then_some(*first)
    };
    let (start_s, rate_hz) = (common(0)?, common(1)?);
    (start_s > 1e9 && rate_hz > 0.0 && sample.rows() > 2).then_some(rate_hz)
}
