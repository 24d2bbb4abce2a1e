//! Assignment of columns to channels: by `--columns`, by the names in the header, or, without a
//! header, by the numbers.

mod clock;
mod content;
mod header;
mod several;
mod spec;
mod stream;
#[cfg(test)]
mod tests;

use crate::{Error, Result};

use super::TimeUnit;
use super::board::BoardSettings;
use super::dialect::Dialect;
use super::metadata::is_day_first;
use super::names::{ColumnName, Quantity, bare_axis, understand};
use super::row::{RowScanner, RowStamps};
use super::units::{AccelUnit, GyroUnit};
use crate::stats::median;
use gravical_recording::judge::AccelClaim;

use clock::Clock;
use content::by_content;
pub(super) use header::understand_all;
pub use spec::{Column, ColumnsSpec};
use spec::{Given, list_columns};
pub use stream::stream_layout;

/// Field and meaning of a column.
pub(super) type Named = (usize, ColumnName);

/// The columns that are read, and what their names claim.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    /// Quantity and field (from 0) of each channel that is read.
    pub fields: Vec<(Quantity, usize)>,
    /// Unit and sensitivity of the accelerometer according to header and board.
    pub accel_claim: AccelClaim,
    /// Unit of the gyroscope according to header or board.
    pub gyro_claim: Option<GyroUnit>,
    /// Counts per °/s according to header or board.
    pub gyro_lsb_per_deg_s: Option<f64>,
    /// Temperatures are counts of the sensor of this board.
    pub temperature_counts: Option<BoardSettings>,
    /// The board's settings line says that values are calibrated.
    pub calibrated_by_board: bool,
    /// The header gives a unit for the temperature.
    pub temperature_claimed: bool,
    /// Some columns were assigned by their numbers alone.
    pub guessed: bool,
    /// Unit of the time according to the header.
    pub time_claim: Option<TimeUnit>,
    /// The time column holds differences from row to row, which are summed.
    pub sums_time: bool,
    /// Field with the fraction of a second of the time stamp, and its unit in s.
    pub fraction: Option<(usize, f64)>,
    /// Only rows with this value in this field are read, if several sensors share the file.
    pub instance: Option<(usize, f64)>,
}

/// What is known about a file besides its contents.
#[derive(Debug, Clone, Copy, Default)]
pub struct Request<'a> {
    /// The columns given by the user.
    pub columns: Option<&'a ColumnsSpec>,
    /// The sensor chosen by the user.
    pub sensor: Option<&'a str>,
    /// Name of the file.
    pub file: &'a str,
}

/// Names of the columns of calibrated specific force that this program writes, in m/s² and in g.
/// Loggers use `ax_g` for what they measure.
pub(crate) const CALIBRATED: [[&str; 3]; 2] = [
    ["ax_mps2", "ay_mps2", "az_mps2"],
    ["ax_calibrated_g", "ay_calibrated_g", "az_calibrated_g"],
];

/// The names of calibrated columns, if there are all three.
fn calibrated_names(names: &[String]) -> Option<[&'static str; 3]> {
    let has = |own: &&[&str; 3]| own.iter().all(|own| names.iter().any(|n| n == own));
    CALIBRATED.iter().find(has).copied()
}

/// True if there are columns with the names of calibrated ones.
pub(crate) fn has_calibrated(names: &[String]) -> bool {
    calibrated_names(names).is_some()
}

impl Layout {
    /// Field of a channel, from 0.
    #[must_use]
    pub fn field(&self, quantity: Quantity) -> Option<usize> {
        self.fields
            .iter()
            .find(|(q, _)| *q == quantity)
            .map(|(_, f)| *f)
    }

    /// True if the file has all three axes of the gyroscope.
    #[must_use]
    pub fn has_gyro(&self) -> bool {
        (0..3).all(|i| self.field(Quantity::Gyro(i)).is_some())
    }

    /// A scanner for these columns.
    #[must_use]
    pub fn scanner(&self, dialect: &Dialect) -> RowScanner {
        let mut scanner = RowScanner::new(dialect.delimiter, dialect.decimal_comma, dialect.fields);
        for &(quantity, field) in &self.fields {
            if quantity == Quantity::Label {
                scanner.assign_label(field);
            } else if let Some(slot) = quantity.slot() {
                scanner.assign(field, slot);
            }
        }
        scanner.set_day_first(is_day_first(&dialect.metadata));
        if let Some((field, unit_s)) = self.fraction {
            scanner.assign_fraction(field, unit_s);
        }
        if let Some((field, value)) = self.instance {
            scanner.assign_instance(field, value);
        }
        if let Some(board) = self.temperature_counts {
            scanner.convert_temperature(board);
        }
        scanner
    }

