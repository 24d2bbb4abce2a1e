//! The grade of a calibration and its reasons.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::calibration_file::{
    AccelerometerSection, GOOD_MG, Grade, PoseKind, PoseResult, TiltSource, Verdict,
};
use crate::estimate::accelerometer::Method;
use crate::recording::{Finding, FindingKind};

use super::errors::free_norm_error;

/// The same as [`GOOD_MG`] for a result that is fair, mg.
const FAIR_MG: f64 = 20.0;
/// Predicted 2σ error over all directions, mg, beyond which a result that nothing verifies
/// is poor: six faces placed by hand stay below.
const UNVERIFIED_MG: f64 = 50.0;
/// With fewer degrees of freedom no reading could contradict the result.
const LEAST_FREEDOM: f64 = 0.5;
/// Leave-one-out errors contradict the result when the largest of them, each over its own
/// standard deviation, is rarer than this among so many.
const CHANCE: f64 = 1e-3;

fn mg(mps2: f64) -> f64 {
    1000.0 * mps2 / STANDARD_GRAVITY_MPS2
}

/// A figure in mg with two digits that count.
fn figure(mps2: f64) -> String {
    let v = mg(mps2);
    if v.abs() < 0.995 {
        format!("{v:.2} mg")
    } else if v.abs() < 9.95 {
        format!("{v:.1} mg")
    } else {
        format!("{v:.0} mg")
    }
}

/// What is wrong with the session comes before what is wrong with the fit.
const SESSION: [FindingKind; 8] = [
    FindingKind::SameFileTwice,
    FindingKind::SameFaceTwice,
    FindingKind::MissingFace,
    FindingKind::FewOrientations,
    FindingKind::NamesMirrored,
    FindingKind::UnitChanged,
    FindingKind::ClippedPose,
    FindingKind::RepeatsContradict,
];

/// Grade and reasons: the session, the error of the result and what it could hide, what
/// poses contradict, and what would improve it.
#[must_use]
pub fn verdict(section: &AccelerometerSection, findings: &[Finding], gravity: f64) -> Verdict {
    let measured = measured(section);
    let grade = match findings.iter().any(|f| f.kind.is_gate()) {
        true => Grade::Poor,
        false => measured,
    };
    let in_session = |f: &&Finding| SESSION.contains(&f.kind);
    let session = findings.iter().filter(in_session);
    let gates = findings
        .iter()
        .filter(|f| f.kind.is_gate() && !in_session(f));
    let mut reasons: Vec<String> = session.chain(gates).map(|f| f.message.clone()).collect();
    reasons.extend(worst_direction(section));
    reasons.extend(detectable(section));
    if let Some(error) = section.predicted_norm_error_mps2 {
        let tilt = section.pose_tilt_deg.map_or(String::new(), |t| {
            format!(
                "; tilt of the face poses {:.2}°, {}",
                t.value,
                match t.source {
                    TiltSource::Given => "given",
                    TiltSource::Estimated => "estimated",
                    TiltSource::Assumed => "assumed",
                }
            )
        });
        reasons.push(format!(
            "predicted error of ‖a‖: {} (1σ, over all directions{tilt})",
            figure(error)
        ));
    }
    match section
        .leave_one_out_rms_mps2
        .filter(|_| verifiable(section))
    {
        Some(error) => reasons.push(format!(
            "leave-one-out error of ‖a‖: {} rms over {} poses",
            figure(error),
            section
                .poses
                .iter()
                .filter(|p| p.left_out_error_mps2.is_some())
                .count(),
        )),
        None => reasons.push(unverified(section)),
    }
    if let Some(c) = contradiction(section).filter(|_| verifiable(section)) {
        reasons.push(format!(
            "{} contradicts the other poses: its leave-one-out error is {}, {:.1} times the limit of chance",
            c.position.called(),
            figure(c.error_mps2),
            c.excess
        ));
    }
    if let Some(c) = &section.contradicted {
        reasons.push(format!(
            "{} contradicts the other poses: its residual is {:.1} times the limit of chance by their scatter",
            c.label, c.excess
        ));
    }
    if section.leave_one_out_rms_mps2.is_none()
        && let Some((error, count)) = free_norm_error(&section.poses, gravity)
    {
        reasons.push(format!(
            "error of ‖a‖ at {count} free {} that the fit did not use: {} rms",
            if count == 1 { "pose" } else { "poses" },
            figure(error)
        ));
    }
    reasons.extend(open_angles(section));
    if let Some(worst) = &section.least_consistent_pose
        && verifiable(section)
    {
        reasons.push(format!(
            "least consistent pose: {} ({})",
            worst.label, worst.reason
        ));
    }
    reasons.extend(improvement(section, grade));
    Verdict { grade, reasons }
}

