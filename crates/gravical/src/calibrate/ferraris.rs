//! Ferraris' six-position calibration: from placements to what the closed form
//! of [`gravical_core::six_position`] needs, and back.

mod faces;

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use gravical_core::six_position::{
    AccelerometerParameters, SixPositionError, ferraris_accelerometer,
};
use gravical_fit::model::{Covariance, DRIFT};
use gravical_fit::propagate;
use nalgebra::DVector;

use crate::poses::face::{AXES, AxisMap, Face};
use crate::{Error, Result};

pub(super) use faces::six_positions;
pub use faces::{Faces, sort_into_faces};

/// A fitted accelerometer.
#[derive(Debug, Clone)]
pub struct AccelerometerFit {
    /// K, R and b.
    pub parameters: AccelerometerParameters<f64>,
    /// matrix · (raw − bias).
    pub calibration: Calibration<f64>,
}

impl AccelerometerFit {
    /// Angle of each face that placement and misalignment leave when bias and
    /// scale are taken off, rms over the faces, degrees. Ferraris' method
    /// cannot tell the two apart, so this bounds the tilt from above.
    #[must_use]
    pub fn face_angle_rms_deg(&self, faces: &Faces) -> f64 {
        let AccelerometerParameters { scale, bias, .. } = &self.parameters;
        let squares = faces.means.iter().map(|reading| {
            let channels = std::array::from_fn(|i| (reading[i] - bias[i]) / scale[i]);
            Face::nearest(channels).1.powi(2)
        });
        (squares.sum::<f64>() / 6.0).sqrt()
    }

    /// Covariance of M and b by the standard errors of the means and a tilt of the faces (standard
    /// deviation of each of its two components); none without standard errors.
    ///
    /// The closed form is computed again with each of its 30 errors: a tilt costs the matrix about σ_tilt,
    /// and the bias g√(σ_tilt⁴/2 + c²σ_tilt²), c the cross-axis terms.
    #[must_use]
    pub(super) fn covariance(
        &self,
        faces: &Faces,
        gravity: f64,
        tilt_rad: f64,
    ) -> Option<Covariance> {
        let errors = faces.standard_errors.as_ref()?;
        let model = self.parameters.model();
        let parameters = |face: Face, change: [f64; 3]| {
            let mut means = faces.means;
            let mean = &mut means[face.index()];
            *mean = matrix3::add(mean, &change);
            let moved = ferraris_accelerometer(&six_positions(&means), gravity).ok()?;
            let matrix = moved.model();
            Some(DVector::from_iterator(
                DRIFT,
                matrix.as_flattened().iter().chain(&moved.bias).copied(),
            ))
        };
        let here = parameters(Face::all()[0], [0.0; 3])?;
        // Three components of six means, then two of six tilts.
        let covariance = propagate(&here, 18 + 12, |k, step| {
            let mut change = [0.0; 3];
            if k < 18 {
                let face = Face::all()[k / 3];
                change[k % 3] = step * errors[k / 3][k % 3];
                return parameters(face, change);
            }
            let face = Face::all()[(k - 18) / 2];
            let (sine, cosine) = (step * tilt_rad).sin_cos();
            change = face.direction().map(|d| gravity * d * (cosine - 1.0));
            change[(face.axis + 1 + k % 2) % 3] = gravity * sine;
            parameters(face, matrix3::mul_vec(&model, &change))
        })?;
        Some(Covariance::from_fn(|i, k| {
            covariance.get((i, k)).copied().unwrap_or(0.0)
        }))
    }
}

/// Fits K, R and b. `names` is how the board sits in the case whose faces the
/// names tell; none when the faces are the data's own.
///
/// # Errors
///
/// `singular`; `left-handed` when the faces were taken from names
/// and contradict each other.
pub fn accelerometer(
    faces: &Faces,
    gravity: f64,
    names: Option<&AxisMap>,
) -> Result<AccelerometerFit> {
    let failed = |e: SixPositionError| {
        Error::input(
            "singular",
            format!("the six means determine no parameters: {e}"),
        )
        .with_hint("`gravical inspect` shows what each pose reads")
    };
    let parameters =
        ferraris_accelerometer(&six_positions(&faces.means), gravity).map_err(failed)?;
    if let Some(axes) = names
        && let Some(why) = mirrored(faces, &parameters, axes)
    {
        return Err(left_handed(&why));
    }
    let calibration = parameters
        .calibration()
        .ok_or_else(|| failed(SixPositionError::Singular))?;
    Ok(AccelerometerFit {
        parameters,
        calibration,
    })
}

pub(super) fn turns_are_singular(e: SixPositionError) -> Error {
    Error::input("singular", format!("the turns determine no gyroscope: {e}"))
}

/// Faces that were taken from names make a mirror image.
pub(super) fn left_handed(why: &str) -> Error {
    Error::input(
        "left-handed",
        format!("the faces as named make a left-handed sensor ({why}): two poses are swapped"),
    )
    .with_hint("leave --faces-from names out, and the faces are taken from the data")
}

/// Why faces that were taken from names cannot be those of a real sensor.
fn mirrored(
    faces: &Faces,
    parameters: &AccelerometerParameters<f64>,
    axes: &AxisMap,
) -> Option<String> {
    let determinant = parameters.orientation_determinant();
    let seen = |reading: [f64; 3], axis: usize| axes.to_case(reading)[axis];
    let column = |axis: usize| parameters.orientation.map(|row| row[axis]);
    // Each axis of the case is measured by the channel that --axes says, one
    // way or the other.
    let as_told = (0..3).all(|i| seen(column(i), i).abs() > 0.7);
    let clash = (0..3)
        .map(|i| {
            (
                i,
                seen(faces.means[2 * i], i),
                seen(faces.means[2 * i + 1], i),
            )
        })
        .find(|(_, up, down)| up <= down);
    match clash {
        Some((i, up, down)) if as_told => Some(format!(
            "{a} reads less with +{a} up ({up:.4}) than with −{a} up ({down:.4})",
            a = AXES[i]
        )),
        _ => (determinant <= 0.0).then(|| format!("det R = {determinant:.3}")),
    }
}
