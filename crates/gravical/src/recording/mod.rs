//! Reading of recordings in many formats, and the faults found in them.
//!
//! # Overview
//!
//! [`read`] opens a file (plain, gzip, standard input) and reads it with the crate
//! `gravical_recording`: its format, which column is which channel, and what the columns say of clock,
//! units and defects. The [`Ledger`] accounts for every line: it is a row, or it was set aside for a
//! given reason. Every fault is reported as a [`Finding`] with its lines.
//!
//! Values stay in the unit of the file; [`AccelScale::nominal`] is the size of one m/s² in that
//! unit. The bias and matrix of a calibration therefore apply to the numbers in the file.
//!
//! # Example
//!
//! ```
//! use gravical::recording::{ReadOptions, read_bytes};
//!
//! let csv = "t_ms,ax,ay,az\n0,0.1,0.0,9.8\n10,0.1,0.1,9.8\n20,0.1,0.0,9.7\n";
//! let recording = read_bytes(csv.as_bytes(), "desk.csv", &ReadOptions::default())?;
//! assert_eq!(recording.rows(), 3);
//! assert_eq!(recording.accel_scale.unit.name(), "m/s^2");
//! # Ok::<(), gravical::Error>(())
//! ```

pub(crate) mod batches;
#[doc(hidden)]
pub mod board;
mod columns;
#[doc(hidden)]
pub mod following;
mod foreign;
#[doc(hidden)]
pub mod join;
mod ledger;
mod memory;
mod meter;
#[doc(hidden)]
pub mod open;
pub(crate) mod range_end;
pub(crate) mod reading;
mod text_options;

use std::ops::Range;

pub use crate::finding::{Finding, FindingKind, LineSpans, Severity};
use crate::stats::mean_of_finite;
use crate::utc::UtcTime;
pub use columns::parse_columns;
#[doc(hidden)]
pub use gravical_recording::units;
pub use gravical_recording::{ColumnsSpec, Labels, Reason, UnitDoubt};
pub use gravical_recording::{TimeUnit, Timing};
pub(crate) use gravical_recording::{full_scale, metadata};
pub use join::{JoinedFile, join_gyroscope, join_gyroscope_bytes};
pub use memory::{SampleColumns, TableColumn};
pub use meter::{Meter, Progress};
pub use reading::{read, read_bytes, read_head, read_samples};
use serde::{Deserialize, Serialize};
pub use units::{AccelScale, AccelUnit, GyroScale, GyroUnit, Origin};
#[doc(hidden)]
pub use {
    join::{holds_gyroscope_alone, is_named_gyroscope},
    ledger::Ledger,
};

/// Accepted sampling rates (Hz) and full-scale ranges (g, °/s): much wider than any real sensor,
/// so that windows, scales and durations computed from them are finite.
pub(crate) const POSSIBLE: std::ops::RangeInclusive<f64> = 1e-6..=1e9;

