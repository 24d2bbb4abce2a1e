//! What a position is worth: its uncertainty by the distance that it went.

use gravical_core::matrix3::norm;
use gravical_judge::numfmt::{COVERAGE, digits, milli_g};
use gravical_motion::{Ends, PathNode};
use nalgebra::{Quaternion, UnitQuaternion};

use super::estimate::Estimate;
use super::result::{FinalState, MotionJudgement, MotionVerdict, Move, VisibleMove};
use super::uncertainty::GravityMisfit;

/// A position within this share of the distance is usable.
const USABLE: f64 = 0.1;
/// A velocity or an angle beyond so many of its standard deviations is no chance: one of three axes in 5,300.
const SEEN: f64 = 4.0;
/// Nothing moved only if the end is known to so many times what a rest could hide in the duration of the moves.
const HIDDEN: f64 = 4.0;
/// Smaller rotations of what did not move are not reported, degrees.
const REPORTED_ROTATION_DEG: f64 = 2.0;

impl MotionVerdict {
    pub(super) fn new(
        own: &Estimate,
        (moves, end): (&[Move], &FinalState),
        visible: &[VisibleMove],
        misfit: Option<GravityMisfit>,
    ) -> Self {
        use MotionJudgement::{AtRest, Open, PositionNotKnown, Rough, Usable};
        let path = &own.motion.path;
        let distances = path.iter().map(|node| norm(&node.position_m));
        let size_m = end.position_m.map(|_| distances.fold(0.0, f64::max));
        let expanded_m = end.sigma_m.map(|sd| {
            let along = match &own.motion.moves[..] {
                [only] => only.along_sd_m,
                _ => sd.into_iter().fold(0.0, f64::max),
            };
            COVERAGE * along
        });
        let ratio = size_m.zip(expanded_m).map(|(size, u)| u / size);
        let is_seen = |node: &PathNode| {
            let each = node.velocity_mps.iter().zip(&node.velocity_sd_mps);
            each.into_iter()
                .any(|(v, sd)| v.abs() > SEEN * sd && *sd > 0.0)
        };
        let ends_open = matches!(
            moves.last().map(|m| m.ends),
            Some(Ends::FromRest | Ends::Free)
        );
        let seconds = moves.iter().map(|m| m.end_s - m.start_s).sum();
        let hidden_m = own.motion.hidden_displacement_m(seconds);
        let is_small = expanded_m
            .zip(hidden_m)
            .is_some_and(|(u, hidden)| u <= HIDDEN * hidden);
        let judgement = match ratio {
            _ if moves.is_empty() && !own.motion.rests.is_empty() => AtRest,
            _ if end.position_m.is_none() => PositionNotKnown,
            _ if ends_open => Open,
            Some(ratio) if ratio <= USABLE => Usable,
            Some(ratio) if ratio <= 1.0 => Rough,
            _ if is_small && !path.iter().any(is_seen) => AtRest,
            _ => PositionNotKnown,
        };
        let mut reasons = Vec::new();
        reasons.extend(misfit.and_then(contradiction));
        reasons.push(reason(own, judgement, moves, visible));
        reasons.extend(rotation(path).filter(|_| judgement == AtRest));
        MotionVerdict {
            judgement,
            size_m,
            expanded_m,
            ratio,
            reasons,
        }
    }
}

fn reason(
    own: &Estimate,
    judgement: MotionJudgement,
    moves: &[Move],
    visible: &[VisibleMove],
) -> String {
    let (all, lost) = (
        moves.len(),
        moves.iter().filter(|m| m.unusable.is_some()).count(),
    );
    match judgement {
        _ if own.motion.rests.is_empty() && own.motion.noise.is_none() && lost == all => {
            "The sensor never rests, so tilt, velocity and noise are not known: hold it still for 2 s before and after each move.".to_owned()
        }
        MotionJudgement::AtRest if all == 0 => {
            let hidden = visible.iter().find(|v| v.seconds >= 2.0).or(visible.last());
            let hidden = hidden.map_or(String::new(), |v| {
                let (distance, seconds) = (digits(v.distance_m, 2), v.seconds);
                format!(" A displacement of up to {distance} m in {seconds} s could hide in it.")
            });
            format!("No move is visible in the recording.{hidden}")
        }
        MotionJudgement::AtRest => "It moves by no more than its uncertainty.".to_owned(),
        MotionJudgement::PositionNotKnown if lost > 0 => format!(
            "Moves whose displacement cannot be determined: {lost} of {all}; the table of moves gives the reasons."
        ),
        MotionJudgement::PositionNotKnown => {
            "The uncertainty of the end is larger than the distance.".to_owned()
        }
        MotionJudgement::Open if moves.iter().all(|m| m.sigma_m.is_none()) => {
            "This procedure knows no rest: nothing limits its drift, whose error grows with the square of time.".to_owned()
        }
        MotionJudgement::Open => {
            "The recording does not end at rest: nothing after the last rest tests it. Hold it still for 2 s after the last move.".to_owned()
        }
        MotionJudgement::Usable | MotionJudgement::Rough => {
            "It ends at rest: the velocity is known to be zero there, which limits the drift.".to_owned()
        }
    }
}

/// That it is turned at the end, though it did not move.
fn rotation(path: &[PathNode]) -> Option<String> {
    let (first, last) = (path.first()?, path.last()?);
    let of = |node: &PathNode| {
        let [w, x, y, z] = node.attitude;
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
    };
    let angle = of(first).angle_to(&of(last));
    let sd = norm(&last.attitude_sd_rad);
    let is_rotated = angle > SEEN * sd && angle.to_degrees() > REPORTED_ROTATION_DEG;
    is_rotated.then(|| {
        let (angle, within) = (angle.to_degrees(), COVERAGE * sd.to_degrees());
        format!(
            "Between start and end it turned by {angle:.1}° ± {}° (95 %).",
            digits(within, 2)
        )
    })
}

fn contradiction(misfit: GravityMisfit) -> Option<String> {
    misfit.contradicts.then(|| format!(
        "At rest the calibrated sensor measures {:.3} m/s², gravity is {:.3} m/s²: off by {:+.1} mg, {:.0} times what the calibration allows. The uncertainties given here include an error of that size; test the calibration with `gravical check`.",
        misfit.measured_mps2,
        misfit.gravity_mps2,
        milli_g(misfit.measured_mps2 - misfit.gravity_mps2),
        misfit.sigmas()
    ))
}
