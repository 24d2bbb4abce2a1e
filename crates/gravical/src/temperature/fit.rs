//! Least squares: one offset for each placement, a polynomial of the
//! temperature for the bias, and one for the scale where it can be told apart.

use nalgebra::{DMatrix, DVector};

use super::polynomial::evaluate;

/// One mean, of one channel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub stretch: usize,
    pub t_c: f64,
    pub y: f64,
    /// What the channel reads in that placement on the whole, in the unit of
    /// the file: what a change of the scale multiplies.
    pub level: f64,
}

/// What is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    pub order: usize,
    pub with_scale: bool,
}

/// Temperature is centred and scaled before it is raised to powers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub centre_c: f64,
    pub half_c: f64,
    /// Unit of `level`, so that the columns are of one size.
    pub gravity: f64,
}

/// y = offset + drift(T − centre) + gain(T − centre) · level.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    frame: Frame,
    /// Of each stretch; none where it has no sample.
    offsets: Vec<Option<f64>>,
    /// Input unit per °C, °C², ….
    pub drift: Vec<f64>,
    /// 1 per °C, °C², …; empty without scale.
    pub gain: Vec<f64>,
}

/// Singular values below this share of the largest are none.
const RANK: f64 = 1e-9;

impl Fit {
    /// Fits `samples`; none when they do not determine the parameters.
    pub fn new(samples: &[Sample], shape: Shape, frame: Frame) -> Option<Self> {
        let stretches = samples.iter().map(|s| s.stretch + 1).max()?;
        let mut column = vec![None; stretches];
        let mut offsets = 0;
        for sample in samples {
            if column[sample.stretch].is_none() {
                column[sample.stretch] = Some(offsets);
                offsets += 1;
            }
        }
        let powers = shape.order;
        let width = offsets + powers * if shape.with_scale { 2 } else { 1 };
        if samples.len() < width + 1 {
            return None;
        }
        let mut matrix = DMatrix::zeros(samples.len(), width);
        for (row, sample) in samples.iter().enumerate() {
            if let Some(c) = column[sample.stretch] {
                matrix[(row, c)] = 1.0;
            }
            let tau = (sample.t_c - frame.centre_c) / frame.half_c;
            for k in 0..powers {
                let power = tau.powi(k as i32 + 1);
                matrix[(row, offsets + k)] = power;
                if shape.with_scale {
                    matrix[(row, offsets + powers + k)] = power * sample.level / frame.gravity;
                }
            }
        }
        let y = DVector::from_iterator(samples.len(), samples.iter().map(|s| s.y));
        // The decomposition may never end on what is not finite.
        if matrix.iter().chain(&y).any(|v| !v.is_finite()) {
            return None;
        }
        let svd = matrix.svd(true, true);
        let tolerance = RANK * svd.singular_values.max();
        if svd.rank(tolerance) < width {
            return None;
        }
        let solved = svd.solve(&y, tolerance).ok()?;
        if !solved.iter().all(|v| v.is_finite()) {
            return None;
        }
        let per_c = |k: usize| frame.half_c.powi(-(k as i32 + 1));
        let gain = if shape.with_scale { powers } else { 0 };
        Some(Fit {
            frame,
            offsets: column.iter().map(|c| c.map(|c| solved[c])).collect(),
            drift: (0..powers)
                .map(|k| solved[offsets + k] * per_c(k))
                .collect(),
            gain: (0..gain)
                .map(|k| solved[offsets + powers + k] * per_c(k) / frame.gravity)
                .collect(),
        })
    }

    /// What the temperature adds to a sample.
    fn drift_of(&self, sample: &Sample) -> f64 {
        let x = sample.t_c - self.frame.centre_c;
        evaluate(&self.drift, x) + evaluate(&self.gain, x) * sample.level
    }

    /// What is left of `samples`. The offset of a placement is that of the
    /// fit; of one that took no part in it, the mean of what is left there.
    pub fn residuals(&self, samples: &[Sample]) -> Vec<f64> {
        let left: Vec<f64> = samples.iter().map(|s| s.y - self.drift_of(s)).collect();
        let means = means_by_stretch(samples, &left);
        samples
            .iter()
            .zip(left)
            .map(|(s, v)| {
                let known = self.offsets.get(s.stretch).copied().flatten();
                v - known.unwrap_or(means[s.stretch])
            })
            .collect()
    }

