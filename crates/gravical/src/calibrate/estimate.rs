//! The accelerometer by the method that was asked for: poses in, parameters in axes of the case out.

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use gravical_fit::model::Covariance;
use gravical_fit::{DriftTest, Fit, Options, Trust, fit};
use serde::Deserialize;

use crate::calibration_file::{Method, PoseTilt, TiltSource};
use crate::poses::Pose;
use crate::poses::face::Face;
use crate::poses::for_fit::{Names, Poses, poses, start};
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

/// What a placement was used for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Use {
    /// The face it was fitted as, axes of the case.
    pub face: Option<Face>,
    /// It took part in the fit.
    pub fitted: bool,
    /// Tilt off the face in degrees (raw angle by Ferraris' method), and its standard deviation.
    pub tilt_deg: Option<(f64, Option<f64>)>,
    /// Direction of specific force, unit vector in axes of the case.
    pub direction: Option<[f64; 3]>,
    /// Left out because it does not fit: chance of that.
    pub bad: Option<f64>,
}

/// An estimated accelerometer, axes of the case.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    /// M of u = M a + b, input unit per m/s².
    pub model: [[f64; 3]; 3],
    /// matrix · (raw − bias); the bias is less the zero offset.
    pub calibration: Calibration<f64>,
    /// For every placement.
    pub uses: Vec<Use>,
    /// The tilt of the placements.
    pub tilt: Option<PoseTilt>,
    /// The six faces in Ferraris' terms, where all are there.
    pub faces: Option<ferraris::Faces>,
    /// The joint fit, and how far it can be trusted; none by the closed form.
    pub fit: Option<Box<(Fit, Trust)>>,
    /// Whether a drift of the bias with temperature helps, where many poses tell.
    pub drift_test: Option<DriftTest>,
    /// Of M and b by the closed form; none by a fit, or without standard errors.
    pub covariance: Option<Box<Covariance>>,
    /// Angle between faces and means that bias and scale of the closed form leave, rms, degrees.
    pub face_angle_rms_deg: Option<f64>,
    pub noise_assumed: bool,
    /// Share of the standard errors that rounding makes.
    pub rounding: f64,
}

impl Estimate {
    pub fn fit(&self) -> Option<&Fit> {
        self.fit.as_deref().map(|(fit, _)| fit)
    }

    pub fn trust(&self) -> Option<&Trust> {
        self.fit.as_deref().map(|(_, trust)| trust)
    }
}

/// Estimates the accelerometer.
///
/// # Errors
///
/// `missing-face`, `same-face-twice`, `singular` (Ferraris); `underdetermined`; `left-handed` where
/// names contradict each other; `sensors-differ` where recordings that can be fitted alone contradict
/// each other; `no-such-pose` (usage) for a name in `--face-pose` or `--free-pose`.
pub(crate) fn accelerometer(session: &Session<'_>, options: &EstimateOptions) -> Result<Estimate> {
    let scale = session.scale();
    let names = Names {
        free: &options.free,
        face: &options.face,
    };
    let found = poses(session.segmentation, names, scale)?;
    let gravity = session.gravity.value_mps2;
    let (axes, by_name) = (session.axes, session.faces_by_name);
    let fit_options = Options {
        gravity,
        gravity_sd: session.gravity.uncertainty_mps2(),
        nominal: session.nominal(),
        prior: options.prior == Prior::DataSheet,
        tilt: options.pose_tilt_deg.map(f64::to_radians),
        start: Some(start(session.segmentation, axes, scale, gravity, by_name)),
        ..Options::default()
    };
    if session.recordings.len() > 1 {
        one_sensor(session, &found.poses, &fit_options)?;
    }
    match options.method {
        Method::Ferraris => by_ferraris(session, options, &found),
        _ => by_fit(session, fit_options, &found),
    }
}

