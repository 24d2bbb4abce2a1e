//! The grade of a calibration and its reasons.

use crate::calibration_file::{AccelerometerSection, Grade, Method, PoseKind, Verdict};
use crate::numfmt::{count, mg, words};
use crate::poses::face::in_words;
use crate::recording::Finding;

use super::estimate::Estimate;

/// Angles between the axes that are less well known than this are worth a word, degrees.
const OPEN_ANGLE_DEG: f64 = 0.3;

/// Grade and reasons: the session, the error of the result and what it could hide, what poses
/// contradict, and what would improve it.
pub(super) fn verdict(estimate: &Estimate, findings: &[Finding]) -> Verdict {
    let section = &estimate.section;
    let gates = || findings.iter().filter(|f| f.kind.is_gate());
    let grade = match (&estimate.fit, section.predicted_norm_error_mps2) {
        _ if gates().next().is_some() => Grade::Poor,
        (Some((_, trust)), _) => trust.grade(),
        // The closed form tests no single pose: it is never verified.
        (None, Some(error)) if 2.0 * error > gravical_fit::UNVERIFIED_MPS2 => Grade::Poor,
        (None, _) => Grade::NotVerifiable,
    };
    let mut reasons: Vec<String> = gates().map(|f| f.message.clone()).collect();
    reasons.extend(section.worst_direction.map(|worst| {
        let (error, direction) = (mg(worst.error_mps2), in_words(worst.direction));
        format!("error of ‖a‖ at most {error} mg (95 %) in the worst direction ({direction})")
    }));
    reasons.extend(detectable(section));
    reasons.extend(section.predicted_norm_error_mps2.map(|error| {
        let tilt = section.pose_tilt_deg.map_or_else(String::new, |tilt| {
            let source = words(&tilt.source);
            format!("; tilt of the face poses {:.2}°, {source}", tilt.value)
        });
        let error = mg(error);
        format!("predicted error of ‖a‖: {error} mg (1σ, over all directions{tilt})")
    }));
    let left_out = section.poses.iter().filter_map(|p| p.left_out_error_mps2);
    reasons.push(match section.leave_one_out_rms_mps2.map(mg) {
        None => unverified(section).to_owned(),
        Some(rms) => format!(
            "leave-one-out error of ‖a‖: {rms} mg rms over {} poses",
            left_out.count()
        ),
    });
    if let Some((index, z)) = section.contradiction() {
        let pose = &section.poses[index];
        let (pose, error) = (pose.called(), pose.left_out_error_mps2.unwrap_or(f64::NAN));
        reasons.push(format!(
            "{pose} contradicts the other poses: its leave-one-out error is {} mg, {z:.1} of its standard deviations",
            mg(error)
        ));
    }
    if section.method == Method::Ferraris
        && let Some((error, poses)) = section.free_norm_error()
    {
        let (poses, error) = (count(poses, "free pose"), mg(error));
        reasons.push(format!(
            "error of ‖a‖ at {poses} that the fit did not use: {error} mg rms"
        ));
    }
    reasons.extend(open_angles(section));
    if section.next_poses.is_empty() && grade == Grade::NotVerifiable {
        let verify =
            "to verify it, calibrate a recording at rest in any free pose: ‖a‖ must equal gravity";
        reasons.push(verify.to_owned());
    }
    Verdict { grade, reasons }
}

/// Which error of one pose is not detected with 90 %, and what it does. The poses that would test it are
/// proposed.
fn detectable(section: &AccelerometerSection) -> Option<String> {
    section.fit?;
    section.leave_one_out_rms_mps2?;
    let Some(hidden) = section.undetected else {
        let text = "there are too few poses to detect an error of one of them, however large";
        return Some(text.to_owned());
    };
    Some(format!(
        "an error of one pose that changes ‖a‖ by less than {} mg ({} mg in {}) may remain undetected",
        mg(hidden.effect_mps2),
        mg(hidden.reading_mps2),
        section.poses[hidden.pose].called()
    ))
}

fn unverified(section: &AccelerometerSection) -> &'static str {
    let mut fitted = section.poses.iter().filter(|p| p.fitted);
    let is_six = fitted.clone().count() == 6;
    if is_six && fitted.all(|p| p.kind == PoseKind::Face) {
        "six faces determine six parameters of ‖a‖ exactly: their residuals verify nothing"
    } else if section.method == Method::Ferraris {
        "the six-face method tests no pose that it was not fitted to: its residuals verify nothing"
    } else {
        "too few poses to leave one out: nothing verifies the result"
    }
}

/// Angles between the axes that face poses do not separate from their own tilt.
fn open_angles(section: &AccelerometerSection) -> Option<String> {
    let angles = section.deviations.as_ref()?.axis_angle_deg;
    let angle_deg = angles.iter().fold(0.0_f64, |m, a| m.max(*a));
    let tilt_deg = section.pose_tilt_deg?.value;
    (angle_deg > OPEN_ANGLE_DEG).then(|| format!(
        "face poses do not separate their tilt (σ {tilt_deg:.1}°) from misalignment: the angles between the axes are known to ±{angle_deg:.1}° (1σ); free poses determine them"
    ))
}
