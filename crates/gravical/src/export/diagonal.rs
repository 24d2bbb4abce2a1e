//! The best model with an offset and a scale for each axis, and what it loses.
//!
//! The full model is f = M⁻¹ (r − b). Over all directions of f at 1 g the diagonal model d (r − p)
//! with the least mean square error ‖d (r − p) − f‖ is, with mᵢ the rows of M, p = b and
//! dᵢ = Mᵢᵢ / ‖mᵢ‖²: the offset is uncorrelated with a direction that is uniform over the sphere,
//! and each axis is a regression on its own.

use gravical_core::matrix3::{det, diagonal, identity, inverse, mul, transpose};
use nalgebra::Matrix3;

use super::sensor::{Matrix, Sensor};
use crate::{Error, Result};

/// Smallest cosine between an axis of the sensor and the nearest axis of the case (25°): beyond
/// it a model of single axes is no calibration.
const MIN_COSINE: f64 = 0.9;

/// An offset and a scale for each axis of the sensor.
pub(super) struct Diagonal {
    /// Scale.
    pub scale: [f64; 3],
    /// Offset, m/s².
    pub offset: [f64; 3],
    /// What is lost against the full model.
    pub loss: Loss,
    /// True if the calibration turns the sensor's axes to others of the case.
    pub is_turned: bool,
}

/// Error of the diagonal model at 1 g, mg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Loss {
    /// Root mean square over all directions of the length of the error.
    pub rms_mg: f64,
    /// The same in the worst direction.
    pub max_mg: f64,
    /// Error of ‖a‖ in its worst direction.
    pub norm_mg: f64,
}

impl Loss {
    /// In a sentence, after what the target cannot hold.
    pub fn describe(&self, without: &str) -> String {
        format!(
            "Without {without}: at 1 g the vector is off by {:.2} mg rms over all directions, by {:.2} mg in the worst, and ‖a‖ by at most {:.2} mg.",
            self.rms_mg, self.max_mg, self.norm_mg
        )
    }
}

/// The diagonal model with the least error; with `scale` given, only its offset is fitted.
///
/// # Errors
///
/// `calibration-values` (input) for a singular matrix, `export-target` (input) if the sensor's
/// axes are those of the case neither in any order nor with any signs.
pub(super) fn fit_diagonal(full: &Sensor, scale: Option<[f64; 3]>) -> Result<Diagonal> {
    let singular = || {
        Error::input(
            "calibration-values",
            "the accelerometer's matrix is singular",
        )
    };
    let model = inverse(&full.matrix).ok_or_else(singular)?;
    let order = order_axes(&model)?;
    // Forces in the axes of the sensor, so that the model is near the identity.
    let model = mul(&model, &transpose(&order));
    let fitted = std::array::from_fn(|i| {
        let [x, y, z] = model[i];
        model[i][i] / (x * x + y * y + z * z)
    });
    let scale = scale.unwrap_or(fitted);
    Ok(Diagonal {
        scale,
        offset: full.bias,
        loss: loss(&mul(&diagonal(scale), &model)),
        is_turned: order != identity::<f64>(),
    })
}

/// Which axis of the case each axis of the sensor is, as a signed permutation.
fn order_axes(model: &Matrix) -> Result<Matrix> {
    let mut order = [[0.0; 3]; 3];
    for (row, chosen) in model.iter().zip(&mut order) {
        let length = row.iter().map(|v| v * v).sum::<f64>().sqrt();
        if let Some(axis) = (0..3).find(|k| row[*k].abs() >= MIN_COSINE * length) {
            chosen[axis] = row[axis].signum();
        }
    }
    let turns = det(&order);
    if turns > 0.5 {
        return Ok(order);
    }
    let why = if turns < -0.5 {
        "the sensor reads its axes with the other sign, and this target has no negative scale"
    } else {
        "an axis of the sensor is more than 25° from every axis of the case, and this target has a scale for each axis only"
    };
    Err(Error::input("export-target", why).with_hint(
        "export to a target with a full matrix, such as c or ros, or calibrate in the axes of the sensor",
    ))
}

/// What `product` = diagonal model · inverse of the full model lacks of the identity.
fn loss(product: &Matrix) -> Loss {
    let error = Matrix3::from_fn(|i, j| product[i][j] - f64::from(u8::from(i == j)));
    let worst = (error.transpose() * error).symmetric_eigenvalues().max();
    let norm = ((error + error.transpose()) / 2.0).symmetric_eigenvalues();
    Loss {
        rms_mg: 1000.0 * error.norm() / 3.0_f64.sqrt(),
        max_mg: 1000.0 * worst.max(0.0).sqrt(),
        norm_mg: 1000.0 * norm.amax(),
    }
}
