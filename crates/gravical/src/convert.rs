//! Any recording as a plain table: SI units (or g and °/s), nothing calibrated.
//!
//! # Overview
//!
//! [`convert_file`] reads the recording once to determine unit, clock and faults from all rows, and
//! once more to write them. The table is `time_s`, the accelerometer, the gyroscope, the
//! temperature and the label, as far as there are any; other columns are not written. Breaks are
//! blank lines. Counts are converted by the sensitivity of the data sheet.
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

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use serde::Serialize;

use crate::apply::{OutputUnit, SetAside, set_aside};
use crate::excerpt::read_ahead;
use crate::output::BlockWriter;
use crate::poses::gyro_unit::settle;
use crate::poses::rests::find_rests;
use crate::recording::collect::Rereader;
use crate::recording::names::Quantity;
use crate::recording::open::Reopenable;
use crate::recording::row::TIME;
use crate::recording::sample::Sample;
use crate::recording::{AccelScale, Finding, GyroScale, ReadOptions, Recording};
use crate::scan::{write_fixed, write_trimmed};
use crate::utc::UtcTime;
use crate::{Error, Result};

/// As [`GyroScale::nominal`] has it, so that °/s stay as they are.
const DEGREES_PER_RADIAN: f64 = 180.0 / std::f64::consts::PI;

/// Decimals of a time, s.
const TIME_DECIMALS: u32 = 6;
/// Decimals of a value, zeros at the end left out: far below what any sensor resolves, and in g
/// enough for every count of a 16-bit converter.
const SI_DECIMALS: u32 = 9;
const G_DECIMALS: u32 = 12;

/// Options of [`convert_file`].
#[derive(Debug, Clone, Copy, Default)]
pub struct ConvertOptions {
    /// m/s² and rad/s, or g and °/s. Default: m/s².
    pub output_unit: OutputUnit,
    /// Times are seconds since 1970 in place of seconds since the first row.
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
/// Memory does not grow with the recording. What comes from a pipe is copied to a temporary file.
///
/// # Errors
///
/// Those of [`crate::recording::read`]; `unit-unknown` (input) for counts of unknown range;
/// `no-date` (input) if times since 1970 are asked for and nothing says when it starts; `changed`
/// (input) if the file does not have the same rows when it is read again; errors of writing.
pub fn convert_file(
    path: &Path,
    read: &ReadOptions,
    options: &ConvertOptions,
    out: &mut dyn Write,
) -> Result<ConvertSummary> {
    let name = path.display().to_string();
    let mut source = Reopenable::of(path);
    let mut recording = read_ahead(&mut source, &name, read)?;
    let stills = find_rests(&recording).spans;
    settle(&mut recording, &stills);
    let mut again = Rereader::new(&mut source, &name, read, recording.known);
    let file = again.open()?;
    let layout = &file.format.layout;
    let mut table = Table::new(
        &recording,
        options,
        recording.known.facts.celsius && layout.field(Quantity::Temperature).is_some(),
        layout.field(Quantity::Label).is_some(),
    )?;
    let mut rows = file.rows;
    let mut out = BlockWriter::new(out);
    out.bytes
        .extend_from_slice(table.names.join(",").as_bytes());
    out.bytes.push(b'\n');
    let mut number = 0;
    while let Some(row) = rows.next_row()? {
        let sample = Sample::of_row(&row, number, &recording.known);
        if row.restarted {
            table.restart(row.values[TIME], sample.time_s);
        }
        // Breaks are written as blank lines.
        out.bytes.extend(row.before.iter().map(|_| b'\n'));
        table.write_row(&sample, number, row.text.label, &mut out.bytes);
        out.write_if_full()?;
        number += 1;
    }
    if number != recording.rows_in_file() {
        return Err(again.changed());
    }
    rows.trailing().iter().for_each(|_| out.bytes.push(b'\n'));
    out.finish()?;
    Ok(ConvertSummary {
        start_unix_s: recording.recorded_at().and(recording.start_unix_s()),
        description: recording.description,
        serial: recording.serial,
        lines: recording.ledger.lines,
        rows: recording.ledger.rows,
        set_aside: set_aside(&recording.ledger),
        accelerometer: recording.accel_scale,
        gyroscope: recording.gyro_scale,
        output_unit: options.output_unit,
        columns: table.names,
        findings: recording.findings,
        input: name,
    })
}

/// The columns of the table.
struct Table {
    names: Vec<String>,
    clock: Clock,
    /// Factors from the unit of the file, of ax … gz; those of channels that there are.
    factors: Vec<(usize, f64)>,
    decimals: u32,
    has_temperature: bool,
    has_label: bool,
}

/// The time column.
#[derive(Clone, Copy)]
enum Clock {
    /// Time stamps, and what is added to them, s; the length of their unit, s, if they are dates.
    Stamps(f64, Option<f64>),
    /// No stamps, but a rate: the time of the first row, s, and Hz.
    Rate(f64, f64),
    Unknown,
}

impl Table {
    fn new(
        recording: &Recording,
        options: &ConvertOptions,
        has_temperature: bool,
        has_label: bool,
    ) -> Result<Self> {
        let here = Path::new(&recording.name);
        let in_g = options.output_unit == OutputUnit::StandardGravity;
        let accel = recording.accel_scale.nominal().ok_or_else(|| {
            let what = "counts of unknown range: they have no unit to convert from";
            Error::input("unit-unknown", what)
                .at(here, None)
                .with_hint("give the range, for example --accel-unit counts --accel-range 2")
        })?;
        // From g to g it is 1, without rounding.
        let accel = match in_g {
            true => 1.0 / (accel * STANDARD_GRAVITY_MPS2),
            false => 1.0 / accel,
        };
        let start_s = match options.absolute_time {
            true => recording.start_unix_s().ok_or_else(|| {
                Error::input("no-date", "nothing in this recording says when it was made")
                    .at(here, None)
                    .with_hint("leave --absolute-time out: times are seconds since the first row")
            })?,
            false => 0.0,
        };
        let clock = match (&recording.time_s, recording.timing.rate_hz()) {
            (Some(_), _) => {
                let reading = recording.known.facts.stamp_reading;
                let unit_s = reading.map(|reading| reading.unit.seconds());
                Clock::Stamps(start_s, unit_s.filter(|_| options.absolute_time))
            }
            (None, Some(rate_hz)) => Clock::Rate(start_s, rate_hz),
            (None, None) => Clock::Unknown,
        };
        let mut names = Vec::new();
        if !matches!(clock, Clock::Unknown) {
            names.push("time_s".to_owned());
        }
        let axes = ["x", "y", "z"];
        names.extend(match (recording.is_calibrated, in_g) {
            (true, _) => options.output_unit.columns().map(str::to_owned),
            (false, true) => axes.map(|axis| format!("a{axis}_g")),
            (false, false) => axes.map(|axis| format!("a{axis}_m_s2")),
        });
        let mut factors: Vec<(usize, f64)> = (0..3).map(|i| (i, accel)).collect();
        if recording.gyro.is_some() {
            // A unit that is not known stays.
            let gyro = recording.gyro_scale.and_then(|scale| scale.nominal());
            let (factor, unit) = match (gyro, in_g) {
                (None, _) => (1.0, ""),
                (Some(nominal), false) => (1.0 / nominal, "_rad_s"),
                (Some(nominal), true) => (DEGREES_PER_RADIAN / nominal, "_deg_s"),
            };
            names.extend(axes.map(|axis| format!("g{axis}{unit}")));
            factors.extend((3..6).map(|i| (i, factor)));
        }
        names.extend(has_temperature.then(|| "temperature_c".to_owned()));
        names.extend(has_label.then(|| "label".to_owned()));
        Ok(Table {
            names,
            clock,
            factors,
            decimals: if in_g { G_DECIMALS } else { SI_DECIMALS },
            has_temperature,
            has_label,
        })
    }