/// How a recording is read where it does not say so itself.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "clap", command(next_help_heading = "Reading the recording"))]
pub struct ReadOptions {
    /// m/s^2, g, mg or counts [default: from the data]
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "UNIT",
            hide_possible_values = true,
            hide_short_help = true
        )
    )]
    pub accel_unit: Option<AccelUnit>,
    /// Full scale in g, for counts [default: from the data]
    #[serde(rename = "accel_range")]
    #[cfg_attr(
        feature = "clap",
        arg(long = "accel-range", value_name = "G", hide_short_help = true)
    )]
    pub accel_range_g: Option<f64>,
    /// rad/s, deg/s or counts [default: from turns, header]
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "UNIT",
            hide_possible_values = true,
            hide_short_help = true
        )
    )]
    pub gyro_unit: Option<GyroUnit>,
    /// Full scale in °/s, for counts [default: from turns]
    #[serde(rename = "gyro_range")]
    #[cfg_attr(
        feature = "clap",
        arg(long = "gyro-range", value_name = "DPS", hide_short_help = true)
    )]
    pub gyro_range_deg_s: Option<f64>,
    /// t=time,ax=acc_x,gx=- or in order: t,ax,ay,az,_,-
    ///
    /// `-` ignores a column, `_` leaves it to recognition.
    #[serde(deserialize_with = "columns::optional")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "LIST", value_parser = parse_columns, allow_hyphen_values = true, hide_short_help = true))]
    pub columns: Option<ColumnsSpec>,
    /// Sensor in the file: part of its name, or its number
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "NAME", hide_short_help = true)
    )]
    pub sensor: Option<String>,
    /// Sampling rate in Hz, where there are no time stamps
    #[serde(rename = "rate")]
    #[cfg_attr(
        feature = "clap",
        arg(long = "rate", value_name = "HZ", hide_short_help = true)
    )]
    pub rate_hz: Option<f64>,
    /// s, ms, us or ns [default: from the header or steps]
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "UNIT",
            hide_possible_values = true,
            hide_short_help = true
        )
    )]
    pub time_unit: Option<TimeUnit>,
    /// Subtracted from counts [default: 32768 if unsigned]
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "N",
            allow_negative_numbers = true,
            hide_short_help = true
        )
    )]
    pub zero_offset: Option<f64>,
    /// Compute the SHA-256 of the file.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub hash: bool,
    /// Counts the bytes read, for a progress bar; default: none.
    #[serde(skip)]
    #[cfg_attr(feature = "clap", arg(skip))]
    pub meter: Option<Meter>,
}

impl ReadOptions {
    /// The same options for a recording whose gyroscope is in a separate file
    /// ([`join_gyroscope`]): gyroscope columns named by the user belong to that file.
    #[must_use]
    pub fn beside_gyroscope_file(&self) -> Self {
        ReadOptions {
            columns: self.columns.as_ref().and_then(columns::of_accelerometer),
            ..self.clone()
        }
    }

    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `option-range` (usage) for a rate or range that is not between 1e-6 and
    /// 1e9, and for an offset beyond 32-bit counts.
    pub fn validate(&self) -> crate::Result<()> {
        for (name, value) in [
            ("rate", self.rate_hz),
            ("accel_range", self.accel_range_g),
            ("gyro_range", self.gyro_range_deg_s),
        ] {
            if let Some(v) = value
                && !POSSIBLE.contains(&v)
            {
                let what = format!("{v} is not possible; 1e-6 to 1e9 is");
                return Err(crate::Error::range(name, what));
            }
        }
        if let Some(offset) = self.zero_offset
            && (offset.is_nan() || offset.abs() > f64::from(u32::MAX))
        {
            let what = format!("{offset} is no number of counts of a converter");
            return Err(crate::Error::range("zero_offset", what));
        }
        Ok(())
    }
}

