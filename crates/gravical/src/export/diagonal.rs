//! The best model with an offset and a scale for each axis, and what it loses.
//!
//! The full model is f = M⁻¹ (r − b). Over all directions of f at 1 g the diagonal model d (r − p)
//! with the least mean square error ‖d (r − p) − f‖ is, with mᵢ the rows of M, p = b and
//! dᵢ = Mᵢᵢ / ‖mᵢ‖²: the offset is uncorrelated with a direction that is uniform over the sphere,
//! and each axis is a regression on its own.

use gravical_core::matrix3::{det, diagonal, identity, inverse, mul, transpose};
use nalgebra::Matrix3;

use super::nominal::{Matrix, Nominal};
use crate::{Error, Result};

/// Smallest cosine between an axis of the sensor and the nearest axis of the case (25°): beyond
/// it a model of single axes is no calibration.
const SMALLEST_COSINE: f64 = 0.9;

/// An offset and a scale for each axis of the sensor.
pub(super) struct Diagonal {
    /// Scale.
    pub scale: [f64; 3],
    /// Offset, m/s².
    pub offset: [f64; 3],
    /// What is lost against the full model.
    pub loss: Loss,
    /// True if the calibration turns the sensor's axes to others of the case.
    pub turned: bool,
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
    pub fn says(&self, without: &str) -> String {
        let Loss {
            rms_mg,
            max_mg,
            norm_mg,
        } = self;
        format!(
            "Without {without}: at 1 g the vector is off by {rms_mg:.2} mg rms over all directions, by {max_mg:.2} mg in the worst, and ‖a‖ by at most {norm_mg:.2} mg."
        )
    }
}

/// The diagonal model with the least error; with `scale` given, only its offset is fitted.
///
/// # Errors
///
/// `calibration-values` (input) for a singular matrix, `export-target` (input) if the sensor's
/// axes are those of the case neither in any order nor with any signs.
pub(super) fn fit(full: &Nominal, scale: Option<[f64; 3]>) -> Result<Diagonal> {
    let singular = || {
        Error::input(
            "calibration-values",
            "the accelerometer's matrix is singular",
        )
    };
    let model = inverse(&full.matrix).ok_or_else(singular)?;
    let order = axes(&model)?;
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
        turned: order != identity::<f64>(),
    })
}

/// Which axis of the case each axis of the sensor is, as a signed permutation.
fn axes(model: &Matrix) -> Result<Matrix> {
    let mut order = [[0.0; 3]; 3];
    for (row, chosen) in model.iter().zip(&mut order) {
        let length = row.iter().map(|v| v * v).sum::<f64>().sqrt();
        if let Some(axis) = (0..3).find(|k| row[*k].abs() >= SMALLEST_COSINE * length) {
            chosen[axis] = row[axis].signum();
        }
    }
    let turns = det(&order);
    if turns > 0.5 {
        return Ok(order);
    }
    let why = match turns < -0.5 {
        true => {
            "the sensor reads its axes with the other sign, and this target has no negative scale"
        }
        false => {
            "an axis of the sensor is more than 25° from every axis of the case, and this target has a scale for each axis only"
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use gravical_core::matrix3::mul_vec;

    /// Directions over the sphere, evenly.
    fn directions() -> Vec<[f64; 3]> {
        let n = 4000;
        let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        (0..n)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
                let (s, c) = (golden * f64::from(i)).sin_cos();
                let r = (1.0 - z * z).sqrt();
                [r * c, r * s, z]
            })
            .collect()
    }

    fn errors(full: &Nominal, d: &Diagonal) -> (f64, f64, f64) {
        let model = inverse(&full.matrix).unwrap();
        let (mut sum, mut max, mut norm) = (0.0, 0.0_f64, 0.0_f64);
        let all = directions();
        for u in &all {
            let raw = mul_vec(&model, u);
            let out: [f64; 3] = std::array::from_fn(|i| d.scale[i] * raw[i]);
            let e: f64 = (0..3).map(|i| (out[i] - u[i]).powi(2)).sum();
            sum += e;
            max = max.max(e.sqrt());
            norm = norm.max((out.iter().map(|v| v * v).sum::<f64>().sqrt() - 1.0).abs());
        }
        let rms = (sum / all.len() as f64).sqrt();
        (1000.0 * rms, 1000.0 * max, 1000.0 * norm)
    }

    fn full() -> Nominal {
        Nominal {
            matrix: [
                [0.98, 0.021, -0.013],
                [0.004, 1.03, 0.017],
                [-0.009, 0.002, 1.01],
            ],
            bias: [0.3, -0.1, 0.2],
        }
    }

    #[test]
    fn no_other_diagonal_is_better_and_the_loss_is_what_directions_show() {
        let full = full();
        let best = fit(&full, None).unwrap();
        let (rms, max, norm) = errors(&full, &best);
        assert!(
            (best.loss.rms_mg - rms).abs() < 0.01 * rms,
            "{:?} {rms}",
            best.loss
        );
        assert!(
            (best.loss.max_mg - max).abs() < 0.01 * max,
            "{:?} {max}",
            best.loss
        );
        assert!(
            (best.loss.norm_mg - norm).abs() < 0.05 * norm,
            "{:?} {norm}",
            best.loss
        );
        assert_eq!(best.offset, full.bias);
        for axis in 0..3 {
            for step in [-1e-3, 1e-3] {
                let mut scale = best.scale;
                scale[axis] += step;
                let other = fit(&full, Some(scale)).unwrap();
                assert!(errors(&full, &other).0 > rms, "{axis} {step}");
            }
        }
        // The diagonal of the matrix alone is worse.
        let kept = fit(&full, Some(std::array::from_fn(|i| full.matrix[i][i]))).unwrap();
        assert!(kept.loss.rms_mg > best.loss.rms_mg);
    }

    #[test]
    fn axes_in_another_order_are_the_same_sensor() {
        let straight = fit(&full(), None).unwrap();
        // The case's x, y, z are the sensor's y, −x, z.
        let turn = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let turned = Nominal {
            matrix: mul(&turn, &full().matrix),
            ..full()
        };
        let turned = fit(&turned, None).unwrap();
        assert!(turned.turned && !straight.turned);
        for i in 0..3 {
            assert!((turned.scale[i] - straight.scale[i]).abs() < 1e-12);
        }
        let mirrored = Nominal {
            matrix: full().matrix.map(|row| row.map(|v| -v)),
            ..full()
        };
        let oblique = Nominal {
            matrix: [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]],
            ..full()
        };
        for none in [mirrored, oblique] {
            assert_eq!(fit(&none, None).err().unwrap().code(), "export-target");
        }
    }
}
