//! Filters for recordings, and their effect on noise.
//!
//! # Overview
//!
//! A [`FilterSpec`] specifies a filter (`savgol:5,2`, `butter:4,5Hz` …), a [`Filter`] is designed
//! for a sampling rate, and [`denoise`] runs several filters over a recording, [`denoise_file`]
//! from file to file: not across breaks and gaps, on an even grid if sampling is uneven, and around
//! empty cells. It reports the effect of each filter on white noise
//! ([`Response`]) and on the noise of this recording at rest ([`DenoiseSummary`]).
//!
//! - `savgol`: polynomials over a window (Savitzky–Golay), and the moving average, which is the one
//!   of order 0.
//! - `butterworth`: second-order sections of `gravical-core`, one pass or two.
//! - `hampel`: outliers.
//! - `even`: uneven sampling.
//! - `engine`: columns through the filters.
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
mod engine;
mod even;
mod file;
mod filter;
mod hampel;
mod parse;
mod response;
mod savgol;
mod spec;
mod summary;
#[cfg(test)]
mod tests;

pub use file::{DenoisedFile, denoise_file};
pub use filter::Filter;
pub use response::Response;
pub use spec::{Band, FilterSpec, Passes};
pub use summary::{DenoiseSummary, FilterOutcome, Sigmas};

use std::ops::Range;

use serde::Deserialize;

use crate::poses::gyro_unit::settle;
use crate::poses::rests::find_rests;
use crate::recording::{Finding, Recording};
use crate::{Error, Result};

use engine::{Done, Setup, run};
use even::{WHOLE_SHARE, whole_share};
use summary::{Scales, findings};

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
                .with_hint(format!("--filter with one of: {}", spec::EXAMPLES)));
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
    /// The channels that were filtered.
    pub channels: Channels,
}

/// Replaces the channels of a recording by filtered ones.
///
/// No filter runs across a break, a gap (a step longer than 10 usual steps) or a step back of the
/// time stamps. Empty cells stay empty, and the samples around them are filtered as if one were
/// lost. If time stamps are uneven (a step differs from the usual one by more than 5 % of it and
/// by more than the resolution of the time stamps), samples are interpolated to an even grid, and
/// the result back to the time stamps. Parts that are too short for a filter are left unchanged.
/// Each of these is reported as a finding.
///
/// # Errors
///
/// `no-filter`, `filter-range`, `rate-unknown` (usage); `no-gyroscope` (input) if only the
/// gyroscope is to be filtered and there is none.
pub fn denoise(mut recording: Recording, options: &DenoiseOptions) -> Result<Denoised> {
    options.validate()?;
    let (setup, mut begun) = begin(&mut recording, options)?;
    let done = filter_in_memory(&setup, &mut recording);
    begun
        .summary
        .finish(&setup, done, begun.scales, begun.duration_s);
    Ok(Denoised {
        summary: begun.summary,
        recording,
        channels: options.channels,
    })
}

/// What is known before the filters run.
struct Begun {
    summary: DenoiseSummary,
    scales: Scales,
    duration_s: Option<f64>,
}

/// Designs the filters, and determines the static intervals and the unit of the gyroscope.
fn begin(recording: &mut Recording, options: &DenoiseOptions) -> Result<(Setup, Begun)> {
    if options.channels == Channels::Gyro && recording.gyro.is_none() {
        return Err(
            Error::input("no-gyroscope", "the recording has no gyroscope")
                .at(std::path::Path::new(&recording.name), None)
                .with_hint("omit --channels, or name its columns with --columns"),
        );
    }
    let stills = find_rests(recording).spans;
    settle(recording, &stills);
    let mut setup = set_up(recording, options)?;
    let mut reach = 0;
    setup.at_rest.push(stills.clone());
    for filter in &setup.filters {
        // A filter spreads motion into the ends of a static interval.
        reach += filter.reach();
        setup.at_rest.push(inner_rows(&stills, reach));
    }
    let begun = Begun {
        summary: DenoiseSummary::start(recording, &stills),
        scales: Scales::of(recording),
        duration_s: recording.timing.duration_s,
    };
    Ok((setup, begun))
}

/// The filters for a recording; noise is not measured.
fn set_up(recording: &Recording, options: &DenoiseOptions) -> Result<Setup> {
    let step_s = recording.timing.rate_hz().map_or(1.0, f64::recip);
    let stamps = recording.time_s.as_ref();
    Ok(Setup {
        filters: design(recording, options)?,
        step_s,
        whole_share: stamps.map_or(WHOLE_SHARE, |t| whole_share(t, step_s)),
        channels: channels(recording.gyro.is_some(), options),
        at_rest: Vec::new(),
    })
}

fn design(recording: &Recording, options: &DenoiseOptions) -> Result<Vec<Filter>> {
    let rate_hz = recording.timing.rate_hz();
    let filters = options.filters.iter();
    filters.map(|spec| Filter::design(spec, rate_hz)).collect()
}

/// Numbers of the channels that are filtered.
fn channels(has_gyro: bool, options: &DenoiseOptions) -> Vec<usize> {
    let accel = (0..3).filter(|_| options.channels != Channels::Gyro);
    let gyro = (3..6).filter(|_| has_gyro && options.channels != Channels::Accel);
    accel.chain(gyro).collect()
}

/// Replaces the channels of a recording by filtered ones.
fn filter_in_memory(setup: &Setup, recording: &mut Recording) -> Done {
    let Recording {
        accel,
        gyro,
        time_s,
        breaks,
        ..
    } = recording;
    let mut channels: [Option<&mut [f64]>; 6] = Default::default();
    let columns = accel.iter_mut().chain(gyro.iter_mut().flatten());
    for (channel, column) in channels.iter_mut().zip(columns) {
        *channel = Some(column);
    }
    run(setup, time_s.as_deref(), breaks, &mut channels)
}

/// Filters the accelerometer of a recording that is to be integrated: the filtered recording, and
/// the findings. Noise is not measured.
///
/// # Errors
///
/// As [`denoise`].
pub(crate) fn smooth(
    mut recording: Recording,
    filters: &[FilterSpec],
) -> Result<(Recording, Vec<Finding>)> {
    let options = DenoiseOptions {
        channels: Channels::Accel,
        ..DenoiseOptions::new(filters.iter().copied())
    };
    options.validate()?;
    let setup = set_up(&recording, &options)?;
    let done = filter_in_memory(&setup, &mut recording);
    let duration_s = recording.timing.duration_s;
    let findings = findings(&setup, &done.treatments, &done.counts, duration_s);
    Ok((recording, findings))
}

/// The intervals without `reach` rows at both ends, if at least ten rows remain.
fn inner_rows(spans: &[Range<usize>], reach: usize) -> Vec<Range<usize>> {
    spans
        .iter()
        .map(|s| s.start + reach..s.end.saturating_sub(reach))
        .filter(|s| s.len() >= 10)
        .collect()
}
