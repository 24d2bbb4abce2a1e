//! Fit and test of one channel: the fit to the cooling sweeps must predict the warming ones, and
//! vice versa.

use std::collections::BTreeMap;

use crate::calibration_file::{ChannelDrift, DriftVerdict, SweepDirection};

use super::fit::{Fit, Frame, Sample, Shape, minus_means, rms};
use super::reason;
use super::sweeps::Bin;
use super::tested::Tested;

use SweepDirection::{Cooling, Warming};

/// A higher order must reduce the unexplained share by this factor …
const BETTER: f64 = 0.9;
/// Highest order: more than two bends in a range of some tens of °C have another cause.
const MOST_ORDER: usize = 3;
/// … unless the rest is within this multiple of the standard errors of the means: noise.
const AT_NOISE: f64 = 1.5;
/// Smallest number of bins in each direction for a test.
const LEAST_BINS: usize = 6;
/// A drift below this multiple of the standard errors of the means is not significant.
const NOISE_FACTOR: f64 = 2.0;
/// Bias and scale can be distinguished if gravity on the axis differs by this much between poses,
/// g.
const LEAST_SPREAD_G: f64 = 0.5;
/// An axis with less gravity than this shows only the drift of its bias, g.
const GRAVITY_ON_AXIS_G: f64 = 0.2;

/// Data common to all channels.
pub(super) struct Common<'a> {
    pub bins: &'a [Bin],
    pub frame: Frame,
    /// Temperature range of both directions, °C.
    pub overlap_c: [f64; 2],
    /// Smallest width required of it, °C.
    pub least_span_c: f64,
    pub unit: &'a str,
}

/// Evaluates channel `index` (0 to 5), relative to `frame.centre_c`.
pub(super) fn judge(common: &Common<'_>, index: usize, name: &str) -> ChannelDrift {
    let samples = samples(common.bins, index);
    let part = |direction: SweepDirection| -> Vec<Sample> {
        let of_direction = samples.iter().filter(|(d, _)| *d == direction);
        of_direction.map(|(_, s)| *s).collect()
    };
    let (cooling, warming) = (part(Cooling), part(Warming));
    let all: Vec<Sample> = samples.iter().map(|(_, s)| *s).collect();
    let scale_observed = index < 3 && scale_is_observable(common, &all);
    let slope = |of: &[Sample]| straight(of, common.frame);
    let joint = slope(&all);
    let mut out = ChannelDrift {
        channel: name.to_owned(),
        input_unit: common.unit.to_owned(),
        verdict: DriftVerdict::NotCorrected,
        reason: String::new(),
        order: 0,
        r2_cooling_to_warming: None,
        r2_warming_to_cooling: None,
        slope: joint,
        slope_cooling: slope(&cooling),
        slope_warming: slope(&warming),
        hysteresis: hysteresis(common.bins, index, joint.unwrap_or(0.0)),
        drift_rms: rms(&minus_means(&all)),
        residual_rms: None,
        coefficients: Vec::new(),
        scale_coefficients: Vec::new(),
        scale_observed,
    };
    let shared_c = common.overlap_c[1] - common.overlap_c[0];
    if cooling.is_empty() || warming.is_empty() {
        let direction = if cooling.is_empty() { Warming } else { Cooling };
        out.reason = reason::one_direction(direction);
        return out;
    }
    if shared_c <= common.least_span_c || cooling.len().min(warming.len()) < LEAST_BINS {
        out.reason = reason::little_shared(shared_c.max(0.0), common.least_span_c);
        return out;
    }
    let noise = mean_noise(common.bins, index);
    // Share of the variance that is noise, which no shape can explain.
    let noise_share = (AT_NOISE * noise / out.drift_rms).powi(2);
    let Some(tested) = choose(common, &cooling, &warming, scale_observed, noise_share) else {
        out.reason = reason::no_fit();
        return out;
    };
    out.order = tested.shape.order as u32;
    out.r2_cooling_to_warming = Some(tested.to_warming);
    out.r2_warming_to_cooling = Some(tested.to_cooling);
    let fit = Fit::new(&all, tested.shape, common.frame);
    match fit {
        Some(fit) if tested.passes() => {
            out.verdict = DriftVerdict::Corrected;
            out.residual_rms = Some(rms(&fit.residuals(&all)));
            let unknown = !scale_observed
                && index < 3
                && all
                    .iter()
                    .any(|s| s.level.abs() > GRAVITY_ON_AXIS_G * common.frame.gravity);
            out.reason = reason::accepted(&tested, unknown);
            out.coefficients = fit.drift;
            out.scale_coefficients = fit.gain;
        }
        _ if out.drift_rms <= NOISE_FACTOR * noise => {
            out.reason = reason::no_drift(out.drift_rms, noise, common.unit);
        }
        _ => out.reason = reason::unpredictable(&tested, out.hysteresis, common.unit),
    }
    out
}

