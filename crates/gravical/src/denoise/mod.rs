//! Filters for recordings, and their effect on noise.
//!
//! # Overview
//!
//! A [`FilterSpec`] specifies a filter (`savgol:5,2`, `butter:4,5Hz` …), a [`Filter`] is designed
//! for a sampling rate, and [`denoise`] runs several filters over a recording, [`denoise_file`]
//! from file to file: not across breaks and gaps, and around empty cells. It reports the effect of
//! each filter on white noise and on the noise of this recording at rest ([`DenoiseSummary`]).
//!
//! - `filter`: polynomials over a window (Savitzky–Golay), second-order sections of `gravical-core` forwards
//!   and backwards, Hampel's for outliers.
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
//! let mut recording = read_bytes(csv.as_bytes(), "desk.csv", &ReadOptions::default())?;
//! let options = DenoiseOptions { filters: vec!["butter:4,5Hz".parse()?] };
//! let summary = denoise(&mut recording, &options)?;
//! assert!(summary.filters[0].noise_gain.unwrap() < 0.4);
//! # Ok::<(), gravical::Error>(())
//! ```

mod filter;
mod rows;
#[cfg(test)]
mod tests;

pub use filter::{Filter, FilterSpec};

use std::io::Write;
use std::ops::Range;

use gravical_recording::source::{Named, open};
use gravical_recording::write::{Table, input_name};
use gravical_recording::{Format, Stream};
use gravical_signal::stats::pooled_deviation;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::calibration_file::InputFile;
use crate::finding::{Case, Finding};
use crate::poses::gyro_unit::decide_unit;
use crate::problem::Problem;
use crate::recording::{ReadOptions, Recording};
use crate::rewrite::write_rows;
use rows::{Grid, Treatment};

/// Decimals of a filtered value.
const DECIMALS: u32 = 6;

/// Options of [`denoise`].
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct DenoiseOptions {
    /// Filter; repeatable, applied in this order
    #[serde(
        rename = "filter",
        deserialize_with = "gravical_judge::option_text::list"
    )]
    #[cfg_attr(feature = "clap", arg(short, long = "filter", value_name = "FILTER"))]
    pub filters: Vec<FilterSpec>,
}

impl DenoiseOptions {
    /// Checks ranges.
    ///
    /// # Errors
    ///
    /// `no-filter`, `filter-range` (usage).
    pub fn validate(&self) -> Result<()> {
        if self.filters.is_empty() {
            return Err(Problem::FilterMissing.error().advise("filter", ""));
        }
        self.filters.iter().try_for_each(FilterSpec::validate)
    }
}

/// Result of [`denoise`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DenoiseSummary {
    /// Path of the recording as given, `-` for standard input.
    pub input: String,
    /// Text format in words.
    pub description: String,
    /// Number of rows.
    pub rows: usize,
    /// The rate that the filters were designed for, Hz; null if unknown.
    pub rate_hz: Option<f64>,
    /// Number of parts between breaks, gaps, uneven steps and steps back; filters restart in each.
    pub segments: usize,
    /// Number of static intervals in which the noise was measured.
    pub static_intervals: usize,
    /// Number of rows of these intervals.
    pub static_rows: usize,
    /// Unit of the accelerometer's standard deviations: `m/s^2` if the unit of the file is known,
    /// otherwise that of the file.
    pub accel_unit: &'static str,
    /// Unit of the gyroscope's standard deviations: `rad/s` if that of the file is known.
    pub gyro_unit: &'static str,
    /// Noise before filtering.
    pub recorded: Sigmas,
    /// The filters in the order in which they ran.
    pub filters: Vec<FilterOutcome>,
    /// All findings, including those of reading.
    pub findings: Vec<Finding>,
}

/// Result of one filter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FilterOutcome {
    /// As text: `savgol:5,2`.
    pub filter: String,
    /// Standard deviation of white noise after the filter over that before it; null for Hampel, which
    /// has no impulse response.
    pub noise_gain: Option<f64>,
    /// Number of samples replaced as outliers; null for filters that do not replace any.
    pub replaced: Option<usize>,
    /// Noise at rest after it.
    pub sigma: Sigmas,
}

