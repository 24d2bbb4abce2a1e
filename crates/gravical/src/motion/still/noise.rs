//! Noise of the sensors while they rest, estimated so that a slow move in what
//! was taken for a rest does not count.

use std::ops::Range;

use gravical_core::still::{Plan, RestNoise};

use super::Noise;
use super::view::{Six, channel};
use crate::motion::samples::Samples;
use crate::stats::median;

/// Median of χ² with one degree of freedom.
const MEDIAN_CHI2_1: f64 = 0.454_936_4;
/// Blocks of a chunk, over which correlations are taken: 5 s.
const CHUNK_BLOCKS: usize = 25;
/// Samples are not looked at beyond this many: they say it well enough.
const ENOUGH: usize = 200_000;

/// A coarse rest with the noise in it.
#[derive(Debug, Clone)]
pub(super) struct Coarse {
    pub span: Range<usize>,
    pub noise: RestNoise<f64>,
}

/// The coarse rests of a recording.
#[derive(Debug, Clone, Default)]
pub(super) struct Levels {
    pub rests: Vec<Coarse>,
}

impl Levels {
    /// Of each rest its own noise, as far as it is long enough to show it.
    pub(super) fn new(samples: &Samples, spans: &[Range<usize>], plan: &Plan) -> Self {
        let pooled = pooled(samples, spans, plan);
        let own: Vec<Six> = spans
            .iter()
            .map(|span| variances(samples, std::slice::from_ref(span), plan, 1.0))
            .collect();
        let floor: Six = std::array::from_fn(|c| {
            let least = own
                .iter()
                .map(|v| v[c])
                .filter(|v| *v > 0.0)
                .fold(f64::INFINITY, f64::min);
            if least.is_finite() { 0.5 * least } else { 0.0 }
        });
        let rests = spans
            .iter()
            .zip(&own)
            .map(|(span, own)| {
                let enough = span.len() >= Plan::SEED_BLOCKS * plan.block;
                let variance: Six = std::array::from_fn(|c| {
                    let v = if enough { own[c] } else { pooled.variance[c] };
                    positive(v.max(floor[c]), samples, c)
                });
                Coarse {
                    span: span.clone(),
                    noise: rest_noise(samples, span, plan, &variance, &pooled.vif),
                }
            })
            .collect();
        Levels { rests }
    }

    /// The coarse rest that a sample lies in.
    pub(super) fn at(&self, sample: usize) -> Option<&Coarse> {
        let after = self.rests.partition_point(|r| r.span.start <= sample);
        let rest = self.rests.get(after.checked_sub(1)?)?;
        rest.span.contains(&sample).then_some(rest)
    }
}

/// A channel without any noise: what rounding of its largest value leaves.
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
    span: &Range<usize>,
    plan: &Plan,
    variance: &Six,
    vif: &[f64; 2],
) -> RestNoise<f64> {
    let widening: [f64; 2] =
        std::array::from_fn(|sensor| widening(samples, span, plan, sensor, variance, vif[sensor]));
    let mean_variance: Six = std::array::from_fn(|c| variance[c] * vif[c / 3] * widening[c / 3]);
    RestNoise {
        mean_variance: [mean_variance; 3],
        gyro_variance: [variance[3], variance[4], variance[5]],
        gyro_vif: vif[1] * widening[1],
        has_gyro: samples.rate_rad_s.is_some(),
    }
}

/// How much more the means of neighbouring blocks differ than σ²·VIF says, by the
/// median; 1 where what was found can be chance (2 standard errors).
fn widening(
    samples: &Samples,
    span: &Range<usize>,
    plan: &Plan,
    sensor: usize,
    variance: &Six,
    vif: f64,
) -> f64 {
    let mut squares = Vec::new();
    for c in 3 * sensor..3 * sensor + 3 {
        let Some(values) = channel(samples, c) else {
            return 1.0;
        };
        let expected = 2.0 * variance[c] * vif / plan.block as f64;
        let means: Vec<f64> = values[span.clone()]
            .chunks_exact(plan.block)
            .map(mean)
            .collect();
        squares.extend(means.windows(2).map(|w| (w[1] - w[0]).powi(2) / expected));
    }
    let count = squares.len() as f64;
    let Some(middle) = median(&mut squares) else {
        return 1.0;
    };
    // The median of squares has 0.37 of the efficiency of their mean.
    let error = (2.0 / (0.37 * count)).sqrt();
    (middle / MEDIAN_CHI2_1 / (1.0 + 2.0 * error)).max(1.0)
}

fn mean(values: &[f64]) -> f64 {
    let first = values.first().copied().unwrap_or(0.0);
    first + values.iter().map(|v| v - first).sum::<f64>() / values.len().max(1) as f64
}

/// Noise of all rests together.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pooled {
    /// Variance of a sample, each channel.
    pub variance: Six,
    /// VIF of accelerometer and gyroscope.
    pub vif: [f64; 2],
}

impl Pooled {
    pub(super) fn accel(&self) -> Noise {
        Noise {
            sigma: std::array::from_fn(|i| self.variance[i].sqrt()),
            vif: self.vif[0],
        }
    }

