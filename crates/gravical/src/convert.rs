//! Any recording as a plain table: SI units (or g and °/s), nothing calibrated.
//!
//! # Overview
//!
//! [`convert_file`] judges the first 262,144 rows of a recording as [`read`](crate::recording::read)
//! does, reads the others alike, batch by batch, and writes each batch. The table is `time_s`, the
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
use gravical_recording::write::{Cell, Table};
use gravical_recording::{BatchReader, Format, Role, Rows, source};
use serde::{Deserialize, Serialize};

use crate::apply::{OutputUnit, SetAside, set_aside};
use crate::poses::gyro_unit::settle;
use crate::recording::{
    AccelScale, Finding, GyroScale, ReadOptions, Recording, TimeUnit, nominal_accel,
};
use crate::rewrite::write_rows;
use crate::utc::UtcTime;
use crate::{Error, Result};

/// A clock that was set differs from what it showed by more, s; jitter and mended stamps do not.
const CLOCK_SET_S: f64 = 1.0;
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

/// Writes the recording at `path` (`-` is standard input) as a table with a header to `out`.
///
/// Memory does not grow with the recording.
///
/// # Errors
///
/// Those of [`crate::recording::read`]; `unit-unknown` (input) for counts of unknown range;
/// `no-date` (input) if times since 1970 are asked for and nothing says when it starts; what later
/// rows contradict, as [`apply`](crate::apply::apply()); errors of writing.
pub fn convert_file(
    path: &Path,
    read: &ReadOptions,
    options: &ConvertOptions,
    out: &mut dyn Write,
) -> Result<ConvertSummary> {
    let name = path.display().to_string();
    let input = source::open(path, read)?;
    let label = |format: &Format| format.columns.iter().position(|c| c.role == Role::Label);
    let copied = |format: &Format| label(format).map(|c| (c, c)).into_iter().collect();
    let mut reader = BatchReader::open(input, &name, read, BatchReader::HEAD, copied)?;
    settle(&mut reader.recording);
    let recording = &reader.recording;
    let start_unix_s = recording.recorded_at().and(recording.start_unix_s());
    let (mut conversion, cells) = Conversion::new(recording, options)?;
    let label = label(&reader.format);
    let label_cell = label.map(|_| ("label".to_owned(), Cell::Quoted(0)));
    let table = Table::plain(cells.into_iter().chain(label_cell), label);
    let columns = table.names.clone();
    let (recording, written, found) =
        write_rows(reader, out, table, true, |rows| conversion.convert(rows))?;
    let findings = recording.findings.into_iter().chain(found);
    Ok(ConvertSummary {
        start_unix_s,
        description: recording.description,
        serial: recording.serial,
        lines: recording.ledger.lines as u64,
        rows: written as u64,
        set_aside: set_aside(&recording.ledger),
        accelerometer: recording.accel_scale,
        gyroscope: recording.gyro_scale,
        output_unit: options.output_unit,
        columns,
        findings: findings.map(|f| f.in_file(&name)).collect(),
        input: name,
    })
}

/// From the units of a recording to those of the table.
struct Conversion {
    /// Time of the first row, s.
    start_s: f64,
    /// Seconds of one unit of the stamps, if times since 1970 are wanted and the stamps are dates.
    dates_unit_s: Option<f64>,
    has_stamps: bool,
    /// Rate of rows without stamps, Hz.
    rate_hz: Option<f64>,
    /// Factors from the unit of the file.
    accel: f64,
    gyro: Option<f64>,
    has_temperature: bool,
    /// Rows that are measurements, so far.
    rows: usize,
}

