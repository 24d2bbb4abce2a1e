//! How noisy each of the coarse rests is, and how much the sensors drift in them.

use std::ops::Range;

use gravical_core::rounding;
use gravical_core::still::{Plan, RestNoise};

use super::noise::{Pooled, beyond_chance, mean, pooled, variances};
use super::view::{Six, channel};
use crate::motion::samples::Samples;

/// Lower quartile of χ² with three degrees of freedom.
const QUARTILE_CHI2_3: f64 = 1.212_533;
/// A rest that has more than so many times the variance of the quietest one is
/// held in a hand, or lies on something that shakes.
const HELD: f64 = 3.0;

/// A coarse rest with the noise in it.
#[derive(Debug, Clone)]
pub(super) struct Coarse {
    pub span: Range<usize>,
    pub noise: RestNoise<f64>,
    /// Not lying on anything steady.
    pub held: bool,
}

/// The coarse rests of a recording.
#[derive(Debug, Clone, Default)]
pub(super) struct Levels {
    pub rests: Vec<Coarse>,
    /// How much more the means of seconds differ within a rest than V says.
    pub wander: f64,
    /// Variance that rounding leaves in a mean, however long.
    pub left: Six,
}

impl Levels {
    /// Of each rest its own variance, as far as it is another one than that of all;
    /// VIF and drift of all together.
    pub(super) fn new(samples: &Samples, spans: &[Range<usize>], plan: &Plan) -> Self {
        let pooled = pooled(samples, spans, plan);
        let own: Vec<Six> = spans
            .iter()
            .map(|span| {
                let [a, g] = pooled
                    .vif
                    .map(|vif| variances(samples, std::slice::from_ref(span), plan, vif));
                [a[0], a[1], a[2], g[3], g[4], g[5]]
            })
            .collect();
        let long = |span: &Range<usize>| span.len() >= Plan::SEED_BLOCKS * plan.block;
        let floor: Six = std::array::from_fn(|c| {
            let least = spans
                .iter()
                .zip(&own)
                .filter(|(span, v)| long(span) && v[c] > 0.0)
                .map(|(_, v)| v[c])
                .fold(f64::INFINITY, f64::min);
            let least = if least.is_finite() { least } else { 0.0 };
            rounding::sample_variance(least, samples.resolution[c])
        });
        let variance: Vec<Six> = spans
            .iter()
            .zip(&own)
            .map(|(span, own)| {
                let differs = [0, 1]
                    .map(|sensor| long(span) && differs(own, &pooled.variance, sensor, span.len()));
                std::array::from_fn(|c| {
                    let v = if differs[c / 3] {
                        own[c].max(0.5 * floor[c])
                    } else {
                        pooled.variance[c]
                    };
                    positive(
                        rounding::sample_variance(v, samples.resolution[c]),
                        samples,
                        c,
                    )
                })
            })
            .collect();
        let held: Vec<bool> = spans
            .iter()
            .zip(&variance)
            .map(|(_, variance)| {
                let over = |sensor: usize| {
                    let axes = 3 * sensor..3 * sensor + 3;
                    let sum = |of: &Six| axes.clone().map(|c| of[c]).sum::<f64>();
                    sum(&floor) > 0.0 && sum(variance) > HELD * sum(&floor)
                };
                over(0) || samples.rate_rad_s.is_some() && over(1)
            })
            .collect();
        let drift: [f64; 2] = std::array::from_fn(|sensor| {
            drift(
                samples,
                spans,
                &variance,
                &held,
                plan,
                sensor,
                pooled.vif[sensor],
            )
        });
        let rests: Vec<Coarse> = spans
            .iter()
            .zip(&variance)
            .zip(&held)
            .map(|((span, variance), held)| Coarse {
                span: span.clone(),
                noise: rest_noise(samples, variance, &pooled, drift, plan),
                held: *held,
            })
            .collect();
        let wander = wander(samples, &rests, plan);
        Levels {
            rests,
            wander,
            left: pooled.left,
        }
    }

    /// The coarse rest that begins last before the middle of `range`, or the first.
    pub(super) fn nearest(&self, range: &Range<usize>) -> &Coarse {
        let middle = range.start + range.len() / 2;
        let after = self.rests.partition_point(|r| r.span.start <= middle);
        &self.rests[after.saturating_sub(1)]
    }

    /// The coarse rest that a sample lies in.
    pub(super) fn at(&self, sample: usize) -> Option<&Coarse> {
        let after = self.rests.partition_point(|r| r.span.start <= sample);
        let rest = self.rests.get(after.checked_sub(1)?)?;
        rest.span.contains(&sample).then_some(rest)
    }
}

