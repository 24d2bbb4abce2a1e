//! Poses that contradict the others.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::explanations::{BAD_POSE, BAD_POSE_MPS2};
use super::state::{Found, Search};
use crate::rows::{Hyperparameters, Lengths};

/// What is known of χ² per degree of freedom before any residual is seen: about 4, since real sensors
/// miss the model by more than the noise of their means (8.8 was seen on 38 poses), worth as much as
/// four residuals.
pub(crate) const USUAL_CHI2: f64 = 4.0;
/// … so many.
pub(crate) const USUAL_FREEDOM: f64 = 4.0;
/// A pose is bad when one as far off is rarer than this among all poses.
const CHANCE: f64 = 1e-3;
/// More poses than this are no session by hand.
pub(crate) const MAX_SESSION: usize = 64;
/// With fewer degrees of freedom one bad pose can look like another: the worst has to be so many times
/// rarer than the next.
const PLENTY_OF_FREEDOM: f64 = 3.0;
const CLEARLY: f64 = 100.0;
/// At most this share of the poses is left out.
const MAX_SHARE_OUT: f64 = 0.2;

/// A pose, tried without.
struct Deletion {
    pose: usize,
    /// Probability that deleting a good pose lowers χ² by as much.
    chance: f64,
    /// Degrees of freedom of what remains.
    freedom: f64,
}

impl Search {
    /// The pose whose deletion lowers χ² of the lengths by more than chance, and the chance of that: an
    /// F test by noise alone against what remains, with Bonferroni's correction for having picked the
    /// worst. The nonlinearity is left out, since it would take in what one bad pose does. Of more poses than a
    /// session by hand has, all that are rarer than chance.
    pub fn suspects(&self) -> Vec<(usize, f64)> {
        let held = self.held.noise_only();
        let counted = (0..self.poses.len()).filter(|k| self.poses[*k].bad.is_none());
        let count = counted.clone().count();
        let out = (self.poses.len() - count) as f64;
        let spare = MAX_SHARE_OUT * self.poses.len() as f64 - out;
        let Some(found) = self.fit(&held).filter(|_| spare >= 1.0) else {
            return Vec::new();
        };
        let whole = found.linear.lengths(&held, &found.solution, |_| true);
        let trials = counted.map(|k| self.delete(k, &found, &held, whole));
        let mut trials: Vec<Deletion> = trials.collect();
        trials.sort_by(|a, b| a.chance.total_cmp(&b.chance));
        let next = trials.get(1).map_or(1.0, |d| d.chance);
        let is_many = count > MAX_SESSION;
        let is_bad = |d: &&Deletion| {
            let is_clear = is_many || d.freedom >= PLENTY_OF_FREEDOM || next > CLEARLY * d.chance;
            is_clear && count as f64 * d.chance < CHANCE
        };
        let most = if is_many { spare as usize } else { 1 };
        let bad = trials.iter().take(most).filter(is_bad);
        bad.map(|d| (d.pose, count as f64 * d.chance)).collect()
    }

    /// The fit without pose `k`. Of many poses, by the residual and its share of the redundancy, which
    /// is exact for a free pose. The scale of χ² is known by what remains and by what is usual.
    fn delete(&self, k: usize, found: &Found, held: &Hyperparameters, whole: Lengths) -> Deletion {
        let linear = &found.linear;
        let rest = if self.poses.len() <= MAX_SESSION {
            let solution = linear.solve_poses(held, |i| i != k);
            solution.map(|solution| linear.lengths(held, &solution, |i| i != k))
        } else {
            let row = &linear.rows[k];
            let derivative = row.jacobian.row(0);
            let variance = row.noise[(0, 0)];
            let taken = (derivative * found.solution.covariance * derivative.transpose())[0];
            let share = (1.0 - taken / variance).max(1e-6);
            Some(Lengths {
                chi2: whole.chi2 - row.residual[0].powi(2) / variance / share,
                freedom: whole.freedom - share,
            })
        };
        let chance = |rest: Lengths| {
            let freed = (whole.freedom - rest.freedom).max(0.5);
            let chi2 = rest.chi2.max(0.0) + USUAL_FREEDOM * USUAL_CHI2;
            let freedom = rest.freedom + USUAL_FREEDOM;
            let ratio = (whole.chi2 - rest.chi2).max(0.0) / freed / (chi2 / freedom);
            FisherSnedecor::new(freed, freedom).map_or(1.0, |f| f.sf(ratio.min(1e6)))
        };
        let rest = rest.filter(|rest| rest.freedom >= 1.0);
        Deletion {
            pose: k,
            chance: rest.map_or(1.0, chance),
            freedom: rest.map_or(0.0, |rest| rest.freedom),
        }
    }

    /// An error of pose `k` explains the session better than a nonlinear response does: the evidence for
    /// both, a pose in fifty being off by some 50 mg.
    pub fn is_outlier(&self, k: usize, found: &Found) -> bool {
        if self.poses.len() > MAX_SESSION {
            return true;
        }
        let mut other = self.clone();
        other.poses[k].outlier_sd = BAD_POSE_MPS2;
        let Some(without) = other.converge() else {
            return false;
        };
        other.evidence(&without) + BAD_POSE.ln() > self.evidence(found)
    }

    /// Logarithm of the likelihood of the session, integrated over parameters and the spread of nonlinearity
    /// (MacKay, Neural Computation 4, 1992).
    pub(super) fn evidence(&self, found: &Found) -> f64 {
        if self.is_linear {
            return found.solution.log_likelihood;
        }
        let sum = |(grid, best): (Vec<(f64, f64)>, f64)| {
            best + grid.iter().map(|(_, weight)| weight).sum::<f64>().ln()
        };
        self.likely_bends(found).map_or(f64::NEG_INFINITY, sum)
    }
}
