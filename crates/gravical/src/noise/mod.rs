//! Noise of a sensor at rest: Allan deviation, and what it says.
//!
//! # Overview
//!
//! [`noise`] reads a recording of a sensor that lies still and returns for each channel the
//! overlapping Allan deviation with its 95 % intervals, the noise density N, the bias instability B
//! and the random walk K with theirs, or why the recording does not determine them. Everything is in
//! SI units, converted by the nominal scale: 3 % of scale error are 3 % of N.
//!
//! It fails where noise is not what the model says: vibration of the place and drift with
//! temperature look like noise of the sensor. Neither can be removed afterwards.
//!
//! # Example
//!
//! ```
//! use gravical::noise::noise_of_samples;
//!
//! // White noise of standard deviation 0.0289 at 100 Hz: N = 0.00289.
//! let uniform = |i: u32| (f64::from(i).sin() * 43_758.545_3).rem_euclid(1.0);
//! let samples: Vec<f64> = (0..50_000).map(|i| 0.1 * uniform(i)).collect();
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

use gravical_judge::numfmt;
use gravical_signal::rounding;
use gravical_signal::stats::pooled_deviation;
use gravical_signal::{
    AllanVariance, BLOCK_S, NoiseModel, allan_variances, block_len, fit_noise, remove_trend,
};

use crate::Result;
use crate::calibration_file::{CHANNELS, InputFile, TemperatureRange};
use crate::finding::{Case, Finding, LineSpans, RecordingCase, hidden};
use crate::poses::check_units;
use crate::poses::gyro_unit::decide_unit;
use crate::poses::rests::{find_quiet, why_never_static};
use crate::problem::Problem;
use crate::recording::{self, ReadOptions, Recording, nominal_accel};

#[doc(hidden)]
pub use gravical_signal::NoiseLimit;
pub use gravical_signal::{AllanPoint, Drift, Estimate, FittedCurve, Misfit, NoiseTerm as Term};
pub use result::*;

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
    if recording.gyro.is_some() {
        decide_unit(&mut recording);
    }
    let mut pieces = Pieces::new(&recording, &ranges, 1.0 / rate_hz);
    let width = block_len(1.0 / rate_hz, BLOCK_S);
    pieces.leave_out_disturbances(&recording, width);
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
        let (noise, found) = noise_of_segments(CHANNELS[i], segments, step, period_s);
        if noise.adev.is_empty() {
            let channel = noise.channel;
            findings.push(RecordingCase::NoNeighbours { channel }.finding());
        } else {
            findings.extend(found);
            channels.push(noise);
        }
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
    noise_of_segments(channel, vec![samples.to_vec()], step, period_s).0
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
        let why = why_never_static(recording);
        let problem = match longest {
            0 => Problem::NeverAtRest { why },
            _ => Problem::ShortRest { longest_s },
        };
        return Err(problem.error().at(here, None));
    }
    ranges.retain(|range| range.len() as f64 >= MIN_OF_LONGEST * longest as f64);
    Ok((ranges, rate_hz))
}

/// The result of one channel, of segments of samples in SI units, in steps of `step`; and what is odd
/// about it.
fn noise_of_segments(
    name: &str,
    mut segments: Vec<Vec<f64>>,
    step: f64,
    period_s: f64,
) -> (ChannelNoise, Vec<Finding>) {
    let rounding = Rounding::of(&segments, step, period_s);
    let (drift, walks) = remove_trend(&mut segments, period_s);
    let longest = segments.iter().map(Vec::len).max().unwrap_or(0);
    let mut variances = allan_variances(&segments, period_s);
    rounding.subtract(&mut variances);
    let fit = fit_noise(&variances, longest, period_s).filter(|_| !rounding.hides());
    // Without a fit the distribution of the points has to be that of some noise.
    let model = fit.as_ref().map_or(NoiseModel::WHITE, |fit| fit.model);
    let is_gyroscope = name.starts_with('g');
    let unit = if is_gyroscope { "rad/s" } else { "m/s^2" };
    let mut noise = ChannelNoise {
        channel: name.to_owned(),
        unit: unit.to_owned(),
        adev: variances.iter().filter_map(|v| v.point(&model)).collect(),
        fit: fit.as_ref().map(|fit| FittedCurve { drift, ..fit.curve }),
        ..ChannelNoise::default()
    };
    let mut findings = noise.findings();
    if let Some(fit) = fit {
        noise.take_estimates(&fit, longest as f64 * period_s, walks);
        if let Some(n) = &mut noise.n {
            let off = rounding.off();
            (n.low, n.high) = (n.low * (1.0 - off), n.high * (1.0 + off));
        }
        return (noise, findings);
    }
    let mut limit = NoiseLimit::default();
    let reason = if variances.iter().all(|v| v.variance <= 0.0) {
        "the values do not change: the noise is below the resolution".to_owned()
    } else if rounding.hides() {
        let most = (MIN_OF_RESOLUTION * step).hypot(rounding::floor(step).sqrt());
        limit.at_most = Some(most * period_s.sqrt());
        let unit = numfmt::unit(unit);
        let reason = hidden(step, &unit);
        let channel = name.to_owned();
        let case = Case::NoiseBelowResolution {
            channel,
            step,
            unit,
        };
        findings.push(case.finding());
        reason
    } else {
        "the values change too rarely for any averaging time to show noise".to_owned()
    };
    // The limit is that of N, which comes first.
    let missing = |term| NotObservable::new(term, reason.clone(), std::mem::take(&mut limit));
    noise.not_observable = Term::ALL.map(missing).into();
    (noise, findings)
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

    /// Takes it off, at most its share: an Allan variance of few degrees of freedom stays above zero.
    fn subtract(&self, octaves: &mut [AllanVariance]) {
        let rounding = rounding::floor(self.step);
        if !self.hides() {
            let share = rounding / (rounding + self.before);
            for (octave, point) in octaves.iter_mut().enumerate() {
                let rounding = rounding / 2_f64.powi(octave as i32);
                point.variance -= rounding.min(share * point.variance);
            }
        }
    }

    /// How far off N may be, relative: with s = σ/q, the first terms of what the errors have in common
    /// with the noise, 4 exp(−2π²s²), and of their variance, over s², for the worst level between two
    /// steps. s itself is too large by that.
    fn off(&self) -> f64 {
        let seen = self.before.sqrt() / self.step;
        (0..8).fold(0.0, |off: f64, _| {
            let square = (PI * seen / (1.0 + off)).powi(2);
            (0.5 * (-2.0 * square).exp() * (4.0 + 1.0 / square)).min(1.0)
        })
    }
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
        let [from, to] = recording.lines_of(range);
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
