//! Poses that do not fit: moved, bumped, clipped.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::Held;
use super::fit::{Fit, Pose, fit};

/// A pose is bad when one as far off is rarer than this among all poses.
const CHANCE: f64 = 1e-3;
/// Degrees of freedom that have to remain to judge by.
const LEAST_FREEDOM: f64 = 3.0;
/// At most this share of the poses is left out.
const MOST_SHARE: f64 = 0.2;

/// The pose whose deletion lowers χ² most, when that is more than chance: an F
/// test of the deletion against what remains, with Bonferroni's correction for
/// having picked the worst. None when every pose may stay.
pub(super) fn worst(work: &[Pose], found: &Fit, bad: &[Option<f64>]) -> Option<(usize, f64)> {
    let gone = bad.iter().filter(|b| b.is_some()).count();
    let there = work.iter().filter(|p| !p.left_out).count();
    if (gone + 1) as f64 > MOST_SHARE * work.len() as f64 {
        return None;
    }
    // Without a model error and with tilts that scatter as they do.
    let held = Held {
        gravity: found.model.gravity,
        tilt: found.model.tilt,
        prior: found.model.prior,
        model_error: 0.0,
    };
    let start = (found.state.m, found.state.b);
    let whole = fit(work, &held, start)?;
    if whole.freedom < LEAST_FREEDOM + 1.0 {
        return None;
    }
    let mut best: Option<(usize, f64)> = None;
    let mut trial = work.to_vec();
    for k in (0..work.len()).filter(|&k| !work[k].left_out) {
        trial[k].left_out = true;
        if let Some(rest) = fit(&trial, &held, start).filter(|f| f.freedom >= LEAST_FREEDOM) {
            let freed = (whole.freedom - rest.freedom).max(0.1);
            let f = (whole.chi2 - rest.chi2).max(0.0) / freed / (rest.chi2 / rest.freedom);
            let chance =
                FisherSnedecor::new(freed, rest.freedom).map_or(1.0, |d| d.sf(f) * there as f64);
            if chance < CHANCE && best.is_none_or(|(_, c)| chance < c) {
                best = Some((k, chance));
            }
        }
        trial[k].left_out = false;
    }
    best
}
