//! The accelerometer by the method that was asked for: poses in, parameters in axes of the case out.

use std::array::from_fn;

use gravical_core::calibration::LinearCalibration;
use gravical_core::matrix3;
use gravical_fit::model::DRIFT;
use gravical_fit::{BiasDrift, DriftTest, Fit, FittedPose, Hint, Options, Sensor, Trust, fit};
use gravical_judge::numfmt::COVERAGE;
use serde::Deserialize;

use crate::Result;
use crate::calibration_file::{
    Accelerometer, Covariance, Method, PoseTilt, Reliability, TiltSource,
};
use crate::poses::Pose;
use crate::poses::face::Claim;
use crate::problem::Problem;
use crate::recording::AccelUnit;

use super::ferraris;
use super::session::{Session, explain, one_sensor};

/// What the user says about estimating.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct EstimateOptions {
    /// joint, or ferraris: six faces
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "METHOD",
            default_value = "joint",
            hide_possible_values = true
        )
    )]
    pub method: Method,
    /// Tilt of faces, degrees (sd) [default: estimated]
    ///
    /// Standard deviation in each of two directions: 0.1 in a jig, 0.5 to 1 in a box on a table, 2
    /// by hand.
    #[serde(rename = "pose_tilt")]
    #[cfg_attr(feature = "clap", arg(long = "pose-tilt", value_name = "DEG"))]
    pub pose_tilt_deg: Option<f64>,
    /// Limits of the data sheet, or off
    #[cfg_attr(
        feature = "clap",
        arg(
            long,
            value_name = "PRIOR",
            default_value = "data-sheet",
            hide_possible_values = true,
            hide_short_help = true
        )
    )]
    pub prior: Prior,
    /// Take this pose (label or file) as free; repeatable
    #[serde(rename = "free_pose")]
    #[cfg_attr(
        feature = "clap",
        arg(
            long = "free-pose",
            value_name = "NAME",
            allow_hyphen_values = true,
            hide_short_help = true
        )
    )]
    pub free: Vec<String>,
    /// Take this pose as a face; repeatable
    #[serde(rename = "face_pose")]
    #[cfg_attr(
        feature = "clap",
        arg(
            long = "face-pose",
            value_name = "NAME",
            allow_hyphen_values = true,
            hide_short_help = true
        )
    )]
    pub face: Vec<String>,
}

/// What is known of the sensor before the estimation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Prior {
    /// The limits of the data sheet: scale ±3 %, cross-axis ±2 %, bias ±0.6 m/s².
    #[default]
    DataSheet,
    /// Nothing.
    Off,
}

/// An estimated accelerometer, axes of the case.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    /// What is written to the file.
    pub accelerometer: Accelerometer,
    /// How far it can be trusted; the budget is added with the poses.
    pub reliability: Reliability,
    /// matrix · (raw − bias); the bias is less the zero offset.
    pub calibration: LinearCalibration<f64>,
    /// What became of each placement, axes of the case; by the closed form only faces are fitted.
    pub poses: Vec<FittedPose>,
    /// The joint fit, and how far it can be trusted; none by the closed form.
    pub fit: Option<(Fit, Trust)>,
    /// Where many poses tell: whether a drift of the bias with temperature helps.
    pub drift_test: Option<DriftTest>,
}

impl Estimate {
    /// Drift of the bias with temperature, where the joint fit has one.
    pub fn drift(&self) -> Option<BiasDrift> {
        self.fit.as_ref().and_then(|(fit, _)| fit.drift())
    }
}

/// Estimates the accelerometer, with a drift of its bias with temperature where `drift` asks for a test of
/// that and it helps.
///
/// # Errors
///
/// `missing-face` (Ferraris); `singular`; `underdetermined`; `sensors-differ` where recordings that can
/// be fitted alone contradict each other; `no-such-pose` (usage) for a name in `--face-pose` or
/// `--free-pose`.
pub(crate) fn accelerometer(session: &Session<'_>, drift: bool) -> Result<Estimate> {
    let options = &session.options.estimate;
    let scale = session.scale();
    check_names(session)?;
    let placements = &session.segmentation.poses;
    let poses: Vec<gravical_fit::Pose> = placements
        .iter()
        .map(|p| gravical_fit::Pose {
            mean: p.mean,
            sd: standard_error(p, session, scale),
            temperature_c: p.temperature_c,
            hint: hint(p, options),
        })
        .collect();
    let gravity = session.gravity_mps2();
    let fit_options = Options {
        gravity,
        gravity_sd: session.options.gravity.uncertainty_mps2(),
        nominal: session.nominal(),
        prior: options.prior == Prior::DataSheet,
        tilt: options.pose_tilt_deg.map(f64::to_radians),
        // As the board sits in its case.
        start: Some(matrix3::diagonal([scale; 3]).map(|row| session.axes().to_case(row))),
        drift,
    };
    if session.recordings.len() > 1 {
        one_sensor(session, &poses, fit_options)?;
    }
    match options.method {
        Method::Ferraris => by_ferraris(session),
        _ => by_fit(session, fit_options, &poses),
    }
}

