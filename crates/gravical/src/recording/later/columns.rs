//! Columns of a header further down, as in two concatenated recordings: which of them are those of
//! the first header, and in which units.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::recording::ReadOptions;
use crate::recording::board;
use crate::recording::dialect::{Dialect, Header};
use crate::recording::format::Format;
use crate::recording::layout::{Layout, Named, understand_all, with_claims};
use crate::recording::metadata::range_g;
use crate::recording::names::{Quantity, Role};
use crate::recording::row::{
    ACCEL, Delimiter, GYRO, RowDefect, RowScanner, SLOTS, Span, TEMPERATURE, TIME, Values,
};
use crate::recording::units::{AccelUnit, GyroUnit};

/// The columns of a later header, as those of the first.
#[derive(Debug)]
pub(in crate::recording) struct Columns {
    /// For each field of a row under the first header.
    sources: Vec<Source>,
    /// Reads a row under the later header into the slots of the first.
    scanner: RowScanner,
    /// Factors from the units of the later header to those of the first, by slot.
    factors: [f64; SLOTS],
    /// Names of columns that the first header does not have.
    pub surplus: Vec<String>,
    /// Description of the differences.
    pub changes: String,
}

/// Where a row under the later header has the text of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    /// In this field.
    Field(usize),
    /// In another unit: the value of this slot.
    Slot(usize),
    Nowhere,
}

impl Columns {
    /// Rows under both headers are read equally.
    pub fn is_identity(&self) -> bool {
        let same = (0..self.scanner.fields()).map(Source::Field);
        self.sources.iter().copied().eq(same)
    }

    /// As [`RowScanner::scan`], with values in the units of the first header.
    ///
    /// # Errors
    ///
    /// As [`RowScanner::scan`].
    pub fn scan(
        &self,
        line: &[u8],
        values: &mut Values,
        label: &mut Span,
    ) -> Result<(), RowDefect> {
        self.scanner.scan(line, values, label)?;
        self.convert(values);
        Ok(())
    }

    /// The same, and writes the row as under the first header to `row`, which is empty; the ranges
    /// of its fields go to `spans`.
    ///
    /// # Errors
    ///
    /// As [`RowScanner::scan`]; `row` stays empty.
    pub fn rewrite(
        &self,
        line: &[u8],
        dialect: &Dialect,
        values: &mut Values,
        row: &mut Vec<u8>,
        spans: &mut Vec<Span>,
    ) -> Result<(), RowDefect> {
        let mut fields = Vec::new();
        self.scanner.scan_spans(line, values, &mut fields)?;
        self.convert(values);
        let (between, empty): (u8, &[u8]) = match dialect.delimiter {
            Delimiter::Byte(byte) => (byte, b""),
            Delimiter::Whitespace => (b'\t', b"-"),
        };
        spans.clear();
        for source in &self.sources {
            if !spans.is_empty() {
                row.push(between);
            }
            let from = row.len() as u32;
            match *source {
                Source::Slot(slot) if values[slot].is_finite() => {
                    let text = values[slot].to_string();
                    match dialect.decimal_comma {
                        true => row.extend(text.replace('.', ",").bytes()),
                        false => row.extend(text.bytes()),
                    }
                }
                Source::Field(field) if fields[field].0 < fields[field].1 => {
                    let (from, to) = fields[field];
                    row.extend(&line[from as usize..to as usize]);
                }
                _ => row.extend(empty),
            }
            spans.push((from, row.len() as u32));
        }
        Ok(())
    }

    fn convert(&self, values: &mut Values) {
        for (value, factor) in values.iter_mut().zip(self.factors) {
            *value *= factor;
        }
    }
}

/// Size of a unit, as far as the header gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Size {
    /// Not given.
    Unnamed,
    /// Counts of a converter with unknown range.
    Counts,
    /// Size relative to a common unit.
    Of(f64),
}

impl Size {
    fn accel(layout: &Layout, given: &ReadOptions) -> Self {
        let claim = layout.accel_claim;
        match claim.unit.or(given.accel_unit) {
            Some(AccelUnit::MetrePerSecondSquared) => Size::Of(1.0 / STANDARD_GRAVITY_MPS2),
            Some(AccelUnit::StandardGravity) => Size::Of(1.0),
            Some(AccelUnit::MilliGravity) => Size::Of(1e-3),
            Some(AccelUnit::Counts) => claim.lsb_per_g.map_or(Size::Counts, |n| Size::Of(1.0 / n)),
            Some(AccelUnit::Unknown) | None => Size::Unnamed,
        }
    }

