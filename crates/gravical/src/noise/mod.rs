//! Noise of a sensor at rest: Allan deviation, and what it says.
//!
//! # Overview
//!
//! [`noise`] reads a recording of a sensor that lies still and returns for each channel the
//! overlapping Allan deviation with its 95 % intervals, the noise density N, the bias instability B
//! and the random walk K with theirs, or why the recording does not determine them.
//!
//! - `series`: rows to samples; the static intervals of [`crate::poses`], gaps, the temperature.
//! - `gravical_signal`: Allan variances, the fit of the model, the power spectral density.
//! - `result`: what is written, and data sheets. `words`: what it says.
//!
//! Everything is in SI units, converted by the nominal scale: 3 % of scale error are 3 % of N.
//!
//! It fails where noise is not what the model says: vibration of the place and drift with
//! temperature look like noise of the sensor. Both are reported, neither can be removed afterwards.
//!
//! # Example
//!
//! ```
//! use gravical::noise::noise_of_samples;
//! # let mut state = 1_u64;
//! # let mut uniform = move || {
//! #     state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
//! #     (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
//! # };
//!
//! // White noise of standard deviation 0.0289 at 100 Hz: N = 0.00289.
//! let samples: Vec<f64> = (0..50_000).map(|_| 0.1 * uniform()).collect();
//! let channel = noise_of_samples("ax", &samples, 0.01);
//! let n = channel.n.unwrap();
//! assert!(n.low < 0.00289 && 0.00289 < n.high);
//! assert!(channel.k.is_none());
//! ```

mod result;
mod series;
mod words;

use std::ops::Range;
use std::path::Path;

use gravical_signal::{
    BLOCK_S, NoiseFit, NoiseModel, NoisePoints, TermEstimate, allan_variances, block_len,
    chi_square_factors, density_ratio, fit_noise, quantile,
};
use serde::Deserialize;

use crate::calibration_file::{CHANNELS, InputFile};
use crate::finding::{Finding, finding};
use crate::poses::check_units;
use crate::poses::gyro_unit;
use crate::poses::rests::{find_quiet, find_rests, why_never_static};
use crate::recording::{self, ReadOptions, Recording};
use crate::stats::{floors, moments};
use crate::{Error, Result};

pub use gravical_signal::NoiseTerm as Term;
pub use result::{
    AllanPoint, ChannelNoise, DataSheet, DensityCheck, Estimate, FittedCurve, Misfit, NOISE_FORMAT,
    NoiseResult, NotObservable, PARTS, Part, TemperatureDrift, read_noise,
};
pub use words::{Unit, duration_text};

use series::{Pieces, scatter};

/// Shortest static interval whose noise is analysed, s.
const MIN_DURATION_S: f64 = 10.0;
/// Static intervals of less than this fraction of the longest one are left out: a hand lets go of the
/// sensor at the start of each.
const MIN_OF_LONGEST: f64 = 0.25;
/// A block whose standard deviation is this multiple of that of the median one is disturbed.
const DISTURBED: f64 = 3.0;
/// A line through the recording that is steeper than the largest noise that fits makes it, by this
/// many standard deviations, is a steady drift.
const STEADY_DRIFT: f64 = 3.0;

/// Options of [`noise`].
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct NoiseOptions {
    /// Compare with MPU6050, MPU9250 or ICM42688P
    #[serde(deserialize_with = "crate::option_text::optional")]
    #[cfg_attr(feature = "clap", arg(long, value_name = "PART"))]
    pub part: Option<Part>,
}

/// Analyses the noise of the recording at `path`; `-` is standard input.
///
/// # Errors
///
/// As [`read_samples`](crate::recording::read_samples); `unit-unknown`; `rate-unknown` (usage) without
/// time stamps and rate; `not-at-rest` without a static interval of ten seconds.
pub fn noise(path: &Path, read: &ReadOptions, options: &NoiseOptions) -> Result<NoiseResult> {
    noise_of(&recording::read_samples(path, read)?, options)
}

