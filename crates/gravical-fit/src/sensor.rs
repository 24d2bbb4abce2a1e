//! A calibration as numbers: parameters, their covariance, and what these say of ‖a‖.

use nalgebra::{DMatrix, SMatrix};
use serde::{Deserialize, Serialize};

use crate::model::{
    BENDS, BIAS, Covariance, DIRECTIONS, Parameters, invariants, jacobian, matrix, sensitivity,
    sphere,
};

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
pub fn covariance_by_gravity(x: &Parameters, relative_sd: f64) -> Covariance {
    let by_gravity = derivative_by_gravity(x) * relative_sd;
    by_gravity * by_gravity.transpose()
}

/// Derivative of the parameters by ln g.
pub(crate) fn derivative_by_gravity(x: &Parameters) -> Parameters {
    Parameters::from_fn(|i, _| if i < BIAS { -x[i] } else { 0.0 })
}

/// Standard deviations (1σ) from the covariance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Deviations {
    /// Of the bias, input unit.
    pub bias: [f64; 3],
    /// Of the scale, input unit per m/s².
    pub scale: [f64; 3],
    /// Of the angles between the sensitive axes xy, yz and zx, degrees.
    pub axis_angle_deg: [f64; 3],
}

/// Standard deviations of what no turn of the board changes: bias, lengths of the rows of M (scale), and
/// angles between them; NaN where M is singular.
pub fn deviations(x: &Parameters, covariance: &Covariance) -> Deviations {
    // Derivatives are taken where M is about 1.
    let unit = matrix(x).norm() / 3_f64.sqrt();
    let scaled = x / unit;
    let all: Vec<usize> = (0..BENDS).collect();
    let slopes = jacobian(&scaled, &all, |x| Some(invariants(x)));
    let slopes = slopes.unwrap_or_else(|| DMatrix::repeat(9, BENDS, f64::NAN));
    let covariance = covariance.view((0, 0), (BENDS, BENDS)) / (unit * unit);
    let variances = (&slopes * covariance * slopes.transpose()).diagonal();
    let sd = |i: usize| root(variances[i]);
    Deviations {
        bias: [0, 1, 2].map(|i| unit * sd(i)),
        scale: [3, 4, 5].map(|i| unit * sd(i)),
        axis_angle_deg: [6, 8, 7].map(|i| sd(i).to_degrees()),
    }
}

/// Root of a variance that rounding may have left below zero.
fn root(variance: f64) -> f64 {
    if variance < 0.0 { 0.0 } else { variance.sqrt() }
}

impl Gravity {
    /// Its standard uncertainty as a fraction of it.
    pub fn relative_sd(&self) -> f64 {
        self.sd_mps2 / self.value_mps2
    }
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
    pub fn covariance_with_gravity(&self) -> Covariance {
        self.covariance + covariance_by_gravity(&self.parameters, self.gravity.relative_sd())
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
            root((covariance * h).dot(&h))
        };
        directions.map(sd).collect()
    }

    /// Root mean square of [`Self::sd_along`] over the sphere, m/s².
    pub fn predicted_mps2(&self) -> f64 {
        let each = self.sd_along(sphere(DIRECTIONS).map(Into::into));
        (each.iter().map(|sd| sd * sd).sum::<f64>() / DIRECTIONS as f64).sqrt()
    }

    /// The direction in which [`Self::sd_along`] is largest, and its value there, m/s².
    pub fn weakest(&self) -> ([f64; 3], f64) {
        let each = self.sd_along(sphere(DIRECTIONS).map(Into::into));
        let each = sphere(DIRECTIONS).map(Into::into).zip(each);
        each.fold(([0.0, 0.0, 1.0], 0.0), |worst, one| {
            if one.1 <= worst.1 { worst } else { one }
        })
    }

    /// Derivatives (21 × 6) of the other parameters by the bends once these are fixed, and the
    /// covariance that is left: C_mb C_bb⁺ and C_mm − C_mb C_bb⁺ C_bm.
    pub(crate) fn at_known_bends(&self) -> (SMatrix<f64, 21, 6>, Covariance) {
        const MIN_VARIANCE: f64 = 1e-14;
        let with_bends: SMatrix<f64, 21, 6> = self.covariance.fixed_columns::<6>(BENDS).into();
        let of_bends = self.covariance_of_bends();
        let inverse = of_bends.pseudo_inverse(MIN_VARIANCE).unwrap_or_default();
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

#[cfg(test)]
mod tests {
    use super::*;

    fn sensor() -> Sensor {
        let m = [1.02, 0.01, -0.02, 0.0, 0.97, 0.03, -0.01, 0.02, 1.01];
        let parameters = Parameters::from_fn(|i, _| m.get(i).copied().unwrap_or(0.1));
        let mut covariance = Covariance::zeros();
        covariance[(BIAS, BIAS)] = 0.09;
        Sensor {
            parameters,
            covariance,
            gravity: Gravity {
                value_mps2: 9.81,
                sd_mps2: 0.0,
            },
            model_error_mps2: 0.0,
            tilt_freedom: f64::INFINITY,
        }
    }

    /// ‖a‖ along n errs by 0.3 n_x, whose root mean square is 0.3/√3.
    #[test]
    fn a_bias_alone_shows_in_full_along_its_axis() {
        let mut one = sensor();
        for (i, element) in nalgebra::Matrix3::<f64>::identity().iter().enumerate() {
            one.parameters[i] = *element;
        }
        assert!((one.predicted_mps2() - 0.3 / 3_f64.sqrt()).abs() < 1e-4);
        let (direction, sd) = one.weakest();
        assert!(direction[0].abs() > 0.99 && (sd - 0.3).abs() < 3e-3);
        one.covariance[(0, 0)] = f64::NAN;
        assert!(one.predicted_mps2().is_nan() && one.weakest().1.is_nan());
    }

    #[test]
    fn units_do_not_matter() {
        let one = sensor();
        let counts = one.clone().rescaled(1.0 / 1670.0);
        let in_mps2 = deviations(&one.parameters, &one.covariance_with_gravity());
        let in_counts = deviations(&counts.parameters, &counts.covariance_with_gravity());
        assert!((in_mps2.bias[0] - 0.3).abs() < 1e-9 && in_mps2.scale[0] == 0.0);
        assert!((in_counts.bias[0] / 1670.0 / in_mps2.bias[0] - 1.0).abs() < 1e-9);
        assert!((counts.predicted_mps2() / one.predicted_mps2() - 1.0).abs() < 1e-9);
    }
}
