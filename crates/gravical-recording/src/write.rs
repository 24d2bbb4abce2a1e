//! Tables: batches to text.
//!
//! A [`Table`] says where each column of the output comes from: copied byte for byte from the
//! text of the rows, or written from values. A [`Writer`] writes batch after batch in memory that
//! does not grow.

mod fixed;

pub use fixed::{write_fixed, write_trimmed};

use std::io::{self, Write};

use memchr::{memchr, memchr2};

use crate::text::{Delimiter, Format, Layout, Role, RowTexts};

/// Bytes that are collected before they are written.
const BLOCK_BYTES: usize = 1 << 18;

/// A column of values that takes the place of a column of the input, or is appended.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct NewColumn {
    /// Its name
    pub name: String,
    /// Column of the input whose place it takes; `None`: it is appended
    pub replaces: Option<usize>,
}

/// Where the cells of a column come from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Cell {
    /// Columns of the input from the first to the last, byte for byte
    Copied(usize, usize),
    /// A text of the input in quotes where this table needs them
    Quoted(usize),
    /// A column of values with so many decimals; empty where it is NaN
    Fixed(usize, u32),
    /// The same without zeros at the end of the decimals
    Trimmed(usize, u32),
}

/// Columns of an output.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Table {
    /// Their names
    pub names: Vec<String>,
    /// Columns of the input that were renamed, because a new one has their name: old and new name
    pub renamed: Vec<(String, String)>,
    cells: Vec<Cell>,
    delimiter: u8,
    decimal_comma: bool,
    /// Delimiter of the text of the rows, and the number of its fields that are looked at
    input: (Delimiter, usize),
}

impl Table {
    /// All columns of the input, with those that are replaced in their place and the others at
    /// the end; with `keep_replaced` all new columns come at the end.
    ///
    /// Delimiter and decimal sign are those of the input; white space becomes a tab.
    #[must_use]
    pub fn with_new(
        format: &Format,
        columns: &[NewColumn],
        decimals: u32,
        keep_replaced: bool,
    ) -> Self {
        let (delimiter, decimal_comma) = dialect(format);
        let mut table = Table {
            names: Vec::new(),
            renamed: Vec::new(),
            cells: Vec::new(),
            delimiter: match delimiter {
                Delimiter::Byte(byte) => byte,
                Delimiter::Whitespace => b'\t',
            },
            decimal_comma,
            input: (delimiter, 0),
        };
        let fields = format.columns.len();
        let input: Vec<String> = (0..fields).map(|c| input_name(format, c)).collect();
        for (field, name) in input.iter().enumerate() {
            let new = columns.iter().position(|c| c.replaces == Some(field));
            match new.filter(|_| !keep_replaced) {
                Some(value) => {
                    table.push(columns[value].name.clone(), Cell::Fixed(value, decimals))
                }
                None => {
                    let name = table.unused_name(name, columns, &input);
                    table.copy(field, name);
                }
            }
        }
        for (value, column) in columns.iter().enumerate() {
            if keep_replaced || column.replaces.is_none() {
                table.push(column.name.clone(), Cell::Fixed(value, decimals));
            }
        }
        let last = |cell: &Cell| {
            if let Cell::Copied(_, last) = cell {
                last + 1
            } else {
                0
            }
        };
        table.input.1 = table.cells.iter().map(last).max().unwrap_or(0);
        table
    }

    /// A table of these columns, parted by commas.
    #[must_use]
    pub fn plain(format: &Format, columns: impl IntoIterator<Item = (String, Cell)>) -> Self {
        let (names, cells): (Vec<String>, Vec<Cell>) = columns.into_iter().unzip();
        let last = |cell: &Cell| {
            if let Cell::Quoted(field) = cell {
                field + 1
            } else {
                0
            }
        };
        let fields = cells.iter().map(last).max().unwrap_or(0);
        Table {
            names,
            renamed: Vec::new(),
            cells,
            delimiter: b',',
            decimal_comma: false,
            input: (dialect(format).0, fields),
        }
    }

