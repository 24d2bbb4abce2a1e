//! Columns of the output: their names and sources.

use crate::recording::dialect::Dialect;
use crate::recording::layout::Layout;
use crate::recording::names::Quantity;
use crate::recording::row::{Delimiter, Span};
use crate::recording::{Finding, FindingKind};
use crate::scan::write_fixed;

/// Decimals of a calibrated value.
const DECIMALS: u32 = 6;

/// Part of an output row.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Piece {
    /// Fields of the line, from the first to the last, unchanged.
    Kept(usize, usize),
    /// A calibrated value.
    Value(usize),
}

/// The layout of the output.
pub(crate) struct Plan {
    /// Names of the columns.
    pub names: Vec<String>,
    /// Columns that had to be renamed.
    pub findings: Vec<Finding>,
    pieces: Vec<Piece>,
    delimiter: u8,
    decimal_comma: bool,
    /// Fields are separated by one byte, so that neighbours can be copied together.
    copies_neighbours: bool,
}

impl Plan {
    /// Channels with a name here are written as values under that name; all other columns are
    /// copied.
    pub fn with_names(
        dialect: &Dialect,
        layout: &Layout,
        names: &[Option<String>; 6],
        keep_raw: bool,
    ) -> Self {
        // Names of the values, and of the other columns of the input.
        let mut taken: Vec<String> = names.iter().flatten().cloned().collect();
        taken.extend((0..dialect.fields).map(|field| input_name(dialect, layout, field)));
        let mut plan = Plan {
            names: Vec::new(),
            findings: Vec::new(),
            pieces: Vec::new(),
            // White space becomes one tab, which no field contains.
            delimiter: match dialect.delimiter {
                Delimiter::Byte(b) => b,
                Delimiter::Whitespace => b'\t',
            },
            decimal_comma: dialect.decimal_comma,
            copies_neighbours: matches!(dialect.delimiter, Delimiter::Byte(_)),
        };
        for field in 0..dialect.fields {
            let value = names
                .iter()
                .enumerate()
                .find(|(i, name)| name.is_some() && channel_field(layout, *i) == Some(field));
            match value {
                Some((i, Some(name))) if !keep_raw => plan.value(i, name),
                _ => {
                    let name = input_name(dialect, layout, field);
                    let name = plan.unused_name(name, names, &taken);
                    plan.keep(field, name);
                }
            }
        }
        for (i, name) in names.iter().enumerate() {
            // A channel of another file has no column here.
            if let Some(name) = name
                && (keep_raw || channel_field(layout, i).is_none())
            {
                plan.value(i, name);
            }
        }
        plan
    }

    fn value(&mut self, i: usize, name: &str) {
        self.names.push(name.to_owned());
        self.pieces.push(Piece::Value(i));
    }

    /// Renames a copied column that has the name of a calibrated one, to a name that no other
    /// column has.
    fn unused_name(
        &mut self,
        name: String,
        values: &[Option<String>; 6],
        taken: &[String],
    ) -> String {
        if !values.iter().flatten().any(|value| *value == name) {
            return name;
        }
        let mut free = format!("input_{name}");
        while taken.contains(&free) || self.names.contains(&free) {
            free.insert_str(0, "input_");
        }
        self.findings.push(Finding::new(
            FindingKind::RenamedColumn,
            format!("the input has a column {name}; it is written as {free}"),
        ));
        free
    }

    fn keep(&mut self, field: usize, name: String) {
        self.names.push(name);
        match self.pieces.last_mut() {
            Some(Piece::Kept(_, last)) if self.copies_neighbours => *last = field,
            _ => self.pieces.push(Piece::Kept(field, field)),
        }
    }

    /// The header line; names are quoted if necessary.
    pub fn header(&self) -> Vec<u8> {
        let mut writer = csv::WriterBuilder::new()
            .delimiter(self.delimiter)
            .from_writer(Vec::new());
        // Writing to memory does not fail.
        let _ = writer.write_record(&self.names);
        writer.into_inner().unwrap_or_default()
    }

    /// Appends the row of `line`, whose fields are at `spans`.
    #[inline]
    pub fn write_row(&self, line: &[u8], spans: &[Span], values: &[f64; 6], out: &mut Vec<u8>) {
        for piece in &self.pieces {
            match *piece {
                Piece::Kept(first, last) => {
                    // The span excludes spaces after the delimiter.
                    let from = match first.checked_sub(1) {
                        Some(before) if self.copies_neighbours => spans[before].1 + 1,
                        Some(_) => spans[first].0,
                        None if self.copies_neighbours => 0,
                        None => spans[0].0,
                    };
                    out.extend_from_slice(&line[from as usize..spans[last].1 as usize]);
                }
                Piece::Value(i) => {
                    write_fixed(out, values[i], DECIMALS);
                    if self.decimal_comma {
                        set_decimal_comma(out);
                    }
                }
            }
            out.push(self.delimiter);
        }
        // The last delimiter ends the line.
        if let Some(end) = out.last_mut() {
            *end = b'\n';
        }
    }
}

/// Replaces the point of the last number by a comma.
fn set_decimal_comma(out: &mut [u8]) {
    let at = out.len().wrapping_sub(DECIMALS as usize + 1);
    if let Some(point) = out.get_mut(at)
        && *point == b'.'
    {
        *point = b',';
    }
}

/// Field of channel `i`: 0 to 2 the accelerometer's axes, 3 to 5 the gyroscope's.
pub(crate) fn channel_field(layout: &Layout, i: usize) -> Option<usize> {
    match i {
        0..3 => layout.field(Quantity::Accel(i)),
        _ => layout.field(Quantity::Gyro(i - 3)),
    }
}

/// Name of a copied column, from the header or by its channel.
pub(crate) fn input_name(dialect: &Dialect, layout: &Layout, field: usize) -> String {
    if let Some(header) = &dialect.header {
        return header.names.get(field).cloned().unwrap_or_default();
    }
    let axis = |prefix: &str, i: usize| format!("{prefix}{}", ["x", "y", "z"][i]);
    match layout.fields.iter().find(|(_, f)| *f == field) {
        Some((Quantity::Time, _)) => "t".to_owned(),
        Some((Quantity::Temperature, _)) => "temperature".to_owned(),
        Some((Quantity::Label, _)) => "label".to_owned(),
        Some((Quantity::Accel(i), _)) => axis("a", *i),
        Some((Quantity::Gyro(i), _)) => axis("g", *i),
        _ => format!("column_{}", field + 1),
    }
}
