//! The accelerometer by the method that was asked for: placements in,
//! parameters in axes of the case out.

mod faces;
mod poses;
mod sensors;
mod undetermined;

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;

use crate::Result;
use crate::calibration_file::{FitQuality, PoseTilt};
use crate::recording::{Finding, Recording};
use crate::segment::face::{AxisMap, Face, angle_deg};
use crate::segment::{Placement, Segmentation};

pub use sensors::one_sensor;

use super::ferraris;
pub use super::joint::ASSUMED_TILT_DEG;
use super::joint::{DriftTest, JointFit};
use super::pose_noise::{PoseNoise, pose_noise};

/// How the accelerometer is estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Faces and free poses in one fit, tilts as nuisance.
    #[default]
    Joint,
    /// Six faces in closed form.
    Ferraris,
    /// Faces taken as exact, least squares.
    Linear12,
    /// Nine parameters from the length of gravity.
    Magnitude9,
    /// Six parameters from the length of gravity.
    Magnitude6,
}

impl Method {
    /// As it is written in options and files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Method::Joint => "joint",
            Method::Ferraris => "ferraris",
            Method::Linear12 => "linear12",
            Method::Magnitude9 => "magnitude9",
            Method::Magnitude6 => "magnitude6",
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
    pub pose_tilt_deg: Option<f64>,
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
            pose_tilt_deg: None,
            prior: true,
            free: Vec::new(),
            face: Vec::new(),
        }
    }
}

/// What a placement was used for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
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
    /// Standard deviation that this error should have, m/s²; none where the
    /// method does not say.
    pub left_out_sd: Option<f64>,
    /// Left out because it does not fit: chance of that.
    pub bad: Option<f64>,
}

impl Use {
    /// By a method that knows faces only, and nothing of their tilts.
    fn on_face(face: Option<Face>, placement: &Placement) -> Self {
        Use {
            face,
            fitted: face.is_some(),
            tilt_deg: face.map(|_| (placement.angle_deg, None)),
            ..Use::default()
        }
    }
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
    pub tilt: Option<PoseTilt>,
    /// Magnitudes less parameters of the magnitude.
    pub degrees_of_freedom: u32,
    /// The six faces in Ferraris' terms, where all are there.
    pub faces: Option<ferraris::Faces>,
    /// Angle between faces and means that bias and scale leave, rms, degrees
    /// (Ferraris' method).
    pub face_angle_rms_deg: Option<f64>,
    /// What a fit shows of itself.
    pub quality: Option<FitQuality>,
    /// What the joint fit, or a method with assumptions in place of it, says beyond that.
    pub joint: Option<JointFit>,
    /// Whether a drift of the bias with temperature helps, where many poses tell.
    pub drift: Option<DriftTest>,
    /// Uncertainty of the means.
    pub noise: PoseNoise,
    /// What is odd.
    pub findings: Vec<Finding>,
}

/// So many times the assumed tilt is more than chance and a good board explain.
pub const UNUSUAL_TILT: f64 = 1.6;

/// Nobody places a sensor in so many poses: they are found in days of wear, and enough to test a
/// model on eighths of them.
pub const MANY_POSES: usize = 64;

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
    /// The drift with temperature is tested by the joint fit, and fitted where it helps.
    pub drift: bool,
}

/// Estimates the accelerometer.
///
/// # Errors
///
/// `missing-face`, `same-face-twice`, `left-handed`, `singular` (Ferraris);
/// `underdetermined`, `not-converged`, `reading-values` (the others); `sensors-differ`
/// where recordings that can be fitted alone contradict each other;
/// `no-such-pose` (usage) for a name in `--face-pose` or `--free-pose`.
pub fn accelerometer(session: &Session<'_>, options: &EstimateOptions) -> Result<Estimate> {
    let nominal = session
        .recordings
        .first()
        .and_then(|r| r.accel_scale.nominal());
    let about = nominal.unwrap_or_else(|| usual_scale(session));
    let noise = pose_noise(session.segmentation, about);
    if session.recordings.len() > 1 {
        let names: Vec<&str> = session.recordings.iter().map(|r| r.name.as_str()).collect();
        let (poses, of_joint) = poses::joint_problem(session, options, &noise, nominal);
        let placements = &session.segmentation.placements;
        let recording_of: Vec<usize> = placements.iter().map(|p| p.recording).collect();
        one_sensor(&poses, &recording_of, &names, &of_joint)?;
    }
    match options.method {
        Method::Ferraris => faces::by_ferraris(session, options, noise),
        _ => poses::by_joint(session, options, noise, nominal),
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
