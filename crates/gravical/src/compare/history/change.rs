//! Did a set of quantities change over several measurements? Generalised least squares with a
//! constant, and with one step after each of them.
//!
//! Measurement i is x_i = μ + σ_g m_i δ + noise of covariance C_i, where δ, of unit variance, is an
//! error that all measurements of a group share: that of one value of gravity. The χ² of the
//! residuals of a constant μ has as many degrees of freedom as the measurements beyond the first
//! determine; with a step Δ after measurement k it falls by Δᵀ Cov(Δ)⁻¹ Δ, the test of that step.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::uncertainty::{ChiSquare, freedom_of_sum, information, upper_tail};

/// Eigenvalues of the normal matrix, scaled to ones on its diagonal, under this share of the
/// largest are zero: nothing determines that direction.
const RANK_TOLERANCE: f64 = 1e-10;

/// A measurement of the quantities.
pub(super) struct Measured {
    pub values: DVector<f64>,
    /// Without what is shared.
    pub covariance: DMatrix<f64>,
    /// The group that shares an error, and the effect of one standard deviation of it.
    pub shared: Option<(usize, DVector<f64>)>,
    /// Degrees of freedom that the covariance is estimated with; none where it counts as known.
    pub freedom: Option<f64>,
}

/// What the measurements say of a change.
pub(super) struct Change {
    /// All measurements against their weighted mean.
    pub whole: ChiSquare,
    /// The step that explains most.
    pub step: Option<Step>,
    /// The weighted mean.
    pub mean: DVector<f64>,
}

/// A step between two measurements.
pub(super) struct Step {
    /// Number of measurements before it.
    pub before: usize,
    /// Its test.
    pub test: ChiSquare,
    /// Mean after less mean before.
    pub difference: DVector<f64>,
    /// Covariance of the difference.
    pub covariance: DMatrix<f64>,
}

impl Change {
    /// Tests `measured`, in order of time. None for less than two, or where no direction is
    /// determined twice.
    pub fn of(measured: &[Measured]) -> Option<Self> {
        let n = measured.len();
        if n < 2 {
            return None;
        }
        let normal = Normal::of(measured)?;
        let constant = normal.fit(n);
        let freedom = normal.rank.checked_sub(constant.rank)?;
        if freedom == 0 {
            return None;
        }
        let (corrected, known_by) = welch(measured, constant.chi2);
        let whole = ChiSquare {
            chi2: corrected,
            degrees_of_freedom: freedom,
            covariance_freedom: known_by,
            p_value: upper_tail(corrected, f64::from(freedom), known_by)?,
        };
        let step = (1..n).filter_map(|before| normal.step(measured, before, &constant));
        Some(Change {
            whole,
            // Probabilities below the smallest number are zero.
            step: step.min_by(|a, b| {
                let p = a.test.p_value.total_cmp(&b.test.p_value);
                p.then(b.test.chi2.total_cmp(&a.test.chi2))
            }),
            mean: constant.solution.rows(0, normal.size).into_owned(),
        })
    }

    /// Probability of a result as extreme as the more extreme of the two tests by chance: the
    /// steps, one after each measurement, and both tests are each given their share (Bonferroni).
    /// With two measurements there is one test.
    pub fn p_value(&self, count: usize) -> f64 {
        let Some(step) = self.step.as_ref().filter(|_| count > 2) else {
            return self.whole.p_value;
        };
        let steps = (count - 1) as f64 * step.test.p_value;
        (2.0 * steps.min(self.whole.p_value)).min(1.0)
    }
}

/// The normal equations, measurement by measurement.
struct Normal<'a> {
    measured: &'a [Measured],
    /// Inverse covariances.
    weights: Vec<DMatrix<f64>>,
    /// Sum of their ranks.
    rank: u32,
    /// Number of quantities, and of groups that share an error.
    size: usize,
    groups: usize,
}

/// A least squares solution.
struct Solution {
    solution: DVector<f64>,
    inverse: DMatrix<f64>,
    rank: u32,
    chi2: f64,
}

impl<'a> Normal<'a> {
    fn of(measured: &'a [Measured]) -> Option<Self> {
        let weights: Option<Vec<_>> = measured
            .iter()
            .map(|m| information(&m.covariance))
            .collect();
        let (weights, ranks): (Vec<_>, Vec<u32>) = weights?.into_iter().unzip();
        let shared = measured.iter().filter_map(|m| m.shared.as_ref());
        Some(Normal {
            measured,
            weights,
            rank: ranks.iter().sum(),
            size: measured.first()?.values.len(),
            groups: shared.map(|(group, _)| group + 1).max().unwrap_or(0),
        })
    }