/// A recording in columns. All channels have the same number of rows; an empty
/// cell is NaN.
///
/// It can be serialised in formats that hold NaN (JSON does not).
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Recording {
    /// Path of the file as given, `-` for standard input.
    pub name: String,
    /// SHA-256 of the file, if requested.
    pub sha256: Option<String>,
    /// Text format of the file in words: `comma, header in line 1`.
    pub description: String,
    /// Serial number of the sensor, where the lines above the header name it.
    pub serial: Option<String>,
    /// Names of the columns; empty without a header.
    pub column_names: Vec<String>,
    /// The accelerometer is read from columns with the names that `gravical apply` writes, or a
    /// board calibrated it.
    pub is_calibrated: bool,
    /// The board's settings line says that it sends calibrated values.
    pub is_calibrated_by_board: bool,
    /// Specific force along x, y, z in the unit of the file, less
    /// [`zero_offset`](Self::zero_offset).
    pub accel: [Vec<f64>; 3],
    /// Angular rate about x, y, z in the unit of the file.
    pub gyro: Option<[Vec<f64>; 3]>,
    /// The file of the gyroscope, if it is a separate one ([`join`]).
    pub gyro_file: Option<JoinedFile>,
    /// Temperature of the sensor, °C.
    pub temperature_c: Option<Vec<f64>>,
    /// Seconds since the first row; `None` without usable time stamps.
    pub time_s: Option<Vec<f64>>,
    /// The first time stamp, s, on the recorder's clock: where [`time_s`](Self::time_s) is 0. It
    /// aligns two files from the same recorder.
    pub time_origin_s: Option<f64>,
    /// When it starts by the lines above the header, s since 1970; used where no time stamp is a
    /// date.
    pub stated_start_s: Option<f64>,
    /// The clock restarted at least once.
    pub restarted: bool,
    /// The label column.
    pub labels: Option<Labels>,
    /// Rows that do not continue the row before: after blank lines, a named gap, a reset of the
    /// board or a repeated header. A single blank line or a header is not a break if the clock
    /// continues across it.
    pub breaks: Vec<usize>,
    /// Value subtracted from the accelerometer's counts.
    pub zero_offset: f64,
    /// Unit of the accelerometer.
    pub accel_scale: AccelScale,
    /// Why the unit of the accelerometer is unknown; `None` if it is known.
    pub unit_doubt: Option<UnitDoubt>,
    /// Unit of the accelerometer according to the header.
    pub header_unit: Option<AccelUnit>,
    /// Unit of the gyroscope; `None` without a gyroscope.
    pub gyro_scale: Option<GyroScale>,
    /// Resolution of ax, ay, az, gx, gy, gz, each in its own unit; 0 where it is
    /// unknown.
    pub resolution: [f64; 6],
    /// Rates, gaps, jitter.
    pub timing: Timing,
    /// Counts of rows and of lines that were set aside.
    pub ledger: Ledger,
    /// Faults found.
    pub findings: Vec<Finding>,
    /// Line of each row, from 1.
    pub(crate) lines: Vec<u32>,
}

/// The serial number that the files name, if any does.
///
/// # Errors
///
/// `sensors-differ` where they name several.
pub(crate) fn common_serial(recordings: &[Recording]) -> crate::Result<Option<String>> {
    let named = || {
        recordings
            .iter()
            .filter_map(|r| Some((r, r.serial.as_ref()?)))
    };
    let Some((one, serial)) = named().next() else {
        return Ok(None);
    };
    match named().find(|(_, other)| *other != serial) {
        None => Ok(Some(serial.clone())),
        Some((other, another)) => Err(crate::Error::input(
            "sensors-differ",
            format!(
                "{} is of the sensor with the serial number {serial}, {} of {another}",
                one.name, other.name
            ),
        )
        .at(other.name.as_ref(), None)
        .with_hint("calibrate the recordings of each sensor alone; --sensor-id NAME says that they are of one")),
    }
}

/// Ranges between `breaks` in `0..len`, without empty ones.
pub(crate) fn between(breaks: &[usize], len: usize) -> Vec<std::ops::Range<usize>> {
    let mut edges = vec![0];
    edges.extend(breaks.iter().copied());
    edges.push(len);
    edges
        .windows(2)
        .map(|w| w[0]..w[1])
        .filter(|r| !r.is_empty())
        .collect()
}

