//! Any recording as a plain table: SI units (or g and °/s), nothing calibrated.
//!
//! # Overview
//!
//! [`convert_file`] reads a recording and writes its rows as a table: `time_s`, the
//! accelerometer, the gyroscope, the temperature and the label, as far as there are any; other
//! columns, and rows that are no measurement, are not written. Breaks are blank lines. Counts are
//! converted by the sensitivity of the data sheet.
//!
//! # Example
//!
//! ```
//! use gravical::convert::{ConvertOptions, convert_file};
//! use gravical::recording::ReadOptions;
//!
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("desk.csv");
//! # std::fs::write(&path, "t_ms;ax;ay;az\n0;0,01;0,00;1,00\n10;0,02;0,00;1,01\n")?;
//! let mut out = Vec::new();
//! let summary = convert_file(&path, &ReadOptions::default(), &ConvertOptions::default(), &mut out)?;
//! assert_eq!(summary.rows, 2);
//! assert_eq!(
//!     String::from_utf8_lossy(&out),
//!     "time_s,ax_m_s2,ay_m_s2,az_m_s2\n\
//!      0.000000,0.0980665,0,9.80665\n\
//!      0.010000,0.196133,0,9.9047165\n"
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::io::Write;
use std::path::Path;

use gravical_core::unit::{DEGREES_PER_RADIAN, STANDARD_GRAVITY_MPS2};
use gravical_judge::utc::UtcTime;
use gravical_recording::CopiedText;
use gravical_recording::source::Named;
use gravical_recording::write::{Cell, Table, Writer};
use serde::{Deserialize, Serialize};

use crate::apply::{OutputUnit, SetAside, set_aside};
use crate::poses::gyro_unit::decide_unit;
use crate::problem::Problem;
use crate::recording::{
    AccelScale, Finding, GyroScale, ReadOptions, Recording, nominal_accel, read_samples,
};
use crate::{Error, Result};

/// Decimals of a time, s.
const TIME_DECIMALS: u32 = 6;
/// Decimals of a value, zeros at the end left out: far below what any sensor resolves, and in g
/// enough for every count of a 16-bit converter.
const SI_DECIMALS: u32 = 9;
const G_DECIMALS: u32 = 12;

/// Options of [`convert_file`].
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct ConvertOptions {
    /// m/s^2, or g with °/s
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "UNIT",
            default_value = "m/s^2",
            hide_possible_values = true
        )
    )]
    pub output_unit: OutputUnit,
    /// Seconds since 1970 [default: since the first row]
    #[cfg_attr(feature = "clap", arg(long))]
    pub absolute_time: bool,
}

/// Result of [`convert_file`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConvertSummary {
    /// Path of the recording as given, `-` for standard input.
    pub input: String,
    /// Its format in words.
    pub description: String,
    /// Serial number of the sensor, where the file names it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// When it starts, s since 1970, if its time stamps or the lines above the header say it.
    pub start_unix_s: Option<f64>,
    /// Its lines: `lines = rows + Σ set_aside`.
    pub lines: u64,
    /// Rows that were written.
    pub rows: u64,
    /// Lines that are not rows, by reason. Breaks are written as blank lines.
    pub set_aside: Vec<SetAside>,
    /// Unit of the accelerometer in the recording, and its source.
    pub accelerometer: AccelScale,
    /// The same for the gyroscope.
    pub gyroscope: Option<GyroScale>,
    /// Unit of the specific force written; with g angular rates are in °/s.
    pub output_unit: OutputUnit,
    /// Names of the columns written.
    pub columns: Vec<String>,
    /// Faults found.
    pub findings: Vec<Finding>,
}

