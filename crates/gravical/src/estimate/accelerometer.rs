//! The accelerometer by the method that was asked for: placements in,
//! parameters in axes of the case out.

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;

use crate::calibration_file::{PlacementTilt, TiltSource};
use crate::recording::{Finding, Recording};
use crate::segment::face::{AxisMap, Claim, Face, angle_deg};
use crate::segment::{Placement, Segmentation};
use crate::{Error, Result};

use super::joint::{JointFit, JointOptions, JointPose, Role, TiltFrom, joint};
use super::pose_noise::{PoseNoise, pose_noise};
use super::{ferraris, undetermined};

/// How the accelerometer is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Faces and free poses in one fit, tilts as nuisance.
    #[default]
    Joint,
    /// Six faces in closed form.
    Ferraris,
}

impl Method {
    /// As it is written in options and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Method::Joint => "joint",
            Method::Ferraris => "ferraris",
        }
    }
}

/// What the user says about estimating.
#[derive(Debug, Clone)]
pub struct EstimateOptions {
    /// Which estimator.
    pub method: Method,
    /// Tilt of the placements, degrees (sd of each of two components); default:
    /// estimated, or 1 assumed.
    pub placement_tilt_deg: Option<f64>,
    /// Use what the data sheet says about scale, cross-axis and bias. Default.
    pub prior: bool,
    /// Placements (label or file name) that are no faces, whatever they look
    /// like.
    pub free: Vec<String>,
    /// Placements that are faces, however they lie.
    pub face: Vec<String>,
}

impl Default for EstimateOptions {
    fn default() -> Self {
        EstimateOptions {
            method: Method::default(),
            placement_tilt_deg: None,
            prior: true,
            free: Vec::new(),
            face: Vec::new(),
        }
    }
}

/// What a placement was used for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Use {
    /// The face it was fitted as, axes of the case.
    pub face: Option<Face>,
    /// It took part in the fit.
    pub fitted: bool,
    /// Tilt off the face in degrees (raw angle by Ferraris' method), and its
    /// standard deviation where the fit knows one.
    pub tilt_deg: Option<(f64, Option<f64>)>,
    /// Direction of specific force, unit vector in axes of the case.
    pub direction: Option<[f64; 3]>,
    /// ‖a‖ − g with it and its neighbours left out, m/s².
    pub left_out_error: Option<f64>,
    /// Left out because it does not fit: chance of that.
    pub bad: Option<f64>,
}

/// An estimated accelerometer, axes of the case.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// How.
    pub method: Method,
    /// M of u = M a + b, input unit per m/s².
    pub model: [[f64; 3]; 3],
    /// b, input unit, less the zero offset.
    pub bias: [f64; 3],
    /// matrix · (raw − bias).
    pub calibration: Calibration<f64>,
    /// Of row-major M and b; none without standard errors.
    pub covariance: Option<[[f64; 12]; 12]>,
    /// For every placement.
    pub uses: Vec<Use>,
    /// The tilt of the placements.
    pub tilt: Option<PlacementTilt>,
    /// Magnitudes less parameters of the magnitude.
    pub degrees_of_freedom: u32,
    /// The six faces in Ferraris' terms, where all are there.
    pub faces: Option<ferraris::Faces>,
    /// Angle between faces and means that bias and scale leave, rms, degrees
    /// (Ferraris' method).
    pub face_angle_rms_deg: Option<f64>,
    /// What the joint fit says beyond that.
    pub joint: Option<JointFit>,
    /// Uncertainty of the means.
    pub noise: PoseNoise,
    /// What is odd.
    pub findings: Vec<Finding>,
}

/// Tilt of a box on a table, degrees (sd of each component).
pub const ASSUMED_TILT_DEG: f64 = 1.0;

/// So many times the assumed tilt is more than chance and a good board explain.
pub const UNUSUAL_TILT: f64 = 1.6;

/// Parameters of the magnitude: M Mᵀ and b.
const MAGNITUDE_PARAMETERS: u32 = 9;

