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

pub use check::{Check, Length, StaticMean, check};
pub use compare::{Compare, Difference, NormDifference, compare};

/// Covariance of `f` by the errors of the parameters, from steps of one standard deviation along the axes of
/// their covariance.
///
/// With slopes s_k and curves q_k from steps of ±1 it is Σ s_k s_kᵀ + 2 Σ q_k q_kᵀ + (Σ q_k)(Σ q_k)ᵀ: a
/// frame known to 2° lengthens a reading by 0.06 %, of which slopes know nothing. None where `f` does not
/// exist after a step.
fn propagated(
    x: &Parameters,
    covariance: &Covariance,
    f: impl Fn(&Parameters) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    let eigen = SymmetricEigen::try_new(*covariance, f64::EPSILON, MAX_STEPS)?;
    let here = f(x)?;
    let mut curved = DVector::zeros(here.len());
    let mut out = DMatrix::zeros(here.len(), here.len());
    let axes = eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues);
    for (axis, variance) in axes.filter(|(_, variance)| **variance > 0.0) {
        let step = axis * variance.sqrt();
        let (up, down) = (f(&(x + step))?, f(&(x - step))?);
        let slope = (&up - &down) / 2.0;
        let curve = (up + down) / 2.0 - &here;
        out += &slope * slope.transpose() + &curve * curve.transpose() * 2.0;
        curved += curve;
    }
    Some(out + &curved * curved.transpose())
}