    /// Converts the time column to time stamps, row by row.
    #[must_use]
    pub fn stamps(&self) -> RowStamps {
        RowStamps::new(self.sums_time)
    }
}

/// Assigns the columns of a file: as given by `--columns`, otherwise by the names in the header,
/// otherwise, without a header, by the numbers.
///
/// # Errors
///
/// `no-accelerometer` or `columns-unknown` (input) if they cannot be found, with
/// the names in the file; `columns-missing`, `sensor-unknown` (usage) if an option names
/// something that is not in the file.
pub(super) fn find(dialect: &Dialect, request: Request<'_>) -> Result<Layout> {
    let names: &[String] = dialect.header.as_ref().map_or(&[], |h| &h.names);
    let given = Given::of(dialect, request.columns)?;
    let complete = given.has_all(Quantity::Accel);
    let mut columns = match &dialect.header {
        Some(header) => understand_all(header, request.file),
        None if complete => by_content(dialect).unwrap_or_default(),
        None => by_content(dialect)?,
    };
    columns.retain(|(field, c)| !given.uses(*field) && !given.includes(c.quantity));
    // If several sensors share the rows, the rows of one.
    let instance = several::instance(&dialect.sample, &columns, request.sensor)?;
    let of_sensor = |row: &&Vec<f64>| {
        instance.is_none_or(|(field, value)| row.get(field).is_none_or(|v| *v == value))
    };
    let sample: Vec<&Vec<f64>> = dialect.sample.iter().filter(of_sensor).collect();

    // The three fields of a sensor: given, with a common name, or the remaining ones of that
    // sensor.
    let axes = |of: fn(usize) -> Quantity, chosen: Option<[usize; 3]>| -> Option<[usize; 3]> {
        let any_given = (0..3).any(|i| given.field(of(i)).is_some());
        let left = |i: usize| {
            let first = columns.iter().find(|(_, c)| c.quantity == of(i));
            first.filter(|_| any_given).map(|(field, _)| *field)
        };
        let axis = |i: usize| {
            given
                .field(of(i))
                .or_else(|| chosen.map(|t| t[i]))
                .or_else(|| left(i))
        };
        Some([axis(0)?, axis(1)?, axis(2)?])
    };
    let mut fields = Vec::new();
    let found = several::triples(&columns, Quantity::Accel);
    let wanted = request.sensor.filter(|_| instance.is_none() && !complete);
    let chosen = several::choose(&columns, &found, wanted)?;
    let accel =
        axes(Quantity::Accel, chosen).ok_or_else(|| no_accelerometer(&columns, names, dialect))?;
    let name = names.get(accel[0]).and_then(|n| understand(n));
    let sensor = name.map_or_else(String::new, |c| c.sensor);
    fields.extend((0..3).map(|i| (Quantity::Accel(i), accel[i])));
    let gyros = several::triples(&columns, Quantity::Gyro);
    let shared = |t: &[usize; 3]| {
        let words = several::words_of(&columns, *t);
        let same = words.join(" ") == sensor;
        let shared = sensor.split(' ').filter(|w| words.iter().any(|o| o == w));
        (same, shared.count())
    };
    // Among equals the first: `max_by_key` returns the last.
    let chosen = gyros.iter().rev().max_by_key(|t| shared(t)).copied();
    if let Some(gyro) = axes(Quantity::Gyro, chosen) {
        fields.extend((0..3).map(|i| (Quantity::Gyro(i), gyro[i])));
    }
    for quantity in [Quantity::Temperature, Quantity::Label] {
        let is = |(_, c): &&Named| c.quantity == quantity;
        let of_sensor = columns.iter().filter(is).find(|(_, c)| c.sensor == sensor);
        let any = of_sensor.or_else(|| columns.iter().find(is));
        let field = given.field(quantity).or(any.map(|(field, _)| *field));
        fields.extend(field.map(|field| (quantity, field)));
    }
    let stamps = given.field(Quantity::Time).map(|field| Clock {
        field,
        is_steps: false,
        fraction: None,
    });
    let steps = given.field(Quantity::TimeStep).map(|field| Clock {
        field,
        is_steps: true,
        fraction: None,
    });
    let clock = stamps.or(steps).or_else(|| {
        let none = given.includes(Quantity::Time) || given.includes(Quantity::TimeStep);
        (!none).then(|| clock::choose(&sample, &columns, names, &sensor))?
    });
    fields.extend(clock.map(|clock| (Quantity::Time, clock.field)));
    fields.sort_by_key(|(_, field)| *field);
    let mut layout = with_claims(fields, dialect, &columns);
    layout.sums_time = clock.is_some_and(|clock| clock.is_steps);
    layout.fraction = clock.and_then(|clock| clock.fraction);
    if layout.fraction.is_some() {
        layout.time_claim = Some(TimeUnit::Second);
    }
    layout.instance = instance;
    let by_numbers = |(q, f): &(Quantity, usize)| given.field(*q) != Some(*f);
    layout.guessed = dialect.header.is_none() && layout.fields.iter().any(by_numbers);
    Ok(layout)
}