    /// The clock of the recording was set at a row with this stamp and time: dates are those of its
    /// stamps from there on.
    #[cold]
    fn restart(&mut self, stamp: f64, time_s: f64) {
        if let Clock::Stamps(start_s, Some(unit_s)) = &mut self.clock
            && UtcTime::of_stamp(stamp * *unit_s).is_some()
        {
            *start_s = stamp * *unit_s - time_s;
        }
    }

    #[inline]
    fn write_row(&self, sample: &Sample, number: usize, label: &[u8], out: &mut Vec<u8>) {
        match self.clock {
            Clock::Stamps(start_s, _) => write_fixed(out, sample.time_s + start_s, TIME_DECIMALS),
            Clock::Rate(start_s, rate_hz) => {
                write_fixed(out, start_s + number as f64 / rate_hz, TIME_DECIMALS);
            }
            Clock::Unknown => {}
        }
        let mut first = matches!(self.clock, Clock::Unknown);
        for (channel, factor) in &self.factors {
            if !std::mem::take(&mut first) {
                out.push(b',');
            }
            write_trimmed(out, sample.values[*channel] * factor, self.decimals);
        }
        if self.has_temperature {
            out.push(b',');
            write_trimmed(out, sample.temperature_c, SI_DECIMALS);
        }
        if self.has_label {
            out.push(b',');
            write_label(label.trim_ascii(), out);
        }
        out.push(b'\n');
    }
}

/// Appends a label, in quotes if necessary; one that has quotes keeps them.
fn write_label(label: &[u8], out: &mut Vec<u8>) {
    let quoted = label.len() > 1 && label.first() == Some(&b'"') && label.last() == Some(&b'"');
    if quoted || !label.iter().any(|b| matches!(b, b',' | b'"')) {
        return out.extend_from_slice(label);
    }
    out.push(b'"');
    for byte in label {
        out.push(*byte);
        if *byte == b'"' {
            out.push(b'"');
        }
    }
    out.push(b'"');
}
