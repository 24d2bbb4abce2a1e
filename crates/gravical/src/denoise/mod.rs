//! Filters for recordings, and their effect on noise.
//!
//! # Overview
//!
//! A [`FilterSpec`] specifies a filter (`savgol:5,2`, `butter:4,5Hz` …), a [`Filter`] is designed
//! for a sampling rate, and [`denoise`] runs several filters over a recording, [`denoise_file`]
//! from file to file: not across breaks and gaps, and around empty cells. It reports the effect of
//! each filter on white noise ([`Response`]) and on the noise of this recording at rest
//! ([`DenoiseSummary`]).
//!
//! - `savgol`: polynomials over a window (Savitzky–Golay), and the moving average, which is the one
//!   of order 0.
//! - `butterworth`: second-order sections of `gravical-core`, one pass or two.
//! - `hampel`: outliers.
//! - `rows`: columns through the filters.
//!
//! Smoothing makes plots readable. It does not improve integration: the noise it removes would
//! have averaged out in the integral, and an offset passes every low-pass filter unchanged.
//!
//! # Example
//!
//! ```
//! use gravical::denoise::{DenoiseOptions, denoise};
//! use gravical::recording::{ReadOptions, read_bytes};
//!
//! let mut csv = "t_ms,ax,ay,az\n".to_owned();
//! for i in 0..300 {
//!     let noise = f64::from(i * 7919 % 101) / 1000.0 - 0.05;
//!     csv += &format!("{},{noise:.3},{:.3},{:.3}\n", 10 * i, -noise, 9.81 + noise);
//! }
//! let recording = read_bytes(csv.as_bytes(), "desk.csv", &ReadOptions::default())?;
//! let done = denoise(recording, &DenoiseOptions::new(["butter:4,5Hz".parse()?]))?;
//! let step = &done.summary.filters[0];
//! assert!(step.response.noise_gain.unwrap() < 0.4);
//! assert_eq!(step.response.minus_3db_hz.as_deref(), Some(&[5.0][..]));
//! # Ok::<(), gravical::Error>(())
//! ```

mod butterworth;
mod filter;
mod hampel;
mod rows;
mod savgol;
mod spec;
mod summary;
#[cfg(test)]
mod tests;

pub use filter::{Filter, Response};
pub use spec::{Band, FilterSpec, Passes};
pub use summary::{DenoiseSummary, FilterOutcome, Sigmas};

use std::io::Write;
use std::ops::Range;
use std::path::Path;

use gravical_recording::Format;
use gravical_recording::write::{NewColumn, Table, input_name};
use serde::Deserialize;

use crate::calibration_file::InputFile;
use crate::poses::gyro_unit::settle;
use crate::poses::rests::find_rests;
use crate::recording::{ReadOptions, Recording};
use crate::rewrite::write_rows;
use crate::{Error, Result};
use gravical_recording::BatchReader;
use gravical_recording::source::open;

/// Decimals of a filtered value.
const DECIMALS: u32 = 6;

/// The channels that are filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Channels {
    /// The accelerometer.
    Accel,
    /// The gyroscope.
    Gyro,
    /// All channels of the recording. The default.
    #[default]
    All,
}

impl Channels {
    /// Of channel 0 to 2, the accelerometer, and 3 to 5, the gyroscope.
    fn contain(self, channel: usize) -> bool {
        match self {
            Channels::Accel => channel < 3,
            Channels::Gyro => channel >= 3,
            Channels::All => true,
        }
    }
}

/// Options of [`denoise`].
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct DenoiseOptions {
    /// Filter; repeatable, applied in this order
    #[serde(rename = "filter", deserialize_with = "crate::option_text::list")]
    #[cfg_attr(feature = "clap", arg(short, long = "filter", value_name = "FILTER"))]
    pub filters: Vec<FilterSpec>,
    /// accel, gyro or all
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "CHANNELS",
            default_value = "all",
            hide_possible_values = true
        )
    )]
    pub channels: Channels,
}

impl DenoiseOptions {
    /// Options with these filters and defaults otherwise.
    #[must_use]
    pub fn new(filters: impl IntoIterator<Item = FilterSpec>) -> Self {
        DenoiseOptions {
            filters: filters.into_iter().collect(),
            ..Self::default()
        }
    }

    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `no-filter`, `filter-range` (usage).
    pub fn validate(&self) -> Result<()> {
        if self.filters.is_empty() {
            return Err(Error::usage("no-filter", "no filter was given")
                .with_hint(format!("give one of: {}", spec::EXAMPLES))
                .advise("filter", ""));
        }
        self.filters.iter().try_for_each(FilterSpec::validate)
    }
}

/// A recording with filtered channels.
#[derive(Debug, Clone)]
pub struct Denoised {
    /// The recording with filtered channels; its findings are those of reading.
    pub recording: Recording,
    /// Results, with all findings.
    pub summary: DenoiseSummary,
}