/// The error of ‖a‖ that the covariance predicts in the worst direction.
fn worst_direction(section: &AccelerometerSection) -> Option<String> {
    let worst = section.worst_direction.as_ref()?;
    Some(format!(
        "error of ‖a‖ at most {} (2σ) in the worst direction ({})",
        figure(worst.error_mps2),
        worst.hint
    ))
}

/// Which error of one pose would have been detected, what a smaller one does, and the pose
/// that would test it.
fn detectable(section: &AccelerometerSection) -> Option<String> {
    if !verifiable(section) || !tests_poses(section) {
        return None;
    }
    let now = section
        .undetected
        .as_ref()
        .map_or(f64::INFINITY, |u| u.effect_mps2);
    let next = tested_by(section, now).unwrap_or_default();
    let Some(hidden) = &section.undetected else {
        return Some(format!(
            "there are too few poses to detect an error of one of them, however large{next}"
        ));
    };
    let effect = figure(hidden.effect_mps2);
    let reading = figure(hidden.reading_mps2);
    let label = &hidden.label;
    Some(if mg(hidden.effect_mps2) <= GOOD_MG {
        format!(
            "an error of one pose that changes ‖a‖ by more than {effect} would have been detected with 90 % ({reading} in {label})"
        )
    } else {
        format!(
            "an error of {reading} in {label} would not be detected and would change ‖a‖ by {effect} ({}){next}",
            hidden.hint
        )
    })
}

/// What improves the result most: to know gravity, or to record poses. Poses are named
/// where they matter.
fn improvement(section: &AccelerometerSection, grade: Grade) -> Vec<String> {
    let mut out = Vec::new();
    let Some(now) = section.predicted_norm_error_mps2 else {
        return out;
    };
    if let Some(known) = &section.known_gravity {
        out.push(format!(
            "most of the predicted error is that of gravity, which was assumed: give {}: {} → {}",
            known.hint,
            figure(now),
            figure(known.predicted_norm_error_mps2)
        ));
    }
    let Some((next, last)) = section.next_poses.first().zip(section.next_poses.last()) else {
        if grade == Grade::NotVerifiable {
            out.push(
                "to verify it, calibrate a recording at rest in any free pose: ‖a‖ must equal gravity"
                    .to_owned(),
            );
        }
        return out;
    };
    if section.next_poses_lower_error() {
        let more = match section.next_poses.len() {
            1 => String::new(),
            n => format!(
                ", all {n} proposed poses to {}",
                figure(last.predicted_norm_error_mps2)
            ),
        };
        out.push(format!(
            "best next pose: {}; it lowers the predicted error to {}{more}",
            next.hint,
            figure(next.predicted_norm_error_mps2)
        ));
    }
    out
}

/// How many of the proposed poses leave the smallest undetected error, where that is less
/// than now.
fn tested_by(section: &AccelerometerSection, now_mps2: f64) -> Option<String> {
    let (count, least) = (1..)
        .zip(&section.next_poses)
        .filter_map(|(count, next)| Some((count, next.undetected_effect_mps2?)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, least)| *least < now_mps2)?;
    let first = &section.next_poses.first()?.hint;
    Some(if count == 1 {
        format!("; one more pose, {first}, leaves {}", figure(least))
    } else {
        format!(
            "; {count} more poses, the first {first}, leave {}",
            figure(least)
        )
    })
}

/// The method tests each pose against the others.
fn tests_poses(section: &AccelerometerSection) -> bool {
    section.method != Method::Ferraris.name()
}

