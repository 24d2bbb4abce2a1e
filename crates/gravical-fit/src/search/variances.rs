//! Tilt, nonlinearity and model error: the variances that the poses are weighed with.

use super::state::{Found, MAX_ROUNDS, Search};
use crate::rows::Hyperparameters;

/// What is known of the tilt before any pose, degrees: a box on a table, give or take a factor of e.
pub(crate) const USUAL_TILT_DEG: f64 = 1.0;
/// What is known of a nonlinearity coefficient before any pose: 0.05 % of g at 1 g, give or take a factor of e^1.5.
pub(crate) const USUAL_NONLINEARITY: (f64, f64) = (5e-4, 1.5);
/// Shares by which a variance may still change.
const CLOSE: f64 = 2e-3;

impl Search {
    /// Tilt, nonlinearity and model error by restricted maximum likelihood (Patterson and Thompson, Biometrika 58,
    /// 1971) of the linearised problem.
    pub(super) fn estimate_variances(&mut self) -> Option<()> {
        for _ in 0..MAX_ROUNDS {
            let before = self.held;
            let found = self.fit(&self.held)?;
            self.x = found.linear.x;
            let likelihood = |held: &Hyperparameters| {
                let solution = found.linear.solve_poses(held, |_| true);
                solution.map_or(f64::NEG_INFINITY, |s| s.log_likelihood)
            };
            if self.tilt.is_none() && self.is_oriented() {
                self.held.tilt = likeliest_tilt(&self.held, likelihood);
            }
            if !self.is_linear {
                let (grid, _) = self.likely_bends(&found)?;
                let all: f64 = grid.iter().map(|(_, weight)| weight).sum();
                let mean = |value: fn(f64) -> f64| {
                    let each = grid.iter().map(|(sd, weight)| value(*sd) * weight);
                    each.sum::<f64>() / all
                };
                self.held.nonlinearity_sd = mean(|sd| sd * sd).sqrt();
                self.typical_nonlinearity = mean(f64::ln).exp();
            }
            let mut bare = self.held;
            bare.model_error = 0.0;
            let exact = found.linear.solve_poses(&bare, |_| true)?;
            // Without a length left over there is no error to see.
            let lengths = found.linear.lengths(&bare, &exact, |_| true);
            self.held.model_error = if lengths.freedom < 1.0 {
                0.0
            } else {
                likeliest_error(&self.held, likelihood)
            };
            let values =
                |held: &Hyperparameters| [held.tilt, held.nonlinearity_sd, held.model_error];
            let mut pairs = values(&self.held).into_iter().zip(values(&before));
            if pairs.all(|(a, b)| (a - b).abs() <= CLOSE * a.abs().max(b.abs())) {
                break;
            }
        }
        Some(())
    }

    /// Spreads of nonlinearity with their density, prior times likelihood, as a share of the largest; and the
    /// logarithm of that. Six coefficients tell little of their spread: all that are likely count.
    pub(super) fn likely_bends(&self, found: &Found) -> Option<(Vec<(f64, f64)>, f64)> {
        let normal = found.linear.normal(&self.held, |_| true)?;
        let (usual, factor) = USUAL_NONLINEARITY;
        let density = |i: i32| {
            let sd = 3e-5 * 2_f64.powi(i);
            let before = -0.5 * ((sd / usual).ln() / factor).powi(2);
            let solution = found.linear.solve(
                &normal,
                &Hyperparameters {
                    nonlinearity_sd: sd,
                    ..self.held
                },
            );
            let likelihood = solution.map_or(f64::NEG_INFINITY, |s| s.log_likelihood);
            (sd, before + likelihood)
        };
        let grid: Vec<(f64, f64)> = (0..10).map(density).collect();
        let best = grid.iter().map(|g| g.1).fold(f64::NEG_INFINITY, f64::max);
        let shares = grid.iter().map(|(sd, log)| (*sd, (log - best).exp()));
        best.is_finite().then(|| (shares.collect(), best))
    }
}

/// The largest of a function between `low` and `high`, by golden sections.
fn golden_section(mut low: f64, mut high: f64, value: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (value(left), value(right));
    for _ in 0..24 {
        if at_left > at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - ratio * (high - low);
            at_left = value(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + ratio * (high - low);
            at_right = value(right);
        }
    }
    0.5 * (low + high)
}

fn likeliest_tilt(held: &Hyperparameters, likelihood: impl Fn(&Hyperparameters) -> f64) -> f64 {
    let value = |log: f64| {
        let tilt = log.exp();
        let before = -0.5 * (tilt.to_degrees() / USUAL_TILT_DEG).ln().powi(2);
        before + likelihood(&Hyperparameters { tilt, ..*held })
    };
    golden_section(0.1_f64.to_radians().ln(), 8_f64.to_radians().ln(), value).exp()
}

/// The model error, m/s²; none where that is likelier.
fn likeliest_error(held: &Hyperparameters, likelihood: impl Fn(&Hyperparameters) -> f64) -> f64 {
    let value = |model_error: f64| {
        likelihood(&Hyperparameters {
            model_error,
            ..*held
        })
    };
    let best = golden_section(1e-4_f64.ln(), 0.3_f64.ln(), |log| value(log.exp())).exp();
    if value(best) > value(0.0) { best } else { 0.0 }
}
