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

use nalgebra::{DMatrix, DVector, SMatrix, SymmetricEigen};

use crate::consistent::MAX_STEPS;
use crate::model::{BENDS, BIAS, Covariance, Parameters};

pub use check::{Check, Explanation, Length, StaticMean, check};
pub use compare::{Compare, Difference, NormDifference, compare};

/// Gravity, and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    /// m/s².
    pub value_mps2: f64,
    /// Standard uncertainty, m/s²; 0 if it was given.
    pub sd_mps2: f64,
}

/// A calibration as numbers, in working units.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// M, b, drift and bends; what is not known of the last two is 0.
    pub parameters: Parameters,
    /// Covariance of these by the readings: without the error of gravity, which later readings in
    /// the same place share. Rows of what is not known are 0.
    pub covariance: Covariance,
    /// Gravity that M rests on.
    pub gravity: Gravity,
    /// Standard deviation of what the model leaves out of a length, m/s².
    pub model_error_mps2: f64,
    /// Tilts of placements that σ_tilt, and with it the uncertainty of the frame, was estimated
    /// from; infinite where it was given.
    pub tilt_freedom: f64,
}

impl Sensor {
    fn is_finite(&self) -> bool {
        let gravity = [
            self.gravity.value_mps2,
            self.gravity.sd_mps2,
            self.model_error_mps2,
        ];
        let all = self.parameters.iter().chain(&self.covariance);
        all.chain(&gravity).all(|v| v.is_finite()) && self.gravity.value_mps2 > 0.0
    }

    /// Derivative of the parameters by ln g: M is fitted in proportion to 1/g, b does not depend
    /// on it.
    fn by_gravity(&self) -> Parameters {
        Parameters::from_fn(|i, _| if i < BIAS { -self.parameters[i] } else { 0.0 })
    }

    /// Derivatives (21 × 6) of the other parameters by the bends once these are fixed, and the
    /// covariance that is left: C_mb C_bb⁺ and C_mm − C_mb C_bb⁺ C_bm.
    fn at_known_bends(&self) -> (SMatrix<f64, 21, 6>, Covariance) {
        const LEAST: f64 = 1e-14;
        let with_bends: SMatrix<f64, 21, 6> = self.covariance.fixed_columns::<6>(BENDS).into();
        let of_bends = self.covariance_of_bends();
        let inverse = of_bends.pseudo_inverse(LEAST).unwrap_or_default();
        let by_bends = with_bends * inverse;
        (
            by_bends,
            self.covariance - by_bends * with_bends.transpose(),
        )
    }

    fn covariance_of_bends(&self) -> SMatrix<f64, 6, 6> {
        self.covariance.fixed_view::<6, 6>(BENDS, BENDS).into()
    }
}

/// Covariance of `f` by the errors of the parameters, from steps of one standard deviation along
/// the axes of their covariance. With slopes s_k and curves q_k along these it is
/// Σ s_k s_kᵀ + 2 Σ q_k q_kᵀ + (Σ q_k)(Σ q_k)ᵀ: a frame known to 2° lengthens a reading by 0.06 %,
/// of which slopes know nothing.
fn propagated(
    x: &Parameters,
    covariance: &Covariance,
    f: impl Fn(&Parameters) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    let here = f(x)?;
    let eigen = SymmetricEigen::try_new(*covariance, f64::EPSILON, MAX_STEPS)?;
    let mut covariance = DMatrix::zeros(here.len(), here.len());
    let mut curved = DVector::zeros(here.len());
    for (variance, axis) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        if *variance <= 0.0 {
            continue;
        }
        let step = axis * variance.sqrt();
        let (up, down) = (f(&(x + step))?, f(&(x - step))?);
        let slope = (&up - &down) / 2.0;
        let curve = (up + down) / 2.0 - &here;
        covariance += &slope * slope.transpose() + &curve * curve.transpose() * 2.0;
        curved += curve;
    }
    covariance += &curved * curved.transpose();
    Some(covariance)
}
