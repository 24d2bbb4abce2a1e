//! A calibration as numbers: parameters, their covariance, and what these say of ‖a‖.

use nalgebra::{DVector, SMatrix};

use crate::model::{
    BENDS, BIAS, Covariance, Parameters, invariants, jacobian, matrix, sensitivity, sphere,
};

/// Directions over which ‖a‖ is looked at.
const DIRECTIONS: usize = 400;

/// Gravity, and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gravity {
    /// m/s².
    pub value_mps2: f64,
    /// Standard uncertainty, m/s²; 0 if it was given.
    pub sd_mps2: f64,
}

/// A calibration as numbers, in the unit of the readings.
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

/// What a relative error of gravity of this standard deviation does to the parameters: M is fitted in
/// proportion to 1/g, b does not depend on it.
#[must_use]
pub fn covariance_by_gravity(x: &Parameters, relative_sd: f64) -> Covariance {
    let by_gravity = derivative_by_gravity(x) * relative_sd;
    by_gravity * by_gravity.transpose()
}

/// Derivative of the parameters by ln g.
pub(crate) fn derivative_by_gravity(x: &Parameters) -> Parameters {
    Parameters::from_fn(|i, _| if i < BIAS { -x[i] } else { 0.0 })
}

/// Standard deviations of what no turn of the board changes: bias, lengths of the rows of M (scale), and
/// angles between them (xy, xz, yz), rad. None where M is singular.
#[must_use]
pub fn deviations(x: &Parameters, covariance: &Covariance) -> Option<[f64; 9]> {
    let all: Vec<usize> = (0..BENDS).collect();
    let slopes = jacobian(x, &all, |x| Some(invariants(x)))?;
    let covariance = covariance.view((0, 0), (BENDS, BENDS));
    let variances: DVector<f64> = (&slopes * covariance * slopes.transpose()).diagonal();
    Some(std::array::from_fn(|i| variances[i].max(0.0).sqrt()))
}

impl Sensor {
    pub(crate) fn is_finite(&self) -> bool {
        let gravity = [
            self.gravity.value_mps2,
            self.gravity.sd_mps2,
            self.model_error_mps2,
        ];
        let all = self.parameters.iter().chain(&self.covariance);
        all.chain(&gravity).all(|v| v.is_finite()) && self.gravity.value_mps2 > 0.0
    }

    /// The same for readings divided by `unit`.
    #[must_use]
    pub fn rescaled(mut self, unit: f64) -> Sensor {
        for i in 0..BENDS {
            self.parameters[i] /= unit;
            self.covariance.row_mut(i).scale_mut(unit.recip());
            self.covariance.column_mut(i).scale_mut(unit.recip());
        }
        self
    }

    /// The covariance with the error of gravity.
    #[must_use]
    pub fn covariance_with_gravity(&self) -> Covariance {
        let relative_sd = self.gravity.sd_mps2 / self.gravity.value_mps2;
        self.covariance + covariance_by_gravity(&self.parameters, relative_sd)
    }

    /// Standard deviation of ‖a‖ by parameters and gravity along each of some unit vectors, m/s²; NaN
    /// where M is singular.
    pub fn sd_along(&self, directions: impl Iterator<Item = [f64; 3]>) -> Vec<f64> {
        let covariance = self.covariance_with_gravity();
        let inverse = matrix(&self.parameters).try_inverse();
        let sd = |n: [f64; 3]| {
            let Some(inverse) = &inverse else {
                return f64::NAN;
            };
            let h = sensitivity(inverse, &n.into(), self.gravity.value_mps2);
            (covariance * h).dot(&h).max(0.0).sqrt()
        };
        directions.map(sd).collect()
    }

    /// Root mean square of [`Self::sd_along`] over the sphere, and the direction where it is largest
    /// with its value there.
    #[must_use]
    pub fn over_sphere(&self) -> (f64, ([f64; 3], f64)) {
        let each = self.sd_along(sphere(DIRECTIONS).map(Into::into));
        let squares: f64 = each.iter().map(|sd| sd * sd).sum();
        let largest = sphere(DIRECTIONS).map(Into::into).zip(each);
        let largest = largest.max_by(|a, b| a.1.total_cmp(&b.1));
        let none = ([0.0, 0.0, 1.0], f64::INFINITY);
        (
            (squares / DIRECTIONS as f64).sqrt(),
            largest.unwrap_or(none),
        )
    }

    /// Derivatives (21 × 6) of the other parameters by the bends once these are fixed, and the
    /// covariance that is left: C_mb C_bb⁺ and C_mm − C_mb C_bb⁺ C_bm.
    pub(crate) fn at_known_bends(&self) -> (SMatrix<f64, 21, 6>, Covariance) {
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

    pub(crate) fn covariance_of_bends(&self) -> SMatrix<f64, 6, 6> {
        self.covariance.fixed_view::<6, 6>(BENDS, BENDS).into()
    }
}
