//! Least squares: an offset for each pose, a polynomial of the temperature for the bias, and one
//! for the scale if it can be distinguished.

use nalgebra::{DMatrix, DVector};

use crate::polynomial::evaluate;

/// One mean of one channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub pose: usize,
    pub t_c: f64,
    pub y: f64,
    /// Mean of the channel in that pose, in the unit of the file, which a change of the scale
    /// multiplies.
    pub level: f64,
}

/// Shape of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub order: usize,
    pub with_scale: bool,
}

/// Centre and scale of the temperature before it is raised to powers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub centre_c: f64,
    pub half_c: f64,
    /// Scale of `level`, so that the columns have similar sizes.
    pub gravity: f64,
}

/// y = offset + drift(T − centre) + gain(T − centre) · level.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    frame: Frame,
    /// For each pose; `None` without samples.
    offsets: Vec<Option<f64>>,
    /// Input unit per °C, °C², ….
    pub drift: Vec<f64>,
    /// 1 per °C, °C², …; empty without scale.
    pub gain: Vec<f64>,
}

/// Smallest singular value, relative to the size of the columns.
const RANK: f64 = 1e-9;

impl Fit {
    /// Fits `samples`; `None` if they do not determine the parameters.
    pub fn new(samples: &[Sample], shape: Shape, frame: Frame) -> Option<Self> {
        let intervals = samples.iter().map(|s| s.pose + 1).max()?;
        let mut is_used = vec![false; intervals];
        samples.iter().for_each(|s| is_used[s.pose] = true);
        let offsets = is_used.iter().filter(|used| **used).count();
        let powers = shape.order;
        let width = powers * if shape.with_scale { 2 } else { 1 };
        if samples.len() < offsets + width + 1 {
            return None;
        }
        let mut matrix = DMatrix::zeros(samples.len(), width);
        for (row, sample) in samples.iter().enumerate() {
            let tau = (sample.t_c - frame.centre_c) / frame.half_c;
            for k in 0..powers {
                let power = tau.powi(k as i32 + 1);
                matrix[(row, k)] = power;
                if shape.with_scale {
                    matrix[(row, powers + k)] = power * sample.level / frame.gravity;
                }
            }
        }
        let mut y = DVector::from_iterator(samples.len(), samples.iter().map(|s| s.y));
        // The decomposition may not terminate for values that are not finite.
        if matrix.iter().chain(&y).any(|v| !v.is_finite()) {
            return None;
        }
        // The offsets are eliminated: what is left of a column, less its mean in each pose, fits
        // what is left of y (Frisch and Waugh, Econometrica 1 (1933) 387).
        let tolerance = RANK * matrix.norm();
        let subtract_means = |column: &mut [f64]| {
            let means = means_by_pose(samples, column);
            let rows = column.iter_mut().zip(samples);
            rows.for_each(|(value, sample)| *value -= means[sample.pose]);
            means
        };
        let columns = matrix.as_mut_slice().chunks_mut(samples.len());
        let means: Vec<Vec<f64>> = columns.map(subtract_means).collect();
        let mean_y = subtract_means(y.as_mut_slice());
        let svd = matrix.svd(true, true);
        if svd.rank(tolerance) < width {
            return None;
        }
        let solved = svd.solve(&y, tolerance).ok()?;
        if !solved.iter().all(|v| v.is_finite()) {
            return None;
        }
        let offset = |pose: usize| {
            let fitted = means.iter().zip(&solved).map(|(mean, by)| mean[pose] * by);
            is_used[pose].then(|| mean_y[pose] - fitted.sum::<f64>())
        };
        let per_c = |k: usize| frame.half_c.powi(-(k as i32 + 1));
        let gain = if shape.with_scale { powers } else { 0 };
        Some(Fit {
            frame,
            offsets: (0..intervals).map(offset).collect(),
            drift: (0..powers).map(|k| solved[k] * per_c(k)).collect(),
            gain: (0..gain)
                .map(|k| solved[powers + k] * per_c(k) / frame.gravity)
                .collect(),
        })
    }

    /// Drift of a sample.
    fn drift_of(&self, sample: &Sample) -> f64 {
        let x = sample.t_c - self.frame.centre_c;
        evaluate(&self.drift, x) + evaluate(&self.gain, x) * sample.level
    }

    /// Residuals of `samples`. The offset of a pose is that of the fit; for a pose that was not
    /// in the fit it is the mean residual of that pose.
    pub fn residuals(&self, samples: &[Sample]) -> Vec<f64> {
        let left: Vec<f64> = samples.iter().map(|s| s.y - self.drift_of(s)).collect();
        let means = means_by_pose(samples, &left);
        samples
            .iter()
            .zip(left)
            .map(|(s, v)| {
                let known = self.offsets.get(s.pose).copied().flatten();
                v - known.unwrap_or(means[s.pose])
            })
            .collect()
    }

    /// 1 − Σ residuals² / Σ (y − mean of its pose)²; `None` if nothing varies.
    pub fn r2(&self, samples: &[Sample]) -> Option<f64> {
        let total = squares(&minus_means(samples));
        let r2 = 1.0 - squares(&self.residuals(samples)) / total;
        r2.is_finite().then_some(r2)
    }
}

/// The samples minus the mean of their pose.
pub(super) fn minus_means(samples: &[Sample]) -> Vec<f64> {
    let y: Vec<f64> = samples.iter().map(|s| s.y).collect();
    let means = means_by_pose(samples, &y);
    samples.iter().map(|s| s.y - means[s.pose]).collect()
}

fn means_by_pose(samples: &[Sample], values: &[f64]) -> Vec<f64> {
    let intervals = samples.iter().map(|s| s.pose + 1).max().unwrap_or(0);
    let mut sums = vec![(0.0, 0.0); intervals];
    for (sample, value) in samples.iter().zip(values) {
        sums[sample.pose].0 += value;
        sums[sample.pose].1 += 1.0;
    }
    sums.iter().map(|(sum, n)| sum / n).collect()
}

fn squares(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}

/// Root mean square.
pub(super) fn rms(values: &[f64]) -> f64 {
    (squares(values) / values.len().max(1) as f64).sqrt()
}