/// The section of a calibration, without what tells how well it is known.
fn section(session: &Session<'_>, calibration: &LinearCalibration<f64>) -> Accelerometer {
    // A zero offset is only a way of reading; what is applied to the file's own numbers carries it in
    // the bias.
    let offset = session.zero_offset();
    let first = session.recordings.first();
    Accelerometer {
        method: session.options.estimate.method,
        input_unit: first.map_or(AccelUnit::Unknown, |r| r.units.accel.unit),
        bias: calibration.bias.map(|b| b + offset),
        matrix: calibration.matrix,
        nominal_scale: session.nominal(),
        ..Accelerometer::default()
    }
}

/// Standard error of a mean whose scatter is unknown, m/s²: a second of an MPU6050 at 100 Hz with its
/// 44 Hz low-pass.
const ASSUMED_MPS2: f64 = 4e-3;

/// Standard error of each component of a mean, input unit.
pub(super) fn standard_error(pose: &Pose, session: &Session<'_>, scale: f64) -> [f64; 3] {
    let rounding = session.segmentation.noise.rounding;
    match pose.standard_error {
        Some(error) => error.map(|e| e.max(1e-7 * scale)),
        None => rounding.map(|q| q.hypot(ASSUMED_MPS2 * scale)),
    }
}

/// Names were held against the data when the session was cut.
fn hint(pose: &Pose, options: &EstimateOptions) -> Hint {
    if options.free.iter().any(|n| matches_name(pose, n)) {
        return Hint::Free;
    }
    if options.face.iter().any(|n| matches_name(pose, n)) {
        return pose.face.map_or(Hint::Open, Hint::Face);
    }
    match (pose.claim, pose.face) {
        (Some(Claim::Face(_) | Claim::Axis(_)), Some(face)) => Hint::Named(face),
        _ => Hint::Open,
    }
}

/// True when `name` is the label of a pose, its face (`+x`: all poses on it), or its file.
fn matches_name(pose: &Pose, name: &str) -> bool {
    let stem = gravical_recording::source::stem(&pose.source);
    let file = std::path::Path::new(&pose.source).file_name();
    pose.label == name
        || pose.face.is_some_and(|face| face.name() == name)
        || stem == name
        || pose.source == name
        || file.is_some_and(|file| file == name)
}

/// Refuses names in `--free-pose` and `--face-pose` that no pose has.
fn check_names(session: &Session<'_>) -> Result<()> {
    let (poses, options) = (&session.segmentation.poses, &session.options.estimate);
    for (option, names) in [("free_pose", &options.free), ("face_pose", &options.face)] {
        for name in names {
            let pose = poses.iter().find(|p| matches_name(p, name));
            let name = name.clone();
            let problem = match pose {
                None => {
                    let known = poses.iter().map(|p| p.label.clone()).collect();
                    Problem::NoSuchPose { name, known }
                }
                Some(pose) if option == "face_pose" && pose.face.is_none() => {
                    let angle_deg = pose.angle_deg;
                    Problem::NoFacePose { name, angle_deg }
                }
                Some(_) => continue,
            };
            return Err(problem.error().of_option(option));
        }
    }
    Ok(())
}

