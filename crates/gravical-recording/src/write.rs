//! Tables: rows to text.
//!
//! A [`Table`] says where each column of the output comes from: copied byte for byte from the
//! text of the rows, or written from values. A [`Writer`] writes piece after piece in memory that
//! does not grow.

mod fixed;

pub use fixed::{write_fixed, write_trimmed};

use std::io::{self, Write};

use gravical_judge::Role;

use crate::text::{CopiedText, Format};

/// Bytes that are collected before they are written.
const BLOCK_BYTES: usize = 1 << 18;

/// Where the cells of a column come from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Cell {
    /// A piece of the text of the input, byte for byte
    Copied(usize),
    /// The same in quotes where this table needs them
    Quoted(usize),
    /// A column of values with so many decimals; empty where it is NaN
    Fixed(usize, u32),
    /// The same without zeros at the end of the decimals
    Trimmed(usize, u32),
}

/// Columns of an output.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Table {
    /// Their names
    pub names: Vec<String>,
    cells: Vec<Cell>,
    delimiter: u8,
    decimal_comma: bool,
    copied: Vec<(usize, usize)>,
}

impl Table {
    /// All columns of the input, with new ones of values: their names, and the column of the input
    /// whose place each takes. Those without one come at the end; with `keep_replaced` all do.
    ///
    /// Delimiter and decimal sign are those of the input; white space becomes a tab.
    pub fn with_new(
        format: &Format,
        columns: &[(String, Option<usize>)],
        decimals: u32,
        keep_replaced: bool,
    ) -> Self {
        let delimiter = format.dialect.delimiter;
        let mut table = Table {
            delimiter: delimiter.unwrap_or(b'\t'),
            decimal_comma: format.dialect.decimal_comma,
            ..Table::default()
        };
        let fields = format.columns.len();
        let input: Vec<String> = (0..fields).map(|c| input_name(format, c)).collect();
        for (field, name) in input.iter().enumerate() {
            let takes_place =
                |new: &(String, Option<usize>)| !keep_replaced && new.1 == Some(field);
            match columns.iter().position(takes_place) {
                Some(value) => table.push(columns[value].0.clone(), Cell::Fixed(value, decimals)),
                None => {
                    let name = table.unused_name(name, columns, &input);
                    table.copy(field, name, delimiter);
                }
            }
        }
        for (value, (name, replaces)) in columns.iter().enumerate() {
            if keep_replaced || replaces.is_none() {
                table.push(name.clone(), Cell::Fixed(value, decimals));
            }
        }
        table
    }

    /// A table of these columns, parted by commas; `copied` are the columns of the input that are
    /// its pieces.
    pub fn plain(
        columns: impl IntoIterator<Item = (String, Cell)>,
        copied: impl IntoIterator<Item = usize>,
    ) -> Self {
        let (names, cells) = columns.into_iter().unzip();
        Table {
            names,
            cells,
            delimiter: b',',
            copied: copied.into_iter().map(|c| (c, c)).collect(),
            ..Table::default()
        }
    }

    /// The columns whose text is copied, for [`Format::parse_with_text`].
    pub fn copied(&self) -> &[(usize, usize)] {
        &self.copied
    }

    fn push(&mut self, name: String, cell: Cell) {
        self.names.push(name);
        self.cells.push(cell);
    }

    /// Copies a column, together with the one before it if that is copied too and one byte parts
    /// them.
    fn copy(&mut self, field: usize, name: String, delimiter: Option<u8>) {
        let follows = matches!(self.cells.last(), Some(Cell::Copied(_)));
        match self.copied.last_mut() {
            Some((_, last)) if follows && delimiter.is_some() => {
                *last = field;
                self.names.push(name);
            }
            _ => {
                self.push(name, Cell::Copied(self.copied.len()));
                self.copied.push((field, field));
            }
        }
    }

    /// The name of a copied column, or one that no other column has if a new one is called so.
    fn unused_name(&self, name: &str, new: &[(String, Option<usize>)], input: &[String]) -> String {
        let is_new = |name: &str| new.iter().any(|(new, _)| new == name);
        let mut free = name.to_owned();
        while is_new(&free) || free != name && (input.contains(&free) || self.names.contains(&free))
        {
            free.insert_str(0, "input_");
        }
        free
    }
}

/// Name of a column of the input: from the header, or by what it holds.
pub fn input_name(format: &Format, column: usize) -> String {
    if !format.names.is_empty() {
        return format.names.get(column).cloned().unwrap_or_default();
    }
    match format.role(column) {
        role @ (Role::Accel(_) | Role::Gyro(_)) => role.name(column),
        _ if format.columns[column].is_dropped => format!("column_{}", column + 1),
        Role::Time => "t".to_owned(),
        Role::Temperature => "temperature".to_owned(),
        Role::Label => "label".to_owned(),
        _ => format!("column_{}", column + 1),
    }
}

/// Writes a table piece by piece.
pub struct Writer<W> {
    out: W,
    table: Table,
    bytes: Vec<u8>,
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
        Writer { out, table, bytes }
    }

    /// Writes rows: their text, and columns of values of the same length. A blank line
    /// stands before the rows of `breaks`, which rise.
    ///
    /// # Errors
    ///
    /// Errors of writing.
    pub fn write_rows(
        &mut self,
        rows: impl IntoIterator<Item = usize>,
        text: &CopiedText,
        values: &[&[f64]],
        breaks: &[usize],
    ) -> io::Result<()> {
        let mut breaks = breaks.iter().copied().peekable();
        for row in rows {
            while breaks.next_if(|b| *b <= row).is_some() {
                self.bytes.push(b'\n');
            }
            self.write_row(text, values, row);
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
    fn write_row(&mut self, text: &CopiedText, values: &[&[f64]], row: usize) {
        let out = &mut self.bytes;
        for cell in &self.table.cells {
            match *cell {
                Cell::Copied(piece) => out.extend_from_slice(text.piece(row, piece)),
                Cell::Quoted(piece) => {
                    write_quoted(out, unquoted(text.piece(row, piece)), self.table.delimiter);
                }
                Cell::Fixed(column, decimals) => {
                    let from = out.len();
                    write_fixed(out, values[column][row], decimals);
                    if self.table.decimal_comma
                        && let Some(point) = out[from..].iter_mut().find(|b| **b == b'.')
                    {
                        *point = b',';
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
    let text = String::from_utf8_lossy(text).replace("\"\"", "\"");
    let text = text.replace('"', "\"\"");
    out.extend_from_slice(format!("\"{text}\"").as_bytes());
}