    pub(super) fn gyro(&self) -> Noise {
        Noise {
            sigma: std::array::from_fn(|i| self.variance[3 + i].sqrt()),
            vif: self.vif[1],
        }
    }
}

/// σ² and VIF over `spans`.
pub(super) fn pooled(samples: &Samples, spans: &[Range<usize>], plan: &Plan) -> Pooled {
    let first = variances(samples, spans, plan, 1.0);
    let vif = [
        inflation(samples, spans, plan, 0, &first),
        inflation(samples, spans, plan, 1, &first),
    ];
    let a = variances(samples, spans, plan, vif[0]);
    let g = variances(samples, spans, plan, vif[1]);
    Pooled {
        variance: [a[0], a[1], a[2], g[3], g[4], g[5]],
        vif,
    }
}

/// Variance of a sample by the median of the variances within blocks; what the
/// mean of a block takes with it, VIF/b of the variance, is put back.
fn variances(samples: &Samples, spans: &[Range<usize>], plan: &Plan, vif: f64) -> Six {
    let b = plan.block as f64;
    let freedom: f64 = b - 1.0;
    // Wilson and Hilferty 1931: median of χ² over its degrees of freedom.
    let middle = f64::powi(1.0 - 2.0 / (9.0 * freedom), 3);
    let kept = (1.0 - (vif - 1.0) / freedom).max(0.2);
    std::array::from_fn(|c| {
        let Some(values) = channel(samples, c) else {
            return 1.0;
        };
        let mut all: Vec<f64> = spans
            .iter()
            .flat_map(|span| {
                let part = &values[span.clone()];
                part.chunks(plan.block)
                    .filter(move |chunk| chunk.len() == plan.block || part.len() < plan.block)
            })
            .filter(|chunk| chunk.len() > 1)
            .map(|chunk| {
                let m = mean(chunk);
                chunk.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (chunk.len() - 1) as f64
            })
            .collect();
        median(&mut all).map_or(0.0, |m| m / middle / kept)
    })
}

/// VIF = max(1, 1 + 2 Σ r_k), r_k the autocorrelation pooled over the axes of a
/// sensor and chunks of 5 s, summed until it falls under 2/√n, at most over
/// 1 s. Chunks whose blocks scatter more than their neighbours differ hold a slow
/// move and are left out.
fn inflation(
    samples: &Samples,
    spans: &[Range<usize>],
    plan: &Plan,
    sensor: usize,
    variance: &Six,
) -> f64 {
    let size = CHUNK_BLOCKS * plan.block;
    let mut chunks: Vec<(f64, Vec<f64>)> = Vec::new();
    let total: usize = spans.iter().map(|s| s.len()).sum();
    let stride = (3 * total / ENOUGH).max(1);
    let mut count = 0;
    for span in spans {
        let pieces = (span.len() / size).max(1);
        for piece in 0..pieces {
            count += 1;
            if count % stride != 0 {
                continue;
            }
            let part = span.start + piece * span.len() / pieces
                ..span.start + (piece + 1) * span.len() / pieces;
            for c in 3 * sensor..3 * sensor + 3 {
                let Some(values) = channel(samples, c) else {
                    return 1.0;
                };
                if variance[c] <= 0.0 {
                    continue;
                }
                let values = &values[part.clone()];
                let centre = mean(values);
                let scale = 1.0 / variance[c].sqrt();
                let rests: Vec<f64> = values.iter().map(|v| (v - centre) * scale).collect();
                chunks.push((unrest(&rests, plan.block), rests));
            }
        }
    }
    let mut levels: Vec<f64> = chunks
        .iter()
        .map(|c| c.0)
        .filter(|u| u.is_finite())
        .collect();
    if let Some(level) = median(&mut levels) {
        let limit = 3.0 * level.max(1.0);
        chunks.retain(|(unrest, _)| *unrest <= limit || unrest.is_nan());
    }
    autocorrelation(&chunks, Plan::SEED_BLOCKS * plan.block)
}

/// Scatter of block means over what their neighbours differ: 1 without any drift.
fn unrest(values: &[f64], block: usize) -> f64 {
    let means: Vec<f64> = values.chunks_exact(block).map(mean).collect();
    let n = means.len() as f64;
    let centre = mean(&means);
    let scatter = means.iter().map(|m| (m - centre).powi(2)).sum::<f64>() / (n - 1.0);
    let steps = means.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / (n - 1.0);
    scatter / (0.5 * steps)
}

fn autocorrelation(chunks: &[(f64, Vec<f64>)], most: usize) -> f64 {
    let samples: usize = chunks.iter().map(|c| c.1.len()).sum();
    let product = |lag: usize| -> f64 {
        chunks
            .iter()
            .map(|(_, v)| {
                v.iter()
                    .zip(v.iter().skip(lag))
                    .map(|(a, b)| a * b)
                    .sum::<f64>()
            })
            .sum()
    };
    let whole = product(0);
    let mut vif = 1.0;
    if whole > 0.0 {
        for lag in 1..=most {
            let r = product(lag) / whole;
            if r < 2.0 / (samples as f64).sqrt() {
                break;
            }
            vif += 2.0 * r;
        }
    }
    vif
}
