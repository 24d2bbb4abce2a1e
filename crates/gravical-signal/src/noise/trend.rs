//! What a recording shows at long times: a trend, a random walk, or neither.
//!
//! A bias that drifts looks like a random walk in the Allan deviation. In the cosine transform of the
//! means over blocks the two differ: the coefficients of noise are independent, with a power that is
//! white, flicker (∝ 1/f) or of a random walk (∝ 1/f²), those of a trend are known but for its size. The
//! models with and without each are compared by their likelihood (P. Whittle, *Arkiv för Matematik*
//! 2, 1953) less a penalty for every parameter.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

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
const ITERATIONS: usize = 40;

/// A trend: a line, an exponential, or both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    /// Slope of the line, 1/samples
    pub slope: f64,
    /// Size of the exponential, which decays
    pub size: f64,
    /// Its time constant, samples; infinite without one
    pub constant: f64,
}

impl Trend {
    /// Its value at a sample, counted from the first of the segment in which it was found.
    pub fn at(&self, sample: f64) -> f64 {
        self.slope * sample + self.size * (-sample / self.constant).exp()
    }
}

/// What explains the slow part of a segment best.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slow {
    /// A trend
    pub trend: Option<Trend>,
    /// A random walk beside it
    pub walks: bool,
}

/// Finds it in evenly spaced samples at rest.
pub fn find_slow(samples: &[f64]) -> Slow {
    let width = samples.len().div_ceil(BLOCKS).max(1);
    let blocks = samples.chunks_exact(width);
    let count = blocks.len();
    if count < MIN_BLOCKS {
        return Slow::default();
    }
    let mean = |block: &[f64]| block.iter().map(|x| x - samples[0]).sum::<f64>() / width as f64;
    let cosines = cosines(count);
    let values = &cosines * DVector::from_iterator(count, blocks.map(mean));
    let shape = |of: &dyn Fn(f64) -> f64| {
        &cosines * DVector::from_fn(count, |k, _| of((k as f64 + 0.5) / count as f64))
    };
    let line = shape(&|t| t);
    let length = (count * width) as f64;
    let mut best = (f64::INFINITY, Slow::default());
    let mut trend_alone = f64::INFINITY;
    // Tries a trend with and without a walk; the score without.
    let mut compare = |penalty: f64, constant: f64, columns: &[DVector<f64>], has_line: bool| {
        let mut without = f64::INFINITY;
        for walks in [false, true] {
            let Some((deviance, sizes)) = deviance(&values, columns, walks) else {
                continue;
            };
            let score = deviance + penalty + if walks { FOR_WALK } else { 0.0 };
            if !walks {
                without = score;
                trend_alone = trend_alone.min(deviance + IN_DOUBT * penalty);
            }
            if score < best.0 {
                let part = |is_there: bool, size: Option<&f64>| {
                    size.copied().filter(|_| is_there).unwrap_or(0.0)
                };
                let trend = Trend {
                    slope: part(has_line, sizes.first()) / length,
                    size: part(constant.is_finite(), sizes.last()),
                    constant: constant * length,
                };
                let trend = (!columns.is_empty()).then_some(trend);
                best = (score, Slow { trend, walks });
            }
        }
        without
    };
    compare(0.0, f64::INFINITY, &[], false);
    compare(FOR_LINE, f64::INFINITY, std::slice::from_ref(&line), true);
    let mut exponential = |constant: f64| {
        let column = shape(&|t| (-t / constant).exp());
        let alone = compare(
            FOR_EXPONENTIAL,
            constant,
            std::slice::from_ref(&column),
            false,
        );
        // A longer one is a line.
        if constant >= 0.5 {
            return alone;
        }
        let both = [line.clone(), column];
        alone.min(compare(FOR_LINE + FOR_EXPONENTIAL, constant, &both, true))
    };
    let mut nearest = (f64::INFINITY, SHORTEST);
    let mut try_one = |constant: f64, nearest: &mut (f64, f64)| {
        let score = exponential(constant);
        if score < nearest.0 {
            *nearest = (score, constant);
        }
    };
    for k in 0..CONSTANTS {
        try_one(SHORTEST * 2_f64.powf(0.5 * f64::from(k)), &mut nearest);
    }
    // A time constant that is off leaves what looks like a walk.
    for step in [0.25, 0.125, 0.0625, 0.031] {
        let middle = nearest.1;
        for exponent in [-step, step] {
            try_one(middle * 2_f64.powf(exponent), &mut nearest);
        }
    }
    let (score, slow) = best;
    let walks = slow.walks && score < trend_alone;
    Slow { walks, ..slow }
}