    /// Fits a constant, and where `before` is less than the number of measurements a step after
    /// that many. Unknowns: the constant, the step, the shared errors. The rank does not count
    /// the latter: each comes with one observation of its own, that it is near zero.
    fn fit(&self, before: usize) -> Solution {
        let step = before < self.measured.len();
        let shared_from = if step { 2 * self.size } else { self.size };
        let count = shared_from + self.groups;
        let mut normal = DMatrix::zeros(count, count);
        let mut right = DVector::zeros(count);
        for g in shared_from..count {
            normal[(g, g)] = 1.0;
        }
        // Differences from the first: what they have in common would cost digits.
        let first = &self.measured[0].values;
        let mut squares = 0.0;
        for (i, (m, w)) in self.measured.iter().zip(&self.weights).enumerate() {
            let mut design = DMatrix::zeros(self.size, count);
            for k in 0..self.size {
                design[(k, k)] = 1.0;
                if step && i >= before {
                    design[(k, self.size + k)] = 1.0;
                }
            }
            if let Some((group, effect)) = &m.shared {
                design.set_column(shared_from + group, effect);
            }
            let d = &m.values - first;
            let weighted = w * &d;
            squares += d.dot(&weighted);
            right += design.transpose() * weighted;
            normal += design.transpose() * w * design;
        }
        let (inverse, rank) = pseudo_inverse(&normal);
        let mut solution = &inverse * &right;
        let chi2 = (squares - right.dot(&solution)).max(0.0);
        for k in 0..self.size {
            solution[k] += first[k];
        }
        Solution {
            solution,
            inverse,
            rank: rank.saturating_sub(self.groups as u32),
            chi2,
        }
    }

    fn step(&self, measured: &[Measured], before: usize, constant: &Solution) -> Option<Step> {
        let with = self.fit(before);
        let rank = with.rank.checked_sub(constant.rank).filter(|r| *r > 0)?;
        let chi2 = (constant.chi2 - with.chi2).max(0.0);
        let share = |i: usize| match i < before {
            true => before as f64,
            false => (measured.len() - before) as f64,
        };
        let parts = measured.iter().enumerate();
        let parts: Vec<(f64, Option<f64>)> = parts
            .map(|(i, m)| (m.covariance.trace() / share(i).powi(2), m.freedom))
            .collect();
        let known_by = freedom_of_sum(&parts);
        let n = self.size;
        Some(Step {
            before,
            test: ChiSquare {
                chi2,
                degrees_of_freedom: rank,
                covariance_freedom: known_by,
                p_value: upper_tail(chi2, f64::from(rank), known_by)?,
            },
            difference: with.solution.rows(n, n).into_owned(),
            covariance: with.inverse.view((n, n), (n, n)).into_owned(),
        })
    }
}

/// Inverse of a normal matrix in the directions that it determines, and their number.
fn pseudo_inverse(normal: &DMatrix<f64>) -> (DMatrix<f64>, u32) {
    let scale = normal.diagonal().map(|v| match v > 0.0 {
        true => 1.0 / v.sqrt(),
        false => 0.0,
    });
    let scale = DMatrix::from_diagonal(&scale);
    let eigen = SymmetricEigen::new(&scale * normal * &scale);
    let least = RANK_TOLERANCE * eigen.eigenvalues.max();
    let rank = eigen.eigenvalues.iter().filter(|v| **v > least).count();
    let inverse = eigen
        .eigenvalues
        .map(|v| if v > least { 1.0 / v } else { 0.0 });
    let v = &scale * eigen.eigenvectors;
    (
        &v * DMatrix::from_diagonal(&inverse) * v.transpose(),
        rank as u32,
    )
}

