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

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::consistent::MAX_STEPS;
use crate::model::{Covariance, Parameters};
use crate::propagate::propagate;

pub use check::{Cause, Check, Explanation, Length, StaticMean, check};
pub use compare::{Compare, NormDifference, ParameterDifference, compare};

/// Covariance of `f` by the errors of the parameters, from steps along the axes of their covariance.
fn propagated(
    x: &Parameters,
    covariance: &Covariance,
    f: impl Fn(&Parameters) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    let eigen = SymmetricEigen::try_new(*covariance, f64::EPSILON, MAX_STEPS)?;
    let axes = eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter());
    let steps: Vec<Parameters> = axes
        .filter(|(variance, _)| **variance > 0.0)
        .map(|(variance, axis)| axis * variance.sqrt())
        .collect();
    propagate(&f(x)?, steps.len(), |k, sign| f(&(x + steps[k] * sign)))
}