/// The same of a recording in memory.
///
/// # Errors
///
/// As [`noise`]; `averaged` (usage) if its rows are means of samples.
pub fn noise_of(recording: &Recording, options: &NoiseOptions) -> Result<NoiseResult> {
    recording.refuse_averaged("use `noise`, which reads the file")?;
    check_units(std::slice::from_ref(recording))?;
    let here = Path::new(&recording.name);
    let Some(accel_per_si) = recording.accel_scale.nominal() else {
        let what = "counts of unknown scale: the noise has no unit";
        return Err(Error::input("unit-unknown", what)
            .at(here, None)
            .with_hint("give the range in g")
            .advise("accel_range", "2"));
    };
    let (ranges, rate_hz) = used_ranges(recording)?;
    let width = block_len(1.0 / rate_hz, BLOCK_S);
    let max_variance = DISTURBED.powi(2) * quiet_variance(recording, &ranges, width);
    let mut pieces = Pieces::new(recording, &ranges, 1.0 / rate_hz);
    pieces.leave_out_disturbances(&recording.accel, width, max_variance);
    let mut findings = recording.findings.clone();
    let gyro_per_si = gyro_scale(recording, &mut findings);
    let period_s = pieces.period_s;
    let mut channels = Vec::new();
    let accel = recording.accel.iter().map(|c| (c, Some(accel_per_si)));
    let gyro = recording.gyro.iter().flatten().map(|c| (c, gyro_per_si));
    for (i, (column, per_si)) in accel.chain(gyro).enumerate() {
        let Some(per_si) = per_si else { continue };
        let column: Vec<f64> = column.iter().map(|v| v / per_si).collect();
        let segments = pieces.samples(&column);
        let mut channel = noise_of_segments(CHANNELS[i], &segments, period_s);
        if channel.adev.is_empty() {
            findings.push(finding!(
                NoiseChannelEmpty,
                "{}: hardly two samples follow each other; this channel is left out",
                channel.channel
            ));
            continue;
        }
        if let (Some(temperature_c), Some(_)) = (&recording.temperature_c, channel.fit) {
            let n = channel.n.map_or(0.0, |n| n.value);
            channel.temperature = pieces.temperature_drift(&column, temperature_c, n);
        }
        let step = recording.resolution[i] / per_si;
        let deviation = scatter(&segments, period_s);
        findings.extend(words::judge(&mut channel, step, deviation, period_s));
        channel.data_sheet = options.part.map(|part| part.data_sheet(&channel));
        channels.push(channel);
    }
    let counts = pieces.counts;
    findings.extend(words::of_recording(recording, &ranges, &counts, period_s));
    findings.extend(words::of_temperature(&channels, counts.temperature_c));
    let rows_s = recording.rows() as f64 * period_s;
    Ok(NoiseResult {
        format: NOISE_FORMAT.to_owned(),
        tool: crate::TOOL.to_owned(),
        inputs: InputFile::of(std::slice::from_ref(recording)),
        description: recording.description.clone(),
        rate_hz: 1.0 / period_s,
        recorded_s: recording.timing.duration_s.unwrap_or(rows_s),
        used_s: counts.used as f64 * period_s,
        static_intervals: ranges.len(),
        segments: counts.segments,
        temperature_c: counts.temperature_c,
        channels,
        findings: findings
            .into_iter()
            .map(|finding| finding.in_file(&recording.name))
            .collect(),
    })
}

/// Noise of one channel from samples in memory, `period_s` apart. Samples must be finite; a name that
/// begins with `g` is a gyroscope.
#[must_use]
pub fn noise_of_samples(channel: &str, samples: &[f64], period_s: f64) -> ChannelNoise {
    noise_of_segments(channel, &[samples.to_vec()], period_s)
}

