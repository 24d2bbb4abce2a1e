//! What can be determined from a recording of motion, and why.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use super::misfit::GravityMisfit;
use super::result::{Ends, FinalState, MotionJudgement, MotionVerdict, Move};
use crate::numfmt::decimals_for;

impl MotionVerdict {
    pub(super) fn of(moves: &[Move], end: &FinalState, misfit: Option<GravityMisfit>) -> Self {
        use MotionJudgement::{
            AtRest, Bounded, CalibrationInDoubt, NotUsable, PartlyOpen, PartlyUsable,
        };
        let all = moves.len();
        let usable = moves.iter().filter(|m| m.usable).count();
        let between_rests = |m: &&Move| m.ends == Ends::RestToRest && m.usable;
        let closed = moves.iter().filter(between_rests).count();
        let (mut judgement, reason) = if all == 0 {
            (AtRest, at_rest(end))
        } else if usable == 0 {
            (
                NotUsable,
                "No displacement can be determined from this recording; the table of moves gives the reasons."
                    .to_owned(),
            )
        } else if closed == all {
            (
                Bounded,
                "Every move is between two rests: the velocity is known to be zero at both ends, which limits the drift."
                    .to_owned(),
            )
        } else if usable == all {
            (
                PartlyOpen,
                format!(
                    "{closed} of {all} moves are between two rests. With one end open, the error grows with the square of time."
                ),
            )
        } else {
            (
                PartlyUsable,
                format!(
                    "{usable} of {all} moves are usable; the table of moves gives the reasons for the others."
                ),
            )
        };
        let mut reasons = vec![reason];
        if let Some(misfit) = misfit.filter(|m| m.contradicts) {
            reasons.insert(0, contradiction(&misfit));
            if !matches!(judgement, AtRest | NotUsable) {
                judgement = CalibrationInDoubt;
            }
        }
        MotionVerdict { judgement, reasons }
    }
}

/// The reason for a recording without a visible move.
fn at_rest(end: &FinalState) -> String {
    let hidden = end.sigma_m.map_or(String::new(), |sigma| {
        let most = sigma.into_iter().fold(0.0, f64::max);
        format!(
            " The position is 0 ± {most:.*} m (1σ): a smaller move is hidden by the noise.",
            decimals_for(most)
        )
    });
    format!("No move is visible in the recording.{hidden}")
}

fn contradiction(misfit: &GravityMisfit) -> String {
    let off = misfit.measured_mps2 - misfit.gravity_mps2;
    format!(
        "At rest the calibrated sensor measures {:.3} m/s², gravity is {:.3} m/s²: off by {:+.1} mg, {:.0} times what the calibration allows. The uncertainties given here include an error of that size; a new calibration removes it.",
        misfit.measured_mps2,
        misfit.gravity_mps2,
        1e3 * off / STANDARD_GRAVITY_MPS2,
        misfit.sigmas()
    )
}