/// χ² of several measurements, each with a covariance that is estimated by itself, and the
/// degrees of freedom with which it is compared with F (Welch 1951, Biometrika 38, 330, with the
/// traces as variances).
fn welch(measured: &[Measured], chi2: f64) -> (f64, Option<f64>) {
    let n = measured.len() as f64;
    let weights = || measured.iter().map(|m| 1.0 / m.covariance.trace());
    let all: f64 = weights().sum();
    let known = weights().zip(measured);
    let doubt: f64 = known
        .filter_map(|(w, m)| Some((1.0 - w / all).powi(2) / m.freedom?))
        .sum();
    if doubt <= 0.0 {
        return (chi2, None);
    }
    let square = n * n - 1.0;
    (
        chi2 / (1.0 + 2.0 * (n - 2.0) / square * doubt),
        Some(square / (3.0 * doubt)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    fn measured(values: &[f64], sd: f64) -> Measured {
        Measured {
            values: DVector::from_column_slice(values),
            covariance: DMatrix::identity(values.len(), values.len()) * (sd * sd),
            shared: None,
            freedom: None,
        }
    }

    #[test]
    fn chi_square_of_a_constant_and_of_a_step_by_hand() {
        // Mean 1.5, residuals −1.5, −0.5, 0.5, 1.5 of one σ.
        let all: Vec<Measured> = (0..4).map(|i| measured(&[f64::from(i)], 1.0)).collect();
        let change = Change::of(&all).unwrap();
        assert!((change.mean[0] - 1.5).abs() < 1e-12);
        assert!((change.whole.chi2 - 5.0).abs() < 1e-12);
        assert_eq!(change.whole.degrees_of_freedom, 3);
        // 0.5 → 2.5, each the mean of two: 2²/(1/2 + 1/2).
        let step = change.step.as_ref().unwrap();
        assert_eq!((step.before, step.test.degrees_of_freedom), (2, 1));
        assert!((step.test.chi2 - 4.0).abs() < 1e-12);
        assert!((step.difference[0] - 2.0).abs() < 1e-12);
        assert!((step.covariance[(0, 0)] - 1.0).abs() < 1e-12);
        assert!((change.p_value(4) - (6.0 * step.test.p_value).min(1.0)).abs() < 0.5);
    }

    #[test]
    fn the_largest_of_steps_beyond_all_probability_is_named() {
        let at = |v: f64| measured(&[v], 1e-3);
        let change = Change::of(&[at(0.0), at(1.0), at(1.0), at(9.0)]).unwrap();
        assert_eq!(change.step.unwrap().before, 3);
    }

    #[test]
    fn two_measurements_are_compared_as_compare_does() {
        let pair = [measured(&[0.0, 0.0], 3.0), measured(&[5.0, 10.0], 4.0)];
        let change = Change::of(&pair).unwrap();
        assert!((change.whole.chi2 - 5.0).abs() < 1e-12);
        assert_eq!(change.p_value(2), change.whole.p_value);
        assert!(Change::of(&pair[..1]).is_none());
    }

    #[test]
    fn an_error_in_common_counts_between_groups_only() {
        let shared = |value: f64, group: usize| Measured {
            shared: Some((group, DVector::from_vec(vec![3.0]))),
            ..measured(&[value], 1.0)
        };
        // Within one group the shared error cancels: 2²/(1 + 1).
        let one = Change::of(&[shared(0.0, 0), shared(2.0, 0)]).unwrap();
        assert!((one.whole.chi2 - 2.0).abs() < 1e-12);
        // Between two groups it counts twice: 2²/(1 + 9 + 1 + 9).
        let two = Change::of(&[shared(0.0, 0), shared(2.0, 1)]).unwrap();
        assert!((two.whole.chi2 - 0.2).abs() < 1e-12);
        assert_eq!(two.whole.degrees_of_freedom, 1);
    }

    #[test]
    fn a_direction_without_variance_is_not_tested() {
        let mut all: Vec<Measured> = (0..3)
            .map(|i| measured(&[f64::from(i), 0.0], 1.0))
            .collect();
        for (i, m) in all.iter_mut().enumerate() {
            m.covariance[(1, 1)] = 0.0;
            m.values[1] = i as f64;
        }
        let change = Change::of(&all).unwrap();
        assert_eq!(change.whole.degrees_of_freedom, 2);
        assert!((change.whole.chi2 - 2.0).abs() < 1e-9);
        // One that determines it alone has nothing to be compared with.
        all[1].covariance[(1, 1)] = 1.0;
        assert_eq!(Change::of(&all).unwrap().whole.degrees_of_freedom, 2);
    }

    /// Share of p < 0.01 among `rounds` histories of `count` measurements of `size` quantities,
    /// of which the first moves by `shift` σ after half of them.
    fn alarms(rounds: u32, count: usize, size: usize, shift: f64) -> f64 {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(11 + count as u64);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut found = 0;
        for _ in 0..rounds {
            // An error of gravity in the first half, another in the second.
            let common = [normal(), normal()];
            let all: Vec<Measured> = (0..count)
                .map(|i| {
                    let group = usize::from(2 * i >= count);
                    let sd = 1.0 + 0.2 * i as f64;
                    let effect = DVector::from_fn(size, |k, _| if k == 1 { 5.0 } else { 0.0 });
                    let values = DVector::from_fn(size, |k, _| {
                        let moved = if k == 0 && group == 1 { shift } else { 0.0 };
                        sd * normal() + moved + effect[k] * common[group]
                    });
                    Measured {
                        covariance: DMatrix::identity(size, size) * (sd * sd),
                        shared: Some((group, effect)),
                        freedom: None,
                        values,
                    }
                })
                .collect();
            found += u32::from(Change::of(&all).unwrap().p_value(count) < 0.01);
        }
        f64::from(found) / f64::from(rounds)
    }

    #[test]
    fn alarms_are_as_rare_as_stated_and_steps_are_found() {
        for count in [2, 3, 6, 12] {
            let rate = alarms(4000, count, 9, 0.0);
            println!("{count} measurements, no change: {rate:.4} at a level of 0.01");
            // 4000 draws scatter by 0.0016.
            assert!(rate <= 0.015, "{count}: {rate}");
            assert!(rate >= 0.003, "{count}: {rate}");
        }
        for (count, shift, least) in [(2, 8.0, 0.8), (6, 8.0, 0.9), (12, 8.0, 0.9)] {
            let rate = alarms(300, count, 9, shift);
            println!("{count} measurements, a step of {shift} σ: found in {rate:.3}");
            assert!(rate >= least, "{count}: {rate}");
        }
    }
}
