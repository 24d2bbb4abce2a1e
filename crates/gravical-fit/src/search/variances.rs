//! Tilt, bends and model error by restricted maximum likelihood.

use super::{MAX_ROUNDS, Search};
use crate::rows::Held;

impl Search {
    /// Tilt, bends and model error by restricted maximum likelihood (Patterson and Thompson, Biometrika 58,
    /// 1971) of the linearised problem.
    pub(super) fn variances(&mut self) -> Option<()> {
        for _ in 0..MAX_ROUNDS {
            let before = self.held;
            let found = self.fit(&self.held)?;
            self.x = *found.x();
            let counts: Vec<bool> = (0..self.poses.len()).map(|k| self.counts(k)).collect();
            let likelihood = |held: &Held| {
                let solution = found.linear.solve_poses(held, |k| counts[k]);
                solution.map_or(f64::NEG_INFINITY, |s| s.log_likelihood)
            };
            if self.tilt.is_none() && self.is_oriented() {
                self.held.tilt = likeliest_tilt(&self.held, likelihood);
            }
            let normal = found.linear.normal(&self.held, |k| counts[k])?;
            (self.held.bend, self.typical_bend) = likely_bend(|bend| {
                let held = Held { bend, ..self.held };
                let solution = found.linear.solve(&normal, &held);
                solution.map_or(f64::NEG_INFINITY, |s| s.log_likelihood)
            })?;
            let bare = Held {
                model_error: 0.0,
                ..self.held
            };
            let exact = found.linear.solve_poses(&bare, |k| counts[k])?;
            // Without a length left over there is no error to see.
            let lengths = found.linear.lengths(&bare, &exact, |k| counts[k]);
            self.held.model_error = if lengths.freedom < 1.0 {
                0.0
            } else {
                likeliest_error(&self.held, likelihood)
            };
            if self.held.is_close(&before) {
                break;
            }
        }
        Some(())
    }
}

impl Held {
    fn is_close(&self, other: &Held) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 2e-3 * a.abs().max(b.abs());
        close(self.tilt, other.tilt)
            && close(self.bend, other.bend)
            && close(self.model_error, other.model_error)
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

/// What is known of the tilt before any pose, degrees: a box on a table, give or take a factor of e.
pub(crate) const USUAL_TILT_DEG: f64 = 1.0;

fn likeliest_tilt(held: &Held, likelihood: impl Fn(&Held) -> f64) -> f64 {
    let value = |log: f64| {
        let tilt = log.exp();
        let before = -0.5 * (tilt.to_degrees() / USUAL_TILT_DEG).ln().powi(2);
        before + likelihood(&Held { tilt, ..*held })
    };
    golden_section(0.1_f64.to_radians().ln(), 8_f64.to_radians().ln(), value).exp()
}

/// What is known of a bend before any pose: 0.05 % of g at 1 g, give or take a factor of e^1.5.
pub(crate) const USUAL_BEND: (f64, f64) = (5e-4, 1.5);

/// Spreads of bends, and the logarithm of their density: prior times likelihood.
pub(super) fn bend_grid(likelihood: impl Fn(f64) -> f64) -> (Vec<(f64, f64)>, f64) {
    let (usual, factor) = USUAL_BEND;
    let density = |bend: f64| {
        let before = -0.5 * ((bend / usual).ln() / factor).powi(2);
        (bend, before + likelihood(bend))
    };
    let grid: Vec<(f64, f64)> = (0..10).map(|i| density(3e-5 * 2_f64.powi(i))).collect();
    let best = grid.iter().map(|g| g.1).fold(f64::NEG_INFINITY, f64::max);
    (grid, best)
}

/// Six bends tell little of their spread: the root of the mean of its square over all that is likely,
/// and the geometric mean.
fn likely_bend(likelihood: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
    let (grid, best) = bend_grid(likelihood);
    let weight = |value: f64| (value - best).exp();
    let all: f64 = grid.iter().map(|(_, value)| weight(*value)).sum();
    let squares: f64 = grid.iter().map(|(b, value)| b * b * weight(*value)).sum();
    let logs: f64 = grid.iter().map(|(b, value)| b.ln() * weight(*value)).sum();
    best.is_finite()
        .then(|| ((squares / all).sqrt(), (logs / all).exp()))
}

/// The model error, m/s²; none where that is likelier.
fn likeliest_error(held: &Held, likelihood: impl Fn(&Held) -> f64) -> f64 {
    let value = |model_error: f64| {
        likelihood(&Held {
            model_error,
            ..*held
        })
    };
    let best = golden_section(1e-4_f64.ln(), 0.3_f64.ln(), |log| value(log.exp())).exp();
    if value(best) > value(0.0) { best } else { 0.0 }
}