/// The grade by the error that is predicted in the worst direction, by the leave-one-out
/// errors, and by what an undetected error of one pose does. The number of poses alone
/// does not matter.
fn measured(section: &AccelerometerSection) -> Grade {
    let Some(predicted) = section.predicted_norm_error_mps2 else {
        return Grade::NotVerifiable;
    };
    let left_out = contradiction(section);
    let excess = section.contradicted.as_ref().map_or(1.0, |c| c.excess);
    let excess = left_out.as_ref().map_or(excess, |c| c.excess.max(excess));
    let error = left_out.as_ref().map_or(0.0, |c| mg(c.error_mps2));
    let worst = section
        .worst_direction
        .as_ref()
        .map_or(f64::INFINITY, |w| mg(w.error_mps2));
    let seen = error.max(worst * excess);
    let unseen = match &section.undetected {
        Some(hidden) => mg(hidden.effect_mps2),
        None if tests_poses(section) => f64::INFINITY,
        // The closed form tests no single pose.
        None => 0.0,
    };
    if verifiable(section) && unseen <= FAIR_MG {
        return if seen.max(unseen) <= GOOD_MG {
            Grade::Good
        } else if seen <= FAIR_MG {
            Grade::Fair
        } else {
            Grade::Poor
        };
    }
    let contradicted = left_out.is_some() || section.contradicted.is_some();
    if 2.0 * mg(predicted) <= UNVERIFIED_MG && (!contradicted || seen <= FAIR_MG) {
        Grade::NotVerifiable
    } else {
        Grade::Poor
    }
}

/// True when a pose can be left out, and degrees of freedom remain to judge by.
fn verifiable(section: &AccelerometerSection) -> bool {
    section.leave_one_out_rms_mps2.is_some() && !nothing_left(section)
}

/// True when there are as many parameters as readings.
fn nothing_left(section: &AccelerometerSection) -> bool {
    section.fit.is_some_and(|f| f.freedom < LEAST_FREEDOM)
}

/// A pose that the fit without it does not predict.
struct Contradiction<'a> {
    position: &'a PoseResult,
    error_mps2: f64,
    /// Its error over the largest that chance makes.
    excess: f64,
}

/// The pose whose leave-one-out error contradicts the result most, if one does: over its
/// own standard deviation it is beyond Student's t with the degrees of freedom of the model
/// error (Bonferroni's correction for testing all). Without standard deviations the
/// predicted error over all directions takes their place.
fn contradiction(section: &AccelerometerSection) -> Option<Contradiction<'_>> {
    let usual = section.predicted_norm_error_mps2?;
    let left_out: Vec<(&PoseResult, f64, f64)> = section
        .poses
        .iter()
        .filter_map(|p| {
            let error = p.left_out_error_mps2?.abs();
            Some((p, error, p.left_out_sd_mps2.unwrap_or(usual)))
        })
        .collect();
    if left_out.is_empty() {
        return None;
    }
    let freedom = section.fit.map_or(1.0, |f| f.freedom.max(1.0));
    let limit = StudentsT::new(0.0, 1.0, freedom)
        .ok()?
        .inverse_cdf(1.0 - 0.5 * CHANCE / left_out.len() as f64);
    left_out
        .into_iter()
        .map(|(position, error_mps2, sd)| Contradiction {
            position,
            error_mps2,
            excess: error_mps2 / (limit * sd),
        })
        .max_by(|a, b| a.excess.total_cmp(&b.excess))
        .filter(|c| c.excess > 1.0)
}

fn unverified(section: &AccelerometerSection) -> String {
    let fitted = section.poses.iter().filter(|p| p.fitted);
    let faces = fitted.clone().filter(|p| p.kind == PoseKind::Face).count();
    if section.method == "ferraris" && section.degrees_of_freedom > 0 {
        return "the six-face method has no pose that it was not fitted to: its residuals verify nothing".to_owned();
    }
    if fitted.clone().count() == faces && faces == 6 {
        return "six faces determine six parameters of ‖a‖ exactly: their residuals verify nothing"
            .to_owned();
    }
    if nothing_left(section) {
        return format!(
            "{} poses determine the parameters exactly: their residuals verify nothing",
            fitted.count()
        );
    }
    "too few poses to leave one out: nothing verifies the result".to_owned()
}

/// Angles between the axes that face poses do not separate from their own tilt.
fn open_angles(section: &AccelerometerSection) -> Option<String> {
    let d = section.deviations.as_ref()?;
    let tilt = section.pose_tilt_deg?;
    let worst = d.axis_angle_deg.iter().fold(0.0_f64, |m, a| m.max(*a));
    (worst > 0.3).then(|| {
        format!(
            "face poses do not separate their tilt (σ {:.1}°) from misalignment: the angles between the axes are known to ±{worst:.1}° (1σ); free poses determine them",
            tilt.value
        )
    })
}
