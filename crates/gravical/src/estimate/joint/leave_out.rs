//! Error of ‖a‖ on poses that were left out of the fit.

use crate::segment::face::angle_deg;

use super::fit::{Fit, Held, Pose, fit};
use super::model;

/// Neighbours within this angle know a pose's answer, degrees.
const NEIGHBOUR_DEG: f64 = 25.0;
/// Poses that have to remain: as many as a diagonal model has parameters.
const LEAST_POSES: usize = 6;
/// What remains determines nothing when its condition, prior off, is worse.
const MOST_CONDITION: f64 = 1e4;

/// For every pose: refit without it and every pose within 25° of it, and
/// ‖M⁻¹(u − b)‖ − g there, m/s². None where what remains does not determine the
/// parameters without the data-sheet prior, and for poses that were left out as
/// bad.
pub(super) fn errors(work: &[Pose], found: &Fit, held: &Held) -> Vec<Option<f64>> {
    let start = (found.state.m, found.state.b);
    let directions: Vec<Option<[f64; 3]>> = work
        .iter()
        .map(|p| found.calibrated(p.mean).map(model::unit))
        .collect();
    (0..work.len())
        .map(|k| {
            if work[k].left_out {
                return None;
            }
            let own = directions[k]?;
            let mut rest = work.to_vec();
            for (pose, direction) in rest.iter_mut().zip(&directions) {
                if direction.is_none_or(|d| angle_deg(d, own) <= NEIGHBOUR_DEG) {
                    pose.left_out = true;
                }
            }
            if rest.iter().filter(|p| !p.left_out).count() < LEAST_POSES {
                return None;
            }
            let open = Held {
                prior: None,
                ..*held
            };
            let bare = fit(&rest, &open, start)?;
            if bare.covariance.values.is_none() || bare.covariance.condition > MOST_CONDITION {
                return None;
            }
            let refit = fit(&rest, held, (bare.state.m, bare.state.b))?;
            Some(model::norm(refit.calibrated(work[k].mean)?) - held.gravity)
        })
        .collect()
}
