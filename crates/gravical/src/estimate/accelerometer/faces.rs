//! Methods that know faces only.

use gravical_core::calibration::Calibration;

use crate::calibration_file::{PlacementTilt, TiltSource};
use crate::estimate::linear::linear12;
use crate::estimate::pose_noise::PoseNoise;
use crate::estimate::{Reading, ferraris};
use crate::recording::Finding;
use crate::segment::Placement;
use crate::segment::face::{Claim, Face};
use crate::{Error, Result};

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
    let tilt = placement_tilt(options.placement_tilt_deg, face_angle);
    let uses = (0..placements.len())
        .map(|index| {
            let face = faces.face_of(index);
            Use {
                face,
                fitted: face.is_some(),
                tilt_deg: face.map(|_| (placements[index].angle_deg, None)),
                direction: None,
                left_out_error: None,
                left_out_sd: None,
                bad: None,
            }
        })
        .collect();
    Ok(Estimate {
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
fn placement_tilt(given: Option<f64>, face_angle_rms_deg: f64) -> PlacementTilt {
    let seen = face_angle_rms_deg / std::f64::consts::SQRT_2;
    let (value, source) = match given {
        Some(value) => (value, TiltSource::Given),
        None if seen > ASSUMED_TILT_DEG * UNUSUAL_TILT => (seen, TiltSource::Estimated),
        None => (ASSUMED_TILT_DEG, TiltSource::Assumed),
    };
    PlacementTilt { value, source }
}

/// A placement that nobody names is no face for a method that takes faces as
/// exact when it lies further off, degrees (bias included).
const MOST_OFF_DEG: f64 = 12.0;

/// The face that a placement is taken for: what it is named, unless another side
/// is up; else the nearest, where that is near.
fn exact_face(placement: &Placement) -> Option<Face> {
    match placement.claim {
        Some(Claim::Face(named)) if placement.face.is_none_or(|f| f == named) => Some(named),
        _ => placement
            .face
            .filter(|_| placement.angle_deg <= MOST_OFF_DEG),
    }
}

/// Least squares with the faces taken as exact: for precise fixtures, and it
/// says so.
pub(super) fn by_linear(session: &Session<'_>, noise: PoseNoise) -> Result<Estimate> {
    let placements = &session.segmentation.placements;
    let faces: Vec<Option<Face>> = placements.iter().map(exact_face).collect();
    let used = || placements.iter().zip(&faces).filter(|(_, f)| f.is_some());
    let readings: Vec<Reading> = used().map(|(p, _)| Reading::from(p)).collect();
    let directions: Vec<[f64; 3]> = faces.iter().flatten().map(|f| f.direction()).collect();
    if readings.is_empty() {
        return Err(Error::input("missing-face", "no placement lies on a face")
            .with_hint("linear12 needs faces; leave --method out for poses of any kind"));
    }
    let fit = linear12(&readings, &directions, session.gravity)?;
    let uses = placements
        .iter()
        .zip(&faces)
        .map(|(p, face)| Use {
            face: *face,
            fitted: face.is_some(),
            tilt_deg: face.map(|_| (p.angle_deg, None)),
            direction: None,
            left_out_error: None,
            left_out_sd: None,
            bad: None,
        })
        .collect();
    Ok(Estimate {
        method: Method::Linear12,
        model: fit.model,
        bias: fit.bias,
        calibration: Calibration {
            matrix: fit.matrix,
            bias: fit.bias,
        },
        covariance: fit.covariance,
        uses,
        tilt: None,
        degrees_of_freedom: (readings.len() as u32).saturating_sub(6),
        faces: ferraris::sort_into_faces(placements, session.recordings).ok(),
        face_angle_rms_deg: None,
        quality: None,
        joint: None,
        noise,
        findings: vec![Finding::warning(
            "faces-exact",
            "linear12 takes every face as exactly level: a tilt of 1° costs about 10 mg, and it is not in the uncertainty. Without a precise fixture, leave --method out",
        )],
    })
}
