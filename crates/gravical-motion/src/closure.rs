//! Closures: what a rest says of the move before it.

use nalgebra::{SMatrix, Vector3};
use serde::Serialize;

use crate::filter::Innovation;
use crate::noise::Density;

/// A rest has no velocity but this, m/s: a table that gives way.
pub(crate) const REST_SPEED_MPS: f64 = 0.001;
/// χ² of velocity (3) and of tilt (2) that chance exceeds once in 100 and, since every move is levelled
/// with a gyroscope whose scale is assumed, once in 3,000.
const MAX_VELOCITY_CHI2: f64 = 11.3;
const MAX_TILT_CHI2: f64 = 16.0;
/// χ² of the velocity at a stance (3) that a step may have: a quarter of good ones have more, and lose nothing
/// by more noise: strides of the gait example are nearer to the cameras than with the limit of moves. A foot that
/// strikes is out of range, or between two samples, for a moment; without more noise such errors, which are alike
/// in all steps, are taken for the scale of the sensor.
pub(crate) const MAX_STEP_CHI2: f64 = 4.0;
/// What the enlarged covariance makes of them: the median by chance.
const USUAL_VELOCITY_CHI2: f64 = 2.0;
const USUAL_TILT_CHI2: f64 = 1.4;
/// Steps of the bisection of a variance between 1e-14 and 1e8, logarithmic: to 1e-15 of the interval.
const BISECTIONS: usize = 50;

/// How well a move closes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Closure {
    /// χ² of the velocity at the rest that ends the move, 3 degrees of freedom.
    pub velocity_chi2: f64,
    /// χ² of the tilt there, 2 degrees of freedom.
    pub tilt_chi2: f64,
    /// They contradicted the noise, so the band of the move was widened until they do not, along all
    /// axes alike.
    pub widened: bool,
}

impl Innovation {
    /// χ² of rows `first..first + D` with `variance` added to each.
    pub fn chi2<const D: usize>(&self, first: usize, variance: f64) -> f64 {
        let y = self.y.fixed_rows::<D>(first).into_owned();
        let s =
            self.s.fixed_view::<D, D>(first, first) + SMatrix::<f64, D, D>::identity() * variance;
        s.try_inverse()
            .map_or(f64::INFINITY, |s| (y.transpose() * s * y)[0])
    }

    /// The density over `seconds` that makes a velocity whose χ² is above `limit` one of chance. None if it is
    /// one.
    pub fn force_density(&self, limit: f64, seconds: f64) -> Option<Density> {
        (self.chi2::<3>(0, 0.0) > limit).then(|| {
            let variance = solve_falling(|v| self.chi2::<3>(0, v), USUAL_VELOCITY_CHI2);
            Density {
                force: isotropic(variance, seconds),
                ..Density::default()
            }
        })
    }
}

/// The density that makes a closure that fails one of chance, in a move that took `seconds`: a model that fails,
/// fails in every direction. Tilt first, since it explains velocity as well. None if the closure holds.
pub(crate) fn enlargement(innovation: &Innovation, gravity: f64, seconds: f64) -> Option<Density> {
    if innovation.chi2::<2>(3, 0.0) > MAX_TILT_CHI2 {
        let variance = solve_falling(|v| innovation.chi2::<2>(3, v), USUAL_TILT_CHI2);
        return Some(Density {
            rate: isotropic(variance / gravity.powi(2).max(f64::MIN_POSITIVE), seconds),
            ..Density::default()
        });
    }
    innovation.force_density(MAX_VELOCITY_CHI2, seconds)
}

fn isotropic(variance: f64, seconds: f64) -> Vector3<f64> {
    Vector3::repeat(variance / seconds.max(f64::MIN_POSITIVE))
}

/// Where a function that falls with its argument reaches a value.
fn solve_falling(f: impl Fn(f64) -> f64, value: f64) -> f64 {
    let (mut low, mut high) = (1e-14_f64.ln(), 1e8_f64.ln());
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if f(middle.exp()) > value {
            low = middle;
        } else {
            high = middle;
        }
    }
    high.exp()
}
