//! The grade of a calibration and its reasons.

use std::fmt;

use gravical_fit::GOOD_MPS2;

use crate::calibration_file::{
    AccelerometerSection, Grade, GravitySource, Method, PoseKind, TiltSource, Verdict,
};
use crate::numfmt::milli_g;
use crate::poses::face::in_words;
use crate::recording::{Finding, FindingKind};

use super::estimate::Estimate;

/// What is wrong with the session comes before what is wrong with the fit.
const SESSION: [FindingKind; 7] = [
    FindingKind::SameFileTwice,
    FindingKind::SameFaceTwice,
    FindingKind::MissingFace,
    FindingKind::FewOrientations,
    FindingKind::NamesMirrored,
    FindingKind::UnitChanged,
    FindingKind::ClippedPose,
];
/// Angles between the axes that are less well known than this are worth a word, degrees.
const OPEN_ANGLE_DEG: f64 = 0.3;

/// Why a calibration has its grade.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Reason {
    /// A finding that decides.
    Finding(String),
    /// Error claimed in the worst direction.
    WorstDirection {
        error_mps2: f64,
        direction: [f64; 3],
    },
    /// An error of one pose that would not show, what it does, and what more poses leave of that.
    Undetected {
        label: String,
        reading_mps2: f64,
        effect_mps2: f64,
        direction: [f64; 3],
        with_poses: Option<(usize, [f64; 3], f64)>,
    },
    /// No pose tests another.
    Untested(Option<(usize, [f64; 3], f64)>),
    /// Predicted error over all directions, with the tilt that it rests on.
    Predicted {
        error_mps2: f64,
        tilt: Option<(f64, TiltSource)>,
    },
    /// Errors of poses left out.
    LeftOut { rms_mps2: f64, count: usize },
    /// No pose can be left out.
    Unverified(&'static str),
    /// A pose that the others contradict.
    Contradiction {
        label: String,
        error_mps2: f64,
        z: f64,
    },
    /// Free poses that Ferraris' method did not use.
    Oblique { error_mps2: f64, count: usize },
    /// Tilt of faces and misalignment are not separated.
    OpenAngles { angle_deg: f64, tilt_deg: f64 },
    /// Gravity was assumed and is most of the error.
    AssumedGravity { now_mps2: f64, known_mps2: f64 },
    /// Poses that lower the predicted error.
    NextPoses {
        direction: [f64; 3],
        first_mps2: f64,
        last_mps2: f64,
        count: usize,
    },
    /// Nothing is proposed, and nothing verifies.
    AnyFreePose,
}

/// A figure in mg with two digits that count.
struct Mg(f64);

impl fmt::Display for Mg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mg = milli_g(self.0);
        let decimals = match mg.abs() {
            small if small < 0.995 => 2,
            middle if middle < 9.95 => 1,
            _ => 0,
        };
        write!(f, "{mg:.decimals$} mg")
    }
}

/// What poses that are still to be recorded leave: how many, the first, the effect then.
struct With<'a>(&'a Option<(usize, [f64; 3], f64)>);

