//! The accelerometer by the method that was asked for: poses in, parameters in axes of the case out.

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use gravical_fit::model::Covariance;
use gravical_fit::{BiasDrift, DriftTest, Fit, FittedPose, Hint, Options, Trust, fit};
use serde::Deserialize;

use crate::calibration_file::{Method, PoseTilt, TiltSource};
use crate::poses::Pose;
use crate::poses::face::Claim;
use crate::{Error, Result};

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
    /// M of u = M a + b, input unit per m/s².
    pub model: [[f64; 3]; 3],
    /// matrix · (raw − bias); the bias is less the zero offset.
    pub calibration: Calibration<f64>,
    /// What became of every placement; by Ferraris' method its tilt is the raw angle.
    pub uses: Vec<FittedPose>,
    /// The tilt of the placements.
    pub tilt: Option<PoseTilt>,
    /// How it was estimated, and how well it is known.
    pub basis: Basis,
}

/// What the uncertainty of an estimate rests on.
#[derive(Debug, Clone)]
pub(crate) enum Basis {
    /// The joint fit, how far it can be trusted, and where many poses tell, whether a drift of the bias
    /// with temperature helps.
    Fit(Box<(Fit, Trust)>, Option<DriftTest>),
    /// The covariance of M and b by the closed form; none without standard errors.
    ClosedForm(Option<Box<Covariance>>),
}

impl Estimate {
    /// The joint fit, and how far it can be trusted; none by the closed form.
    pub fn fit(&self) -> Option<&(Fit, Trust)> {
        match &self.basis {
            Basis::Fit(fit, _) => Some(fit),
            Basis::ClosedForm(_) => None,
        }
    }

    /// Drift of the bias with temperature, where the joint fit has one.
    pub fn drift(&self) -> Option<BiasDrift> {
        self.fit().and_then(|(fit, _)| fit.drift())
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
        let without_drift = Options {
            drift: false,
            ..fit_options
        };
        one_sensor(session, &poses, &without_drift)?;
    }
    match options.method {
        Method::Ferraris => by_ferraris(session),
        _ => by_fit(session, fit_options, &poses),
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
    if options.free.iter().any(|n| is_called(pose, n)) {
        return Hint::Free;
    }
    if options.face.iter().any(|n| is_called(pose, n)) {
        return pose.face.map_or(Hint::Open, Hint::Face);
    }
    match (pose.claim, pose.face) {
        (Some(Claim::Face(_) | Claim::Axis(_)), Some(face)) => Hint::Named(face),
        _ => Hint::Open,
    }
}

/// True when `name` is the label of a pose, its face (`+x`: all poses on it), or its file.
fn is_called(pose: &Pose, name: &str) -> bool {
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
            let Some(pose) = poses.iter().find(|p| is_called(p, name)) else {
                let known: Vec<&str> = poses.iter().map(|p| p.label.as_str()).collect();
                let what = format!("there is no pose {name}");
                return Err(Error::usage("no-such-pose", what)
                    .of_option(option)
                    .with_hint(format!("give one of: {}", known.join(", "))));
            };
            if option == "face_pose" && pose.face.is_none() {
                let what = format!(
                    "{name} is {:.0}° from the nearest axis; beyond 25° it is no face pose",
                    pose.angle_deg
                );
                return Err(Error::usage("no-such-pose", what)
                    .of_option(option)
                    .with_hint("leave it to the fit, which treats it as a free pose"));
            }
        }
    }
    Ok(())
}

fn by_fit(
    session: &Session<'_>,
    mut options: Options,
    poses: &[gravical_fit::Pose],
) -> Result<Estimate> {
    let drift_test = if options.drift {
        gravical_fit::test_drift(poses, &options).ok()
    } else {
        None
    };
    options.drift = drift_test.is_some_and(|test| test.helps);
    let fit = fit(poses, &options).map_err(|open| explain(open, session))?;
    let (model, bias) = (fit.model(), fit.bias());
    // Axes of the case may be those of a mirror image, as the signs of phones are.
    let mounting = matrix3::identity().map(|row| session.axes().to_case(row));
    let hand = matrix3::det(&model) * matrix3::det(&mounting)
        / matrix3::row_norms(&model).iter().product::<f64>();
    let matrix = matrix3::inverse(&model).filter(|_| hand > 0.0);
    let matrix = matrix.ok_or_else(|| {
        let what = format!("the model has no inverse, or is left-handed (det R = {hand:.3})");
        Error::input("singular", what).with_hint("`gravical inspect` shows what each pose reads")
    })?;
    let uses = fit.poses();
    let source = match options.tilt {
        Some(_) => TiltSource::Given,
        // From fewer components it is mostly what is usual.
        None if fit.quality.tilt_degrees_of_freedom >= 4.0 => TiltSource::Estimated,
        None => TiltSource::Assumed,
    };
    let trust = fit.trust();
    Ok(Estimate {
        model,
        calibration: Calibration { matrix, bias },
        tilt: uses.iter().any(|p| p.face.is_some()).then(|| PoseTilt {
            value: fit.tilt().to_degrees(),
            source,
        }),
        uses,
        basis: Basis::Fit(Box::new((fit, trust)), drift_test),
    })
}

/// Tilt of placements that nobody gave, degrees.
const USUAL_TILT_DEG: f64 = 1.0;
/// So many times the usual tilt is more than chance and a good board explain.
pub(crate) const UNUSUAL_TILT: f64 = 1.6;

fn by_ferraris(session: &Session<'_>) -> Result<Estimate> {
    let placements = &session.segmentation.poses;
    let gravity = session.gravity_mps2();
    let faces = ferraris::sort_into_faces(placements, session.recordings)?;
    let (parameters, calibration) = ferraris::accelerometer(&faces, gravity)?;
    // Faces further off than the usual tilt explains are not believed to be better than they look: an
    // angle of rms α has two components of sd α/√2.
    let seen = faces.angle_rms_deg(&parameters) / std::f64::consts::SQRT_2;
    let (value, source) = match session.options.estimate.pose_tilt_deg {
        Some(value) => (value, TiltSource::Given),
        None if seen > USUAL_TILT_DEG * UNUSUAL_TILT => (seen, TiltSource::Estimated),
        None => (USUAL_TILT_DEG, TiltSource::Assumed),
    };
    let on_face = |(index, placement): (usize, &Pose)| {
        let face = faces.face_of(index);
        FittedPose {
            face,
            fitted: face.is_some(),
            tilt: face.map(|_| (placement.angle_deg.to_radians(), None)),
            bad: None,
        }
    };
    let model = parameters.model();
    let covariance = faces.covariance(&model, gravity, value.to_radians());
    Ok(Estimate {
        model,
        calibration,
        uses: placements.iter().enumerate().map(on_face).collect(),
        tilt: Some(PoseTilt { value, source }),
        basis: Basis::ClosedForm(covariance.map(Box::new)),
    })
}
