//! The best model with an offset and a scale for each axis, and what it loses.
//!
//! The full model is f = M⁻¹ (r − b). Over all directions of f at 1 g the diagonal model d (r − p)
//! with the least mean square error ‖d (r − p) − f‖ is, with mᵢ the rows of M, p = b and
//! dᵢ = Mᵢᵢ / ‖mᵢ‖²: the offset is uncorrelated with a direction that is uniform over the sphere,
//! and each axis is a regression on its own.

use gravical_core::matrix3::{
    det, diagonal, dot, identity, inverse, mul, mul_vec, norm, sub, transpose,
};

use super::sensor::{Matrix, Sensor};
use gravical_judge::Result;

use crate::problem::Problem;

/// Smallest cosine between an axis of the sensor and the nearest axis of the case (25°): beyond
/// it a model of single axes is no calibration.
const MIN_COSINE: f64 = 0.9;
/// Directions at which the loss is evaluated, on a spiral over the sphere: 3.5° apart.
const DIRECTIONS: usize = 4000;

/// Scale of each axis of the sensor; its offset is the bias of the full model.
pub(super) struct Diagonal {
    pub scale: [f64; 3],
    /// What is lost against the full model, in words.
    pub loss: String,
    /// True if the calibration turns the sensor's axes to others of the case.
    pub is_turned: bool,
}

/// The diagonal model with the least error.
///
/// # Errors
///
/// `calibration-values` (input) for a singular matrix, `export-target` (input) if the sensor's
/// axes are those of the case neither in any order nor with any signs.
pub(super) fn fit_diagonal(full: &Sensor) -> Result<Diagonal> {
    let model = inverse(&full.matrix).ok_or_else(|| Problem::NotDiagonal.error())?;
    let order = order_axes(&model)?;
    // Forces in the axes of the sensor, so that the model is near the identity.
    let model = mul(&model, &transpose(&order));
    let scale = std::array::from_fn(|i| model[i][i] / dot(&model[i], &model[i]));
    Ok(Diagonal {
        scale,
        loss: describe_loss(&mul(&diagonal(scale), &model)),
        is_turned: order != identity::<f64>(),
    })
}

/// Which axis of the case each axis of the sensor is, as a signed permutation.
fn order_axes(model: &Matrix) -> Result<Matrix> {
    let mut order = [[0.0; 3]; 3];
    for (row, chosen) in model.iter().zip(&mut order) {
        if let Some(axis) = (0..3).find(|k| row[*k].abs() >= MIN_COSINE * norm(row)) {
            chosen[axis] = row[axis].signum();
        }
    }
    if det(&order) > 0.5 {
        return Ok(order);
    }
    Err(Problem::NotDiagonal.error())
}

/// `product`: diagonal model · inverse of the full model, near the identity.
fn describe_loss(product: &Matrix) -> String {
    let (mut square, mut worst) = (0.0, 0.0_f64);
    for i in 0..DIRECTIONS {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / DIRECTIONS as f64;
        let (sin, cos) = (i as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt())).sin_cos();
        let across = (1.0 - z * z).sqrt();
        let truth = [across * cos, across * sin, z];
        let found = mul_vec(product, &truth);
        square += norm(&sub(&found, &truth)).powi(2) / DIRECTIONS as f64;
        worst = worst.max((norm(&found) - 1.0).abs());
    }
    format!(
        "Without cross-axis terms: at 1 g the vector is off by {:.2} mg rms over all directions, and ‖a‖ by at most {:.2} mg.",
        1e3 * square.sqrt(),
        1e3 * worst
    )
}
