//! Filters for recordings, and their effect on noise.
//!
//! # Overview
//!
//! A [`FilterSpec`] specifies a filter (`savgol:5,2`, `butter:4,5Hz` …), a [`Filter`] is designed
//! for a sampling rate, and [`denoise`] runs several filters over a recording: not across breaks
//! and gaps, over the time stamps if sampling is uneven, and around empty cells. It reports the
//! effect of each filter on white noise ([`Response`]) and on the noise of this recording at rest
//! ([`DenoiseSummary`]).
//!
//! - `savgol`, `gram`, `convolve`: polynomials over a window (Savitzky–Golay), and the moving
//!   average, which is the one of order 0.
//! - `butterworth`: second-order sections of `gravical-core`, one pass or two.
//! - `hampel`: outliers.
//! - `clock`, `grid`: uneven sampling.
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
//! assert!(step.response.noise_gain < 0.4);
//! assert_eq!(step.response.minus_3db_hz.as_deref(), Some(&[5.0][..]));
//! # Ok::<(), gravical::Error>(())
//! ```

mod butterworth;
mod clock;
mod convolve;
mod filter;
mod gram;
mod grid;
mod hampel;
mod parse;
mod response;
mod run;
mod savgol;
mod spec;
mod summary;
#[cfg(test)]
mod tests;
mod write;

pub(crate) use butterworth::Butterworth;
pub use filter::Filter;
pub use response::Response;
pub use savgol::Edge;
#[doc(hidden)]
pub use savgol::{causal_coefficients, coefficients};
pub use spec::{Band, FilterSpec, Passes};
#[doc(hidden)]
pub use spec::{MAX_POLYNOMIAL, MAX_WINDOW};
pub use summary::{DenoiseSummary, FilterOutcome, Sigmas};
pub use write::write;

use std::ops::Range;

use crate::recording::{Finding, Recording};
use crate::segment::gyro_unit::{Claims, Evidence, decide};
use crate::segment::still::{StillOptions, find_stills};
use crate::segment::turns::motions;
use crate::{Error, Result};

use run::Runner;
use summary::{filter_findings, row_findings};

/// The channels that are filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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
#[derive(Debug, Clone, Default)]
pub struct DenoiseOptions {
    /// The filters in the order in which they run; at least one.
    pub filters: Vec<FilterSpec>,
    /// Values beyond the ends, for filters with a window. Default: `Interp`.
    pub edge: Edge,
    /// The channels that are filtered. Default: all.
    pub channels: Channels,
    /// A step between time stamps longer than this many usual steps is a gap: filters restart
    /// after it. 1.5 to 1000. Default: 10, twice the window of the weakest smoothing.
    pub gap_steps: Option<f64>,
    /// Options for detecting the static intervals in which noise is measured.
    pub still: StillOptions,
}

impl DenoiseOptions {
    /// Default of [`gap_steps`](Self::gap_steps).
    pub const GAP_STEPS: f64 = 10.0;

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
    /// `no-filter`, `filter-range`, `option-range` (usage).
    pub fn validate(&self) -> Result<()> {
        if self.filters.is_empty() {
            return Err(Error::usage("no-filter", "no filter was given")
                .with_hint(format!("--filter with one of: {}", spec::EXAMPLES)));
        }
        self.filters.iter().try_for_each(FilterSpec::validate)?;
        let gap = self.gap_steps.unwrap_or(Self::GAP_STEPS);
        if !(1.5..=1000.0).contains(&gap) {
            return Err(Error::usage(
                "option-range",
                format!("gap_steps has to be between 1.5 and 1000, not {gap}"),
            ));
        }
        Ok(())
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
/// No filter runs across a break, a gap ([`DenoiseOptions::gap_steps`]) or a step back of the
/// time stamps. Empty cells stay empty, and the samples around them are filtered as if one were
/// lost. If time stamps are uneven (a step differs from the usual one by more than 5 % of it and
/// by more than the resolution of the time stamps), polynomials are fitted over the time stamps,
/// and for Butterworth filters samples are interpolated to an even grid. Parts that are too short
/// for a filter are left unchanged. Each of these is reported as a finding.
///
/// # Errors
///
/// `no-filter`, `filter-range`, `option-range`, `rate-unknown` (usage); `no-gyroscope` (input) if
/// only the gyroscope is to be filtered and there is none.
pub fn denoise(mut recording: Recording, options: &DenoiseOptions) -> Result<Denoised> {
    options.validate()?;
    if options.channels == Channels::Gyro && recording.gyro.is_none() {
        return Err(
            Error::input("no-gyroscope", "the recording has no gyroscope")
                .at(std::path::Path::new(&recording.name), None)
                .with_hint("omit --channels, or name its columns with --columns"),
        );
    }
    let rate_hz = recording.timing.rate_hz();
    let filters: Vec<Filter> = options
        .filters
        .iter()
        .map(|spec| Filter::design(spec, rate_hz, options.edge))
        .collect::<Result<_>>()?;
    let stills = find_stills(&recording, &options.still);
    decide_gyro_unit(&mut recording, &stills.spans);
    let runner = Runner::new(&recording, options);
    let mut summary = DenoiseSummary::start(&recording, options, &stills.spans);
    let (mut derivative, mut reach) = (0, 0);
    for filter in &filters {
        let treatment = runner.run(filter, &mut recording, options.channels);
        derivative += filter.spec().derivative();
        // A filter spreads motion into the ends of a static interval.
        reach += filter.reach();
        let inner = inner_rows(&stills.spans, reach);
        let sigma = Sigmas::of(&recording, options.channels, &inner);
        summary.add(filter, &treatment, sigma, derivative, &recording);
    }
    summary.finish(&runner, &recording);
    Ok(Denoised {
        recording,
        summary,
        channels: options.channels,
    })
}

/// The unit of the gyroscope by the rule of all commands, with its findings: the summary states
/// its noise in rad/s.
fn decide_gyro_unit(recording: &mut Recording, stills: &[Range<usize>]) {
    let mut findings = Vec::new();
    let scale = Claims::of(recording, None).map(|claims| {
        let moves = motions(recording, stills);
        decide(
            claims,
            &Evidence::of(recording, stills, &moves),
            &mut findings,
        )
    });
    if scale.is_some() {
        recording.gyro_scale = scale;
        recording.findings.extend(findings);
    }
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
    edge: Edge,
) -> Result<(Recording, Vec<Finding>)> {
    let options = DenoiseOptions {
        edge,
        channels: Channels::Accel,
        ..DenoiseOptions::new(filters.iter().copied())
    };
    options.validate()?;
    let rate_hz = recording.timing.rate_hz();
    let runner = Runner::new(&recording, &options);
    let mut findings = Vec::new();
    for spec in filters {
        let filter = Filter::design(spec, rate_hz, edge)?;
        let outcome = runner.run(&filter, &mut recording, Channels::Accel);
        let duration_s = recording.timing.duration_s;
        findings.extend(filter_findings(&filter, &outcome, rate_hz, duration_s));
    }
    findings.extend(row_findings(
        runner.splits,
        runner.clock.gap_s,
        runner.stamps_filled,
        runner.empty,
    ));
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