/// Standard deviation of each axis at rest: the deviations from the mean of each static interval,
/// pooled. After a filter, without the ends of each interval, into which it spreads motion. Null
/// if the sensor does not exist or was not static for long enough.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Default)]
pub struct Sigmas {
    /// In the summary's `accel_unit`.
    pub accelerometer: Option<[f64; 3]>,
    /// In the summary's `gyro_unit`.
    pub gyroscope: Option<[f64; 3]>,
}

/// Writes the recording of this file (`-` is standard input) with filtered channels in place of the
/// recorded ones, as [`denoise`] filters them.
///
/// Filtered channels keep the name and the unit of their column, so that a calibration for the
/// recording also applies to the output. Every other column is copied byte for byte, breaks become
/// blank lines. Values have six decimals. A row that is no measurement stays a row with empty
/// channels.
///
/// Channels and the text of other columns are held in memory.
///
/// # Errors
///
/// As [`denoise`] and [`crate::recording::read_samples`]; errors of writing.
pub fn denoise_file<'a>(
    file: impl Into<Named<'a>>,
    read: &ReadOptions,
    options: &DenoiseOptions,
    out: &mut dyn Write,
) -> Result<(DenoiseSummary, Vec<InputFile>)> {
    options.validate()?;
    let file = file.into();
    let name = file.name();
    let copied = |format: &Format| table(format).copied().to_vec();
    let input = open(file, read)?;
    let mut stream = Stream::open(input, &name, read, Stream::WHOLE, copied)?;
    let table = table(&stream.format);
    let mut summary = denoise(&mut stream.recording, options)?;
    // A filter that removes constants also removes the offset.
    let keeps_offset = options.filters.iter().all(FilterSpec::keeps_constants);
    let offset = stream.recording.units.zero_offset * f64::from(keeps_offset);
    // What was found is in the summary; what is still to be found is added to it.
    stream.recording.findings.clear();
    let (recording, _) = write_rows(stream, out, table, |piece| {
        let accel = piece.accel.iter_mut().flatten();
        accel.for_each(|v| *v += offset);
        let gyro = piece.gyro.take().into_iter().flatten();
        let accel = std::mem::take(&mut piece.accel);
        accel.into_iter().chain(gyro).collect()
    })?;
    summary.findings.extend(recording.findings.iter().cloned());
    summary.description = recording.format.describe();
    Ok((summary, InputFile::of(std::slice::from_ref(&recording))))
}

/// All columns, with the filtered channels in their places.
fn table(format: &Format) -> Table {
    let gyro = format.gyro.into_iter().flatten();
    let columns = format.accel.into_iter().chain(gyro);
    let columns = columns.map(|field| (input_name(format, field), Some(field)));
    Table::with_new(format, &columns.collect::<Vec<_>>(), DECIMALS, false)
}