fn samples(bins: &[Bin], index: usize) -> Vec<(SweepDirection, Sample)> {
    let mut levels: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
    let bins = || bins.iter().filter(|b| b.values[index].is_finite());
    for bin in bins() {
        let (sum, n) = levels.entry(bin.pose).or_default();
        *sum += bin.values[index];
        *n += 1.0;
    }
    bins()
        .map(|bin| {
            let (sum, n) = levels.get(&bin.pose).copied().unwrap_or((0.0, 1.0));
            let sample = Sample {
                pose: bin.pose,
                t_c: bin.t_c,
                y: bin.values[index],
                level: sum / n,
            };
            (bin.direction, sample)
        })
        .collect()
}

/// True if poses with different gravity on the axis share temperatures.
fn scale_is_observable(common: &Common<'_>, all: &[Sample]) -> bool {
    // Level and temperatures of each pose.
    let mut poses: BTreeMap<usize, (f64, f64, f64)> = BTreeMap::new();
    for s in all {
        let (_, low, high) = poses.entry(s.pose).or_insert((s.level, s.t_c, s.t_c));
        (*low, *high) = (low.min(s.t_c), high.max(s.t_c));
    }
    let poses: Vec<(f64, f64, f64)> = poses.into_values().collect();
    poses
        .iter()
        .enumerate()
        .any(|(i, (level_a, low_a, high_a))| {
            poses[..i].iter().any(|(level_b, low_b, high_b)| {
                (level_a - level_b).abs() >= LEAST_SPREAD_G * common.frame.gravity
                    && high_a.min(*high_b) - low_a.max(*low_b) > common.least_span_c
            })
        })
}

/// The simplest shape that predicts as well as any other.
fn choose(
    common: &Common<'_>,
    cooling: &[Sample],
    warming: &[Sample],
    scale_observed: bool,
    noise_share: f64,
) -> Option<Tested> {
    let mut best: Option<Tested> = None;
    for order in 1..=MOST_ORDER {
        for with_scale in [false, true] {
            if with_scale && !scale_observed {
                continue;
            }
            let shape = Shape { order, with_scale };
            let Some(tested) = test(shape, common.frame, cooling, warming) else {
                continue;
            };
            let better = best.is_none_or(|b| {
                let left = 1.0 - b.worse();
                (left > noise_share && 1.0 - tested.worse() < BETTER * left)
                    || (tested.passes() && !b.passes())
            });
            if better {
                best = Some(tested);
            }
        }
    }
    best
}

fn test(shape: Shape, frame: Frame, cooling: &[Sample], warming: &[Sample]) -> Option<Tested> {
    Some(Tested {
        shape,
        to_warming: Fit::new(cooling, shape, frame)?.r2(warming)?,
        to_cooling: Fit::new(warming, shape, frame)?.r2(cooling)?,
    })
}

fn straight(samples: &[Sample], frame: Frame) -> Option<f64> {
    let line = Shape {
        order: 1,
        with_scale: false,
    };
    Fit::new(samples, line, frame).and_then(|f| f.drift.first().copied())
}

/// Largest difference between cooling and warming at one temperature in one pose; `slope`
/// corrects for different temperatures within a bin.
fn hysteresis(bins: &[Bin], index: usize, slope: f64) -> Option<f64> {
    let mut pairs: BTreeMap<(usize, i64), [(f64, f64); 2]> = BTreeMap::new();
    for bin in bins.iter().filter(|b| b.values[index].is_finite()) {
        let sums = pairs.entry((bin.pose, bin.degree)).or_default();
        let (sum, n) = &mut sums[usize::from(bin.direction == Warming)];
        *sum += bin.values[index] - slope * bin.t_c;
        *n += 1.0;
    }
    let apart: Vec<f64> = pairs
        .values()
        .filter(|[c, w]| c.1 > 0.0 && w.1 > 0.0)
        .map(|[c, w]| c.0 / c.1 - w.0 / w.1)
        .collect();
    // Mean over three neighbours, to reduce noise.
    apart
        .windows(apart.len().clamp(1, 3))
        .map(|w| (w.iter().sum::<f64>() / w.len() as f64).abs())
        .reduce(f64::max)
}

/// Standard error of the bins (rms), from the scatter of their blocks. Drift within a bin is
/// included, so it is not too small.
fn mean_noise(bins: &[Bin], index: usize) -> f64 {
    let bins = || bins.iter().filter(|b| b.values[index].is_finite());
    let squares: f64 = bins().map(|b| b.squares[index]).sum();
    let freedom: f64 = bins().map(|b| b.blocks - 1.0).sum();
    let (sum, n) = bins().fold((0.0, 0.0), |(sum, n), b| (sum + 1.0 / b.blocks, n + 1.0));
    if freedom < 1.0 {
        return 0.0;
    }
    (squares / freedom * sum / n).sqrt()
}