    fn gyro(layout: &Layout, given: &ReadOptions) -> Self {
        match layout.gyro_claim.or(given.gyro_unit) {
            Some(GyroUnit::RadianPerSecond) => Size::Of(1f64.to_degrees()),
            Some(GyroUnit::DegreePerSecond) => Size::Of(1.0),
            Some(GyroUnit::Counts) => layout
                .gyro_lsb_per_deg_s
                .map_or(Size::Counts, |n| Size::Of(1.0 / n)),
            Some(GyroUnit::Unknown) | None => Size::Unnamed,
        }
    }

    fn time(layout: &Layout, given: &ReadOptions) -> Self {
        let unit = layout.time_claim.or(given.time_unit);
        unit.map_or(Size::Unnamed, |u| Size::Of(u.seconds()))
    }

    /// Factor from this unit to that of `first`; `None` if unknown.
    fn over(self, first: Size) -> Option<f64> {
        match (self, first) {
            (a, b) if a == b => Some(1.0),
            (Size::Of(own), Size::Of(first)) => Some(own / first),
            _ => None,
        }
    }
}

/// True for a header of the sensor that is read, with any other columns; `file`: name of the file.
pub(super) fn names_sensor(header: &Header, first: &Format, file: &str) -> bool {
    let columns = understand_all(header, file, first.role);
    let axis: fn(usize) -> Quantity = match first.role {
        Role::Recording => Quantity::Accel,
        Role::Gyroscope => Quantity::Gyro,
    };
    let named = (0..3).all(|i| columns.iter().any(|(_, c)| c.quantity == axis(i)));
    let known = first.dialect.header.as_ref().is_some_and(|known| {
        let shared = |n: &&String| !n.is_empty() && known.names.contains(*n);
        2 * header.names.iter().filter(shared).count() > header.names.len()
    });
    named || known
}

