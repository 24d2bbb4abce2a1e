//! Finds the parameters, and with them what poses cannot be fitted without: roles, tilt, model error,
//! nonlinearity, and the poses that do not fit.

mod explanations;
mod misfits;
mod roles;
mod state;
mod variances;

use nalgebra::Vector3;

use crate::model::{
    BIAS, DIRECTIONS, DRIFT, NONLINEARITY, Parameters, inverse, matrix, sensitivity, sphere,
    tangents,
};
use crate::pose::Face;
use state::MAX_ROUNDS;

pub use explanations::{Explained, Explanation};
pub(crate) use misfits::{MAX_SESSION, USUAL_CHI2, USUAL_FREEDOM};
pub(crate) use roles::assign_first_roles;
pub(crate) use state::{Found, Search};
pub(crate) use variances::{USUAL_NONLINEARITY, USUAL_TILT_DEG};

impl Search {
    /// Roles and variances in turn until no role changes; then the shift of the scale by tilts.
    pub fn converge(&mut self) -> Option<Found> {
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

/// Where ‖a‖ of a direction is known least, and its standard deviation there by M and b, m/s².
pub(crate) fn least_known(found: &Found, gravity: f64) -> Option<(Vector3<f64>, f64)> {
    let inverse = matrix(&found.linear.x).try_inverse()?;
    sphere(DIRECTIONS)
        .map(|n| {
            let mut h = sensitivity(&inverse, &n, gravity);
            h.fixed_rows_mut::<6>(NONLINEARITY).fill(0.0);
            (n, (found.solution.covariance * h).dot(&h).max(0.0).sqrt())
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
}