/// The rows at rest that are used, and the sampling rate, Hz.
fn used_ranges(recording: &Recording) -> Result<(Vec<Range<usize>>, f64)> {
    let here = Path::new(&recording.name);
    let Some(rate_hz) = recording.timing.rate_hz() else {
        return Err(Error::usage(
            "rate-unknown",
            "there are no time stamps and no sampling rate: averaging times are unknown",
        )
        .at(here, None)
        .with_hint("give the rate in Hz")
        .advise("rate", "100"));
    };
    let mut ranges = find_quiet(recording);
    let longest = ranges.iter().map(Range::len).max().unwrap_or(0);
    let longest_s = longest as f64 / rate_hz;
    if longest_s < MIN_DURATION_S {
        let what = if longest == 0 {
            format!(
                "the sensor is never at rest: {}",
                why_never_static(recording)
            )
        } else {
            format!("the longest static interval takes {longest_s:.1} s")
        };
        return Err(Error::input(
            "not-at-rest",
            format!("{what}: noise is what a sensor shows while nothing moves"),
        )
        .at(here, None)
        .with_hint("record the sensor while it lies still, away from fans and footsteps, for two hours or more; ten seconds are the least"));
    }
    ranges.retain(|range| range.len() as f64 >= MIN_OF_LONGEST * longest as f64);
    Ok((ranges, rate_hz))
}

/// Variance of the accelerometer in the median block of `width` rows at rest, three axes together.
fn quiet_variance(recording: &Recording, rests: &[Range<usize>], width: usize) -> f64 {
    let starts = rests
        .iter()
        .flat_map(|rest| rest.clone().step_by(width).take(rest.len() / width));
    let variances = starts.map(|row| moments(&recording.accel, row..row + width).1);
    let rounding = floors(&recording.accel_resolution());
    quantile(variances.filter(|v| v.is_finite()).collect(), 0.5).max(rounding)
}

/// Units of the gyroscope per rad/s, by the rule of all commands; `None` without a gyroscope or if
/// its unit is unknown, which is a finding then.
fn gyro_scale(recording: &Recording, findings: &mut Vec<Finding>) -> Option<f64> {
    recording.gyro.as_ref().and(recording.gyro_scale)?;
    let nominal = gyro_unit::judge(recording, None, &find_rests(recording), findings)?.nominal();
    if nominal.is_none() {
        let unknown = finding!(
            GyroUnitUnknown,
            "the scale of the gyroscope is unknown: its noise is left out; give its unit, or its range"
        );
        findings.push(unknown.advise("gyro_unit", "").advise("gyro_range", ""));
    }
    nominal
}

/// The result of one channel, of segments of samples in SI units.
fn noise_of_segments(name: &str, segments: &[Vec<f64>], period_s: f64) -> ChannelNoise {
    let lengths: Vec<usize> = segments.iter().map(Vec::len).collect();
    let longest = lengths.iter().max().copied().unwrap_or(0);
    let octaves = (0..).map(|octave| 1_usize << octave);
    let octaves: Vec<usize> = octaves.take_while(|m| 2 * m <= longest).collect();
    let found = variances(segments, &octaves);
    let points = NoisePoints::new(&found, &lengths, period_s);
    let mut fit = fit_noise(&points);
    let drift = fit.is_some().then(|| slope(segments, longest)).flatten();
    let drift_per_s = drift.and_then(|slope| {
        let found = variances(&detrended(segments, slope), &octaves);
        let without = fit_noise(&NoisePoints::new(&found, &lengths, period_s))?;
        let variance = largest_model(&without).slope_variance(longest as f64 * period_s);
        let per_s = slope / period_s;
        let is_steady = per_s.abs() > STEADY_DRIFT * variance.sqrt();
        is_steady.then(|| {
            fit = Some(without);
            per_s
        })
    });
    // Without a fit, white noise: the distribution of the points has to be that of some noise.
    let white = NoiseModel {
        squares: [found.first().map_or(0.0, |o| o.1) * period_s, 0.0, 0.0],
    };
    let model = fit.as_ref().map_or(white, |fit| fit.model);
    let unit = if name.starts_with('g') {
        "rad/s"
    } else {
        "m/s^2"
    };
    let mut channel = ChannelNoise {
        channel: name.to_owned(),
        unit: unit.to_owned(),
        adev: allan_points(&found, &points.degrees_of_freedom(&model), period_s),
        ..ChannelNoise::default()
    };
    let Some(fit) = fit else {
        words::nothing_fitted(&mut channel, found.iter().any(|o| o.1 > 0.0));
        return channel;
    };
    take_estimates(&mut channel, &fit, longest as f64 * period_s);
    channel.fit = Some(FittedCurve {
        from_s: fit.from_s,
        parameters: model.squares.map(f64::sqrt),
        drift_per_s,
        misfit: fit.misfit.map(|(tau_s, ratio)| Misfit { tau_s, ratio }),
    });
    let density = density_ratio(segments, period_s, |hz| model.density(hz));
    channel.density = density.map(|density| DensityCheck {
        n: (model.squares[Term::N as usize] * density.ratio).sqrt(),
        band_hz: density.band_hz,
        ratio: density.ratio,
        ratio_sd: density.sd,
    });
    channel
}

