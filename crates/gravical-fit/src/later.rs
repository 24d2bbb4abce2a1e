//! Does a calibration still fit later readings, and do two calibrations of one sensor differ?
//!
//! [`consistent`](crate::consistent()) answers both. What both sides of a difference share (the gravity of
//! the place, the bends of the sensor) cancels in it and is not counted twice.
//!
//! Working units: readings are divided by the nominal scale, so that M is about 1 and everything
//! is in m/s².

mod check;
mod compare;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};

use crate::model::{Covariance, PARAMETERS, Parameters, jacobian};

pub use check::{Cause, Check, Explanation, Length, StaticMean, check};
pub use compare::{Compare, Difference, NormDifference, compare};

/// Covariance of `f` by the errors of the parameters, J C Jᵀ.
fn propagated(
    x: &Parameters,
    covariance: &Covariance,
    f: impl Fn(&Parameters) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    let all: Vec<usize> = (0..PARAMETERS).collect();
    let slopes = jacobian(x, &all, f)?;
    Some(&slopes * covariance * slopes.transpose())
}