impl fmt::Display for With<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            None => Ok(()),
            Some((1, first, left)) => {
                write!(
                    f,
                    "; one more pose, {}, leaves {}",
                    in_words(*first),
                    Mg(*left)
                )
            }
            Some((count, first, left)) => write!(
                f,
                "; {count} more poses, the first {}, leave {}",
                in_words(*first),
                Mg(*left)
            ),
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::Finding(message) => f.write_str(message),
            Reason::WorstDirection { error_mps2, direction } => write!(
                f,
                "error of ‖a‖ at most {} (95 %) in the worst direction ({})",
                Mg(*error_mps2),
                in_words(*direction)
            ),
            Reason::Undetected { label, reading_mps2, effect_mps2, .. }
                if *effect_mps2 <= GOOD_MPS2 =>
            {
                write!(
                    f,
                    "an error of one pose that changes ‖a‖ by more than {} would have been detected with 90 % ({} in {label})",
                    Mg(*effect_mps2),
                    Mg(*reading_mps2)
                )
            }
            Reason::Undetected { label, reading_mps2, effect_mps2, direction, with_poses } => write!(
                f,
                "an error of {} in {label} would not be detected and would change ‖a‖ by {} ({}){}",
                Mg(*reading_mps2),
                Mg(*effect_mps2),
                in_words(*direction),
                With(with_poses)
            ),
            Reason::Untested(with_poses) => write!(
                f,
                "there are too few poses to detect an error of one of them, however large{}",
                With(with_poses)
            ),
            Reason::Predicted { error_mps2, tilt } => {
                write!(f, "predicted error of ‖a‖: {} (1σ, over all directions", Mg(*error_mps2))?;
                if let Some((tilt_deg, source)) = tilt {
                    let source = source.name();
                    write!(f, "; tilt of the face poses {tilt_deg:.2}°, {source}")?;
                }
                f.write_str(")")
            }
            Reason::LeftOut { rms_mps2, count } => write!(
                f,
                "leave-one-out error of ‖a‖: {} rms over {count} poses",
                Mg(*rms_mps2)
            ),
            Reason::Unverified(why) => f.write_str(why),
            Reason::Contradiction { label, error_mps2, z } => write!(
                f,
                "{label} contradicts the other poses: its leave-one-out error is {}, {z:.1} of its standard deviations",
                Mg(*error_mps2)
            ),
            Reason::Oblique { error_mps2, count } => write!(
                f,
                "error of ‖a‖ at {count} free {} that the fit did not use: {} rms",
                if *count == 1 { "pose" } else { "poses" },
                Mg(*error_mps2)
            ),
            Reason::OpenAngles { angle_deg, tilt_deg } => write!(
                f,
                "face poses do not separate their tilt (σ {tilt_deg:.1}°) from misalignment: the angles between the axes are known to ±{angle_deg:.1}° (1σ); free poses determine them"
            ),
            Reason::AssumedGravity { now_mps2, known_mps2 } => write!(
                f,
                "most of the predicted error is that of gravity, which was assumed: give --latitude or --gravity: {} → {}",
                Mg(*now_mps2),
                Mg(*known_mps2)
            ),
            Reason::NextPoses { direction, first_mps2, last_mps2, count } => {
                write!(
                    f,
                    "best next pose: {}; it lowers the predicted error to {}",
                    in_words(*direction),
                    Mg(*first_mps2)
                )?;
                if *count > 1 {
                    write!(f, ", all {count} proposed poses to {}", Mg(*last_mps2))?;
                }
                Ok(())
            }
            Reason::AnyFreePose => f.write_str(
                "to verify it, calibrate a recording at rest in any free pose: ‖a‖ must equal gravity",
            ),
        }
    }
}

/// Grade and reasons: the session, the error of the result and what it could hide, what poses
/// contradict, and what would improve it.
pub(super) fn verdict(
    section: &AccelerometerSection,
    estimate: &Estimate,
    source: GravitySource,
    findings: &[Finding],
) -> Verdict {
    let is_gate = |f: &&Finding| f.kind.is_gate();
    let measured = match estimate.trust() {
        Some(trust) => trust.grade(),
        None => of_closed_form(section),
    };
    let grade = if findings.iter().any(|f| f.kind.is_gate()) {
        Grade::Poor
    } else {
        measured
    };
    let in_session = |f: &&Finding| SESSION.contains(&f.kind);
    let session = findings.iter().filter(in_session);
    let gates = findings.iter().filter(is_gate).filter(|f| !in_session(f));
    let mut reasons: Vec<Reason> = session
        .chain(gates)
        .map(|f| Reason::Finding(f.message.clone()))
        .collect();
    reasons.extend(
        section
            .worst_direction
            .as_ref()
            .map(|w| Reason::WorstDirection {
                error_mps2: w.error_mps2,
                direction: w.direction,
            }),
    );
    reasons.extend(detectable(section));
    let tilt = section.pose_tilt_deg.map(|t| (t.value, t.source));
    let predicted = section.predicted_norm_error_mps2;
    reasons.extend(predicted.map(|error_mps2| Reason::Predicted { error_mps2, tilt }));
    reasons.push(match section.leave_one_out_rms_mps2 {
        Some(rms_mps2) => Reason::LeftOut {
            rms_mps2,
            count: section
                .poses
                .iter()
                .filter(|p| p.left_out_error_mps2.is_some())
                .count(),
        },
        None => Reason::Unverified(unverified(section)),
    });
    if let Some((index, z)) = section.contradiction() {
        let pose = &section.poses[index];
        reasons.push(Reason::Contradiction {
            label: pose.called(),
            error_mps2: pose.left_out_error_mps2.unwrap_or(f64::NAN),
            z,
        });
    }
    if section.method == Method::Ferraris
        && let Some((error_mps2, count)) = section.free_norm_error()
    {
        reasons.push(Reason::Oblique { error_mps2, count });
    }
    reasons.extend(open_angles(section));
    reasons.extend(improvement(section, source, grade));
    Verdict {
        grade,
        reasons: reasons.iter().map(Reason::to_string).collect(),
    }
}

