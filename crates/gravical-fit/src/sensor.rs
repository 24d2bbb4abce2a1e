//! A calibration as numbers: parameters, their covariance, and what these say of ‖a‖.

use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use statrs::distribution::ContinuousCDF;

use crate::model::{
    BIAS, Covariance, DIRECTIONS, MAX_STEPS, NONLINEARITY, PARAMETERS, Parameters, invariants,
    inverse, jacobian, matrix, nonlinear_error, sensitivity, sphere,
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
    /// M, b, drift and nonlinearity; what is not known of the last two is 0.
    pub parameters: Parameters,
    /// Covariance of these by the readings: without the error of gravity, which later readings in
    /// the same place share. Rows of what is not known are 0.
    pub covariance: Covariance,
    /// Gravity that M rests on.
    pub gravity: Gravity,
    /// Standard deviation of what the model leaves out of a length, m/s².
    pub model_error_mps2: f64,
}

/// What is claimed of ‖a‖ along a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Claim {
    /// Unit vector of specific force.
    pub direction: Vector3<f64>,
    /// Error by the nonlinearity that the poses show, m/s².
    pub nonlinear_mps2: f64,
    /// Standard deviation of what parameters, gravity and nonlinearity leave open, m/s². The model error is in it once
    /// and in full: poses do not average it out.
    pub sd_mps2: f64,
}

/// The direction in which the error claimed of ‖a‖ is largest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WorstDirection {
    /// Unit vector of specific force, axes of the case.
    pub direction: [f64; 3],
    /// Limit of the error, m/s². By the fit: it holds in every direction at once in 95 % of sessions, and is
    /// the nonlinearity that the poses show and 2 to 3 standard uncertainties. By the closed form: 2 standard
    /// uncertainties.
    pub error_mps2: f64,
    /// Standard uncertainty of ‖a‖ there, without the nonlinearity that the poses show, m/s².
    pub sd_mps2: f64,
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
    let slopes = jacobian(&scaled, |x| Some(invariants(x)));
    let slopes = slopes.unwrap_or_else(|| DMatrix::repeat(9, PARAMETERS, f64::NAN));
    let covariance = covariance / (unit * unit);
    let variances = (&slopes * covariance * slopes.transpose()).diagonal();
    let sd = |i: usize| root(variances[i]);
    Deviations {
        bias: [0, 1, 2].map(|i| unit * sd(i)),
        scale: [3, 4, 5].map(|i| unit * sd(i)),
        axis_angle_deg: [6, 8, 7].map(|i| sd(i).to_degrees()),
    }
}

/// How the sensor is turned in its case, as the faces show it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Mounting {
    /// Rotation vector that turns the axes of the case onto those of the sensor, degrees.
    pub rotation_deg: [f64; 3],
    /// Its standard deviations, degrees.
    pub sigma_deg: [f64; 3],
}

/// The rotation of the sensitive axes, each against the axis of the case that is nearest to it, with its deviations;
/// none where M is singular.
pub fn mounting(x: &Parameters, covariance: &Covariance) -> Option<Mounting> {
    let unit = matrix(x).norm() / 3_f64.sqrt();
    let rotation = |x: &Parameters| {
        let mut axes = Matrix3::zeros();
        for row in matrix(x).row_iter() {
            let (axis, nearest) = (row.transpose().normalize(), row.transpose().iamax());
            axes.set_column(nearest, &(axis * axis[nearest].signum()));
        }
        turn(&axes)
    };
    let scaled = x / unit;
    let slopes = jacobian(&scaled, rotation)?;
    let variances = (&slopes * (covariance / (unit * unit)) * slopes.transpose()).diagonal();
    let value = rotation(&scaled)?;
    Some(Mounting {
        rotation_deg: [0, 1, 2].map(|i| value[i].to_degrees()),
        sigma_deg: [0, 1, 2].map(|i| root(variances[i]).to_degrees()),
    })
}

