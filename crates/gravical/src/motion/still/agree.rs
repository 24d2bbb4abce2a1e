//! Whether two rests read the same gravity.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::still::Plan;
use gravical_core::strapdown::{from_rotation_vector, rotate};

use super::merge::Context;
use super::view::{Six, mean_of};

/// A prediction through a turn is off by this share of it times g: the scales of
/// two sensors that nobody calibrated.
const TURN_ERROR: f64 = 0.1;
/// Beyond this angle, rad, one rest says nothing about the force in another.
const MOST_TURN: f64 = 0.5;

impl Context<'_> {
    /// χ² of the mean force of one rest against what that of the other becomes by
    /// the turn between them; 0 after a large turn, which tells nothing.
    pub(super) fn difference(&self, before: &Range<usize>, after: &Range<usize>) -> f64 {
        let most = Plan::REFERENCE_BLOCKS * self.plan.block;
        let a = before.end - most.min(before.len())..before.end;
        let b = after.start..after.start + most.min(after.len());
        let (mean_a, mean_b) = (
            mean_of(self.samples, a.clone()),
            mean_of(self.samples, b.clone()),
        );
        let (n_a, n_b) = (a.len() as f64, b.len() as f64);
        // From the middle of one to the middle of the other.
        let (from, to) = (a.start + a.len() / 2, b.start + b.len() / 2);
        let turn = self.turn(from, to, &mean_a, &mean_b, n_a, n_b);
        if turn.path > MOST_TURN {
            return 0.0;
        }
        // A force fixed in space turns the other way round in the sensor.
        let force = [mean_a[0], mean_a[1], mean_a[2]];
        let predicted = rotate(&from_rotation_vector(&turn.vector.map(|v| -v)), &force);
        let wander = self.levels.wander;
        let g = norm(&force);
        let slack = (TURN_ERROR * turn.path * g).powi(2) + turn.variance * g * g;
        let (va, vb) = (
            &self.level(before).noise.mean_variance[0],
            &self.level(after).noise.mean_variance[0],
        );
        (0..3)
            .map(|c| {
                let off = mean_b[c] - predicted[c];
                let rounded = 2.0 * self.levels.left[c];
                off * off / (wander * (va[c] / n_a + vb[c] / n_b) + rounded + slack)
            })
            .sum()
    }

    /// The angle between the attitudes at the ends of a break, rad.
    pub(super) fn turned_rad(&self, before: &Range<usize>, after: &Range<usize>) -> f64 {
        let near = Plan::SEED_BLOCKS * self.plan.block;
        let a = before.end - near.min(before.len())..before.end;
        let b = after.start..after.start + near.min(after.len());
        let (n_a, n_b) = (a.len() as f64, b.len() as f64);
        let (mean_a, mean_b) = (mean_of(self.samples, a), mean_of(self.samples, b));
        let turn = self.turn(before.end - 1, after.start, &mean_a, &mean_b, n_a, n_b);
        norm(&turn.vector)
    }

    /// The turn between two samples, its bias that of the rests around.
    fn turn(&self, from: usize, to: usize, a: &Six, b: &Six, n_a: f64, n_b: f64) -> Turn {
        let t = &self.samples.t_s;
        let block = self.plan.block;
        let bias: [f64; 3] =
            std::array::from_fn(|c| (a[3 + c] * n_a + b[3 + c] * n_b) / (n_a + n_b));
        let mut turn = Turn {
            vector: [0.0; 3],
            path: 0.0,
            variance: 0.0,
        };
        if self.samples.rate_rad_s.is_none() {
            return turn;
        }
        let mut at = from;
        while at < to {
            let next = (at + block).min(to);
            let mean = mean_of(self.samples, at..next);
            let h = t[next] - t[at];
            let step: [f64; 3] = std::array::from_fn(|c| (mean[3 + c] - bias[c]) * h);
            for c in 0..3 {
                turn.vector[c] += step[c];
            }
            turn.path += step.iter().map(|v| v * v).sum::<f64>().sqrt();
            at = next;
        }
        let whole = t[to] - t[from];
        let v = self.levels.nearest(&(from..to)).noise.mean_variance[0];
        let density = (v[3] + v[4] + v[5]) / 3.0;
        let left = &self.levels.left;
        let rounded = (left[3] + left[4] + left[5]) / 3.0;
        turn.variance = density * (whole * whole / (n_a + n_b) + whole * self.step_s())
            + 2.0 * rounded * whole * whole;
        // What noise adds to the path is no turn.
        let noise = (3.0 * density / block as f64).sqrt() * whole;
        turn.path = (turn.path - noise).max(0.0);
        turn
    }
}

struct Turn {
    /// Rotation vector, rad.
    vector: [f64; 3],
    /// Sum of the angles, rad.
    path: f64,
    /// Variance of each component by noise and bias, rad².
    variance: f64,
}
