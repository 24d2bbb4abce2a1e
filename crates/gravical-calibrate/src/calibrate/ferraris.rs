//! Ferraris' six-position calibration: from placements to what the closed form
//! of [`gravical_core::six_position`] needs, and back.

use gravical_core::calibration::LinearCalibration;
use gravical_core::matrix3;
use gravical_core::six_position::{
    AccelerometerParameters, SixPositionError, SixPositionMeans, ferraris_accelerometer,
};
use gravical_fit::covariance_by_gravity;
use gravical_fit::model::{BIAS, Covariance, DRIFT, Parameters};
use gravical_signal::stats::rms;

use crate::poses::face::{Face, angle_deg};
use crate::poses::{MAX_FACE_ANGLE_DEG, Pose, advise_rate};
use crate::problem::Problem;
use crate::recording::Recording;
use crate::{Error, Result};

use super::session::at_only;

/// A repeat of a face that points this far from the best one is an oblique
/// pose, degrees.
const REPEAT_WITHIN_DEG: f64 = 5.0;

/// What lies on each face.
#[derive(Debug, Clone)]
pub struct Faces {
    /// The face for which each placement is used; none when it is oblique.
    pub of_placements: Vec<Option<Face>>,
    /// In the order of [`Face::all`].
    means: [[f64; 3]; 6],
    /// Of these means; none if one is not known.
    standard_errors: Option<Vec<[f64; 3]>>,
}

/// Means in the order of [`Face::all`] as the closed form takes them.
fn six_positions(means: &[[f64; 3]; 6]) -> SixPositionMeans<f64> {
    SixPositionMeans {
        plus: std::array::from_fn(|axis| means[2 * axis]),
        minus: std::array::from_fn(|axis| means[2 * axis + 1]),
    }
}

/// Sorts placements into the six faces. Repeats of a face are pooled, weighted
/// by their rows.
///
/// # Errors
///
/// `missing-face` with the faces that are there.
pub fn sort_into_faces(placements: &[Pose], recordings: &[Recording]) -> Result<Faces> {
    let best = Face::all().map(|face| {
        let there = placements.iter().filter(|p| p.face == Some(face));
        there.min_by(|a, b| a.angle_deg.total_cmp(&b.angle_deg))
    });
    let mut missing = Face::all().to_vec();
    missing.retain(|face| best[face.index()].is_none());
    if !missing.is_empty() {
        return Err(incomplete(placements, &missing, recordings));
    }
    let used_as = |p: &Pose| {
        let face = p.face?;
        let is_near = |best: &Pose| angle_deg(p.mean, best.mean) <= REPEAT_WITHIN_DEG;
        best[face.index()].is_some_and(is_near).then_some(face)
    };
    let of_placements: Vec<Option<Face>> = placements.iter().map(used_as).collect();
    let pooled = Face::all().map(|face| {
        let poses = || {
            let each = placements.iter().zip(&of_placements);
            each.filter(move |(_, used_as)| **used_as == Some(face))
        };
        let rows: f64 = poses().map(|(p, _)| p.count as f64).sum();
        let (mut mean, mut variance) = ([0.0; 3], Some([0.0; 3]));
        for (pose, _) in poses() {
            let weight = pose.count as f64 / rows;
            mean = std::array::from_fn(|i| mean[i] + weight * pose.mean[i]);
            let known = variance.zip(pose.standard_error);
            variance = known.map(|(sum, error): ([f64; 3], [f64; 3])| {
                std::array::from_fn(|i| sum[i] + (weight * error[i]).powi(2))
            });
        }
        (mean, variance)
    });
    let errors = pooled.iter().map(|(_, v)| v.map(|v| v.map(f64::sqrt)));
    Ok(Faces {
        means: pooled.map(|(mean, _)| mean),
        standard_errors: errors.collect(),
        of_placements,
    })
}

fn incomplete(placements: &[Pose], missing: &[Face], recordings: &[Recording]) -> Error {
    let problem = Problem::MissingFaces {
        missing: missing.to_vec(),
        oblique: placements.iter().filter(|p| p.face.is_none()).count(),
        poses: placements.len(),
        limit_deg: MAX_FACE_ANGLE_DEG,
    };
    let found = placements.iter().filter(|p| p.is_found);
    let found = found.map(|p| &recordings[p.recording]);
    let error = advise_rate(problem.error(), found);
    at_only(recordings, error)
}

impl Faces {
    /// Angle of each face that placement and misalignment leave when bias and
    /// scale are taken off, rms over the faces, degrees. Ferraris' method
    /// cannot tell the two apart, so this bounds the tilt from above.
    pub fn angle_rms_deg(&self, parameters: &AccelerometerParameters<f64>) -> f64 {
        let AccelerometerParameters { scale, bias, .. } = parameters;
        let angle_deg = |reading: &[f64; 3]| {
            let channels = std::array::from_fn(|i| (reading[i] - bias[i]) / scale[i]);
            Face::nearest(channels).1
        };
        rms(self.means.iter().map(angle_deg))
    }

    /// Covariance of `model`, M, and b by the standard errors of the means and a tilt of the faces (standard
    /// deviation of each of its two components); none without standard errors.
    ///
    /// The closed form is computed again with each of these errors. A tilt of σ turns a reading by σ and shortens
    /// it by σ²/2 for each component, σ² on average and σ² of scatter: the first is an error of all faces alike,
    /// as one of gravity.
    pub(super) fn covariance(
        &self,
        model: &[[f64; 3]; 3],
        gravity: f64,
        tilt_rad: f64,
    ) -> Option<Covariance> {
        let errors = self.standard_errors.as_ref()?;
        let parameters = |face: Face, change: [f64; 3]| {
            let mut means = self.means;
            let mean = &mut means[face.index()];
            *mean = matrix3::add(mean, &change);
            let moved = ferraris_accelerometer(&six_positions(&means), gravity).ok()?;
            let matrix = moved.model();
            Some(Parameters::from_fn(|i, _| match i {
                0..BIAS => matrix[i / 3][i % 3],
                BIAS..DRIFT => moved.bias[i - BIAS],
                _ => 0.0,
            }))
        };
        let (turned, shorter) = (tilt_rad.sin(), 2.0 * (1.0 - tilt_rad.cos()));
        let mut covariance = Covariance::zeros();
        let mut add = |face: Face, change: [f64; 3]| {
            let back = change.map(|c| -c);
            let slope = (parameters(face, change)? - parameters(face, back)?) / 2.0;
            covariance += slope * slope.transpose();
            Some(())
        };
        for face in Face::all() {
            for axis in 0..3 {
                let along = |size: f64| std::array::from_fn(|i| if i == axis { size } else { 0.0 });
                add(face, along(errors[face.index()][axis]))?;
                let tilt = if axis == face.axis { shorter } else { turned };
                add(face, matrix3::mul_vec(model, &along(gravity * tilt)))?;
            }
        }
        let here = parameters(Face::all()[0], [0.0; 3])?;
        Some(covariance + covariance_by_gravity(&here, shorter))
    }
}

/// K, R and b, and matrix · (raw − bias).
///
/// # Errors
///
/// `singular`.
pub fn accelerometer(
    faces: &Faces,
    gravity: f64,
) -> Result<(AccelerometerParameters<f64>, LinearCalibration<f64>)> {
    let parameters = ferraris_accelerometer(&six_positions(&faces.means), gravity);
    let both = parameters.and_then(|parameters| {
        let calibration = parameters.calibration();
        Ok((parameters, calibration.ok_or(SixPositionError::Singular)?))
    });
    both.map_err(|why| Problem::SixMeans { why }.error())
}
