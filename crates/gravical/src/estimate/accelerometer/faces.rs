//! Ferraris' method.

use crate::Result;
use crate::calibration_file::{PoseTilt, TiltSource};
use crate::estimate::ferraris;
use crate::estimate::pose_noise::PoseNoise;

use super::{ASSUMED_TILT_DEG, Estimate, EstimateOptions, Method, Session, UNUSUAL_TILT, Use};

pub(super) fn by_ferraris(
    session: &Session<'_>,
    options: &EstimateOptions,
    noise: PoseNoise,
) -> Result<Estimate> {
    let placements = &session.segmentation.placements;
    let faces = ferraris::sort_into_faces(placements, session.recordings)?;
    let names = session.faces_by_name.then_some(session.axes);
    let fit = ferraris::accelerometer(&faces, session.gravity, names)?;
    let face_angle = fit.face_angle_rms_deg(&faces);
    let tilt = pose_tilt(options.pose_tilt_deg, face_angle);
    let uses = (0..placements.len())
        .map(|index| Use::on_face(faces.face_of(index), &placements[index]))
        .collect();
    Ok(Estimate {
        drift: None,
        method: Method::Ferraris,
        model: fit.parameters.model(),
        bias: fit.parameters.bias,
        calibration: fit.calibration,
        covariance: fit.covariance(&faces, session.gravity, tilt.value.to_radians()),
        uses,
        tilt: Some(tilt),
        degrees_of_freedom: (faces.placements() as u32).saturating_sub(6),
        face_angle_rms_deg: Some(face_angle),
        faces: Some(faces),
        quality: None,
        joint: None,
        noise,
        findings: Vec::new(),
    })
}

/// The tilt that Ferraris' uncertainty is computed with. Faces that lie further
/// off than the usual tilt explains are not believed to be better than they
/// look: an angle of rms α has two components of sd α/√2.
fn pose_tilt(given: Option<f64>, face_angle_rms_deg: f64) -> PoseTilt {
    let seen = face_angle_rms_deg / std::f64::consts::SQRT_2;
    let (value, source) = match given {
        Some(value) => (value, TiltSource::Given),
        None if seen > ASSUMED_TILT_DEG * UNUSUAL_TILT => (seen, TiltSource::Estimated),
        None => (ASSUMED_TILT_DEG, TiltSource::Assumed),
    };
    PoseTilt { value, source }
}