/// Replaces the channels of a recording by filtered ones, and measures the noise in its static
/// intervals.
///
/// No filter runs across a break, or a step of the time stamps that goes back, is longer than 10
/// usual steps (a gap), or is no whole number of them; Hampel filters alone run across any step up to
/// a gap. Lost samples are interpolated for the filter, and not written; empty cells stay empty, and
/// the samples around them are filtered as if one were lost. Parts that are too short for a filter are
/// left unchanged, which is a finding.
///
/// # Errors
///
/// `no-filter`, `filter-range`, `rate-unknown` (usage); `uneven-stamps` (input) if more than 1 % of
/// the steps are uneven, for all filters but Hampel's.
pub fn denoise(recording: &mut Recording, options: &DenoiseOptions) -> Result<DenoiseSummary> {
    options.validate()?;
    let rests = decide_unit(recording);
    let rate_hz = recording.clock.rate_hz();
    let designed = options.filters.iter();
    let designed = designed.map(|spec| Filter::design(spec, rate_hz));
    let designed = designed.collect::<Result<Vec<Filter>>>()?;
    let grid = Grid::new(recording, &designed)?;
    let recorded = sigmas(recording, &rests);
    let mut findings = recording.findings.clone();
    let (mut filters, mut reach) = (Vec::new(), 0);
    let gyro = recording.gyro.iter().flatten();
    let channels = recording.accel.iter().chain(gyro);
    let stretches: Vec<_> = channels.map(|c| grid.stretches(c)).collect();
    for filter in &designed {
        let spec = filter.spec;
        let gyro = recording.gyro.iter_mut().flatten();
        let channels = recording.accel.iter_mut().chain(gyro);
        let mut treatment = Treatment::default();
        for (channel, stretches) in channels.zip(&stretches) {
            for stretch in stretches {
                grid.filter(filter, stretch, channel, &mut treatment);
            }
        }
        findings.extend(filter_findings(
            filter,
            treatment,
            recording.clock.duration_s,
        ));
        // A filter spreads motion into the ends of a static interval.
        reach += filter.reach;
        filters.push(FilterOutcome {
            filter: spec.to_string(),
            noise_gain: filter.noise_gain(),
            replaced: matches!(spec, FilterSpec::Hampel { .. }).then_some(treatment.replaced),
            sigma: sigmas(recording, &inner_rows(&rests, reach)),
        });
    }
    if rests.is_empty() {
        findings.push(Case::EffectUnknown.finding());
    }
    let findings = findings.into_iter().map(|f| f.in_file(&recording.name));
    let (accel, gyro) = (recording.units.accel, recording.units.gyro);
    let unknown_gyro = gyro.filter(|scale| scale.nominal().is_none());
    Ok(DenoiseSummary {
        input: recording.name.clone(),
        description: recording.format.describe(),
        rows: recording.rows(),
        rate_hz,
        segments: grid.starts.len(),
        static_intervals: rests.len(),
        static_rows: rests.iter().map(ExactSizeIterator::len).sum(),
        accel_unit: accel.nominal().map_or(accel.unit.name(), |_| "m/s^2"),
        gyro_unit: unknown_gyro.map_or("rad/s", |scale| scale.unit.name()),
        recorded,
        filters,
        findings: findings.collect(),
    })
}

/// Standard deviations of the channels in rows at rest, in SI units where the scale is known.
fn sigmas(recording: &Recording, at_rest: &[Range<usize>]) -> Sigmas {
    let sensor = |axes: &[Vec<f64>; 3], nominal: Option<f64>| {
        let sigmas = axes.each_ref().map(|channel| {
            let intervals = at_rest.iter().map(|rows| &channel[rows.clone()]);
            pooled_deviation(intervals) / nominal.unwrap_or(1.0)
        });
        sigmas.iter().all(|v| v.is_finite()).then_some(sigmas)
    };
    let gyro_nominal = recording.units.gyro.and_then(|scale| scale.nominal());
    let gyro = recording.gyro.as_ref();
    Sigmas {
        accelerometer: sensor(&recording.accel, recording.units.accel.nominal()),
        gyroscope: gyro.and_then(|axes| sensor(axes, gyro_nominal)),
    }
}

/// Findings of one filter.
fn filter_findings(filter: &Filter, treatment: Treatment, duration_s: Option<f64>) -> Vec<Finding> {
    let (spec, mut findings) = (filter.spec, Vec::new());
    if treatment.too_short > 0 {
        let case = Case::NotFiltered {
            filter: spec.to_string(),
            samples: treatment.too_short,
            shortest: filter.shortest,
        };
        findings.push(case.finding().counting(treatment.too_short as u64));
    }
    if let FilterSpec::Butterworth { cutoff_hz, .. } = spec
        && let Some(duration_s) = duration_s
        && duration_s * cutoff_hz < 1.0
    {
        let case = Case::ShortForCutoff {
            filter: spec.to_string(),
            cutoff_hz,
            duration_s,
        };
        findings.push(case.finding());
    }
    findings
}

/// The intervals without `reach` rows at both ends, if at least ten rows remain.
fn inner_rows(spans: &[Range<usize>], reach: usize) -> Vec<Range<usize>> {
    let inner = spans.iter();
    let inner = inner.map(|s| s.start + reach..s.end.saturating_sub(reach));
    inner.filter(|s| s.len() >= 10).collect()
}
