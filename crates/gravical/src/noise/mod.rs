//! Noise of a sensor at rest: Allan deviation, and what it says.
//!
//! # Overview
//!
//! [`noise`] reads a recording of a sensor that lies still and returns for each channel the
//! overlapping Allan deviation with its 95 % intervals, the noise density N, the bias instability B
//! and the random walk K with theirs, or why the recording does not determine them.
//!
//! - `series`: rows to samples; the static intervals of [`crate::poses`], gaps.
//! - `gravical_signal`: Allan variances, the fit of the model.
//! - `result`: what is written.
//!
//! Everything is in SI units, converted by the nominal scale: 3 % of scale error are 3 % of N.
//!
//! It fails where noise is not what the model says: vibration of the place and drift with
//! temperature look like noise of the sensor. Neither can be removed afterwards.
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
//! let channel = noise_of_samples("ax", &samples, 0.01, 0.0);
//! let n = channel.n.unwrap();
//! assert!(n.low < 0.00289 && 0.00289 < n.high);
//! assert!(channel.k.is_none());
//! ```

mod result;
mod series;

use std::ops::Range;
use std::path::Path;

use gravical_signal::{
    AllanVariance, BLOCK_S, NoiseFit, NoiseModel, NoisePoints, TermEstimate, allan_variances,
    block_len, chi_square_factors, fit_noise,
};

use crate::Result;
use crate::calibration_file::{CHANNELS, InputFile, TemperatureRange};
use crate::finding::{Case, Finding, LineSpans, RecordingCase, hidden};
use crate::numfmt::{self, duration_text};
use crate::poses::check_units;
use crate::poses::gyro_unit::settle;
use crate::poses::rests::{find_quiet, why_never_static};
use crate::problem::Problem;
use crate::recording::{self, ReadOptions, Recording, nominal_accel};
use crate::rounding;
use crate::stats::pooled_deviation;

pub use gravical_signal::NoiseTerm as Term;
pub use result::{
    AllanPoint, ChannelNoise, Estimate, FittedCurve, Misfit, NOISE_FORMAT, NoiseResult,
    NotObservable, Unit, read_noise,
};

use series::Pieces;

/// Shortest static interval whose noise is analysed, s.
const MIN_DURATION_S: f64 = 10.0;
/// Static intervals of less than this fraction of the longest one are left out: a hand lets go of the
/// sensor at the start of each.
const MIN_OF_LONGEST: f64 = 0.25;
/// A line through the recording that is steeper than the largest noise that fits makes it, by this
/// many standard deviations, is a steady drift.
const STEADY_DRIFT: f64 = 3.0;
/// Length of the means about which samples scatter, s.
const MEAN_S: f64 = 1.0;
/// Noise before rounding below this fraction of the resolution does not average it away
/// ([`rounding`]).
const MIN_OF_RESOLUTION: f64 = 0.34;
/// Change of the temperature beyond which the drift of the bias, up to 1 mg per °C, is more than the bias
/// instability of most sensors, °C.
const MAX_CHANGE_C: f64 = 1.0;

/// Analyses the noise of the recording at `path`; `-` is standard input.
///
/// # Errors
///
/// As [`read_samples`](crate::recording::read_samples); `unit-unknown`; `rate-unknown` (usage) without
/// time stamps and rate; `not-at-rest` without a static interval of ten seconds.
pub fn noise(path: impl AsRef<Path>, read: &ReadOptions) -> Result<NoiseResult> {
    let path = path.as_ref();
    noise_of(recording::read_samples(path, read)?)
}

