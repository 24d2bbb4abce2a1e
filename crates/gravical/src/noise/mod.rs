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

use std::f64::consts::PI;
use std::ops::Range;
use std::path::Path;

use gravical_signal::{
    AllanVariance, BLOCK_S, NoiseFit, NoiseModel, NoisePoints, TermEstimate, allan_variances,
    block_len, chi_square_factors, find_slow, fit_noise,
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
    AllanPoint, ChannelNoise, Drift, Estimate, FittedCurve, Misfit, NOISE_FORMAT, NoiseResult,
    NotObservable, Unit, read_noise,
};

use series::Pieces;

/// Shortest static interval whose noise is analysed, s.
const MIN_DURATION_S: f64 = 10.0;
/// Static intervals of less than this fraction of the longest one are left out: a hand lets go of the
/// sensor at the start of each.
const MIN_OF_LONGEST: f64 = 0.25;
/// Length of the means about which samples scatter, s.
const MEAN_S: f64 = 1.0;
/// Noise before rounding below this fraction of the resolution is known only to a factor: it depends on
/// where between two steps the truth lies.
const MIN_OF_RESOLUTION: f64 = 0.4;
/// Change of the temperature beyond which the drift of the bias, up to 1 mg per °C, is more than the bias
/// instability of most sensors, °C.
const MAX_CHANGE_C: f64 = 1.0;
/// Why N is not seen, however long the recording.
const HIDDEN_N: &str = "not visible: no averaging time is beyond the low-pass and below the wander of the bias; set a wider low-pass and a faster rate";
/// Why K is not given where a trend explains the recording as well.
const LIKE_A_TREND: &str =
    "a drift of the bias explains it as well; record at constant temperature, and for longer";

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
        let step = recording.units.resolution[i / 3][i % 3] / per_si;
        let (channel, hidden) = noise_of_segments(CHANNELS[i], &segments, step, period_s);
        if channel.adev.is_empty() {
            let channel = channel.channel;
            findings.push(RecordingCase::NoNeighbours { channel }.finding());
            continue;
        }
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
    noise_of_segments(channel, &[samples.to_vec()], step, period_s).0
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

/// The result of one channel, of segments of samples in SI units, in steps of `step`; and that the
/// steps hide the noise.
fn noise_of_segments(
    name: &str,
    segments: &[Vec<f64>],
    step: f64,
    period_s: f64,
) -> (ChannelNoise, Option<Finding>) {
    let is_gyroscope = name.starts_with('g');
    let unit = if is_gyroscope { "rad/s" } else { "m/s^2" };
    let mut channel = ChannelNoise {
        channel: name.to_owned(),
        unit: unit.to_owned(),
        ..ChannelNoise::default()
    };
    let rounding = Rounding::of(segments, step, period_s);
    let longest = segments.iter().map(Vec::len).max().unwrap_or(0);
    let longest_s = longest as f64 * period_s;
    let first = segments.iter().position(|s| s.len() == longest);
    let slow = first.map_or_else(Default::default, |first| find_slow(&segments[first]));
    let without_trend: Vec<Vec<f64>> = slow.trend.map_or_else(Vec::new, |trend| {
        let without = |segment: &Vec<f64>| -> Vec<f64> {
            let samples = segment.iter().enumerate();
            samples
                .map(|(k, value)| value - trend.at(k as f64))
                .collect()
        };
        // The exponential has decayed to an unknown part in the others.
        let kept = segments.iter().enumerate();
        let kept = kept.filter(|(i, _)| trend.size == 0.0 || Some(*i) == first);
        kept.map(|(_, segment)| without(segment)).collect()
    });
    let segments = if slow.trend.is_some() {
        &without_trend[..]
    } else {
        segments
    };
    let lengths: Vec<usize> = segments.iter().map(Vec::len).collect();
    let octaves = (0..).map(|octave| 1_usize << octave);
    let octaves: Vec<usize> = octaves.take_while(|m| 2 * m <= longest).collect();
    let mut variances = allan_variances(segments, &octaves);
    variances.iter_mut().for_each(|v| rounding.take_off(v));
    let points = NoisePoints::new(&variances, &lengths, period_s);
    let fit = fit_noise(&points).filter(|_| !rounding.hides());
    // Without a fit the distribution of the points has to be that of some noise.
    let squares = fit
        .as_ref()
        .map_or(NoiseModel::WHITE.squares, |fit| fit.model.squares);
    let model = NoiseModel { squares, edge: 0.0 };
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
    let freedom = points.degrees_of_freedom(&model);
    channel.adev = variances.iter().zip(freedom).filter_map(point).collect();
    let is_constant = variances.iter().all(|v| v.variance <= 0.0);
    if rounding.hides() && !is_constant {
        let unit = numfmt::unit(unit);
        let most = rounding.most() * period_s.sqrt();
        channel.not_observable = none_observable(&hidden(step, &unit), Some(most));
        let channel_name = name.to_owned();
        let case = Case::NoiseBelowResolution {
            channel: channel_name,
            step,
            unit,
        };
        return (channel, Some(case.finding()));
    }
    let Some(fit) = fit else {
        let reason = match is_constant {
            true => "the values do not change: the noise is below the resolution",
            false => "the values change too rarely for any averaging time to show noise",
        };
        channel.not_observable = none_observable(reason, None);
        return (channel, None);
    };
    take_estimates(&mut channel, &fit, longest_s, slow.walks);
    if let Some(n) = &mut channel.n {
        let off = rounding.off();
        (n.low, n.high) = (n.low * (1.0 - off), n.high * (1.0 + off));
    }
    let drift = slow.trend.map(|trend| Drift {
        change: trend.at(longest as f64) - trend.at(0.0),
        during_s: longest_s,
        time_constant_s: Some(trend.constant * period_s).filter(|s| s.is_finite()),
    });
    channel.fit = Some(FittedCurve {
        from_s: fit.from_s,
        parameters: model.squares.map(f64::sqrt),
        drift,
        misfit: fit.misfit.map(|(tau_s, ratio)| Misfit { tau_s, ratio }),
    });
    (channel, None)
}

