//! Finds the parameters, and with them what poses cannot be fitted without: roles, tilt, model error,
//! bends, and the poses that do not fit.

mod misfits;
mod roles;
mod variances;

use nalgebra::{Matrix3, Vector3};

use crate::model::{
    BENDS, BIAS, DIRECTIONS, DRIFT, Parameters, inverse, matrix, sensitivity, sphere, tangents,
};
use crate::pose::Face;
use crate::rows::{Hyperparameters, Linear, Placed, Solution, free_parameters};

pub(crate) use misfits::{MAX_SESSION, USUAL_CHI2, USUAL_FREEDOM};
pub(crate) use roles::assign_first_roles;
pub(crate) use variances::{USUAL_BEND, USUAL_TILT_DEG};

/// Steps of the search for the parameters.
const MAX_STEPS: usize = 40;
/// Rounds in which roles and variances settle.
const MAX_ROUNDS: usize = 8;

/// The fit so far.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    pub poses: Vec<Placed>,
    /// Place among them of every pose that was given: repeats are merged.
    pub place_of: Vec<usize>,
    /// Input unit per working unit.
    pub scale: f64,
    /// Mean temperature of the poses, °C.
    pub reference_c: f64,
    pub held: Hyperparameters,
    /// Geometric mean of the likely spreads of bends; `held` has their root mean square.
    pub typical_bend: f64,
    /// Tilt that was given, rad.
    pub tilt: Option<f64>,
    /// The channel along each axis of the case.
    pub channel_of: [usize; 3],
    pub x: Parameters,
}

/// Parameters at which the search came to rest, the problem linearised there, and its solution.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub linear: Linear,
    pub solution: Solution,
}

impl Search {
    /// What parameters are estimated with. What is claimed of them has to allow for all bends that are
    /// likely, and `held` has their mean square; with that the parameters would trust directions across
    /// an axis, which no bend changes, more than is usually right.
    pub fn estimating(&self) -> Hyperparameters {
        Hyperparameters {
            bend: self.typical_bend,
            ..self.held
        }
    }

    pub fn is_oriented(&self) -> bool {
        let counted = self.poses.iter().filter(|p| p.bad.is_none());
        let mut faces = counted.filter_map(|p| p.face);
        let first = faces.next();
        first.is_some_and(|first| faces.any(|face| face.axis != first.axis))
    }

    /// Gauss–Newton with the weights of the present parameters; steps are halved until they help.
    pub fn fit(&self, held: &Hyperparameters) -> Option<Found> {
        let oriented = self.is_oriented();
        let free = free_parameters(oriented, self.channel_of, held);
        let mut x = self.x;
        if held.bend == 0.0 {
            x.fixed_rows_mut::<6>(BENDS).fill(0.0);
        }
        if !oriented {
            upper_triangular(&mut x, self.channel_of)?;
        }
        let mut found: Option<Found> = None;
        for _ in 0..MAX_STEPS {
            let linear = Linear::new(&self.poses, &x, (oriented, &free), held)?;
            let solution = linear.solve_poses(held, |_| true)?;
            let now = linear.cost_at(&self.poses, &x, held)?;
            let no_worse = |x: &Parameters| {
                let cost = linear.cost_at(&self.poses, x, held);
                cost.is_some_and(|cost| cost <= now * (1.0 + 1e-9))
            };
            let shares = (0..14).map(|i| 0.5_f64.powi(i));
            let next = shares.map(|share| x + share * solution.step).find(no_worse);
            let converged = solution.decrement < 1e-3 || next.is_none();
            found = Some(Found { linear, solution });
            match next {
                Some(next) if !converged => x = next,
                _ => break,
            }
        }
        found
    }

    /// Roles and variances in turn until no role changes; then the shift of the scale by tilts.
    pub fn settle(&mut self) -> Option<Found> {
        self.poses.iter_mut().for_each(|p| p.shortfall = 0.0);
        for _ in 0..MAX_ROUNDS {
            let before: Vec<Option<Face>> = self.poses.iter().map(|p| p.face).collect();
            self.estimate_variances()?;
            roles::assign_roles(&mut self.poses, &self.x, self.tilt);
            if self.poses.iter().map(|p| p.face).eq(before) {
                break;
            }
        }
        let found = self.fit(&self.estimating())?;
        self.estimate_shortfalls(&found);
        let linear = self.fit(&self.estimating())?.linear;
        self.x = linear.x;
        let solution = linear.solve_poses(&self.held, |_| true)?;
        Some(Found { linear, solution })
    }

    /// What ‖a‖ of the faces falls short of by angles that the stretch of M leaves open. A rotation of
    /// the frame changes no length and does not count.
    fn estimate_shortfalls(&mut self, found: &Found) {
        let by_case = inverse(&found.linear.x).transpose();
        let gravity = self.held.gravity;
        let covariance = &found.solution.covariance;
        for pose in &mut self.poses {
            let Some(face) = pose.face else { continue };
            let n = Vector3::from(face.direction());
            let across = |t: &Vector3<f64>| {
                let (along, aside) = (by_case * n, by_case * t);
                let h = Parameters::from_fn(|i, _| match i {
                    0..BIAS => 0.5 * (aside[i / 3] * n[i % 3] + along[i / 3] * t[i % 3]),
                    BIAS..DRIFT => aside[i - BIAS] / gravity,
                    _ => 0.0,
                });
                (covariance * h).dot(&h)
            };
            let variance: f64 = tangents(&n).iter().map(across).sum();
            pose.shortfall = 0.5 * gravity * variance;
        }
    }
}

/// M = U Q with U upper triangular in the axes of the channels, by a Cholesky decomposition of M Mᵀ = U Uᵀ
/// from its last row up: turns the frame of the case, which no length tells.
fn upper_triangular(x: &mut Parameters, channel_of: [usize; 3]) -> Option<()> {
    let m = matrix(x);
    let flip = |m: Matrix3<f64>| Matrix3::from_fn(|r, c| m[(2 - r, 2 - c)]);
    let upper = flip(flip(m * m.transpose()).cholesky()?.l());
    for (axis, channel) in channel_of.into_iter().enumerate() {
        let sign = m[(channel, axis)].signum();
        for r in 0..3 {
            x[3 * r + axis] = sign * upper[(r, channel)];
        }
    }
    x.iter().all(|v| v.is_finite()).then_some(())
}

/// Where ‖a‖ of a direction is known least, and its standard deviation there by M and b, m/s².
pub(crate) fn least_known(found: &Found, gravity: f64) -> Option<(Vector3<f64>, f64)> {
    let inverse = matrix(&found.linear.x).try_inverse()?;
    sphere(DIRECTIONS)
        .map(|n| {
            let mut h = sensitivity(&inverse, &n, gravity);
            h.fixed_rows_mut::<6>(BENDS).fill(0.0);
            (n, (found.solution.covariance * h).dot(&h).max(0.0).sqrt())
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
}