/// The same of a recording in memory.
///
/// # Errors
///
/// As [`noise`]; `averaged` (usage) if its rows are means of samples.
pub fn noise_of(mut recording: Recording) -> Result<NoiseResult> {
    recording.refuse_averaged("use `noise`, which reads the file")?;
    check_units(std::slice::from_ref(&recording))?;
    let accel_per_si = nominal_accel(&recording)?;
    let (ranges, rate_hz) = used_ranges(&recording)?;
    settle(&mut recording);
    let mut pieces = Pieces::new(&recording, &ranges, 1.0 / rate_hz);
    let width = block_len(1.0 / rate_hz, BLOCK_S);
    pieces.leave_out_disturbances(&recording.accel, &recording.units.resolution[0], width);
    let period_s = pieces.period_s;
    let mut findings = recording.findings.clone();
    let gyro_per_si = recording.units.gyro.and_then(|scale| scale.nominal());
    if recording.gyro.is_some() && gyro_per_si.is_none() {
        let unknown = Case::GyroNoiseLeftOut.finding();
        findings.push(unknown.advise("gyro_unit", "").advise("gyro_range", ""));
    }
    let mut channels = Vec::new();
    // Of the channel with most gaps.
    let mut segment_count = 0;
    let accel = recording.accel.iter().map(|c| (c, Some(accel_per_si)));
    let gyro = recording.gyro.iter().flatten().map(|c| (c, gyro_per_si));
    for (i, (column, per_si)) in accel.chain(gyro).enumerate() {
        let Some(per_si) = per_si else { continue };
        let column: Vec<f64> = column.iter().map(|v| v / per_si).collect();
        let segments = pieces.samples(&column);
        segment_count = segment_count.max(segments.len() as u64);
        let mut channel = noise_of_segments(CHANNELS[i], &segments, period_s);
        if channel.adev.is_empty() {
            let channel = channel.channel;
            findings.push(RecordingCase::NoNeighbours { channel }.finding());
            continue;
        }
        let step = recording.units.resolution[i / 3][i % 3] / per_si;
        let hidden = hide_below_resolution(&mut channel, &segments, step, period_s);
        findings.extend(hidden);
        findings.extend(channel_findings(&channel));
        channels.push(channel);
    }
    let rows_s = recording.rows() as f64 * period_s;
    let temperature = recording.temperature_c.as_deref();
    let temperature = temperature.and_then(|t_c| {
        let used = pieces.rows().map(|row| t_c[row]);
        TemperatureRange::of(used.filter(|t| t.is_finite()))
    });
    findings.extend(of_rests(&recording, &ranges, period_s));
    let changed_c = temperature.as_ref().map(TemperatureRange::span_c);
    if let Some(changed_c) = changed_c.filter(|changed_c| *changed_c > MAX_CHANGE_C) {
        findings.push(Case::NoiseTemperature { changed_c }.finding());
    }
    let in_file = findings.into_iter().map(|f| f.in_file(&recording.name));
    Ok(NoiseResult {
        format: NOISE_FORMAT.to_owned(),
        tool: crate::TOOL.to_owned(),
        inputs: InputFile::of(std::slice::from_ref(&recording)),
        description: recording.format.describe(),
        rate_hz: 1.0 / period_s,
        recorded_s: recording.clock.duration_s.unwrap_or(rows_s),
        used_s: pieces.rows().count() as f64 * period_s,
        static_intervals: ranges.len(),
        segments: segment_count,
        temperature_c: temperature.map(|range| [range.min, range.max]),
        channels,
        findings: in_file.collect(),
    })
}

/// Noise of one channel from samples in memory, `period_s` apart, in steps of `step`, 0 if unknown.
/// Samples must be finite; a name that begins with `g` is a gyroscope.
#[doc(hidden)]
pub fn noise_of_samples(channel: &str, samples: &[f64], period_s: f64, step: f64) -> ChannelNoise {
    let segments = [samples.to_vec()];
    let mut channel = noise_of_segments(channel, &segments, period_s);
    hide_below_resolution(&mut channel, &segments, step, period_s);
    channel
}

/// The rows at rest that are used, and the sampling rate, Hz.
fn used_ranges(recording: &Recording) -> Result<(Vec<Range<usize>>, f64)> {
    let here = Path::new(&recording.name);
    let Some(rate_hz) = recording.clock.rate_hz() else {
        let error = Problem::NoiseWithoutRate.error().at(here, None);
        return Err(error.advise("rate", ""));
    };
    let mut ranges = find_quiet(recording);
    let longest = ranges.iter().map(Range::len).max().unwrap_or(0);
    let longest_s = longest as f64 / rate_hz;
    if longest_s < MIN_DURATION_S {
        let problem = match longest {
            0 => Problem::NeverAtRest {
                why: why_never_static(recording),
            },
            _ => Problem::ShortRest { longest_s },
        };
        return Err(problem.error().at(here, None));
    }
    ranges.retain(|range| range.len() as f64 >= MIN_OF_LONGEST * longest as f64);
    Ok((ranges, rate_hz))
}