impl Conversion {
    /// The conversion, and the columns of values of the table.
    fn new(recording: &Recording, options: &ConvertOptions) -> Result<(Self, Vec<(String, Cell)>)> {
        let in_g = options.output_unit == OutputUnit::StandardGravity;
        let per_mps2 = nominal_accel(recording)?;
        let start_s = match recording.start_unix_s() {
            Some(start_s) if options.absolute_time => start_s,
            None if options.absolute_time => {
                let what = "nothing in this recording says when it was made";
                return Err(Error::input("no-date", what)
                    .at(recording.name.as_ref(), None)
                    .with_hint("leave absolute time out: times are seconds since the first row")
                    .advise("absolute_time", ""));
            }
            _ => 0.0,
        };
        // A unit that is not known stays.
        let gyro = recording.gyro.as_ref().map(|_| {
            match (recording.gyro_scale.and_then(|s| s.nominal()), in_g) {
                (None, _) => (1.0, ""),
                (Some(nominal), false) => (1.0 / nominal, "_rad_s"),
                (Some(nominal), true) => (DEGREES_PER_RADIAN / nominal, "_deg_s"),
            }
        });
        let has_stamps = recording.time_s.is_some();
        let rate_hz = recording.timing.rate_hz();
        let has_temperature = recording.temperature_c.is_some();
        let has_time = has_stamps || rate_hz.is_some();
        let time = has_time.then(|| ("time_s".to_owned(), Cell::Fixed(0, TIME_DECIMALS)));
        let decimals = if in_g { G_DECIMALS } else { SI_DECIMALS };
        let axes = |sensor: &str, unit: &str| ["x", "y", "z"].map(|a| format!("{sensor}{a}{unit}"));
        let accel = match (recording.is_calibrated, in_g) {
            (true, _) => options.output_unit.columns().map(str::to_owned),
            (false, true) => axes("a", "_g"),
            (false, false) => axes("a", "_m_s2"),
        };
        let gyro_names = gyro.map(|(_, unit)| axes("g", unit));
        let channels = accel.into_iter().chain(gyro_names.into_iter().flatten());
        let temperature = has_temperature.then(|| ("temperature_c".to_owned(), SI_DECIMALS));
        let values = channels.map(|name| (name, decimals)).chain(temperature);
        let values = (usize::from(has_time)..).zip(values);
        let values = values.map(|(i, (name, decimals))| (name, Cell::Trimmed(i, decimals)));
        let unit_s = recording.timing.unit.map(TimeUnit::seconds);
        let accel_unit = if in_g { STANDARD_GRAVITY_MPS2 } else { 1.0 };
        let conversion = Conversion {
            start_s,
            dates_unit_s: unit_s.filter(|_| options.absolute_time),
            has_stamps,
            rate_hz,
            // From g to g it is 1, without rounding.
            accel: 1.0 / (per_mps2 * accel_unit),
            gyro: gyro.map(|g| g.0),
            has_temperature,
            rows: 0,
        };
        Ok((conversion, time.into_iter().chain(values).collect()))
    }

    /// Where the clock of the recorder was set among the rows, dates are those of its stamps from
    /// there on: two rows that agree on another start.
    fn follow_dates(&mut self, stamps: Option<&[f64]>, time_s: &[f64], row: usize) {
        let (Some(unit_s), Some(stamps)) = (self.dates_unit_s, stamps) else {
            return;
        };
        let start_of = |row: usize| Some(stamps.get(row)? * unit_s - time_s.get(row)?);
        if let (Some(start_s), Some(next_s)) = (start_of(row), start_of(row + 1))
            && (start_s - self.start_s).abs() > CLOCK_SET_S
            && (next_s - start_s).abs() < CLOCK_SET_S
            && UtcTime::of_stamp(stamps[row] * unit_s).is_some()
        {
            self.start_s = start_s;
        }
    }

    /// Columns of values of the table.
    fn convert(&mut self, rows: &mut Rows) -> Vec<Vec<f64>> {
        let mut values = Vec::new();
        let is_measured = &rows.readings.is_measured;
        if self.has_stamps {
            let none = || vec![f64::NAN; is_measured.len()];
            let mut time_s = rows.readings.time_s.take().unwrap_or_else(none);
            for row in 0..time_s.len() {
                self.follow_dates(rows.stamps.as_deref(), &time_s, row);
                time_s[row] += self.start_s;
            }
            values.push(time_s);
        } else if let Some(rate_hz) = self.rate_hz {
            let mut row = self.rows as f64;
            let times_s = is_measured.iter().map(|is_measured| {
                let time_s = self.start_s + row / rate_hz;
                row += f64::from(u8::from(*is_measured));
                time_s
            });
            values.push(times_s.collect());
        }
        self.rows += is_measured.iter().filter(|m| **m).count();
        let readings = &mut rows.readings;
        let scaled = |mut channel: Vec<f64>, factor: f64| {
            channel.iter_mut().for_each(|v| *v *= factor);
            channel
        };
        let accel = std::mem::take(&mut readings.accel);
        values.extend(accel.map(|channel| scaled(channel, self.accel)));
        if let (Some(gyro), Some(factor)) = (readings.gyro.take(), self.gyro) {
            values.extend(gyro.map(|channel| scaled(channel, factor)));
        }
        let temperature_c = readings.temperature_c.take();
        values.extend(temperature_c.filter(|_| self.has_temperature));
        values
    }
}
