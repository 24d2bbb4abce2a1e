//! Noise of the sensors while they rest, estimated so that a slow move in what
//! was taken for a rest does not count.

use std::ops::Range;

use gravical_core::rounding;
use gravical_core::still::Plan;

use super::Noise;
use super::view::{Six, channel};
use crate::motion::samples::Samples;
use crate::stats::median;

/// Blocks of a chunk, over which correlations are taken: 5 s.
const CHUNK_BLOCKS: usize = 25;
/// A chunk whose blocks scatter so many times more than their neighbours differ
/// holds a slow move or a knock. White noise has 1 ± 0.3.
const MOST_UNREST: f64 = 2.5;
/// Samples are not looked at beyond this many: they say it well enough.
const ENOUGH: usize = 200_000;

/// Noise of all rests together.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pooled {
    /// Variance of a sample as it reads, each channel: zero where rounding hides the
    /// noise.
    pub variance: Six,
    /// Variance that rounding leaves in a mean.
    pub left: Six,
    /// What the samples are rounded to.
    step: Six,
    /// VIF of accelerometer and gyroscope.
    pub vif: [f64; 2],
}

impl Pooled {
    pub(super) fn accel(&self) -> Noise {
        self.of_sensor(0)
    }

    pub(super) fn gyro(&self) -> Noise {
        self.of_sensor(1)
    }

    fn of_sensor(&self, sensor: usize) -> Noise {
        let of = |c: usize| self.variance[c].max(rounding::floor(self.step[c]));
        Noise {
            sigma: std::array::from_fn(|i| of(3 * sensor + i).sqrt()),
            vif: self.vif[sensor],
            rounding: std::array::from_fn(|i| self.left[3 * sensor + i].sqrt()),
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
    let variance = [a[0], a[1], a[2], g[3], g[4], g[5]];
    let step = samples.resolution;
    Pooled {
        variance,
        left: std::array::from_fn(|c| rounding::mean_variance(variance[c], step[c])),
        step,
        vif,
    }
}

/// Variance of a sample from the variances within blocks, those left out that stand
/// out from their median: a knock, an edge. What the mean of a block takes with
/// it, VIF/b of the variance, is put back.
pub(super) fn variances(samples: &Samples, spans: &[Range<usize>], plan: &Plan, vif: f64) -> Six {
    let freedom = plan.block as f64 - 1.0;
    // Four standard deviations of χ² over its degrees of freedom.
    let most = 1.0 + 4.0 * (2.0 / freedom).sqrt();
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
        let Some(middle) = median(&mut all) else {
            return 0.0;
        };
        // Most blocks may never change, and those that do are no knocks.
        let middle = rounding::sample_variance(middle, samples.resolution[c]);
        all.retain(|v| *v <= most * middle);
        all.iter().sum::<f64>() / all.len().max(1) as f64 / kept
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
                let mut rests: Vec<f64> = values.iter().map(|v| v - centre).collect();
                // Each chunk counts alike, whatever its noise.
                let squares = rests.iter().map(|v| v * v).sum::<f64>() / rests.len() as f64;
                if squares > 0.0 {
                    // … as far as it shows through rounding: a few flips say nothing.
                    let shown = rounding::shown(squares, samples.resolution[c]);
                    let size = (shown / squares).sqrt();
                    rests.iter_mut().for_each(|v| *v *= size);
                    chunks.push((unrest(&rests, plan.block), rests));
                }
            }
        }
    }
    let mut levels: Vec<f64> = chunks.iter().map(|c| c.0).collect();
    levels.retain(|u| u.is_finite());
    levels.sort_unstable_by(f64::total_cmp);
    if let Some(level) = levels.get(levels.len() / 4) {
        let limit = MOST_UNREST * level.max(1.0);
        chunks.retain(|(unrest, _)| *unrest <= limit || unrest.is_nan());
    }
    let all = autocorrelation(&chunks, Plan::SEED_BLOCKS * plan.block);
    let by_steps = inflation_by_steps(samples, spans, plan, sensor, variance);
    by_steps.map_or(all, |steps| all.min(MOST_BEYOND_STEPS * steps.max(1.0)))
}

/// Correlation that neighbouring means of 0.2 s do not show is a move in what was taken
/// for a rest, beyond this factor.
const MOST_BEYOND_STEPS: f64 = 2.0;
/// Fewer steps from one mean to the next say nothing.
const FEWEST_STEPS: usize = 6;
/// Median of χ² with three degrees of freedom.
const MEDIAN_CHI2_3: f64 = 2.365_974;

/// How much larger than χ² with three degrees of freedom values are, by their median; 1 where
/// that can be chance: it scatters by 1.1/√n of itself.
pub(super) fn beyond_chance(chi2: &mut [f64]) -> f64 {
    let error = 1.1 / (chi2.len() as f64).sqrt();
    median(chi2).map_or(1.0, |middle| {
        (middle / MEDIAN_CHI2_3 / (1.0 + 2.0 * error)).max(1.0)
    })
}

/// VIF by the median step between neighbouring means of 0.2 s: a move changes few of
/// them much. None where there are too few.
fn inflation_by_steps(
    samples: &Samples,
    spans: &[Range<usize>],
    plan: &Plan,
    sensor: usize,
    variance: &Six,
) -> Option<f64> {
    let total: usize = spans.iter().map(|s| s.len()).sum();
    let stride = (3 * total / ENOUGH).max(1);
    let mut squares = Vec::new();
    for span in spans {
        let pairs = (span.len() / plan.block).saturating_sub(1);
        for pair in (0..pairs).step_by(stride) {
            let from = span.start + pair * plan.block;
            let mut sum = 0.0;
            for c in 3 * sensor..3 * sensor + 3 {
                let values = channel(samples, c)?;
                let early = mean(&values[from..from + plan.block]);
                let late = mean(&values[from + plan.block..from + 2 * plan.block]);
                let white = 2.0 * variance[c] / plan.block as f64;
                sum += if white > 0.0 {
                    (late - early).powi(2) / white
                } else {
                    0.0
                };
            }
            squares.push(sum);
        }
    }
    if squares.len() < FEWEST_STEPS {
        return None;
    }
    median(&mut squares).map(|middle| middle / MEDIAN_CHI2_3)
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

/// Mean of values, summed less the first one, which keeps the digits under gravity.
pub(super) fn mean(values: &[f64]) -> f64 {
    let first = values.first().copied().unwrap_or(0.0);
    first + values.iter().map(|v| v - first).sum::<f64>() / values.len().max(1) as f64
}