/// The orthonormal cosine transform without its first row, the mean.
fn cosines(count: usize) -> DMatrix<f64> {
    let n = count as f64;
    DMatrix::from_fn(count - 1, count, |i, k| {
        (2.0 / n).sqrt() * (PI * (i + 1) as f64 * (k as f64 + 0.5) / n).cos()
    })
}

/// −2 ln L of noise beside the trend of these columns, and the sizes of the columns.
fn deviance(
    values: &DVector<f64>,
    columns: &[DVector<f64>],
    walks: bool,
) -> Option<(f64, Vec<f64>)> {
    let count = values.len();
    let powers: Vec<[f64; 3]> = (1..=count)
        .map(|k| {
            let angle = PI * k as f64 / (count + 1) as f64;
            let step = 2.0 * (0.5 * angle).sin();
            // Means over blocks of a random walk.
            let walk = (2.0 + angle.cos()) / (3.0 * step * step);
            [1.0, 1.0 / step, if walks { walk } else { 0.0 }]
        })
        .collect();
    let mut residual = values.clone();
    let mut sizes = vec![0.0; columns.len()];
    let mut parts = [0.0; 3];
    let mut model: Vec<f64> = powers.iter().map(|p| p[1]).collect();
    for iteration in 0..ITERATIONS {
        if !columns.is_empty() {
            let weigh = |v: &DVector<f64>| DVector::from_fn(count, |k, _| v[k] / model[k].sqrt());
            let design = DMatrix::from_columns(&columns.iter().map(weigh).collect::<Vec<_>>());
            let normal = design.tr_mul(&design).cholesky()?;
            let solved = normal.solve(&design.tr_mul(&weigh(values)));
            residual = values.clone();
            for (column, size) in columns.iter().zip(&solved) {
                residual.axpy(-size, column, 1.0);
            }
            sizes = solved.iter().copied().collect();
        }
        let squares: Vec<f64> = residual.iter().map(|r| r * r).collect();
        if iteration == 0 {
            let usual = |j: usize| {
                let shares = squares.iter().zip(&powers).map(|(s, p)| s / p[j]);
                shares.sum::<f64>() / (3 * count) as f64
            };
            parts = [usual(0), usual(1), if walks { usual(2) } else { 0.0 }];
        }
        // Raises the likelihood of parts that add (C. Févotte, *Neural Computation* 21, 2009).
        for _ in 0..2 {
            let mut ratios = [[0.0; 2]; 3];
            for (square, power) in squares.iter().zip(&powers) {
                let model = total(&parts, power);
                for j in 0..3 {
                    ratios[j][0] += square * power[j] / (model * model);
                    ratios[j][1] += power[j] / model;
                }
            }
            for (part, [up, down]) in parts.iter_mut().zip(ratios) {
                *part *= if down > 0.0 { up / down } else { 0.0 };
            }
        }
        model = powers.iter().map(|power| total(&parts, power)).collect();
    }
    let each = residual.iter().zip(&model).map(|(r, p)| p.ln() + r * r / p);
    Some((each.sum::<f64>(), sizes)).filter(|(deviance, _)| deviance.is_finite())
}

fn total(parts: &[f64; 3], power: &[f64; 3]) -> f64 {
    parts
        .iter()
        .zip(power)
        .map(|(part, power)| part * power)
        .sum()
}