fn by_fit(
    session: &Session<'_>,
    mut options: Options,
    poses: &[gravical_fit::Pose],
) -> Result<Estimate> {
    let test = || gravical_fit::test_drift(poses, &options).ok();
    let drift_test = options.drift.then(test).flatten();
    options.drift = drift_test.is_some_and(|test| test.helps);
    let fit = fit(poses, &options).map_err(|open| explain(open, session))?;
    let (model, bias) = (fit.model(), fit.bias());
    // Axes of the case may be those of a mirror image, as the signs of phones are.
    let mounting = matrix3::identity().map(|row| session.axes().to_case(row));
    let hand = matrix3::det(&model) * matrix3::det(&mounting)
        / matrix3::row_norms(&model).iter().product::<f64>();
    let matrix = matrix3::inverse(&model).filter(|_| hand > 0.0);
    let matrix = matrix.ok_or_else(|| Problem::NoInverse { hand }.error())?;
    let fitted = fit.poses();
    let source = match options.tilt {
        Some(_) => TiltSource::Given,
        // From fewer components it is mostly what is usual.
        None if fit.quality.tilt_degrees_of_freedom >= 4.0 => TiltSource::Estimated,
        None => TiltSource::Assumed,
    };
    let has_faces = fitted.iter().any(|pose| pose.face.is_some());
    let tilt = has_faces.then(|| PoseTilt {
        value: fit.tilt().to_degrees(),
        source,
    });
    let trust = fit.trust(Some(&session.order().0));
    let calibration = LinearCalibration { matrix, bias };
    let left_out_rms = trust.left_out_rms();
    let accelerometer = Accelerometer {
        covariance: Some(Covariance::new(fit.covariance())),
        nonlinearity: Some(fit.nonlinearity()),
        ..section(session, &calibration)
    };
    let reliability = Reliability {
        predicted_mps2: Some(trust.predicted_mps2),
        worst_direction: Some(trust.worst).filter(|w| w.error_mps2.is_finite()),
        explanations: trust.explanations.clone(),
        left_out_rms_mps2: left_out_rms,
        undetected: trust.undetected.filter(|u| u.effect_mps2.is_finite()),
        pose_tilt_deg: tilt,
        fit: Some(fit.quality),
        next_poses: trust.next.clone(),
        budget: None,
    };
    Ok(Estimate {
        accelerometer,
        reliability,
        calibration,
        poses: fitted,
        fit: Some((fit, trust)),
        drift_test,
    })
}

/// Tilt of placements that nobody gave, degrees.
const USUAL_TILT_DEG: f64 = 1.0;
/// So many times the usual tilt is more than chance and a good board explain.
pub(crate) const UNUSUAL_TILT: f64 = 1.6;

fn by_ferraris(session: &Session<'_>) -> Result<Estimate> {
    let gravity = session.gravity_mps2();
    let faces = ferraris::sort_into_faces(&session.segmentation.poses, session.recordings)?;
    let (parameters, calibration) = ferraris::accelerometer(&faces, gravity)?;
    // Faces further off than the usual tilt explains are not believed to be better than they look: an
    // angle of rms α has two components of sd α/√2.
    let seen = faces.angle_rms_deg(&parameters) / std::f64::consts::SQRT_2;
    let (value, source) = match session.options.estimate.pose_tilt_deg {
        Some(value) => (value, TiltSource::Given),
        None if seen > USUAL_TILT_DEG * UNUSUAL_TILT => (seen, TiltSource::Estimated),
        None => (USUAL_TILT_DEG, TiltSource::Assumed),
    };
    let model = parameters.model();
    let mut accelerometer = section(session, &calibration);
    let mut reliability = Reliability {
        pose_tilt_deg: Some(PoseTilt { value, source }),
        ..Reliability::default()
    };
    // The closed form leaves no pose out and tests none.
    let covariance = faces.covariance(&model, gravity, value.to_radians());
    if let Some((covariance, parameters)) = covariance.zip(accelerometer.parameters()) {
        let sensor = Sensor {
            parameters,
            covariance,
            gravity: session.options.gravity.for_fit(),
            model_error_mps2: 0.0,
        };
        let predicted = Some(sensor.predicted_mps2());
        reliability.predicted_mps2 = predicted.filter(|p| p.is_finite());
        let worst = Some(sensor.weakest(COVERAGE));
        reliability.worst_direction = worst.filter(|w| w.error_mps2.is_finite());
        let all = sensor.covariance_with_gravity();
        let row = |i: usize| from_fn(|k| all[(i, k)]);
        accelerometer.covariance = Some(Covariance::new::<DRIFT>(from_fn(row)));
    }
    let pose = |face| FittedPose {
        face,
        ..FittedPose::default()
    };
    Ok(Estimate {
        accelerometer,
        reliability,
        calibration,
        poses: faces.of_placements.into_iter().map(pose).collect(),
        fit: None,
        drift_test: None,
    })
}