impl Recording {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.accel[0].len()
    }

    /// When it starts, if its time stamps are dates or seconds since 1970, or the lines above the
    /// header say it; a date without a zone counts as UTC.
    #[must_use]
    pub fn recorded_at(&self) -> Option<UtcTime> {
        self.start_unix_s().and_then(UtcTime::of_stamp)
    }

    /// The same in s since 1970.
    pub(crate) fn start_unix_s(&self) -> Option<f64> {
        let is_date = |s: &f64| UtcTime::of_stamp(*s).is_some();
        self.time_origin_s.filter(is_date).or(self.stated_start_s)
    }

    /// Line number in the file, from 1, of row `row` (from 0).
    #[must_use]
    pub fn line(&self, row: usize) -> u64 {
        self.lines
            .get(row)
            .map_or(row as u64 + 1, |line| u64::from(*line))
    }

    /// The rows in these lines, the first and the last.
    #[must_use]
    pub fn rows_at(&self, [first, last]: [u32; 2]) -> Range<usize> {
        let before = |line: u32| self.lines.partition_point(|l| *l < line);
        let start = before(first);
        start..before(last.saturating_add(1)).max(start)
    }

    /// True for a long file of a worn device: its rows are means of neighbouring samples.
    #[must_use]
    pub fn is_averaged(&self) -> bool {
        self.ledger.rows > self.rows() as u64
    }

    /// Samples that each row is the mean of, one where a row of any recording is a sample.
    pub(crate) fn samples_of_rows(recordings: &[Recording]) -> f64 {
        let each = recordings
            .iter()
            .map(|r| r.ledger.rows as f64 / r.rows().max(1) as f64);
        each.fold(f64::INFINITY, f64::min).clamp(1.0, 1e6)
    }

    /// Refuses means of samples; `hint`: what to do instead.
    ///
    /// # Errors
    ///
    /// `averaged` (usage).
    pub(crate) fn refuse_averaged(&self, hint: &str) -> crate::Result<()> {
        match self.is_averaged() {
            false => Ok(()),
            true => Err(crate::Error::usage(
                "averaged",
                "the rows of this recording are means of neighbouring samples",
            )
            .at(self.name.as_ref(), None)
            .with_hint(hint)),
        }
    }

    /// True if there is a break within `rows`.
    pub(crate) fn is_broken(&self, rows: &std::ops::Range<usize>) -> bool {
        let at = self.breaks.partition_point(|b| *b <= rows.start);
        self.breaks.get(at).is_some_and(|b| *b < rows.end)
    }

    /// Lowest and highest temperature, °C; `None` without any.
    pub(crate) fn temperature_range_c(&self) -> Option<[f64; 2]> {
        let all = self.temperature_c.iter().flatten();
        let [low, high] = all
            .filter(|t| t.is_finite())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], t| {
                [l.min(*t), h.max(*t)]
            });
        (low <= high).then_some([low, high])
    }

    /// Mean temperature over these rows, °C; `None` without any.
    pub(crate) fn mean_temperature_c(&self, rows: &[Range<usize>]) -> Option<f64> {
        let all = self.temperature_c.as_ref()?;
        let mean = mean_of_finite(rows.iter().flat_map(|rows| &all[rows.clone()]));
        mean.is_finite().then_some(mean)
    }

    /// True if there are columns with the names that `gravical apply` writes, whether they are
    /// read or not: the file is a result, not a recording of a session.
    #[must_use]
    pub fn is_result(&self) -> bool {
        let has = |name: &&str| self.column_names.iter().any(|n| n == name);
        gravical_recording::CALIBRATED
            .iter()
            .any(|own| own.iter().all(has))
    }

    /// True if the header claims another unit of the accelerometer than the magnitude at rest
    /// shows.
    #[must_use]
    pub fn contradicts_header(&self) -> bool {
        let claimed = self
            .header_unit
            .filter(|claim| *claim != self.accel_scale.unit);
        claimed.is_some() && self.accel_scale.origin == Origin::Data
    }

    /// Accelerometer values of a row.
    #[must_use]
    pub fn accel_at(&self, row: usize) -> [f64; 3] {
        [self.accel[0][row], self.accel[1][row], self.accel[2][row]]
    }

    /// Row ranges between the breaks, none of them empty.
    #[must_use]
    pub fn segments(&self) -> Vec<std::ops::Range<usize>> {
        between(&self.breaks, self.rows())
    }

    /// [`resolution`](Self::resolution) of the accelerometer.
    #[must_use]
    pub fn accel_resolution(&self) -> [f64; 3] {
        let [x, y, z, ..] = self.resolution;
        [x, y, z]
    }

    /// [`resolution`](Self::resolution) of the gyroscope.
    #[must_use]
    pub fn gyro_resolution(&self) -> [f64; 3] {
        let [.., x, y, z] = self.resolution;
        [x, y, z]
    }

    /// The sampling rate to work with, in Hz, and whether it had to be assumed.
    #[must_use]
    pub fn working_rate_hz(&self) -> (f64, bool) {
        match self.timing.rate_hz() {
            Some(rate) => (rate, false),
            None => (Self::ASSUMED_RATE_HZ, true),
        }
    }

    /// Sampling rate assumed for window lengths if it is unknown, Hz.
    pub const ASSUMED_RATE_HZ: f64 = 100.0;
}
