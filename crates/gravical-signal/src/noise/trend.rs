//! What a recording shows at long times: a trend, a random walk, or neither.
//!
//! A bias that drifts looks like a random walk in the Allan deviation. In the cosine transform of the
//! means over blocks the two differ: the coefficients of noise are independent, with a power that is
//! white, flicker (∝ 1/f) or of a random walk (∝ 1/f²), those of a trend are known but for its size. The
//! models with and without each are compared by their likelihood (P. Whittle, *Arkiv för Matematik*
//! 2, 1953) less a penalty for every parameter.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector, MatrixXx3, Vector3};
use serde::{Deserialize, Serialize};

/// Largest number of blocks, and fewest that are looked at.
const BLOCKS: usize = 256;
const MIN_BLOCKS: usize = 32;
/// What −2 ln L has to fall by for a random walk, a line, an exponential.
const FOR_WALK: f64 = 2.0;
const FOR_LINE: f64 = 12.0;
const FOR_EXPONENTIAL: f64 = 13.0;
/// A walk is believed if trends alone are worse even at this part of their penalty.
const IN_DOUBT: f64 = 0.5;
/// Time constants that are tried, over the length of the recording: from 1/96, by √2.
const SHORTEST: f64 = 1.0 / 96.0;
const CONSTANTS: i32 = 16;
/// A longer time constant, over the length of the recording, does not differ from a line.
const LONGEST_BESIDE_LINE: f64 = 0.5;
const ITERATIONS: usize = 40;

/// A drift of the bias along a line or an exponential.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Drift {
    /// Change of the bias, unit.
    pub change: f64,
    /// Time in which it changes so, that of the longest segment, s.
    pub during_s: f64,
    /// Time constant of warming up, s; null for a line.
    pub time_constant_s: Option<f64>,
}

/// A line and an exponential, which decays.
#[derive(Clone, Copy)]
struct Trend {
    /// 1/samples
    slope: f64,
    size: f64,
    /// Time constant, samples; infinite without an exponential
    constant: f64,
}

impl Trend {
    fn at(&self, sample: f64) -> f64 {
        self.slope * sample + self.size * (-sample / self.constant).exp()
    }
}

/// Finds what explains the slow part of the longest segment, of evenly spaced samples at rest, and removes a
/// trend from all: the trend, and whether there is a random walk beside it. Of an exponential only the
/// longest segment is kept: it has decayed to an unknown part in the others.
pub fn remove_trend(segments: &mut Vec<Vec<f64>>, period_s: f64) -> (Option<Drift>, bool) {
    let longest = (0..segments.len()).rev().max_by_key(|i| segments[*i].len());
    let (trend, walks) = longest.map_or((None, false), |i| find_slow(&segments[i]));
    let (Some(longest), Some(trend)) = (longest, trend) else {
        return (None, walks);
    };
    let length = segments[longest].len() as f64;
    if trend.size != 0.0 {
        segments.swap(0, longest);
        segments.truncate(1);
    }
    for segment in segments {
        let samples = segment.iter_mut().enumerate();
        samples.for_each(|(k, value)| *value -= trend.at(k as f64));
    }
    let drift = Drift {
        change: trend.at(length) - trend.at(0.0),
        during_s: length * period_s,
        time_constant_s: Some(trend.constant * period_s).filter(|s| s.is_finite()),
    };
    (Some(drift), walks)
}