    /// 1 − Σ residuals² / Σ (y − mean of its placement)²; none when nothing
    /// varies.
    pub fn r2(&self, samples: &[Sample]) -> Option<f64> {
        let total = squares(&about_means(samples));
        let r2 = 1.0 - squares(&self.residuals(samples)) / total;
        r2.is_finite().then_some(r2)
    }
}

/// The samples less the mean of their placement.
pub(super) fn about_means(samples: &[Sample]) -> Vec<f64> {
    let y: Vec<f64> = samples.iter().map(|s| s.y).collect();
    let means = means_by_stretch(samples, &y);
    samples.iter().map(|s| s.y - means[s.stretch]).collect()
}

fn means_by_stretch(samples: &[Sample], values: &[f64]) -> Vec<f64> {
    let stretches = samples.iter().map(|s| s.stretch + 1).max().unwrap_or(0);
    let mut sums = vec![(0.0, 0.0); stretches];
    for (sample, value) in samples.iter().zip(values) {
        sums[sample.stretch].0 += value;
        sums[sample.stretch].1 += 1.0;
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

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame {
        centre_c: 20.0,
        half_c: 30.0,
        gravity: 9.81,
    };

    /// Two placements at ±1 g over −10 to 50 °C.
    fn samples(drift: &[f64], gain: &[f64]) -> Vec<Sample> {
        (0..2)
            .flat_map(|stretch| (0..60).map(move |i| (stretch, -10.0 + f64::from(i))))
            .map(|(stretch, t_c)| {
                let level = [9.81, -9.81][stretch];
                let x = t_c - FRAME.centre_c;
                let y = 0.3 + level + evaluate(drift, x) + evaluate(gain, x) * level;
                Sample {
                    stretch,
                    t_c,
                    y,
                    level,
                }
            })
            .collect()
    }

    #[test]
    fn bias_and_scale_are_told_apart_in_two_placements() {
        let (drift, gain) = ([2e-3, -1e-5], [4e-4, 2e-6]);
        let all = samples(&drift, &gain);
        let shape = Shape {
            order: 2,
            with_scale: true,
        };
        let fit = Fit::new(&all, shape, FRAME).unwrap();
        for (found, put) in fit.drift.iter().zip(drift) {
            assert!((found - put).abs() < 1e-12, "{found}");
        }
        for (found, put) in fit.gain.iter().zip(gain) {
            assert!((found - put).abs() < 1e-13, "{found}");
        }
        assert!(rms(&fit.residuals(&all)) < 1e-12);
        // In one placement the two have the same effect.
        let one: Vec<Sample> = all.iter().copied().filter(|s| s.stretch == 0).collect();
        assert!(Fit::new(&one, shape, FRAME).is_none());
    }

    #[test]
    fn r2_is_that_of_what_was_not_fitted() {
        let all = samples(&[1e-3], &[0.0]);
        let (cold, warm): (Vec<Sample>, Vec<Sample>) = all.iter().partition(|s| s.stretch == 0);
        let shape = Shape {
            order: 1,
            with_scale: false,
        };
        let fit = Fit::new(&cold, shape, FRAME).unwrap();
        // The other placement has an offset of its own: gravity is no drift.
        assert!(fit.r2(&warm).unwrap() > 1.0 - 1e-9);
        let turned: Vec<Sample> = warm
            .iter()
            .map(|s| Sample {
                y: -9.51 - (s.y + 9.51),
                ..*s
            })
            .collect();
        // The opposite slope: residuals of twice the size, 1 − 4.
        assert!((fit.r2(&turned).unwrap() + 3.0).abs() < 1e-9);
        let flat: Vec<Sample> = warm.iter().map(|s| Sample { y: 1.0, ..*s }).collect();
        assert_eq!(fit.r2(&flat), None);
    }

    #[test]
    fn too_few_samples_determine_nothing() {
        let few: Vec<Sample> = samples(&[1e-3], &[]).into_iter().take(3).collect();
        let shape = Shape {
            order: 3,
            with_scale: false,
        };
        assert!(Fit::new(&few, shape, FRAME).is_none());
        assert!(Fit::new(&[], shape, FRAME).is_none());
    }
}