    fn push(&mut self, name: String, cell: Cell) {
        self.names.push(name);
        self.cells.push(cell);
    }

    /// Copies a column, together with the one before it if that is copied too.
    fn copy(&mut self, field: usize, name: String) {
        let is_parted_by_byte = matches!(self.input.0, Delimiter::Byte(_));
        match self.cells.last_mut() {
            Some(Cell::Copied(_, last)) if is_parted_by_byte => {
                *last = field;
                self.names.push(name);
            }
            _ => self.push(name, Cell::Copied(field, field)),
        }
    }

    /// The name of a copied column, or one that no other column has if a new one is called so.
    fn unused_name(&mut self, name: &str, new: &[NewColumn], input: &[String]) -> String {
        let is_new = |name: &str| new.iter().any(|c| c.name == name);
        let mut free = name.to_owned();
        while is_new(&free) || free != name && (input.contains(&free) || self.names.contains(&free))
        {
            free.insert_str(0, "input_");
        }
        if free != name {
            self.renamed.push((name.to_owned(), free.clone()));
        }
        free
    }
}

fn dialect(format: &Format) -> (Delimiter, bool) {
    match &format.layout {
        Layout::Table(dialect) => (dialect.delimiter, dialect.decimal_comma),
        Layout::Sentences(_) => (Delimiter::Byte(b','), false),
    }
}

/// Name of a column of the input: from the header, or by what it holds.
fn input_name(format: &Format, column: usize) -> String {
    if !format.names.is_empty() {
        return format.names.get(column).cloned().unwrap_or_default();
    }
    let place = |axes: [usize; 3]| axes.iter().position(|c| *c == column);
    let axis = |sensor: &str, i: usize| format!("{sensor}{}", ["x", "y", "z"][i]);
    if let Some(i) = place(format.accel) {
        return axis("a", i);
    }
    if let Some(i) = format.gyro.and_then(place) {
        return axis("g", i);
    }
    match format.columns[column].role {
        Role::Time => "t".to_owned(),
        Role::Temperature => "temperature".to_owned(),
        Role::Label => "label".to_owned(),
        _ => format!("column_{}", column + 1),
    }
}

/// Writes a table batch by batch.
pub struct Writer<W> {
    out: W,
    table: Table,
    bytes: Vec<u8>,
    /// Start and end of the fields of a row.
    spans: Vec<(usize, usize)>,
}

impl<W: Write> Writer<W> {
    /// A table that begins with the names of its columns, quoted where they need it.
    pub fn new(out: W, table: Table) -> Self {
        let mut bytes = Vec::with_capacity(BLOCK_BYTES + BLOCK_BYTES / 4);
        for name in &table.names {
            write_quoted(&mut bytes, name.as_bytes(), table.delimiter);
            bytes.push(table.delimiter);
        }
        end_line(&mut bytes);
        Writer {
            out,
            table,
            bytes,
            spans: Vec::new(),
        }
    }

    /// Writes the rows of a batch: its text, and columns of values of the same length. A blank
    /// line stands before the rows of `breaks`, which rise.
    ///
    /// # Errors
    ///
    /// Errors of writing.
    pub fn write_batch(
        &mut self,
        text: &RowTexts,
        values: &[&[f64]],
        breaks: &[usize],
    ) -> io::Result<()> {
        let mut breaks = breaks.iter().copied().peekable();
        for (row, line) in text.iter().enumerate() {
            if breaks.next_if_eq(&row).is_some() {
                self.bytes.push(b'\n');
            }
            self.write_row(line, values, row);
            if self.bytes.len() >= BLOCK_BYTES {
                self.out.write_all(&self.bytes)?;
                self.bytes.clear();
            }
        }
        Ok(())
    }

    /// Writes what is left.
    ///
    /// # Errors
    ///
    /// Errors of writing.
    pub fn finish(mut self) -> io::Result<()> {
        self.out.write_all(&self.bytes)?;
        self.out.flush()
    }

