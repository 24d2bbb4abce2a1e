//! What can be determined from a recording of motion, and why.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use super::misfit::GravityMisfit;
use super::result::{Ends, MotionJudgement, MotionVerdict, Move, VisibleMove};
use super::words::rounded;

/// What a move without a rest at one of its ends costs.
const GROWS: &str = "the error grows with the square of time: rest for 2 s before the first move and after the last";

impl MotionVerdict {
    pub(super) fn of(
        moves: &[Move],
        visible: &[VisibleMove],
        no_rest: bool,
        zero_velocity: bool,
        misfit: Option<GravityMisfit>,
    ) -> Self {
        use MotionJudgement::{AtRest, Bounded, NotUsable, Open, PartlyOpen};
        let all = moves.len();
        let lost = moves.iter().filter(|m| m.unusable.is_some()).count();
        let is_closed = |m: &&Move| m.ends == Ends::RestToRest && m.unusable.is_none();
        let closed = moves.iter().filter(is_closed).count();
        let (judgement, mut reason) = if no_rest {
            (
                NotUsable,
                "The sensor never rests, so tilt, velocity and noise are not known: hold it still for 2 s before and after each move.".to_owned(),
            )
        } else if all == 0 {
            (AtRest, at_rest(visible))
        } else if lost == all {
            (
                NotUsable,
                "No displacement can be determined from this recording; the table of moves gives the reasons.".to_owned(),
            )
        } else if closed == all {
            (
                Bounded,
                "Every move is between two rests: the velocity is known to be zero at both ends, which limits the drift.".to_owned(),
            )
        } else if closed > 0 {
            let open = match all - closed - lost {
                0 => String::new(),
                _ => format!("; with one end open {GROWS}"),
            };
            let text = format!("{closed} of {all} moves are known and between two rests{open}.");
            (PartlyOpen, text)
        } else if !zero_velocity {
            (
                Open,
                "Nothing corrects the drift after the first rest: the error grows with the square of time and faster.".to_owned(),
            )
        } else {
            (
                Open,
                format!("No move is between two rests: with one end open {GROWS}."),
            )
        };
        if (1..all).contains(&lost) {
            reason += &format!(
                " {lost} of {all} moves cannot be used; the table of moves gives the reasons."
            );
        }
        let contradicts = misfit.filter(|m| m.contradicts);
        let reasons = contradicts
            .iter()
            .map(contradiction)
            .chain([reason])
            .collect();
        MotionVerdict { judgement, reasons }
    }
}

/// The reason for a recording without a visible move.
fn at_rest(visible: &[VisibleMove]) -> String {
    let hidden = visible.iter().find(|v| v.seconds >= 2.0).or(visible.last());
    let hidden = hidden.map_or(String::new(), |v| {
        let (distance, seconds) = (rounded(v.distance_m), v.seconds);
        format!(" A displacement of up to {distance} m in {seconds} s could hide in it.")
    });
    format!("No move is visible in the recording.{hidden}")
}

fn contradiction(misfit: &GravityMisfit) -> String {
    let off = misfit.measured_mps2 - misfit.gravity_mps2;
    format!(
        "At rest the calibrated sensor measures {:.3} m/s², gravity is {:.3} m/s²: off by {:+.1} mg, {:.0} times what the calibration allows. The uncertainties given here include an error of that size; test the calibration with `gravical check`.",
        misfit.measured_mps2,
        misfit.gravity_mps2,
        1e3 * off / STANDARD_GRAVITY_MPS2,
        misfit.sigmas()
    )
}