/// What the estimators need to know of a session.
#[derive(Debug, Clone, Copy)]
pub struct Session<'a> {
    /// The recordings.
    pub recordings: &'a [Recording],
    /// Placements and turns.
    pub segmentation: &'a Segmentation,
    /// How the board sits in its case.
    pub axes: &'a AxisMap,
    /// Names of placements are believed, not data.
    pub faces_by_name: bool,
    /// Local gravity, m/s².
    pub gravity: f64,
}

/// Estimates the accelerometer.
///
/// # Errors
///
/// `missing-face`, `same-face-twice`, `left-handed`, `singular` (Ferraris);
/// `underdetermined`, `not-converged` (joint); `no-such-placement` (usage) for
/// a name in `--face` or `--free`.
pub fn accelerometer(session: &Session<'_>, options: &EstimateOptions) -> Result<Estimate> {
    let nominal = session
        .recordings
        .first()
        .and_then(|r| r.accel_scale.nominal());
    let about = nominal.unwrap_or_else(|| usual_scale(session));
    let noise = pose_noise(session.segmentation, session.recordings, about);
    match options.method {
        Method::Ferraris => by_ferraris(session, options, noise),
        Method::Joint => by_joint(session, options, noise, nominal),
    }
}

fn usual_scale(session: &Session<'_>) -> f64 {
    let mut lengths: Vec<f64> = session
        .segmentation
        .placements
        .iter()
        .map(|p| matrix3::norm(&p.mean))
        .collect();
    crate::stats::median(&mut lengths).unwrap_or(1.0) / session.gravity
}