/// The result of one channel, of segments of samples in SI units.
fn noise_of_segments(name: &str, segments: &[Vec<f64>], period_s: f64) -> ChannelNoise {
    let lengths: Vec<usize> = segments.iter().map(Vec::len).collect();
    let longest = lengths.iter().max().copied().unwrap_or(0);
    let octaves = (0..).map(|octave| 1_usize << octave);
    let octaves: Vec<usize> = octaves.take_while(|m| 2 * m <= longest).collect();
    let variances = allan_variances(segments, &octaves);
    let points = NoisePoints::new(&variances, &lengths, period_s);
    let mut fit = fit_noise(&points);
    let line = fit.as_ref().and_then(|_| without_slope(segments, longest));
    let drift_per_s = line.and_then(|(slope, rest)| {
        let variances = allan_variances(&rest, &octaves);
        let without = fit_noise(&NoisePoints::new(&variances, &lengths, period_s))?;
        let variance = largest_model(&without).slope_variance(longest as f64 * period_s);
        let per_s = slope / period_s;
        let is_steady = per_s.abs() > STEADY_DRIFT * variance.sqrt();
        is_steady.then(|| {
            fit = Some(without);
            per_s
        })
    });
    // Without a fit the distribution of the points has to be that of some noise.
    let model = fit.as_ref().map_or(NoiseModel::WHITE, |fit| fit.model);
    let freedom = points.degrees_of_freedom(&model);
    let point = |(v, edf): (&AllanVariance, f64)| {
        let sigma = v.variance.sqrt();
        let [low, high] = chi_square_factors(edf).filter(|_| sigma.is_finite())?;
        Some(AllanPoint {
            tau_s: v.m as f64 * period_s,
            sigma,
            low: sigma * low,
            high: sigma * high,
            edf,
        })
    };
    let is_gyroscope = name.starts_with('g');
    let mut channel = ChannelNoise {
        channel: name.to_owned(),
        unit: if is_gyroscope { "rad/s" } else { "m/s^2" }.to_owned(),
        adev: variances.iter().zip(freedom).filter_map(point).collect(),
        ..ChannelNoise::default()
    };
    let Some(fit) = fit else {
        let reason = if variances.iter().any(|v| v.variance > 0.0) {
            "the values change too rarely for any averaging time to show noise"
        } else {
            "the values do not change: the noise is below the resolution"
        };
        channel.not_observable = none_observable(reason, None);
        return channel;
    };
    take_estimates(&mut channel, &fit, longest as f64 * period_s);
    channel.fit = Some(FittedCurve {
        from_s: fit.from_s,
        parameters: model.squares.map(f64::sqrt),
        drift_per_s,
        misfit: fit.misfit.map(|(tau_s, ratio)| Misfit { tau_s, ratio }),
    });
    channel
}