/// The columns of the header `later` as those of `first`; `metadata`: the lines between the last
/// row and `later`; `file`: name of the file.
///
/// # Errors
///
/// The reason why they cannot be converted, as a sentence whose subject is the later header.
pub(super) fn corresponding(
    first: &Format,
    mut later: Header,
    metadata: Vec<String>,
    file: &str,
) -> Result<Columns, String> {
    let layout = &first.layout;
    if let Some(board) = board::last(&metadata)
        && board.is_calibrated() != layout.calibrated_by_board
    {
        let [now, before] = match board.is_calibrated() {
            true => ["calibrated", "raw"],
            false => ["raw", "calibrated"],
        };
        return Err(format!(
            "follows a line of the board that announces {now} values, and those before are {before}"
        ));
    }
    let known = first.dialect.header.as_ref();
    let known_names = known.map_or(&[][..], |h| &h.names);
    if let Some(known) = known
        && later.units.is_empty()
        && later.names == known.names
    {
        later.units.clone_from(&known.units);
    }
    let before = known.map_or_else(Vec::new, |h| understand_all(h, file, first.role));
    let after = understand_all(&later, file, first.role);
    let by_name = |field: usize| same_name(known_names, field, &later.names);
    let of_first: Vec<Option<usize>> = (0..first.dialect.fields)
        .map(|field| by_name(field).or_else(|| same_meaning(layout, &before, field, &after)))
        .collect();
    let moved = |field: usize| {
        let to = of_first.get(field).copied().flatten();
        to.ok_or_else(|| {
            let name = name_of(known, field);
            format!("names no column for {name}, which is read under the first header")
        })
    };
    let fields = layout
        .fields
        .iter()
        .map(|(of, field)| Ok((*of, moved(*field)?)));
    let fields: Vec<(Quantity, usize)> = fields.collect::<Result<_, String>>()?;
    let pair = |of: Option<(usize, f64)>| {
        of.map(|(field, x)| moved(field).map(|to| (to, x)))
            .transpose()
    };
    let own = Layout {
        fields: fields.clone(),
        fraction: pair(layout.fraction)?,
        instance: pair(layout.instance)?,
        ..layout.clone()
    };
    // In a column of the same name time is in the same unit.
    let time_is_same = layout.field(Quantity::Time).and_then(by_name).is_some();
    let surplus = later.names.iter().enumerate();
    let surplus = surplus.filter(|(at, name)| !name.is_empty() && !of_first.contains(&Some(*at)));
    let surplus = surplus.map(|(_, name)| name.clone()).collect();
    let mut dialect = Dialect {
        fields: later.names.len(),
        header: Some(later),
        ..first.dialect.clone()
    };
    let scanner = own.scanner(&dialect);
    if board::of_counts(&metadata).is_some() || range_g(&metadata).is_some() {
        dialect.metadata = metadata;
    }
    let mut claims = with_claims(fields, &dialect, &after);
    claims.apply_board_settings(&dialect.metadata);
    let sizes = |of: fn(&Layout, &ReadOptions) -> Size| {
        (of(&claims, &first.options), of(layout, &first.options))
    };
    let mut changes = Vec::new();
    let mut in_order = of_first.iter().enumerate();
    if in_order.any(|(i, from)| from.is_some_and(|from| from != i)) {
        changes.push("other columns or another order".to_owned());
    }
    let mut factors = [1.0; SLOTS];
    for (what, slots, (own, was)) in [
        ("accelerometer", ACCEL..GYRO, sizes(Size::accel)),
        ("gyroscope", GYRO..TEMPERATURE, sizes(Size::gyro)),
        ("time", TIME..ACCEL, sizes(Size::time)),
    ] {
        let is_read = layout
            .fields
            .iter()
            .any(|(of, _)| of.slot().is_some_and(|slot| slots.contains(&slot)));
        if !is_read || (what == "time" && time_is_same) {
            continue;
        }
        let Some(factor) = own.over(was) else {
            return Err(format!(
                "and the first one do not both give the unit of the {what}, or the range of its counts"
            ));
        };
        if factor != 1.0 {
            changes.push(format!("the {what} in another unit, times {factor}"));
        }
        factors[slots].fill(factor);
    }
    let source = |(field, from): (usize, &Option<usize>)| {
        let read = layout.fields.iter().find(|(_, f)| *f == field);
        let slot = read.and_then(|(of, _)| of.slot());
        match (from, slot.filter(|slot| factors[*slot] != 1.0)) {
            (None, _) => Source::Nowhere,
            (_, Some(slot)) => Source::Slot(slot),
            (Some(field), None) => Source::Field(*field),
        }
    };
    Ok(Columns {
        sources: of_first.iter().enumerate().map(source).collect(),
        scanner,
        factors,
        surplus,
        changes: changes.join(", "),
    })
}

fn name_of(header: Option<&Header>, field: usize) -> String {
    let name = header.and_then(|h| h.names.get(field));
    name.filter(|n| !n.is_empty()).map_or_else(
        || format!("column {}", field + 1),
        |name| format!("\"{name}\""),
    )
}

/// The column of the same name; of several, the one at the same position among them.
fn same_name(known: &[String], field: usize, later: &[String]) -> Option<usize> {
    let name = known.get(field).filter(|n| !n.is_empty())?;
    let place = known.iter().take(field).filter(|n| *n == name).count();
    let mut alike = later.iter().enumerate().filter(|(_, n)| *n == name);
    alike.nth(place).map(|(at, _)| at)
}

/// The column of the same quantity and sensor; of any sensor if there is only one.
fn same_meaning(layout: &Layout, before: &[Named], field: usize, after: &[Named]) -> Option<usize> {
    let named = before.iter().find(|(f, _)| *f == field).map(|(_, c)| c);
    let read = layout.fields.iter().find(|(_, f)| *f == field);
    let quantity = match read.map(|(q, _)| *q) {
        Some(Quantity::Time) if layout.sums_time => Quantity::TimeStep,
        Some(quantity) => quantity,
        None => named?.quantity,
    };
    let alike: Vec<&Named> = after.iter().filter(|c| c.1.quantity == quantity).collect();
    let sensor = |c: &Named| (c.1.sensor.clone(), c.1.without_gravity);
    let own = named.map(|c| (c.sensor.clone(), c.without_gravity));
    let same = alike.iter().find(|c| own == Some(sensor(c)));
    match (same, &alike[..]) {
        (Some(found), _) | (None, [found]) => Some(found.0),
        _ => None,
    }
}
