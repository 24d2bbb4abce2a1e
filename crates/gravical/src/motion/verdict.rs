//! What a position is worth: its uncertainty by the distance that it went.

use gravical_calibrate::numfmt::{digits, milli_g};
use gravical_core::matrix3::norm;
use gravical_motion::{Ends, PathNode};
use nalgebra::{Quaternion, UnitQuaternion};

use super::estimate::Estimate;
use super::result::{FinalState, MotionJudgement, MotionVerdict, Move, VisibleMove};
use super::uncertainty::GravityMisfit;

/// Coverage factor of 95 %.
const COVERAGE: f64 = 2.0;
/// A position within this share of the distance is usable.
const USABLE: f64 = 0.1;
/// A velocity or an angle beyond so many of its standard deviations is there: one node of 16,000 by chance.
const SEEN: f64 = 4.0;
/// A turn below this is said of no rest, degrees.
const REPORTED_TURN_DEG: f64 = 2.0;

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
            let along = moves.first().filter(|_| moves.len() == 1);
            let along = along.and_then(|only| only.displacement_m);
            COVERAGE * along.map_or(sd.into_iter().fold(0.0, f64::max), |d| along_it(&d, &sd))
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
        let judgement = match ratio {
            _ if moves.is_empty() && !own.motion.rests.is_empty() => AtRest,
            _ if end.position_m.is_none() => PositionNotKnown,
            _ if ends_open => Open,
            Some(ratio) if ratio <= USABLE => Usable,
            Some(ratio) if ratio <= 1.0 => Rough,
            _ if !path.iter().any(is_seen) => AtRest,
            _ => PositionNotKnown,
        };
        let mut reasons = Vec::new();
        reasons.extend(misfit.and_then(contradiction));
        reasons.push(reason(own, judgement, moves, visible));
        reasons.extend(turn(path).filter(|_| judgement == AtRest));
        MotionVerdict {
            judgement,
            size_m,
            expanded_m,
            ratio,
            reasons,
        }
    }
}

/// Standard deviation along a displacement, of those along the axes.
fn along_it(displacement: &[f64; 3], sd: &[f64; 3]) -> f64 {
    let long = norm(displacement);
    let part = |i: usize| {
        if long > 0.0 {
            displacement[i] / long * sd[i]
        } else {
            sd[i]
        }
    };
    norm(&[0, 1, 2].map(part))
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
            "The uncertainty of the end is larger than the distance: rest more often, calibrate, and record a gyroscope.".to_owned()
        }
        MotionJudgement::Open => {
            "The recording ends in motion: nothing corrects the drift, whose error grows with the square of time and faster. Hold it still for 2 s after the last move.".to_owned()
        }
        MotionJudgement::Usable | MotionJudgement::Rough => {
            "It ends at rest: the velocity is known to be zero there, which limits the drift.".to_owned()
        }
    }
}

/// That it turned, though it did not move.
fn turn(path: &[PathNode]) -> Option<String> {
    let (first, last) = (path.first()?, path.last()?);
    let of = |node: &PathNode| {
        let [w, x, y, z] = node.attitude;
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
    };
    let angle = of(first).angle_to(&of(last));
    let sd = norm(&last.attitude_sd_rad);
    let is_turn = angle > SEEN * sd && angle.to_degrees() > REPORTED_TURN_DEG;
    is_turn.then(|| {
        let (angle, within) = (angle.to_degrees(), COVERAGE * sd.to_degrees());
        format!("It turned by {angle:.1}° ± {}° (95 %).", digits(within, 2))
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
