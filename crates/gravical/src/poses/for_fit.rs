//! Poses of a segmentation as poses of the fit.

use gravical_fit::Hint;

use crate::poses::face::Claim;
use crate::poses::{Pose, Segmentation};
use crate::{Error, Result};

/// Standard error of a mean whose scatter is unknown, m/s²: a second of an MPU6050 at 100 Hz with its
/// 44 Hz low-pass.
const ASSUMED_MPS2: f64 = 4e-3;

/// Poses that the user names: labels, faces or files.
#[derive(Clone, Copy)]
pub(crate) struct Names<'a> {
    /// They are no faces, whatever they look like.
    pub free: &'a [String],
    /// They are faces, however they lie.
    pub face: &'a [String],
}

/// The poses, and how far their noise is known.
pub(crate) struct Poses {
    pub poses: Vec<gravical_fit::Pose>,
    /// A row was a mean itself, and its standard error is assumed.
    pub noise_assumed: bool,
    /// Share of the standard errors that rounding makes, root mean square.
    pub rounding: f64,
}

/// The poses of a session; `scale` is about 1 m/s² in the input unit.
///
/// # Errors
///
/// `no-such-pose` (usage) for one of `names` that no pose has.
pub(crate) fn poses(session: &Segmentation, names: Names<'_>, scale: f64) -> Result<Poses> {
    check_names(&session.poses, names)?;
    let rounding = session.noise.rounding;
    let sd = |p: &Pose| match p.standard_error {
        Some(error) => error.map(|e| e.max(1e-7 * scale)),
        None => rounding.map(|q| q.hypot(ASSUMED_MPS2 * scale)),
    };
    let poses: Vec<gravical_fit::Pose> = session
        .poses
        .iter()
        .map(|p| gravical_fit::Pose {
            mean: p.mean,
            sd: sd(p),
            temperature_c: p.temperature_c,
            hint: hint(p, names),
        })
        .collect();
    let squares = |of: &dyn Fn(&gravical_fit::Pose) -> [f64; 3]| -> f64 {
        poses.iter().flat_map(of).map(|v| v * v).sum()
    };
    Ok(Poses {
        noise_assumed: session.poses.iter().any(|p| p.standard_error.is_none()),
        rounding: (squares(&|_| rounding) / squares(&|p| p.sd))
            .sqrt()
            .min(1.0),
        poses,
    })
}

/// Names were held against the data when the session was cut.
fn hint(pose: &Pose, names: Names<'_>) -> Hint {
    if names.free.iter().any(|n| is_called(pose, n)) {
        return Hint::Free;
    }
    if names.face.iter().any(|n| is_called(pose, n)) {
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

fn check_names(poses: &[Pose], names: Names<'_>) -> Result<()> {
    for (option, names) in [("free_pose", names.free), ("face_pose", names.face)] {
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
