//! What the rows of a board are: how they are written, and which number is what. Learned
//! once, from a header, from the names in the rows or from the first rows, by the same rules as
//! the format and the columns of a file.

use gravical::Result;
use gravical::recording::dialect::{Dialect, Header, names_alone, sniff, without_last_delimiter};
use gravical::recording::layout::Layout;
use gravical::recording::names::{Quantity, understand};
use gravical::recording::row::{Delimiter, RowDefect};
use gravical::recording::{ColumnsSpec, stream_layout};

use super::item::{FIELDS, Reason, Row};
use super::named::{column_names, unnamed};

/// The column of arrival times, where the board sends no time.
pub const HOST_TIME: &str = "t_host_ms";

/// Rows of one form that are needed where nothing names the columns.
pub const LEAST_ROWS: usize = 5;

/// The rows of a board.
#[derive(Debug, Clone)]
pub struct RowShape {
    /// The texts around the numbers, where each has its name.
    texts: Option<Vec<String>>,
    dialect: Dialect,
    layout: Layout,
    columns: Vec<u8>,
    notes: Vec<String>,
    /// The board sends no time: the file has a column of arrival times.
    pub host_time: bool,
}

/// The texts around the numbers of a line, if they have names, and its numbers as a row of a file.
fn plain(text: &[u8]) -> (Option<Vec<String>>, Vec<u8>) {
    match unnamed(text) {
        Some((texts, numbers)) => (Some(texts), numbers),
        None => (None, without_last_delimiter(text).to_vec()),
    }
}

fn reason(defect: RowDefect) -> Reason {
    match defect {
        RowDefect::NotANumber(_) => Reason::NotANumber,
        _ => Reason::FieldCount,
    }
}

/// The names in a header, and what separates them.
pub fn header_names(text: &[u8]) -> Option<(Delimiter, Vec<String>)> {
    names_alone(text).filter(|(_, names)| FIELDS.contains(&names.len()))
}

/// Checks that a line is a row of some form.
///
/// # Errors
///
/// Why it is none.
pub fn check_row(text: &[u8]) -> std::result::Result<(), Reason> {
    let (_, line) = plain(text);
    let dialect = sniff(&line, true, *FIELDS.start());
    let dialect = dialect.filter(|dialect| FIELDS.contains(&dialect.fields));
    let numbers = dialect.ok_or(Reason::FieldCount)?.numbers(&line);
    numbers.map(drop).map_err(reason)
}

impl RowShape {
    /// By the header of the board; its rows may not have arrived yet.
    ///
    /// # Errors
    ///
    /// `columns-missing` (usage) when `spec` names a column that the header does not have.
    pub fn of_header(header: &[u8], spec: Option<&ColumnsSpec>) -> Result<Option<Self>> {
        let Some((delimiter, names)) = header_names(header) else {
            return Ok(None);
        };
        let dialect = Dialect::of_columns(delimiter, names.len(), Some(names), Vec::new());
        Self::new(None, dialect, Some(header), spec).map(Some)
    }