/// What rounding to steps does to noise. Its errors are white with a variance of q²/12 where the noise
/// spreads over several steps (Widrow and Kollár, *Quantization Noise*, 2008, chapter 4).
struct Rounding {
    /// q, 0 where unknown
    step: f64,
    /// Variance of the samples about their means over [`MEAN_S`], less q²/12
    before: f64,
}

impl Rounding {
    fn of(segments: &[Vec<f64>], step: f64, period_s: f64) -> Self {
        let length = (MEAN_S / period_s).max(2.0) as usize;
        let deviation = pooled_deviation(segments.iter().flat_map(|s| s.chunks(length)));
        let before = (deviation * deviation - rounding::floor(step)).max(0.0);
        Rounding { step, before }
    }

    fn hides(&self) -> bool {
        self.step > 0.0 && self.before < (MIN_OF_RESOLUTION * self.step).powi(2)
    }

    /// The largest standard deviation that may be hidden.
    fn most(&self) -> f64 {
        (MIN_OF_RESOLUTION * self.step).hypot(rounding::floor(self.step).sqrt())
    }

    /// Takes it off, at most its share: an Allan variance of few degrees of freedom stays above zero.
    fn take_off(&self, point: &mut AllanVariance) {
        let rounding = rounding::floor(self.step);
        if rounding > 0.0 && !self.hides() {
            let share = rounding / (rounding + self.before);
            point.variance -= (rounding / point.m as f64).min(share * point.variance);
        }
    }

    /// How far off N may be, relative: with s = σ/q, the first terms of what the errors have in common
    /// with the noise, 4 exp(−2π²s²), and of their variance, over s², for the worst level between two
    /// steps. s itself is too large by that.
    fn off(&self) -> f64 {
        if self.step <= 0.0 {
            return 0.0;
        }
        let seen = self.before.sqrt() / self.step;
        let off = |s: f64| {
            let square = (PI * s).powi(2);
            0.5 * (-2.0 * square).exp() * (4.0 + 1.0 / square)
        };
        (0..8).fold(0.0, |last: f64, _| off(seen / (1.0 + last)).min(1.0))
    }
}

fn take_estimates(channel: &mut ChannelNoise, fit: &NoiseFit, longest_s: f64, walks: bool) {
    let is_filtered = fit.model.edge != 0.0;
    let places = [&mut channel.n, &mut channel.b, &mut channel.k];
    for ((term, place), estimate) in Term::ALL.into_iter().zip(places).zip(fit.estimates) {
        let what = format!("not observable in {}", duration_text(longest_s));
        let (at_most, record_s, reason) = match estimate {
            TermEstimate::Known { high, .. } if term == Term::K && !walks => {
                (Some(high), None, format!("{what}: {LIKE_A_TREND}"))
            }
            TermEstimate::Known { value, low, high } => {
                *place = Some(Estimate { value, low, high });
                continue;
            }
            TermEstimate::Unknown { at_most, .. } if term == Term::N && is_filtered => {
                (at_most, None, HIDDEN_N.to_owned())
            }
            TermEstimate::Unknown { at_most, record_s } => {
                let reason = match record_s {
                    Some(s) => format!("{what}: record at least {}", duration_text(s)),
                    None => format!("{what}, nor in a thousand times that"),
                };
                (at_most, record_s, reason)
            }
        };
        channel.not_observable.push(NotObservable {
            term: term.symbol().to_owned(),
            reason,
            at_most,
            record_s,
        });
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
    if let Some(drift) = channel.fit.and_then(|fit| fit.drift) {
        let unit = Unit::of(Term::B, channel.is_gyroscope());
        let case = Case::NoiseDrift {
            channel: name.clone(),
            change: unit.factor * drift.change,
            unit: unit.name,
            during_s: drift.during_s,
            constant_s: drift.time_constant_s,
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