/// The trend that explains the slow part of samples best, and whether there is a random walk beside it.
fn find_slow(samples: &[f64]) -> (Option<Trend>, bool) {
    let width = samples.len().div_ceil(BLOCKS).max(1);
    let blocks = samples.chunks_exact(width);
    let count = blocks.len();
    if count < MIN_BLOCKS {
        return (None, false);
    }
    let mean = |block: &[f64]| block.iter().map(|x| x - samples[0]).sum::<f64>() / width as f64;
    let cosines = cosines(count);
    let values = &cosines * DVector::from_iterator(count, blocks.map(mean));
    let length = (count * width) as f64;
    let mut best = (f64::INFINITY, None, false);
    let mut trend_alone = f64::INFINITY;
    // Tries a trend of these columns, over time from 0 to 1, with and without a walk; the score without.
    let mut compare = |columns: &[Trend]| {
        let shape = |k: usize, j: usize| columns[j].at((k as f64 + 0.5) / count as f64);
        let shapes = &cosines * DMatrix::from_fn(count, columns.len(), shape);
        let penalties = columns.iter();
        let penalties = penalties.map(|c| c.slope * FOR_LINE + c.size * FOR_EXPONENTIAL);
        let penalty: f64 = penalties.sum();
        let mut without = f64::INFINITY;
        for (walks, for_walk) in [(false, 0.0), (true, FOR_WALK)] {
            let Some((deviance, sizes)) = deviance(&values, &shapes, walks) else {
                continue;
            };
            let score = deviance + penalty + for_walk;
            if !walks {
                without = score;
                trend_alone = trend_alone.min(deviance + IN_DOUBT * penalty);
            }
            if score < best.0 {
                let sized = || columns.iter().zip(&sizes);
                let trend = columns.last().map(|last| Trend {
                    slope: sized().map(|(c, size)| c.slope * size).sum::<f64>() / length,
                    size: sized().map(|(c, size)| c.size * size).sum(),
                    constant: last.constant * length,
                });
                best = (score, trend, walks);
            }
        }
        without
    };
    let line = Trend {
        slope: 1.0,
        size: 0.0,
        constant: f64::INFINITY,
    };
    compare(&[]);
    compare(&[line]);
    // A time constant that is off leaves what looks like a walk.
    let coarse: Vec<f64> = (0..CONSTANTS).map(|k| 0.5 * f64::from(k)).collect();
    let finer = [0.25, 0.125, 0.0625, 0.031].map(|step| vec![-step, step]);
    let mut nearest = (f64::INFINITY, SHORTEST);
    for exponents in std::iter::once(coarse).chain(finer) {
        let middle = nearest.1;
        for exponent in exponents {
            let exponential = Trend {
                slope: 0.0,
                size: 1.0,
                constant: middle * 2_f64.powf(exponent),
            };
            let mut score = compare(&[exponential]);
            if exponential.constant < LONGEST_BESIDE_LINE {
                score = score.min(compare(&[line, exponential]));
            }
            if score < nearest.0 {
                nearest = (score, exponential.constant);
            }
        }
    }
    let (score, trend, walks) = best;
    (trend, walks && score < trend_alone)
}

/// The orthonormal cosine transform without its first row, the mean.
fn cosines(count: usize) -> DMatrix<f64> {
    let n = count as f64;
    DMatrix::from_fn(count - 1, count, |i, k| {
        (2.0 / n).sqrt() * (PI * (i + 1) as f64 * (k as f64 + 0.5) / n).cos()
    })
}

/// −2 ln L of noise beside a trend of these shapes, and the sizes of the shapes.
fn deviance(
    values: &DVector<f64>,
    shapes: &DMatrix<f64>,
    walks: bool,
) -> Option<(f64, DVector<f64>)> {
    let count = values.len();
    // Of white noise, of flicker noise, and of means over blocks of a random walk.
    let powers = MatrixXx3::from_fn(count, |k, j| {
        let angle = PI * (k + 1) as f64 / (count + 1) as f64;
        let step = 2.0 * (0.5 * angle).sin();
        [1.0, 1.0 / step, (2.0 + angle.cos()) / (3.0 * step * step)][j]
    });
    let mut parts = Vector3::y();
    let (mut residual, mut sizes) = (values.clone(), DVector::zeros(0));
    for iteration in 0..ITERATIONS {
        let roots = (&powers * parts).map(f64::sqrt);
        let mut design = shapes.clone();
        let columns = design.column_iter_mut();
        columns.for_each(|mut column| column.component_div_assign(&roots));
        let normal = design.tr_mul(&design).cholesky()?;
        sizes = normal.solve(&design.tr_mul(&values.component_div(&roots)));
        residual = values - shapes * &sizes;
        let squares = residual.map(|r| r * r);
        if iteration == 0 {
            parts = powers.map(f64::recip).tr_mul(&squares) / (3 * count) as f64;
            parts.z *= f64::from(u8::from(walks));
        }
        // Raises the likelihood of parts that add (C. Févotte, *Neural Computation* 21, 2009).
        for _ in 0..2 {
            let model = &powers * parts;
            let down = powers.tr_mul(&model.map(f64::recip));
            let up =
                powers.tr_mul(&squares.zip_map(&model, |square, model| square / (model * model)));
            parts.component_mul_assign(&up.component_div(&down));
        }
    }
    let each = residual.zip_map(&(&powers * parts), |r, model| model.ln() + r * r / model);
    Some((each.sum(), sizes)).filter(|(deviance, _)| deviance.is_finite())
}