    /// By rows: the form of most of them, at least [`LEAST_ROWS`]; none where there are
    /// fewer. `header` is used if it has the form of the rows.
    ///
    /// # Errors
    ///
    /// As [`of_header`](Self::of_header).
    pub fn of_rows<'a>(
        rows: impl Iterator<Item = &'a [u8]>,
        header: Option<&[u8]>,
        spec: Option<&ColumnsSpec>,
    ) -> Result<Option<Self>> {
        // Rows by the texts around their numbers.
        let mut forms: Vec<(Option<Vec<String>>, usize, Vec<u8>)> = Vec::new();
        for (texts, line) in rows.map(plain) {
            let line = [&line[..], b"\n"].concat();
            match forms.iter_mut().find(|(known, ..)| *known == texts) {
                Some((_, n, lines)) => (*n, *lines) = (*n + 1, [&lines[..], &line].concat()),
                None => forms.push((texts, 1, line)),
            }
        }
        // Of equals the first: the last of the reversed.
        let most = forms.into_iter().rev().max_by_key(|(_, n, _)| *n);
        let Some((texts, _, lines)) = most else {
            return Ok(None);
        };
        let dialect = sniff(&lines, true, *FIELDS.start());
        let Some(mut dialect) = dialect.filter(|d| d.sample.len() >= LEAST_ROWS) else {
            return Ok(None);
        };
        let fits = |(delimiter, names): &(Delimiter, Vec<String>)| {
            texts.is_none() && *delimiter == dialect.delimiter && names.len() == dialect.fields
        };
        let named = header.and_then(header_names).filter(fits);
        let header = header.filter(|_| named.is_some());
        let names = texts.as_deref().map(column_names);
        let names = names.or(named.map(|(_, names)| names));
        dialect.header = names.map(Header::of_names);
        Self::new(texts, dialect, header, spec).map(Some)
    }

    /// `header`: the line with the names of `dialect`, if they are not in the rows.
    fn new(
        texts: Option<Vec<String>>,
        dialect: Dialect,
        header: Option<&[u8]>,
        spec: Option<&ColumnsSpec>,
    ) -> Result<Self> {
        let layout = stream_layout(&dialect, spec)?;
        let host_time = layout.field(Quantity::Time).is_none();
        let names = dialect.header.as_ref().map(|header| &header.names[..]);
        let named = file_names(&layout, dialect.fields, names, spec.is_some());
        let mut notes = Vec::new();
        match (names, header) {
            (None, _) => {
                let how = match spec {
                    Some(_) => "as given with --columns",
                    None => "recognised by the numbers",
                };
                notes.push(format!("# the board names no columns: {how}"));
            }
            (Some(own), Some(_)) if *own != named => {
                notes.push(format!("# the board names its columns {}", own.join(",")));
            }
            (Some(_), None) => {
                notes.push("# the board sends each number with its name".to_owned());
            }
            _ => {}
        }
        let separator = char::from(separator(&dialect)).to_string();
        let unchanged = header.filter(|_| names == Some(&named));
        let mut columns = match unchanged {
            Some(header) => header.to_vec(),
            None => named.join(&separator).into_bytes(),
        };
        if host_time {
            columns = [HOST_TIME.as_bytes(), separator.as_bytes(), &columns[..]].concat();
            notes.push(format!(
                "# {HOST_TIME}: the board sends no time; this is the time of arrival at the computer, ms since the first row"
            ));
        }
        Ok(RowShape {
            texts,
            dialect,
            layout,
            columns,
            notes,
            host_time,
        })
    }

    /// The header of the file.
    pub fn columns(&self) -> &[u8] {
        &self.columns
    }

    /// Lines that begin with `#`, for the head of the file.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Whether a header is written as the rows are, with a name for each number.
    pub fn fits(&self, header: &[u8]) -> bool {
        let own = (self.dialect.delimiter, self.dialect.fields);
        let named = header_names(header);
        self.texts.is_none() && named.is_some_and(|(by, names)| (by, names.len()) == own)
    }

    /// A row, and the line of it for the file.
    ///
    /// # Errors
    ///
    /// Why the line is none.
    pub fn row(&self, text: &[u8]) -> std::result::Result<(Vec<u8>, Row), Reason> {
        let (texts, line) = plain(text);
        if texts != self.texts {
            return Err(Reason::FieldCount);
        }
        let numbers = self.dialect.numbers(&line).map_err(reason)?;
        let value = |quantity| numbers.get(self.layout.field(quantity)?).copied();
        let axes = [0, 1, 2].map(|axis| value(Quantity::Accel(axis)));
        // Differences and parts of a stamp are no clock by themselves.
        let is_clock = !self.layout.sums_time && self.layout.fraction.is_none();
        let row = Row {
            stamp: value(Quantity::Time).filter(|_| is_clock),
            accel: match axes {
                [Some(x), Some(y), Some(z)] => Some([x, y, z]),
                _ => None,
            },
            temperature: value(Quantity::Temperature),
        };
        Ok((line, row))
    }

    /// A line of the file with its arrival time in front, where the board sends none.
    pub fn with_host_time(&self, line: Vec<u8>, time_s: f64) -> Vec<u8> {
        if !self.host_time {
            return line;
        }
        let mut stamped = format!("{:.1}", time_s * 1e3).into_bytes();
        stamped.push(separator(&self.dialect));
        stamped.extend(line);
        stamped
    }
}

/// What separates the columns of the file.
fn separator(dialect: &Dialect) -> u8 {
    match dialect.delimiter {
        Delimiter::Byte(byte) => byte,
        Delimiter::Whitespace => b' ',
    }
}

/// Whether a header can be used before the first row: it names an accelerometer, and not
/// just with the words of a sentence.
pub fn is_certain(header: &[u8]) -> bool {
    let is_sentence = header_names(header).is_none_or(|(by, _)| by == Delimiter::Whitespace);
    let shape = RowShape::of_header(header, None);
    let layout = shape.ok().flatten().map(|shape| shape.layout);
    !is_sentence && layout.is_some_and(|layout| layout.field(Quantity::Accel(0)).is_some())
}

/// The names of the columns in the file: those of the board, unless `--columns` says
/// otherwise; a channel's own name where there is none, and `c5` for an unknown column.
fn file_names(
    layout: &Layout,
    fields: usize,
    names: Option<&[String]>,
    is_given: bool,
) -> Vec<String> {
    let of_field = |field: usize| {
        let channel = layout.fields.iter().find(|(_, f)| *f == field);
        let channel = channel.map(|(quantity, _)| *quantity);
        let own = names.and_then(|names| names.get(field));
        let understood = own.and_then(|name| understand(name)).map(|c| c.quantity);
        match own {
            Some(own) if !is_given || understood == channel => return own.clone(),
            _ => {}
        }
        channel
            .and_then(|quantity| channel_name(quantity, layout.sums_time))
            .unwrap_or_else(|| format!("c{}", field + 1))
    };
    (0..fields).map(of_field).collect()
}

fn channel_name(quantity: Quantity, sums_time: bool) -> Option<String> {
    let axis = |i: usize| ["x", "y", "z"].get(i).copied().unwrap_or_default();
    Some(match quantity {
        Quantity::Time if sums_time => "dt".to_owned(),
        Quantity::Time => "Timestamp".to_owned(),
        Quantity::Accel(i) => format!("a{}", axis(i)),
        Quantity::Gyro(i) => format!("g{}", axis(i)),
        Quantity::Temperature => "temp".to_owned(),
        Quantity::Label => "label".to_owned(),
        _ => return None,
    })
}