    #[inline]
    fn write_row(&mut self, line: &[u8], values: &[&[f64]], row: usize) {
        let (delimiter, fields) = self.table.input;
        split(line, delimiter, fields, &mut self.spans);
        let out = &mut self.bytes;
        for cell in &self.table.cells {
            match *cell {
                Cell::Copied(first, last) => {
                    if let (Some(from), Some(to)) = (self.spans.get(first), self.spans.get(last)) {
                        out.extend_from_slice(&line[from.0..to.1]);
                    }
                }
                Cell::Quoted(field) => {
                    if let Some((from, to)) = self.spans.get(field) {
                        write_quoted(out, unquoted(&line[*from..*to]), self.table.delimiter);
                    }
                }
                Cell::Fixed(column, decimals) => {
                    write_fixed(out, values[column][row], decimals);
                    if self.table.decimal_comma {
                        set_decimal_comma(out, decimals);
                    }
                }
                Cell::Trimmed(column, decimals) => {
                    write_trimmed(out, values[column][row], decimals);
                }
            }
            out.push(self.table.delimiter);
        }
        end_line(out);
    }
}

/// The last delimiter ends the line.
fn end_line(out: &mut [u8]) {
    if let Some(end) = out.last_mut() {
        *end = b'\n';
    }
}

/// Start and end of the first fields of a line; quotes and blanks beside a delimiter belong to
/// the field.
fn split(line: &[u8], delimiter: Delimiter, fields: usize, spans: &mut Vec<(usize, usize)>) {
    spans.clear();
    let mut at = 0;
    while spans.len() < fields {
        let rest = &line[at..];
        match delimiter {
            Delimiter::Whitespace => {
                let Some(start) = rest.iter().position(|b| !b.is_ascii_whitespace()) else {
                    return;
                };
                let length = rest[start..].iter().position(u8::is_ascii_whitespace);
                let end = length.map_or(line.len(), |n| at + start + n);
                spans.push((at + start, end));
                at = end;
            }
            Delimiter::Byte(byte) => {
                let Some(length) = field_length(rest, byte) else {
                    spans.push((at, line.len()));
                    return;
                };
                spans.push((at, at + length));
                at += length + 1;
            }
        }
    }
}

/// Bytes before the next delimiter that stands outside of quotes.
fn field_length(text: &[u8], delimiter: u8) -> Option<usize> {
    let mut at = memchr2(delimiter, b'"', text)?;
    while text[at] == b'"' {
        at += 1;
        at += memchr(b'"', &text[at..])? + 1;
        at += memchr2(delimiter, b'"', &text[at..])?;
    }
    Some(at)
}

/// A text without blanks and quotes around it; quotes in it stay doubled.
fn unquoted(text: &[u8]) -> &[u8] {
    let text = text.trim_ascii();
    let inner = text.strip_prefix(b"\"").and_then(|t| t.strip_suffix(b"\""));
    inner.unwrap_or(text)
}

/// Writes a text, in quotes where it needs them; quotes in it are doubled unless they are.
fn write_quoted(out: &mut Vec<u8>, text: &[u8], delimiter: u8) {
    let is_special = |b: &u8| *b == delimiter || matches!(b, b'"' | b'\n' | b'\r');
    if !text.iter().any(is_special) {
        return out.extend_from_slice(text);
    }
    out.push(b'"');
    let mut at = 0;
    while let Some(byte) = text.get(at) {
        out.push(*byte);
        at += 1;
        if *byte == b'"' {
            out.push(b'"');
            at += usize::from(text.get(at) == Some(&b'"'));
        }
    }
    out.push(b'"');
}

/// Replaces the point of the last number by a comma.
fn set_decimal_comma(out: &mut [u8], decimals: u32) {
    let at = out.len().wrapping_sub(decimals as usize + 1);
    if let Some(point) = out.get_mut(at)
        && *point == b'.'
    {
        *point = b',';
    }
}