/// Writes the recording of this file (`-` is standard input) as a table with a header to `out`.
///
/// # Errors
///
/// Those of [`read_samples`]; `unit-unknown` (input) for counts of unknown range; `no-date` (input)
/// if times since 1970 are asked for and nothing says when it starts; errors of writing.
pub fn convert_file<'a>(
    file: impl Into<Named<'a>>,
    read: &ReadOptions,
    options: &ConvertOptions,
    out: &mut dyn Write,
) -> Result<ConvertSummary> {
    let mut recording = read_samples(file, read)?;
    decide_unit(&mut recording);
    let start_unix_s = recording.recorded_at().and(recording.start_unix_s());
    let rows = recording.rows();
    let mut columns = columns(&mut recording, options)?;
    let labels = recording.labels.take().unwrap_or_default();
    let label = |row: &u32| labels.names[*row as usize].as_str();
    let text = CopiedText::of_rows(labels.of_row.iter().map(label));
    let (names, values): (Vec<_>, Vec<_>) = columns.drain(..).unzip();
    let cells = names.into_iter().enumerate();
    let cells = cells.map(|(column, name)| match name.as_str() {
        "time_s" => (name, Cell::Fixed(column, TIME_DECIMALS)),
        _ if options.is_in_g() => (name, Cell::Trimmed(column, G_DECIMALS)),
        _ => (name, Cell::Trimmed(column, SI_DECIMALS)),
    });
    let label = ("label".to_owned(), Cell::Quoted(0));
    let label = Some(label).filter(|_| !labels.names.is_empty());
    let table = Table::plain(cells.chain(label), []);
    let names = table.names.clone();
    let output = |e| Error::io(Path::new("output"), e);
    let mut writer = Writer::new(out, table);
    let values: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    writer
        .write_rows(0..rows, &text, &values, &recording.breaks)
        .map_err(output)?;
    writer.finish().map_err(output)?;
    Ok(ConvertSummary {
        start_unix_s,
        description: recording.format.describe(),
        serial: recording.format.serial(),
        lines: recording.ledger.lines as u64,
        rows: rows as u64,
        set_aside: set_aside(&recording.ledger),
        accelerometer: recording.units.accel,
        gyroscope: recording.units.gyro,
        output_unit: options.output_unit,
        columns: names,
        findings: recording.findings,
        input: recording.name,
    })
}

impl ConvertOptions {
    fn is_in_g(self) -> bool {
        self.output_unit == OutputUnit::StandardGravity
    }
}

/// Takes the channels of a recording as the columns of the table: their names and values.
fn columns(recording: &mut Recording, options: &ConvertOptions) -> Result<Vec<(String, Vec<f64>)>> {
    let in_g = options.is_in_g();
    let per_mps2 = nominal_accel(recording)?;
    let times_s = times_s(recording, options)?;
    let axes = |sensor: &str, unit: &str| ["x", "y", "z"].map(|a| format!("{sensor}{a}{unit}"));
    let accel_names = match (recording.format.is_calibrated(), in_g) {
        (true, _) => options.output_unit.columns().map(str::to_owned),
        (false, true) => axes("a", "_g"),
        (false, false) => axes("a", "_m_s2"),
    };
    let scaled = |mut channel: Vec<f64>, factor: f64| {
        channel.iter_mut().for_each(|v| *v *= factor);
        channel
    };
    let mut columns = Vec::new();
    columns.extend(times_s.map(|times_s| ("time_s".to_owned(), times_s)));
    // From g to g the factor is 1, without rounding.
    let accel_unit = if in_g { STANDARD_GRAVITY_MPS2 } else { 1.0 };
    let factor = 1.0 / (per_mps2 * accel_unit);
    let accel = std::mem::take(&mut recording.accel).map(|c| scaled(c, factor));
    columns.extend(accel_names.into_iter().zip(accel));
    if let Some(gyro) = recording.gyro.take() {
        // A unit that is not known stays.
        let (factor, unit) = match recording.units.gyro.and_then(|s| s.nominal()) {
            None => (1.0, ""),
            Some(nominal) if in_g => (DEGREES_PER_RADIAN / nominal, "_deg_s"),
            Some(nominal) => (1.0 / nominal, "_rad_s"),
        };
        let gyro = gyro.map(|channel| scaled(channel, factor));
        columns.extend(axes("g", unit).into_iter().zip(gyro));
    }
    let temperature_c = recording.temperature_c.take();
    columns.extend(temperature_c.map(|t| ("temperature_c".to_owned(), t)));
    Ok(columns)
}

/// Times of the rows, s; `None` without a clock or rate.
fn times_s(recording: &mut Recording, options: &ConvertOptions) -> Result<Option<Vec<f64>>> {
    let start_s = match recording.start_unix_s() {
        Some(start_s) if options.absolute_time => start_s,
        None if options.absolute_time => {
            let error = Problem::NoDate.error().at(recording.name.as_ref(), None);
            return Err(error.advise("absolute_time", ""));
        }
        _ => 0.0,
    };
    let Some(mut times_s) = recording.time_s.take() else {
        let rate_hz = recording.clock.rate_hz();
        let rows = 0..recording.rows();
        return Ok(rate_hz.map(|hz| rows.map(|row| start_s + row as f64 / hz).collect()));
    };
    let mut restarts = recording.clock.restarts.iter().peekable();
    let mut shift_s = start_s;
    for (time_s, line) in times_s.iter_mut().zip(&recording.lines) {
        // Where the clock of the recorder was set back, dates are those of its stamps from there on.
        while let Some((_, start_s)) = restarts.next_if(|restart| restart.0 <= *line) {
            let is_date = options.absolute_time && UtcTime::of_stamp(*start_s).is_some();
            shift_s = if is_date { *start_s } else { shift_s };
        }
        *time_s += shift_s;
    }
    Ok(Some(times_s))
}
