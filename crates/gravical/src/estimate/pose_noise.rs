//! How far the mean of a placement may be off: noise and rounding.

use crate::segment::Segmentation;

/// Standard error that is taken for means whose scatter nobody knows, m/s²: a
/// second of an MPU6050 at 100 Hz with its 44 Hz low-pass.
const ASSUMED_MPS2: f64 = 4e-3;
/// Uncertainty of the means, input unit.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseNoise {
    /// For every placement: by noise and by rounding.
    pub noise: Vec<[f64; 3]>,
    /// What of it rounding leaves, which no number of rows averages away.
    pub quantisation: [f64; 3],
    /// Some standard errors were assumed: a row was a mean itself.
    pub assumed: bool,
}

/// The uncertainty of every placement's mean. `scale` is about one m/s² in the
/// input unit.
#[must_use]
pub fn pose_noise(session: &Segmentation, scale: f64) -> PoseNoise {
    let least = 1e-7 * scale;
    let mut assumed = false;
    let quantisation = session.noise.rounding;
    let noise = session
        .placements
        .iter()
        .map(|p| match p.standard_error {
            Some(error) => error.map(|e| e.max(least)),
            None => {
                assumed = true;
                quantisation.map(|q| q.hypot(ASSUMED_MPS2 * scale))
            }
        })
        .collect();
    PoseNoise {
        noise,
        quantisation,
        assumed,
    }
}
