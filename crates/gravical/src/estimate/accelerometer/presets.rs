//! Methods that assume what the joint fit finds out.

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;

use crate::calibration_file::FitQuality;
use crate::estimate::joint::{Preset, PresetFit, PresetOptions, preset, preset_left_out};
use crate::estimate::pose_noise::PoseNoise;
use crate::estimate::{Reading, ferraris};
use crate::recording::{Finding, FindingKind};
use crate::segment::Placement;
use crate::segment::face::{Claim, Face};
use crate::{Error, Result};

use super::{Estimate, Method, Session, Use};

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
pub(super) fn by_linear(
    session: &Session<'_>,
    noise: PoseNoise,
    nominal: Option<f64>,
) -> Result<Estimate> {
    let placements = &session.segmentation.placements;
    let faces: Vec<Option<Face>> = placements.iter().map(exact_face).collect();
    let all = || placements.iter().zip(&faces);
    let fitted: Vec<(Reading, Face)> = all()
        .filter_map(|(p, face)| Some((Reading::from(p), (*face)?)))
        .collect();
    let (readings, on): (Vec<Reading>, Vec<Face>) = fitted.into_iter().unzip();
    if readings.is_empty() {
        return Err(Error::input("missing-face", "no pose lies on a face")
            .with_hint("linear12 needs faces; leave --method out for poses of any kind"));
    }
    let options = PresetOptions {
        preset: Preset::Linear12(&on),
        gravity: session.gravity,
        nominal,
    };
    let fit = preset(&readings, &options)?;
    let exact = Finding::new(
        FindingKind::FacesExact,
        "linear12 takes every face as exactly level: a tilt of 1° costs about 10 mg, and it is not in the uncertainty. Without a precise fixture, leave --method out",
    );
    Ok(Estimate {
        uses: all().map(|(p, face)| Use::on_face(*face, p)).collect(),
        degrees_of_freedom: (readings.len() as u32).saturating_sub(6),
        findings: vec![exact],
        ..estimate(Method::Linear12, &fit, session, noise)
    })
}

/// Parameters from the length of gravity alone; the frame is fixed by the
/// triangular convention.
pub(super) fn by_magnitude(
    session: &Session<'_>,
    (method, of): (Method, Preset<'_>),
    noise: PoseNoise,
    nominal: Option<f64>,
) -> Result<Estimate> {
    let placements = &session.segmentation.placements;
    let readings: Vec<Reading> = placements.iter().map(Reading::from).collect();
    let options = PresetOptions {
        preset: of,
        gravity: session.gravity,
        nominal,
    };
    let mut fit = preset(&readings, &options)?;
    let left_out = preset_left_out(&readings, &options, None)?;
    let axes = session.axes;
    let uses = placements
        .iter()
        .zip(left_out)
        .map(|(p, left_out_error)| {
            let force = axes.to_case(fit.calibrated(p.mean));
            let length = matrix3::norm(&force);
            Use {
                fitted: true,
                direction: Some(force.map(|f| f / length)),
                left_out_error,
                ..Use::default()
            }
        })
        .collect();
    // The board's axes were fitted.
    fit.model = fit.model.map(|row| axes.to_case(row));
    fit.matrix = axes.rows_to_case(&fit.matrix);
    if let Some(c) = &mut fit.covariance {
        axes.columns_to_case(c);
    }
    Ok(Estimate {
        uses,
        degrees_of_freedom: fit.freedom as u32,
        quality: Some(FitQuality {
            chi2_per_freedom: None,
            freedom: fit.freedom,
            model_error_mps2: 0.0,
            condition: Some(fit.condition).filter(|c| c.is_finite()),
            oriented: false,
            shared_tilts: false,
            tilt_degrees_of_freedom: 0.0,
            prior: false,
        }),
        ..estimate(method, &fit, session, noise)
    })
}

/// What all of them have in common, in axes of the case.
fn estimate(method: Method, fit: &PresetFit, session: &Session<'_>, noise: PoseNoise) -> Estimate {
    Estimate {
        method,
        model: fit.model,
        bias: fit.bias,
        calibration: Calibration {
            matrix: fit.matrix,
            bias: fit.bias,
        },
        covariance: fit.covariance,
        uses: Vec::new(),
        tilt: None,
        degrees_of_freedom: 0,
        faces: ferraris::sort_into_faces(&session.segmentation.placements, session.recordings).ok(),
        face_angle_rms_deg: None,
        quality: None,
        joint: None,
        noise,
        findings: Vec::new(),
    }
}