/// Whether the variances of a rest of `n` samples are others than those of all
/// rests by more than chance (four standard errors, the axes together). Otherwise
/// those of all are the better ones.
fn differs(own: &Six, all: &Six, sensor: usize, n: usize) -> bool {
    let ratio = (3 * sensor..3 * sensor + 3)
        .filter(|&c| all[c] > 0.0)
        .map(|c| own[c] / all[c] / 3.0)
        .sum::<f64>();
    (ratio - 1.0).abs() > 4.0 * (2.0 / (3.0 * n as f64)).sqrt()
}

/// A channel without any noise whose steps are not known: what the digits of its
/// largest value leave.
fn positive(variance: f64, samples: &Samples, c: usize) -> f64 {
    if variance > 0.0 && variance.is_finite() {
        return variance;
    }
    let largest = channel(samples, c)
        .and_then(|v| v.first())
        .map_or(1.0, |v| v.abs().max(1.0));
    (largest * 1e-9).powi(2)
}

fn rest_noise(
    samples: &Samples,
    variance: &Six,
    pooled: &Pooled,
    drift: [f64; 2],
    plan: &Plan,
) -> RestNoise<f64> {
    let wide: [f64; 2] = std::array::from_fn(|sensor| pooled.vif[sensor] * drift[sensor]);
    let mean_variance: Six = std::array::from_fn(|c| variance[c] * wide[c / 3]);
    RestNoise {
        mean_variance: [mean_variance; 3],
        variance: *variance,
        gyro_vif: wide[1],
        has_gyro: samples.rate_rad_s.is_some(),
    }
    .with_rounding(plan, &samples.resolution, &pooled.left)
}

/// How much more neighbouring means of 2 s differ than V says, by the median over
/// all steady rests; 1 where that can be chance, and with fewer than five rests:
/// one slow move would be too much of them.
fn wander(samples: &Samples, rests: &[Coarse], plan: &Plan) -> f64 {
    let width = Plan::LEAST_REFERENCE * plan.block;
    let mut chi2 = Vec::new();
    let mut long = 0;
    for rest in rests
        .iter()
        .filter(|r| !r.held && r.span.len() >= 2 * width)
    {
        long += 1;
        let variance = &rest.noise.mean_variance[0];
        for at in (rest.span.start..=rest.span.end - 2 * width).step_by(width) {
            let sum: f64 = (0..3)
                .map(|c| {
                    let values = &samples.force_mps2[c];
                    let early = mean(&values[at..at + width]);
                    let late = mean(&values[at + width..at + 2 * width]);
                    (late - early).powi(2) / (2.0 * variance[c] / width as f64)
                })
                .sum();
            chi2.push(sum);
        }
    }
    match long >= 5 {
        true => beyond_chance(&mut chi2),
        false => 1.0,
    }
}

/// Fewer differences, 20 s of rest, do not tell a drift from a move.
const FEWEST_DIFFERENCES: usize = 100;

/// How much more means of 0.4 s that are 1 s apart differ than σ²·VIF says: a bias
/// that wanders, a floor that shakes. From the lower quartile over all steady
/// rests, so that a slow move in the greater part of one does not count; 1 where
/// what was found can be chance (two standard errors).
fn drift(
    samples: &Samples,
    spans: &[Range<usize>],
    variance: &[Six],
    held: &[bool],
    plan: &Plan,
    sensor: usize,
    vif: f64,
) -> f64 {
    let width = 2 * plan.block;
    let apart = Plan::SEED_BLOCKS * plan.block;
    let mut chi2 = Vec::new();
    let all_held = held.iter().all(|h| *h);
    for ((span, variance), held) in spans.iter().zip(variance).zip(held) {
        if *held && !all_held {
            continue;
        }
        let mut at = span.start;
        while at + apart + width <= span.end {
            let mut sum = 0.0;
            for c in 3 * sensor..3 * sensor + 3 {
                let Some(values) = channel(samples, c) else {
                    return 1.0;
                };
                let early = mean(&values[at..at + width]);
                let late = mean(&values[at + apart..at + apart + width]);
                sum += (late - early).powi(2) / (2.0 * variance[c] * vif / width as f64);
            }
            chi2.push(sum);
            at += plan.block;
        }
    }
    // In a short recording a move may be the greater part of it.
    if chi2.len() < FEWEST_DIFFERENCES {
        return 1.0;
    }
    chi2.sort_unstable_by(f64::total_cmp);
    let Some(quartile) = chi2.get(chi2.len() / 4) else {
        return 1.0;
    };
    // Neighbouring differences share samples: about a third of them counts. The
    // lower quartile scatters by 1.4/√n of itself.
    let error = 1.4 / (chi2.len() as f64 / 3.0).sqrt();
    (quartile / QUARTILE_CHI2_3 / (1.0 + 2.0 * error)).max(1.0)
}
