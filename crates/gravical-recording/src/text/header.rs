//! Names and units of the columns, from the lines above the rows.

use std::collections::HashSet;

use gravical_judge::Role;
use gravical_judge::units::{AccelUnit, GyroUnit, is_unit};

use super::dialect::{Dialect, fields, is_blank, is_comment, uncommented};
use super::format::Format;
use super::names::Column;
use super::number::parse_cell;
use super::roles::is_counter;

/// Rows by which a column without a name is recognised.
const ROWS: usize = 400;

/// Names and units of the columns, from the lines above the rows.
#[derive(Default)]
pub(crate) struct Header {
    pub names: Vec<String>,
    pub units: Vec<String>,
    /// Line that holds the names, from 1; 0 without one.
    pub line: usize,
}

impl Header {
    pub(crate) fn parse(above: &[&str], rows: &[&str], dialect: Dialect) -> Self {
        let lines = (1..).zip(above).filter(|(_, line)| !is_blank(line));
        let lines = lines.map(|(number, line)| (number, header_fields(line, dialect)));
        let mut lines: Vec<(usize, Option<Vec<String>>)> = lines.collect();
        let mut header = Header::default();
        if let Some(named) = named_line(above, dialect) {
            // Other lines below the names are no header.
            let is_kept = |(number, fields): &(usize, Option<Vec<String>>)| {
                *number <= named + 1 || fields.as_ref().is_some_and(|f| is_row_of_units(f))
            };
            lines.retain(is_kept);
        }
        while let [.., (_, Some(_)), (_, Some(row))] = &lines[..]
            && is_row_of_units(row)
        {
            let is_of_sensor =
                |u: &String| AccelUnit::parse(u).is_some() || GyroUnit::parse(u).is_some();
            if row.iter().any(is_of_sensor) {
                header.units.clone_from(row);
            }
            lines.pop();
        }
        let has_letter = |name: &&String| name.chars().any(char::is_alphabetic);
        if let Some((line, Some(names))) = lines.pop()
            && names.iter().filter(has_letter).count() * 2 > names.len()
        {
            (header.names, header.line) = (names, line);
        }
        if let Some((_, Some(upper))) = lines.pop() {
            header.join(upper);
        }
        header.fill_up(rows, dialect);
        header
    }

    /// The place of the first row without measurements, such as `0,--,--,--`, in the lines above the first
    /// row with some, if a line before it names a sensor.
    pub(crate) fn first_row(above: &[&str], dialect: Dialect) -> Option<usize> {
        let below = named_line(above, dialect)? + 1;
        let is_row = |line: &&str| {
            let cells = fields(line, dialect.delimiter).map(|cell| dialect.parse_field(cell));
            let cells = cells.collect::<Option<Vec<f64>>>().unwrap_or_default();
            let is_whole = cells.len() == dialect.fields && !is_comment(line);
            is_whole && cells.iter().any(|v| v.is_finite())
        };
        let row = above[below..].iter().position(is_row)?;
        Some(below + row)
    }

    /// Whether a line among the rows repeats the header, or a piece of it; `None` for a line that names
    /// neither a sensor nor half of the columns.
    pub(crate) fn is_repeated(line: &str, dialect: Dialect, format: &Format) -> Option<bool> {
        let first = format.header_line.checked_sub(1);
        let first = first.and_then(|at| format.metadata.get(at));
        let line = line.trim();
        if line.len() > 3 && first.is_some_and(|first| first.contains(line)) {
            return Some(true);
        }
        let (delimiter, names) = split_names(line, dialect).find(|(_, names)| {
            let known = |name: &&&str| format.names.iter().any(|n| n == **name);
            let is_like_first = names.len() == format.names.len()
                && 2 * names.iter().filter(known).count() >= names.len();
            is_like_first || names_sensor(names)
        })?;
        let role = |column: &usize| names.get(*column).map(|n| Column::from_name(n).role);
        let is_same = if format.names.is_empty() {
            let mut axes = format.accel.iter().enumerate();
            axes.all(|(axis, column)| role(column) == Some(Role::Accel(axis)))
        } else {
            let columns = names.len().max(format.names.len());
            let first = |c: usize| format.names.get(c).map_or("", String::as_str);
            (0..columns).all(|c| names.get(c).copied().unwrap_or_default() == first(c))
        };
        Some(is_same && delimiter == dialect.delimiter)
    }