fn by_ferraris(
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

fn by_joint(
    session: &Session<'_>,
    options: &EstimateOptions,
    noise: PoseNoise,
    nominal: Option<f64>,
) -> Result<Estimate> {
    let placements = &session.segmentation.placements;
    check_names(placements, options)?;
    let faces = ferraris::sort_into_faces(placements, session.recordings).ok();
    if session.faces_by_name
        && let Some(faces) = &faces
    {
        // Names that contradict each other, or --axes, are refused in the words
        // of the closed form.
        ferraris::accelerometer(faces, session.gravity, Some(session.axes))?;
    }
    let poses: Vec<JointPose> = placements
        .iter()
        .enumerate()
        .map(|(k, p)| JointPose {
            mean: p.mean,
            standard_error: noise.noise[k],
            role: role(p, options, session.axes),
        })
        .collect();
    let joint_options = JointOptions {
        gravity: session.gravity,
        nominal,
        prior: options.prior,
        tilt: options.placement_tilt_deg.map(f64::to_radians),
        quantisation: noise.quantisation,
        start: session
            .faces_by_name
            .then(|| start_by_names(&poses, nominal, session.gravity)),
    };
    let fit =
        joint(&poses, &joint_options).map_err(|e| undetermined::explain(e, placements, session))?;
    let turned = matrix3::scale_rows(&fit.model, &matrix3::row_norms(&fit.model).map(|k| 1.0 / k));
    let hand = matrix3::det(&turned);
    if hand <= 0.0 {
        return Err(Error::input(
            "left-handed",
            format!("the faces as named make a left-handed sensor (det R = {hand:.3}): two placements are swapped"),
        )
        .with_hint("leave --faces names out, and the faces are taken from the data"));
    }
    let axes = session.axes;
    // u = M_board a_board + b, and a_board = P a_case.
    let columns = |rows: &[[f64; 3]; 3]| rows.map(|row| axes.to_case(row));
    let model = columns(&fit.model);
    let matrix = matrix3::inverse(&model).ok_or_else(|| {
        Error::input("singular", "the fitted model has no inverse")
            .with_hint("`gravical inspect` shows what each placement reads")
    })?;
    let mut fit = fit;
    for (_, part) in &mut fit.sources {
        axes.columns_to_case(part);
    }
    let mut covariance = fit.covariance;
    axes.columns_to_case(&mut covariance);
    let uses = fit
        .poses
        .iter()
        .map(|pose| Use {
            face: pose.face.map(|f| axes.face_to_case(f)),
            fitted: pose.bad.is_none(),
            tilt_deg: pose
                .tilt
                .map(|(tilt, sd)| (tilt.to_degrees(), Some(sd.to_degrees()))),
            direction: Some(axes.to_case(pose.direction)),
            left_out_error: pose.left_out_error,
            bad: pose.bad,
        })
        .collect();
    let fitted: Vec<[f64; 3]> = fit
        .poses
        .iter()
        .filter(|p| p.bad.is_none())
        .map(|p| p.direction)
        .collect();
    let has_faces = fit.poses.iter().any(|p| p.face.is_some());
    Ok(Estimate {
        method: Method::Joint,
        model,
        bias: fit.bias,
        calibration: Calibration {
            matrix,
            bias: fit.bias,
        },
        covariance: Some(covariance),
        uses,
        tilt: has_faces.then_some(PlacementTilt {
            value: fit.tilt.to_degrees(),
            source: match fit.tilt_from {
                TiltFrom::Given => TiltSource::Given,
                TiltFrom::Estimated => TiltSource::Estimated,
                TiltFrom::Assumed => TiltSource::Assumed,
            },
        }),
        degrees_of_freedom: (distinct(&fitted) as u32).saturating_sub(MAGNITUDE_PARAMETERS),
        faces,
        face_angle_rms_deg: None,
        joint: Some(fit),
        noise,
        findings: Vec::new(),
    })
}

/// Directions that are further than 25° from every one counted before.
#[must_use]
pub fn distinct(directions: &[[f64; 3]]) -> usize {
    let mut kept: Vec<[f64; 3]> = Vec::new();
    for d in directions {
        if kept.iter().all(|k| angle_deg(*k, *d) > 25.0) {
            kept.push(*d);
        }
    }
    kept.len()
}

/// True when `name` is the label of a placement, or its file.
fn is_called(placement: &Placement, name: &str) -> bool {
    let stem = crate::segment::stem(&placement.source);
    placement.label == name || stem == name || placement.source == name
}

fn role(placement: &Placement, options: &EstimateOptions, axes: &AxisMap) -> Role {
    let board = |face: Face| axes.face_to_board(face);
    if options.free.iter().any(|n| is_called(placement, n)) {
        return Role::Free;
    }
    if options.face.iter().any(|n| is_called(placement, n)) {
        return placement.face.map_or(Role::Open, |f| Role::Face(board(f)));
    }
    match (placement.claim, placement.face) {
        // Names were believed, or held against the data, when it was cut.
        (Some(Claim::Face(_) | Claim::Axis(_)), Some(face)) => Role::Named(board(face)),
        _ => Role::Open,
    }
}

fn check_names(placements: &[Placement], options: &EstimateOptions) -> Result<()> {
    for (option, names) in [("--free", &options.free), ("--face", &options.face)] {
        for name in names {
            let Some(placement) = placements.iter().find(|p| is_called(p, name)) else {
                let known: Vec<&str> = placements.iter().map(|p| p.label.as_str()).collect();
                return Err(Error::usage(
                    "no-such-placement",
                    format!(
                        "{option} {name}: there is no such placement ({})",
                        known.join(", ")
                    ),
                ));
            };
            if option == "--face" && placement.face.is_none() {
                return Err(Error::usage(
                    "no-such-placement",
                    format!(
                        "--face {name}: it lies {:.0}° from the nearest axis; beyond 25° it is no face",
                        placement.angle_deg
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// M to start with when names say how the board sits: each column from its two
/// faces, the nominal scale where one is missing.
fn start_by_names(poses: &[JointPose], nominal: Option<f64>, gravity: f64) -> [[f64; 3]; 3] {
    let mean = |face: Face| {
        let some: Vec<[f64; 3]> = poses
            .iter()
            .filter(|p| matches!(p.role, Role::Named(f) | Role::Face(f) if f == face))
            .map(|p| p.mean)
            .collect();
        (!some.is_empty()).then(|| {
            let sum = some
                .iter()
                .fold([0.0; 3], |s, m| std::array::from_fn(|i| s[i] + m[i]));
            sum.map(|s| s / some.len() as f64)
        })
    };
    let mut model = matrix3::diagonal([nominal.unwrap_or(1.0); 3]);
    for axis in 0..3 {
        let sides = [true, false].map(|up| mean(Face { axis, up }));
        if let [Some(up), Some(down)] = sides {
            for row in 0..3 {
                model[row][axis] = (up[row] - down[row]) / (2.0 * gravity);
            }
        }
    }
    model
}
