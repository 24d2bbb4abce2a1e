//! Which columns are written, under which names, from which bytes of a line.

use std::array::from_fn;

use crate::recording::dialect::Dialect;
use crate::recording::layout::Layout;
use crate::recording::names::Quantity;
use crate::recording::row::{Delimiter, Span};
use crate::recording::{Finding, FindingKind};
use crate::scan::write_fixed;

/// Names of the calibrated channels.
const CALIBRATED: [&str; 6] = [
    "ax_mps2", "ay_mps2", "az_mps2", "gx_rad_s", "gy_rad_s", "gz_rad_s",
];

/// Decimals of a calibrated value: a millionth of its unit.
const DECIMALS: u32 = 6;

/// A part of an output row.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Piece {
    /// Fields of the line as they stand, from the first to the last.
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
    /// Fields are parted by one byte, so that neighbours can be copied at once.
    adjoining: bool,
}

impl Plan {
    pub fn new(dialect: &Dialect, layout: &Layout, with_gyro: bool, keep_raw: bool) -> Self {
        let calibrated = if with_gyro { 6 } else { 3 };
        let names = from_fn(|i| (i < calibrated).then(|| CALIBRATED[i].to_owned()));
        Self::with_names(dialect, layout, &names, keep_raw)
    }

    /// Channels that have a name here are written as values under it, the others
    /// kept.
    pub fn with_names(
        dialect: &Dialect,
        layout: &Layout,
        names: &[Option<String>; 6],
        keep_raw: bool,
    ) -> Self {
        let taken: Vec<&str> = names.iter().flatten().map(String::as_str).collect();
        let mut plan = Plan {
            names: Vec::new(),
            findings: Vec::new(),
            pieces: Vec::new(),
            // White space of any width becomes one tab: no field contains it,
            // not even with decimal commas.
            delimiter: match dialect.delimiter {
                Delimiter::Byte(b) => b,
                Delimiter::Whitespace => b'\t',
            },
            decimal_comma: dialect.decimal_comma,
            adjoining: matches!(dialect.delimiter, Delimiter::Byte(_)),
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
                    let name = plan.free_name(name, &taken);
                    plan.keep(field, name);
                }
            }
        }
        if keep_raw {
            for (i, name) in names.iter().enumerate() {
                if let Some(name) = name {
                    plan.value(i, name);
                }
            }
        }
        plan
    }

    fn value(&mut self, i: usize, name: &str) {
        self.names.push(name.to_owned());
        self.pieces.push(Piece::Value(i));
    }

    /// A kept column that has the name of a calibrated one gets another.
    fn free_name(&mut self, name: String, taken: &[&str]) -> String {
        if !taken.contains(&name.as_str()) {
            return name;
        }
        let free = format!("input_{name}");
        self.findings.push(Finding::new(
            FindingKind::RenamedColumn,
            format!("the input has a column {name}; it is kept as {free}"),
        ));
        free
    }

    fn keep(&mut self, field: usize, name: String) {
        self.names.push(name);
        match self.pieces.last_mut() {
            Some(Piece::Kept(_, last)) if self.adjoining => *last = field,
            _ => self.pieces.push(Piece::Kept(field, field)),
        }
    }

    /// The line that names the columns; names are quoted where they have to be.
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
                    // Spaces after a delimiter stand before the span.
                    let from = match first.checked_sub(1) {
                        Some(before) if self.adjoining => spans[before].1 + 1,
                        Some(_) => spans[first].0,
                        None if self.adjoining => 0,
                        None => spans[0].0,
                    };
                    out.extend_from_slice(&line[from as usize..spans[last].1 as usize]);
                }
                Piece::Value(i) => {
                    write_fixed(out, values[i], DECIMALS);
                    if self.decimal_comma {
                        put_comma(out);
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

/// Turns the point of the number that was just written into a comma.
fn put_comma(out: &mut [u8]) {
    let at = out.len().wrapping_sub(DECIMALS as usize + 1);
    if let Some(point) = out.get_mut(at)
        && *point == b'.'
    {
        *point = b',';
    }
}

/// The field of channel `i`: 0 to 2 the accelerometer's axes, 3 to 5 the gyroscope's.
pub(crate) fn channel_field(layout: &Layout, i: usize) -> Option<usize> {
    match i {
        0..3 => layout.field(Quantity::Accel(i)),
        _ => layout.field(Quantity::Gyro(i - 3)),
    }
}

/// The name a kept column has in the header, or gets without one.
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
