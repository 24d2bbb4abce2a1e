//! Filters over recordings, and what they do to noise.
//!
//! # Overview
//!
//! A [`FilterSpec`] says which filter (`savgol:5,2`, `butter:4,5Hz` …), a [`Filter`]
//! is one that is ready for a sampling rate, [`denoise`] runs several over a
//! recording: between breaks and gaps only, over the stamps where sampling is
//! uneven, around empty cells. It says what each does to white noise ([`Response`])
//! and what it did to the noise of this recording at rest ([`DenoiseSummary`]).
//!
//! - `savgol`, `gram`, `convolve`: polynomials over a window (Savitzky–Golay), and the
//!   moving average, which is the one of order 0.
//! - `butterworth`: second-order sections of `gravical-core`, one pass or two.
//! - `hampel`: outliers.
//! - `clock`, `grid`: what is even, what is not, and what is done about it.
//!
//! Smoothing makes plots readable. It does not make integration better: noise that
//! is smoothed away would have averaged out in the integral, and an offset passes
//! every low-pass unchanged.
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
pub use savgol::{Edge, causal_coefficients, coefficients};
pub use spec::{Band, FilterSpec, MAX_POLYNOMIAL, MAX_WINDOW, Passes};
pub use summary::{DenoiseSummary, FilterOutcome, Sigmas};
pub use write::write;

use std::ops::Range;

use crate::recording::{Finding, Recording};
use crate::segment::still::{StillOptions, find_stills};
use crate::{Error, Result};

use run::Runner;
use summary::{told_of_filter, told_of_rows};

/// Which channels are filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Channels {
    /// The accelerometer's three.
    Accel,
    /// The gyroscope's three.
    Gyro,
    /// All that there are. The default.
    #[default]
    All,
}

/// How a recording is filtered.
#[derive(Debug, Clone, Default)]
pub struct DenoiseOptions {
    /// The filters in the order in which they run; at least one.
    pub filters: Vec<FilterSpec>,
    /// What stands beyond the ends, for filters with a window. Default: `Interp`.
    pub edge: Edge,
    /// Which channels are filtered. Default: all.
    pub channels: Channels,
    /// A step between stamps that is longer than this many usual steps parts the
    /// recording: filters start anew behind it. 1.5 to 1000. Default: 10, twice the
    /// window of the least smoothing.
    pub gap_steps: Option<f64>,
    /// How the spans at rest are found that noise is measured in.
    pub still: StillOptions,
}

impl DenoiseOptions {
    /// Usual steps that a gap is longer than, unless said otherwise.
    pub const GAP_STEPS: f64 = 10.0;

    /// These filters, all else by default.
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
    /// As it was, its channels filtered; its findings are those of reading.
    pub recording: Recording,
    /// What was done, with all findings.
    pub summary: DenoiseSummary,
    /// Which channels were filtered.
    pub channels: Channels,
}

/// Filters the channels of a recording in place of themselves.
///
/// No filter runs across a break, a gap ([`DenoiseOptions::gap_steps`]) or a stamp
/// that runs backwards. Empty cells stay empty, and what follows is filtered as
/// samples with one missing. Where stamps are uneven (a step that differs from the
/// usual one by more than 5 % of it and by more than the last digit of the stamps),
/// polynomials are fitted over the stamps, and for Butterworth filters samples are
/// put onto an even grid. Stretches that are too short for a filter stay as they are.
/// Each of these is a finding.
///
/// # Errors
///
/// `no-filter`, `filter-range`, `option-range`, `rate-unknown` (usage);
/// `no-gyroscope` (input) when only a gyroscope shall be filtered that is not there.
pub fn denoise(mut recording: Recording, options: &DenoiseOptions) -> Result<Denoised> {
    options.validate()?;
    if options.channels == Channels::Gyro && recording.gyro.is_none() {
        return Err(
            Error::input("no-gyroscope", "the recording has no gyroscope")
                .at(std::path::Path::new(&recording.name), None)
                .with_hint("leave --channels out, or name its columns with --columns"),
        );
    }
    let rate_hz = recording.timing.rate_hz();
    let filters: Vec<Filter> = options
        .filters
        .iter()
        .map(|spec| Filter::design(spec, rate_hz, options.edge))
        .collect::<Result<_>>()?;
    let stills = find_stills(&recording, &options.still);
    let runner = Runner::new(&recording, options);
    let mut summary = DenoiseSummary::start(&recording, options, &stills.spans);
    let (mut derivative, mut reach) = (0, 0);
    for filter in &filters {
        let treated = runner.run(filter, &mut recording, options.channels);
        derivative += filter.spec().derivative();
        // Motion around a rest is spread into its ends.
        reach += filter.reach();
        let inner = inner_rows(&stills.spans, reach);
        let sigma = Sigmas::of(&recording, options.channels, &inner);
        summary.add(filter, &treated, sigma, derivative, &recording);
    }
    summary.finish(&runner, &recording);
    Ok(Denoised {
        recording,
        summary,
        channels: options.channels,
    })
}

/// The same for the accelerometer of a recording that is integrated: the recording
/// filtered, and what is odd about that. Noise is not measured.
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
        findings.extend(told_of_filter(&filter, &outcome, rate_hz, duration_s));
    }
    findings.extend(told_of_rows(
        runner.parted,
        runner.clock.gap_s,
        runner.stamps_filled,
        runner.empty,
    ));
    Ok((recording, findings))
}

/// The spans without `reach` rows at both ends, those that keep ten rows and more.
fn inner_rows(spans: &[Range<usize>], reach: usize) -> Vec<Range<usize>> {
    spans
        .iter()
        .map(|s| s.start + reach..s.end.saturating_sub(reach))
        .filter(|s| s.len() >= 10)
        .collect()
}