/// Replaces the channels of a recording by filtered ones.
///
/// No filter runs across a break, or a step of the time stamps that goes back, is longer than 10
/// usual steps (a gap), or is no whole number of them; Hampel filters alone run across any step up to
/// a gap. Lost samples are interpolated for the filter, and not written; empty cells stay empty, and
/// the samples around them are filtered as if one were lost. Parts that are too short for a filter are
/// left unchanged, which is a finding.
///
/// # Errors
///
/// `no-filter`, `filter-range`, `rate-unknown` (usage); `no-gyroscope` (input) if only the
/// gyroscope is to be filtered and there is none; `uneven-stamps` (input) if more than 1 % of the
/// steps are uneven, for all filters but Hampel's.
pub fn denoise(mut recording: Recording, options: &DenoiseOptions) -> Result<Denoised> {
    options.validate()?;
    let summary = filter(&mut recording, options)?;
    Ok(Denoised { recording, summary })
}

/// Writes the recording at `path` (`-` is standard input) with filtered channels in place of the
/// recorded ones, as [`denoise`] filters them.
///
/// Filtered channels keep the name and the unit of their column, so that a calibration for the
/// recording also applies to the output; for a derivative `_per_s` is appended. Every other
/// column is copied byte for byte, breaks become blank lines. Values have six decimals. A row that
/// is no measurement stays a row with empty channels.
///
/// Channels and the text of other columns are held in memory.
///
/// # Errors
///
/// As [`denoise`] and [`crate::recording::read_samples`]; errors of writing.
pub fn denoise_file(
    path: &Path,
    read: &ReadOptions,
    options: &DenoiseOptions,
    out: &mut dyn Write,
) -> Result<(DenoiseSummary, Vec<InputFile>)> {
    options.validate()?;
    let name = path.display().to_string();
    let copied = |format: &Format| table(options, format).copied().to_vec();
    let input = open(path, read)?;
    let mut reader = BatchReader::open(input, &name, read, BatchReader::WHOLE, copied)?;
    let table = table(options, &reader.format);
    let mut summary = filter(&mut reader.recording, options)?;
    summary.columns.clone_from(&table.names);
    // A filter that removes constants also removes the offset.
    let keeps_offset = options.filters.iter().all(FilterSpec::keeps_constants);
    let offset = if keeps_offset {
        reader.recording.zero_offset
    } else {
        0.0
    };
    let (recording, .., found) = write_rows(reader, out, table, false, |rows| {
        let readings = &mut rows.readings;
        let accel = readings.accel.iter_mut().flatten();
        accel.for_each(|v| *v += offset);
        let gyro = readings.gyro.take().into_iter().flatten();
        let columns = std::mem::take(&mut readings.accel).into_iter().chain(gyro);
        let filtered = columns
            .enumerate()
            .filter(|(c, _)| options.channels.contain(*c));
        filtered.map(|(_, column)| column).collect()
    })?;
    summary
        .findings
        .extend(found.into_iter().map(|f| f.in_file(&name)));
    summary.description.clone_from(&recording.description);
    Ok((summary, InputFile::of(std::slice::from_ref(&recording))))
}

/// All columns, with the filtered channels in their places.
fn table(options: &DenoiseOptions, format: &Format) -> Table {
    let order: usize = options.filters.iter().map(FilterSpec::derivative).sum();
    let suffix = match order {
        0 => String::new(),
        1 => "_per_s".to_owned(),
        n => format!("_per_s{n}"),
    };
    let fields = format
        .accel
        .into_iter()
        .chain(format.gyro.into_iter().flatten());
    let columns = fields
        .enumerate()
        .filter(|(channel, _)| options.channels.contain(*channel))
        .map(|(_, field)| NewColumn {
            name: input_name(format, field) + &suffix,
            replaces: Some(field),
        });
    Table::with_new(format, &columns.collect::<Vec<_>>(), DECIMALS, false)
}

/// Replaces the channels of a recording by filtered ones, and measures the noise in its static
/// intervals.
fn filter(recording: &mut Recording, options: &DenoiseOptions) -> Result<DenoiseSummary> {
    if options.channels == Channels::Gyro && recording.gyro.is_none() {
        return Err(
            Error::input("no-gyroscope", "the recording has no gyroscope")
                .at(Path::new(&recording.name), None)
                .with_hint("filter the accelerometer, or name the columns of the gyroscope")
                .advise("channels", "accel")
                .advise("columns", ""),
        );
    }
    let rests = find_rests(recording);
    settle(recording, &rests);
    let filters = design(recording, &options.filters)?;
    let mut at_rest = vec![rests.clone()];
    let mut reach = 0;
    for filter in &filters {
        // A filter spreads motion into the ends of a static interval.
        reach += filter.reach();
        at_rest.push(inner_rows(&rests, reach));
    }
    let done = rows::run(recording, &filters, options.channels, &at_rest)?;
    Ok(DenoiseSummary::new(recording, &rests, &filters, &done))
}

fn design(recording: &Recording, filters: &[FilterSpec]) -> Result<Vec<Filter>> {
    let rate_hz = recording.timing.rate_hz();
    let filters = filters.iter();
    filters.map(|spec| Filter::design(spec, rate_hz)).collect()
}

/// The intervals without `reach` rows at both ends, if at least ten rows remain.
fn inner_rows(spans: &[Range<usize>], reach: usize) -> Vec<Range<usize>> {
    spans
        .iter()
        .map(|s| s.start + reach..s.end.saturating_sub(reach))
        .filter(|s| s.len() >= 10)
        .collect()
}