/// Averaging times in samples, and Allan variances.
fn variances(segments: &[Vec<f64>], factors: &[usize]) -> Vec<(usize, f64)> {
    let variances = allan_variances(segments, factors);
    variances.iter().map(|v| (v.m, v.variance)).collect()
}

/// Slope of the line fitted to the first segment of this length, per sample; `None` with fewer than
/// three samples.
fn slope(segments: &[Vec<f64>], length: usize) -> Option<f64> {
    let segment = segments.iter().find(|s| s.len() == length && length > 2)?;
    let middle = 0.5 * (length as f64 - 1.0);
    let offsets = || (0..length).map(|k| k as f64 - middle);
    let reference = segment[0];
    let products = offsets().zip(segment).map(|(k, v)| k * (v - reference));
    Some(products.sum::<f64>() / offsets().map(|k| k * k).sum::<f64>())
}

/// The segments without a slope per sample.
fn detrended(segments: &[Vec<f64>], slope: f64) -> Vec<Vec<f64>> {
    let without = |segment: &Vec<f64>| -> Vec<f64> {
        let samples = segment.iter().enumerate();
        samples.map(|(k, value)| value - slope * k as f64).collect()
    };
    segments.iter().map(without).collect()
}

/// The model with each term at its upper limit.
fn largest_model(fit: &NoiseFit) -> NoiseModel {
    let squares = fit.estimates.map(|estimate| match estimate {
        TermEstimate::Known { high, .. } => high * high,
        TermEstimate::Unknown { at_most, .. } => {
            at_most.map_or(f64::INFINITY, |limit| limit * limit)
        }
    });
    NoiseModel { squares }
}

fn allan_points(points: &[(usize, f64)], freedom: &[f64], period_s: f64) -> Vec<AllanPoint> {
    let with_interval = |((m, variance), edf): (&(usize, f64), &f64)| {
        let sigma = variance.sqrt();
        let [low, high] = chi_square_factors(*edf).filter(|_| sigma.is_finite())?;
        Some(AllanPoint {
            tau_s: *m as f64 * period_s,
            sigma,
            low: sigma * low,
            high: sigma * high,
            edf: *edf,
        })
    };
    points
        .iter()
        .zip(freedom)
        .filter_map(with_interval)
        .collect()
}

fn take_estimates(channel: &mut ChannelNoise, fit: &NoiseFit, longest_s: f64) {
    for (term, estimate) in Term::ALL.into_iter().zip(fit.estimates) {
        match estimate {
            TermEstimate::Known { value, low, high } => {
                let place = match term {
                    Term::N => &mut channel.n,
                    Term::B => &mut channel.b,
                    Term::K => &mut channel.k,
                };
                *place = Some(Estimate { value, low, high });
            }
            TermEstimate::Unknown { at_most, record_s } => {
                channel.not_observable.push(NotObservable {
                    term: term.symbol().to_owned(),
                    reason: words::not_observable(longest_s, record_s),
                    at_most,
                    record_s,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests;