fn no_accelerometer(columns: &[Named], names: &[String], dialect: &Dialect) -> Error {
    let found = |of: fn(usize) -> Quantity| !several::triples(columns, of).is_empty();
    if found(Quantity::Gyro) {
        return Error::input(
            "no-accelerometer",
            "this file holds a gyroscope and no accelerometer",
        )
        .with_hint("give the accelerometer's recording as the input, and this file with --gyro");
    }
    let line = dialect.header.as_ref().map_or(0, |h| h.lines[0]);
    Error::input(
        "no-accelerometer",
        format!("no three columns of the header in line {line} are named as an accelerometer's x, y and z"),
    )
    .with_hint(list_columns(names))
}

/// Adds what the names, and the row of units below them, claim about the chosen columns.
pub(super) fn with_claims(
    fields: Vec<(Quantity, usize)>,
    dialect: &Dialect,
    columns: &[Named],
) -> Layout {
    let texts = |of: Quantity| -> Vec<String> {
        let Some((_, field)) = fields.iter().find(|(q, _)| *q == of) else {
            return Vec::new();
        };
        let Some(header) = &dialect.header else {
            return Vec::new();
        };
        let name = header.names.get(*field).map_or("", String::as_str);
        let read = columns
            .iter()
            .find(|(at, c)| at == field && c.quantity == of);
        let own = match read {
            Some((_, column)) => column.unit.clone(),
            None => understand(name).and_then(|c| c.unit),
        };
        let bare = || bare_axis(name).and_then(|(_, unit)| unit);
        let below = header.unit(*field).map(str::to_owned);
        own.or_else(bare).into_iter().chain(below).collect()
    };
    let accel = texts(Quantity::Accel(0));
    let gyro = texts(Quantity::Gyro(0));
    let time = texts(Quantity::Time);
    let without_gravity = fields
        .iter()
        .filter(|(q, _)| matches!(q, Quantity::Accel(_)))
        .any(|(_, field)| columns.iter().any(|(f, c)| f == field && c.without_gravity));
    Layout {
        accel_claim: AccelClaim {
            unit: accel.iter().find_map(|u| AccelUnit::parse(u)),
            lsb_per_g: accel.iter().find_map(|u| AccelUnit::per_g(u)),
            without_gravity,
        },
        gyro_lsb_per_deg_s: gyro.iter().find_map(|u| GyroUnit::per_deg_s(u)),
        temperature_claimed: !texts(Quantity::Temperature).is_empty(),
        gyro_claim: gyro.iter().find_map(|u| GyroUnit::parse(u)),
        time_claim: time
            .iter()
            .find_map(|u| TimeUnit::parse(u).or_else(|| fine_ticks(u, &fields, dialect))),
        fields,
        ..Layout::default()
    }
}

/// Xsens' `SampleTimeFine` counts 100 µs in files of MT Manager and 1 µs in those of the DOT,
/// whose shortest step is 8333 µs.
fn fine_ticks(unit: &str, fields: &[(Quantity, usize)], dialect: &Dialect) -> Option<TimeUnit> {
    let (_, field) = fields.iter().find(|(q, _)| *q == Quantity::Time)?;
    let stamps = dialect.sample.iter().filter_map(|row| row.get(*field));
    let stamps: Vec<f64> = stamps.copied().filter(|v| v.is_finite()).collect();
    let mut steps: Vec<f64> = stamps.windows(2).map(|w| w[1] - w[0]).collect();
    steps.retain(|step| *step > 0.0);
    let fine = unit == "fine";
    median(&mut steps)
        .filter(|_| fine)
        .map(|step| match step < 8000.0 {
            true => TimeUnit::HundredMicroseconds,
            false => TimeUnit::Microsecond,
        })
}