fn by_fit(session: &Session<'_>, mut options: Options, found: &Poses) -> Result<Estimate> {
    let placements = &session.segmentation.poses;
    let faces = ferraris::sort_into_faces(placements, session.recordings).ok();
    if session.faces_by_name
        && let Some(faces) = &faces
    {
        // Names that contradict each other, or --axes, are refused in the words of the closed form.
        ferraris::accelerometer(faces, options.gravity, Some(session.axes))?;
    }
    let drift_test = if session.drift {
        gravical_fit::test_drift(&found.poses, &options).ok()
    } else {
        None
    };
    options.drift = drift_test.is_some_and(|test| test.helps);
    let fit = fit(&found.poses, &options).map_err(|open| explain(open, session))?;
    let (model, bias) = (fit.model(), fit.bias());
    // Axes of the case may be those of a mirror image, as the signs of phones are.
    let mounting = matrix3::identity().map(|row| session.axes.to_case(row));
    let hand = matrix3::det(&model) * matrix3::det(&mounting)
        / matrix3::row_norms(&model).iter().product::<f64>();
    if hand <= 0.0 {
        return Err(ferraris::left_handed(&format!("det R = {hand:.3}")));
    }
    let matrix = matrix3::inverse(&model).ok_or_else(|| {
        Error::input("singular", "the fitted model has no inverse")
            .with_hint("`gravical inspect` shows what each pose reads")
    })?;
    let fitted = fit.poses();
    let uses = fitted.iter().map(|pose| Use {
        face: pose.face,
        fitted: pose.bad.is_none(),
        tilt_deg: pose
            .tilt
            .map(|(tilt, sd)| (tilt.to_degrees(), Some(sd.to_degrees()))),
        direction: Some(pose.direction),
        bad: pose.bad,
    });
    let source = match options.tilt {
        Some(_) => TiltSource::Given,
        // From fewer components it is mostly what is usual.
        None if fit.quality.tilt_degrees_of_freedom >= 4.0 => TiltSource::Estimated,
        None => TiltSource::Assumed,
    };
    Ok(Estimate {
        model,
        calibration: Calibration { matrix, bias },
        uses: uses.collect(),
        tilt: fitted.iter().any(|p| p.face.is_some()).then(|| PoseTilt {
            value: fit.tilt().to_degrees(),
            source,
        }),
        faces,
        drift_test,
        covariance: None,
        face_angle_rms_deg: None,
        noise_assumed: found.noise_assumed,
        rounding: found.rounding,
        fit: Some(Box::new({
            let trust = fit.trust();
            (fit, trust)
        })),
    })
}

/// Tilt of placements that nobody gave, degrees.
const USUAL_TILT_DEG: f64 = 1.0;
/// So many times the usual tilt is more than chance and a good board explain.
pub(crate) const UNUSUAL_TILT: f64 = 1.6;

fn by_ferraris(
    session: &Session<'_>,
    options: &EstimateOptions,
    found: &Poses,
) -> Result<Estimate> {
    let placements = &session.segmentation.poses;
    let gravity = session.gravity.value_mps2;
    let faces = ferraris::sort_into_faces(placements, session.recordings)?;
    let names = session.faces_by_name.then_some(session.axes);
    let fit = ferraris::accelerometer(&faces, gravity, names)?;
    let face_angle_rms_deg = fit.face_angle_rms_deg(&faces);
    // Faces further off than the usual tilt explains are not believed to be better than they look: an
    // angle of rms α has two components of sd α/√2.
    let seen = face_angle_rms_deg / std::f64::consts::SQRT_2;
    let (value, source) = match options.pose_tilt_deg {
        Some(value) => (value, TiltSource::Given),
        None if seen > USUAL_TILT_DEG * UNUSUAL_TILT => (seen, TiltSource::Estimated),
        None => (USUAL_TILT_DEG, TiltSource::Assumed),
    };
    let on_face = |(index, placement): (usize, &Pose)| {
        let face = faces.face_of(index);
        Use {
            face,
            fitted: face.is_some(),
            tilt_deg: face.map(|_| (placement.angle_deg, None)),
            ..Use::default()
        }
    };
    let covariance = fit.covariance(&faces, gravity, value.to_radians());
    Ok(Estimate {
        model: fit.parameters.model(),
        calibration: fit.calibration,
        uses: placements.iter().enumerate().map(on_face).collect(),
        tilt: Some(PoseTilt { value, source }),
        fit: None,
        drift_test: None,
        covariance: covariance.map(Box::new),
        face_angle_rms_deg: Some(face_angle_rms_deg),
        noise_assumed: found.noise_assumed,
        rounding: found.rounding,
        faces: Some(faces),
    })
}
