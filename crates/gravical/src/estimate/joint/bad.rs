//! Poses that do not fit: moved, bumped, clipped.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::Held;
use super::fit::{Fit, Pose, fit};
use super::reduced::Reduced;

/// A pose is bad when one as far off is rarer than this among all poses.
const CHANCE: f64 = 1e-3;
/// Poses that the linearised deletion finds this rare are tried in earnest.
const SUSPECT: f64 = 0.05;
/// Degrees of freedom that have to remain to judge by.
const LEAST_FREEDOM: f64 = 3.0;
/// At most this share of the poses is left out.
const MOST_SHARE: f64 = 0.2;

/// The pose whose deletion lowers χ² most, when that is more than chance: an F
/// test of the deletion against what remains, with Bonferroni's correction for
/// having picked the worst. None when every pose may stay.
pub(super) fn worst(work: &[Pose], found: &Fit, bad: &[Option<f64>]) -> Option<(usize, f64)> {
    let gone = bad.iter().filter(|b| b.is_some()).count();
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
    let whole = fit(work, &held, &found.start())?;
    if whole.freedom < LEAST_FREEDOM + 1.0 {
        return None;
    }
    let there = work.iter().filter(|p| !p.left_out).count() as f64;
    let start = whole.start();
    let mut best: Option<(usize, f64)> = None;
    let mut trial = work.to_vec();
    for k in suspects(work, &whole, there) {
        trial[k].left_out = true;
        if let Some(rest) = fit(&trial, &held, &start).filter(|f| f.freedom >= LEAST_FREEDOM) {
            let chance = there
                * chance(
                    whole.chi2 - rest.chi2,
                    whole.freedom - rest.freedom,
                    rest.chi2,
                    rest.freedom,
                );
            if chance < CHANCE && best.is_none_or(|(_, c)| chance < c) {
                best = Some((k, chance));
            }
        }
        trial[k].left_out = false;
    }
    best
}

/// Probability that a deletion loses so much of χ² and of the degrees of
/// freedom when so much remains.
fn chance(lost: f64, freed: f64, rest: f64, freedom: f64) -> f64 {
    let freed = freed.max(0.1);
    let f = lost.max(0.0) / freed / (rest / freedom);
    FisherSnedecor::new(freed, freedom).map_or(1.0, |d| d.sf(f))
}

/// Poses that may be bad by the linearised deletion. The cost that it speaks of
/// holds the priors too, which errs on the side of trying.
fn suspects(work: &[Pose], whole: &Fit, there: f64) -> Vec<usize> {
    let Some(values) = &whole.covariance.values else {
        return Vec::new();
    };
    let reduced = Reduced::new(whole);
    (0..work.len())
        .filter(|&k| {
            let Some(place) = whole.place_of[k] else {
                return false;
            };
            if whole.model.places[place].readings.len() > 1 {
                return true;
            }
            let Some((lost, freed)) = reduced.deletion(place, values) else {
                return true;
            };
            let freedom = whole.freedom - freed;
            let rest = (whole.chi2 - lost).max(1e-3 * whole.chi2);
            freedom < LEAST_FREEDOM || there * chance(lost, freed, rest, freedom) < SUSPECT
        })
        .collect()
}