/// Rotation vector of the rotation nearest to a matrix (its polar factor); none where that is singular or mirrors.
pub(crate) fn turn(t: &Matrix3<f64>) -> Option<DVector<f64>> {
    let proper = t.iter().all(|v| v.is_finite()) && t.determinant() > 0.0;
    let svd = proper.then(|| t.try_svd(true, true, f64::EPSILON, MAX_STEPS))??;
    let q = Rotation3::from_matrix_unchecked(svd.u? * svd.v_t?);
    // By the quaternion: exact for the smallest turns, where a cosine is not.
    let turn = UnitQuaternion::from_rotation_matrix(&q).scaled_axis();
    Some(DVector::from_column_slice(turn.as_slice()))
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
    pub fn rescaled(mut self, unit: f64) -> Sensor {
        for i in 0..NONLINEARITY {
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

    /// What is claimed of ‖a‖ along some unit vectors, m/s²; NaN where M is singular.
    pub fn claims(&self, directions: impl Iterator<Item = Vector3<f64>>) -> Vec<Claim> {
        let covariance = self.covariance_with_gravity();
        let inverse = inverse(&self.parameters);
        let gravity = self.gravity.value_mps2;
        let claim = |direction: Vector3<f64>| {
            let h = sensitivity(&inverse, &direction, gravity);
            Claim {
                direction,
                nonlinear_mps2: gravity * nonlinear_error(&self.parameters, &direction),
                sd_mps2: root((covariance * h).dot(&h)).hypot(self.model_error_mps2),
            }
        };
        directions.map(claim).collect()
    }

    /// Predicted error of ‖a‖, root mean square over the sphere, m/s².
    pub fn predicted_mps2(&self) -> f64 {
        let claims = self.claims(sphere(DIRECTIONS));
        let square = |claim: &Claim| claim.nonlinear_mps2.powi(2) + claim.sd_mps2.powi(2);
        (claims.iter().map(square).sum::<f64>() / DIRECTIONS as f64).sqrt()
    }

    /// The direction in which the error claimed of ‖a‖ is largest, standard deviations counting `factor` times.
    pub fn weakest(&self, factor: f64) -> WorstDirection {
        let claims = self.claims(sphere(DIRECTIONS));
        let error = |claim: &Claim| claim.nonlinear_mps2.abs() + factor * claim.sd_mps2;
        let errors = DVector::from_iterator(DIRECTIONS, claims.iter().map(error));
        let worst = &claims[errors.imax()];
        WorstDirection {
            direction: worst.direction.into(),
            error_mps2: error(worst),
            sd_mps2: worst.sd_mps2,
        }
    }

    /// So many times its largest standard deviation is what ‖a‖ is off in any direction in 95 % of
    /// sessions: 2 where one combination of parameters is open, up to 3 where several are. Errors are
    /// drawn from the covariance, always the same ones.
    pub fn coverage_factor(&self) -> f64 {
        let inverse = inverse(&self.parameters);
        let eigen = self.covariance_with_gravity().symmetric_eigen();
        let spread = Covariance::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0).sqrt()));
        let root = eigen.eigenvectors * spread;
        let rows: Vec<Parameters> = sphere(100)
            .map(|n| root.tr_mul(&sensitivity(&inverse, &n, self.gravity.value_mps2)))
            .collect();
        let largest_sd = rows.iter().map(Parameters::norm).fold(0.0, f64::max);
        let mut largest: Vec<f64> = normal_draws()
            .map(|draw| rows.iter().map(|r| r.dot(&draw).abs()).fold(0.0, f64::max))
            .collect();
        largest.sort_by(f64::total_cmp);
        let quantile = largest[largest.len() * 95 / 100] / largest_sd;
        if quantile > 2.0 && quantile.is_finite() {
            quantile
        } else {
            2.0
        }
    }
}

/// Two hundred vectors of standard normal numbers: an additive recurrence (Roberts' generalised golden
/// ratio), which covers the cube more evenly than chance.
fn normal_draws() -> impl Iterator<Item = Parameters> {
    let mut ratio = 2_f64;
    for _ in 0..60 {
        ratio = (1.0 + ratio).powf(1.0 / (PARAMETERS as f64 + 1.0));
    }
    let normal = statrs::distribution::Normal::standard();
    (1..=200).map(move |k| {
        Parameters::from_fn(|i, _| {
            let step = ratio.powi(-(i as i32 + 1));
            normal.inverse_cdf((0.5 + step * f64::from(k)).fract())
        })
    })
}