    /// A header of two rows: sensor above, axis below, each more than once.
    fn join(&mut self, mut upper: Vec<String>) {
        let repeats = |f: &[String]| f.iter().collect::<HashSet<_>>().len() < f.len();
        // Merged cells leave the following ones empty.
        for i in 1..upper.len() {
            if upper[i].is_empty() {
                upper[i] = upper[i - 1].clone();
            }
        }
        if upper.len() == self.names.len() && repeats(&upper) && repeats(&self.names) {
            let names = self.names.iter_mut().zip(upper);
            for (name, upper) in names.filter(|(_, u)| !u.is_empty()) {
                *name = format!("{upper}.{name}");
            }
        }
    }

    /// A header one name short: an index without a name, white space between a date and its time, or a
    /// delimiter at the end of the rows.
    fn fill_up(&mut self, rows: &[&str], dialect: Dialect) {
        if self.names.is_empty() || self.names.len() >= dialect.fields {
            return;
        }
        let (mut is_open, mut time) = (true, None);
        let mut index = Vec::new();
        for row in rows.iter().filter(|l| dialect.is_row(l)).take(ROWS) {
            let cells: Vec<&str> = fields(row, dialect.delimiter).collect();
            is_open &= cells.last().is_some_and(|f| f.is_empty());
            index.extend(parse_cell(cells[0], dialect.decimal_comma));
            let is_part = |c: &usize| cells[*c].contains(':') && cells[c - 1].len() > 5;
            time = (1..cells.len())
                .find(is_part)
                .filter(|_| dialect.delimiter.is_none());
        }
        let at = match time {
            None if !is_open && is_counter(&index) => 0,
            _ => time.unwrap_or(dialect.fields - 1),
        };
        self.names.insert(at, String::new());
    }
}

/// The last line that names a sensor, and is no comment.
fn named_line(above: &[&str], dialect: Dialect) -> Option<usize> {
    let is_named = |line: &&str| {
        !is_comment(line) && header_fields(line, dialect).is_some_and(|f| names_sensor(&f))
    };
    above.iter().rposition(is_named)
}

/// Whether all three axes of a sensor are among the names.
pub(crate) fn names_sensor(names: &[impl AsRef<str>]) -> bool {
    let roles = names.iter().map(|n| Column::from_name(n.as_ref()).role);
    let roles: Vec<Role> = roles.collect();
    let has_all = |role: fn(usize) -> Role| (0..3).all(|i| roles.contains(&role(i)));
    has_all(Role::Accel) || has_all(Role::Gyro)
}

/// The fields of a line of names under the delimiter of the rows, and under others.
fn split_names(line: &str, dialect: Dialect) -> impl Iterator<Item = (Option<u8>, Vec<&str>)> {
    let others = [b'\t', b',', b';'].map(Some);
    let delimiters = [dialect.delimiter].into_iter().chain(others);
    delimiters.map(move |delimiter| (delimiter, fields(uncommented(line), delimiter).collect()))
}

/// The fields of a line of the header, which may have another delimiter than the rows.
fn header_fields(line: &str, dialect: Dialect) -> Option<Vec<String>> {
    for (delimiter, parts) in split_names(line, dialect) {
        let mut parts: Vec<String> = parts.into_iter().map(str::to_owned).collect();
        if parts.len() == dialect.fields + 1 {
            parts.pop_if(|last| last.is_empty());
        }
        let is_own = delimiter == dialect.delimiter;
        let is_one_short = is_own && parts.len() + 1 == dialect.fields;
        if parts.len() == dialect.fields || is_one_short {
            // Words of a sentence: `calibrating, keep it still...`.
            let ends = |p: &String| p.ends_with([',', '.', '!', '?']);
            let is_prose = delimiter.is_none() && parts.iter().any(ends);
            return (!is_prose).then_some(parts);
        }
    }
    // Names with blanks in them, set apart by two.
    let parts = uncommented(line)
        .split("  ")
        .map(str::trim)
        .filter(|f| !f.is_empty());
    let parts: Vec<String> = parts.map(str::to_owned).collect();
    (parts.len() == dialect.fields).then_some(parts)
}

fn is_row_of_units(parts: &[String]) -> bool {
    let is_known = |u: &&String| u.is_empty() || is_unit(u);
    parts.iter().filter(is_known).count() * 10 >= parts.len() * 7
}