/// Slope per sample of the line fitted to the first segment of the length `longest`, and all segments without
/// it; `None` with fewer than three samples.
fn without_slope(segments: &[Vec<f64>], longest: usize) -> Option<(f64, Vec<Vec<f64>>)> {
    let segment = segments
        .iter()
        .find(|s| s.len() == longest && longest > 2)?;
    let middle = 0.5 * (longest as f64 - 1.0);
    let offsets = || (0..longest).map(|k| k as f64 - middle);
    let reference = segment[0];
    let products = offsets().zip(segment).map(|(k, v)| k * (v - reference));
    let slope = products.sum::<f64>() / offsets().map(|k| k * k).sum::<f64>();
    let without = |segment: &Vec<f64>| -> Vec<f64> {
        let samples = segment.iter().enumerate();
        samples.map(|(k, value)| value - slope * k as f64).collect()
    };
    Some((slope, segments.iter().map(without).collect()))
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

fn take_estimates(channel: &mut ChannelNoise, fit: &NoiseFit, longest_s: f64) {
    let places = [&mut channel.n, &mut channel.b, &mut channel.k];
    for ((term, place), estimate) in Term::ALL.into_iter().zip(places).zip(fit.estimates) {
        match estimate {
            TermEstimate::Known { value, low, high } => {
                *place = Some(Estimate { value, low, high });
            }
            TermEstimate::Unknown { at_most, record_s } => {
                let what = format!("not observable in {}", duration_text(longest_s));
                let reason = match record_s {
                    Some(s) => format!("{what}: record at least {}", duration_text(s)),
                    None => format!("{what}, nor in a thousand times that"),
                };
                channel.not_observable.push(NotObservable {
                    term: term.symbol().to_owned(),
                    reason,
                    at_most,
                    record_s,
                });
            }
        }
    }
}

/// All terms, for one reason; `n_at_most` limits N.
fn none_observable(reason: &str, n_at_most: Option<f64>) -> Vec<NotObservable> {
    let missing = |term: Term| NotObservable {
        term: term.symbol().to_owned(),
        reason: reason.to_owned(),
        at_most: n_at_most.filter(|_| term == Term::N),
        record_s: None,
    };
    Term::ALL.map(missing).into()
}

/// Takes noise below the resolution `step` out of the result.
fn hide_below_resolution(
    channel: &mut ChannelNoise,
    segments: &[Vec<f64>],
    step: f64,
    period_s: f64,
) -> Option<Finding> {
    let length = (MEAN_S / period_s).max(2.0) as usize;
    let deviation = pooled_deviation(segments.iter().flat_map(|s| s.chunks(length)));
    let rounding = rounding::floor(step);
    let before = (deviation * deviation - rounding).max(0.0).sqrt();
    if step <= 0.0 || before >= MIN_OF_RESOLUTION * step {
        return None;
    }
    let unit = numfmt::unit(&channel.unit);
    let reason = hidden(step, &unit);
    let most = (MIN_OF_RESOLUTION * step).hypot(rounding.sqrt()) * period_s.sqrt();
    (channel.n, channel.b, channel.k, channel.fit) = (None, None, None, None);
    channel.not_observable = none_observable(&reason, Some(most));
    let channel = channel.channel.clone();
    Some(
        Case::NoiseBelowResolution {
            channel,
            step,
            unit,
        }
        .finding(),
    )
}

/// What is odd about the fit of a channel.
fn channel_findings(channel: &ChannelNoise) -> Vec<Finding> {
    let (name, mut findings) = (&channel.channel, Vec::new());
    if let Some(misfit) = channel.fit.and_then(|fit| fit.misfit) {
        let case = Case::NoiseMisfit {
            channel: name.clone(),
            tau_s: misfit.tau_s,
            ratio: misfit.ratio,
        };
        findings.push(case.finding());
    }
    if let Some(drift_per_s) = channel.fit.and_then(|fit| fit.drift_per_s) {
        let unit = Unit::of(Term::B, channel.is_gyroscope());
        let case = Case::NoiseDrift {
            channel: name.clone(),
            drift_per_hour: unit.factor * 3600.0 * drift_per_s,
            unit: unit.name,
        };
        findings.push(case.finding());
    }
    findings
}

/// That the sensor moved, where it was not at rest all the time.
fn of_rests(recording: &Recording, ranges: &[Range<usize>], period_s: f64) -> Option<Finding> {
    let rows = recording.rows();
    let rest: usize = ranges.iter().map(Range::len).sum();
    if rest as f64 >= 0.95 * rows as f64 {
        return None;
    }
    let mut lines = LineSpans::default();
    for range in ranges {
        let (from, to) = (recording.line(range.start), recording.line(range.end - 1));
        lines.push_range(from, to, range.len() as u64);
    }
    let case = Case::NoiseFromRests {
        intervals: ranges.len(),
        rest_s: rest as f64 * period_s,
        recorded_s: rows as f64 * period_s,
    };
    Some(case.finding().at_lines(&lines))
}

#[cfg(test)]
mod tests;