/// The closed form tests no single pose: it is never verified.
fn of_closed_form(section: &AccelerometerSection) -> Grade {
    match section.predicted_norm_error_mps2 {
        Some(error) if 2.0 * error > gravical_fit::UNVERIFIED_MPS2 => Grade::Poor,
        _ => Grade::NotVerifiable,
    }
}

/// Which error of one pose would have been detected, what a smaller one does, and the poses that would
/// test it.
fn detectable(section: &AccelerometerSection) -> Option<Reason> {
    section.fit?;
    section.leave_one_out_rms_mps2?;
    let now = section
        .undetected
        .as_ref()
        .map_or(f64::INFINITY, |u| u.effect_mps2);
    let with_poses = (1..)
        .zip(&section.next_poses)
        .filter_map(|(count, next)| Some((count, next.undetected_effect_mps2?)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, least)| *least < now)
        .map(|(count, least)| (count, section.next_poses[0].direction, least));
    Some(match &section.undetected {
        None => Reason::Untested(with_poses),
        Some(hidden) => Reason::Undetected {
            label: section.poses[hidden.pose].called(),
            reading_mps2: hidden.reading_mps2,
            effect_mps2: hidden.effect_mps2,
            direction: hidden.direction,
            with_poses,
        },
    })
}

/// What improves the result most: to know gravity, or to record poses.
fn improvement(section: &AccelerometerSection, source: GravitySource, grade: Grade) -> Vec<Reason> {
    let mut reasons = Vec::new();
    let Some(now_mps2) = section.predicted_norm_error_mps2 else {
        return reasons;
    };
    let known_mps2 = section.error_with_known_gravity(source);
    reasons.extend(known_mps2.map(|known_mps2| Reason::AssumedGravity {
        now_mps2,
        known_mps2,
    }));
    match (section.next_poses.first(), section.next_poses.last()) {
        (Some(first), Some(last)) if section.next_poses_lower_error() => {
            reasons.push(Reason::NextPoses {
                direction: first.direction,
                first_mps2: first.predicted_norm_error_mps2,
                last_mps2: last.predicted_norm_error_mps2,
                count: section.next_poses.len(),
            });
        }
        (None, _) if grade == Grade::NotVerifiable => reasons.push(Reason::AnyFreePose),
        _ => {}
    }
    reasons
}

fn unverified(section: &AccelerometerSection) -> &'static str {
    let mut fitted = section.poses.iter().filter(|p| p.fitted);
    if section.method == Method::Ferraris && section.degrees_of_freedom > 0 {
        return "the six-face method has no pose that it was not fitted to: its residuals verify nothing";
    }
    if fitted.clone().count() == 6 && fitted.all(|p| p.kind == PoseKind::Face) {
        return "six faces determine six parameters of ‖a‖ exactly: their residuals verify nothing";
    }
    "too few poses to leave one out: nothing verifies the result"
}

/// Angles between the axes that face poses do not separate from their own tilt.
fn open_angles(section: &AccelerometerSection) -> Option<Reason> {
    let angles = section.deviations.as_ref()?.axis_angle_deg;
    let angle_deg = angles.iter().fold(0.0_f64, |m, a| m.max(*a));
    let tilt_deg = section.pose_tilt_deg?.value;
    (angle_deg > OPEN_ANGLE_DEG).then_some(Reason::OpenAngles {
        angle_deg,
        tilt_deg,
    })
}
