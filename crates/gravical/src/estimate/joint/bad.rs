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
const LEAST_FREEDOM: f64 = 1.0;
/// With fewer than this one bad pose can look like another: then the worst has
/// to be so many times rarer than the next.
const PLENTY_OF_FREEDOM: f64 = 3.0;
const CLEARLY: f64 = 100.0;
/// What is known of χ² per degree of freedom before any residual is seen: about
/// 4 (real sensors miss the model by more than their noise; 8.8 was seen on 38
/// poses), worth as much as so many residuals. Few poses could say nothing else.
const USUAL_CHI2: f64 = 4.0;
const USUAL_FREEDOM: f64 = 4.0;
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
        scatter: found.model.scatter,
    };
    let whole = fit(work, &held, &found.start())?;
    if whole.freedom < LEAST_FREEDOM {
        return None;
    }
    let there = work.iter().filter(|p| !p.left_out).count() as f64;
    let start = whole.start();
    let mut found: Vec<(usize, f64, f64)> = Vec::new();
    let mut trial = work.to_vec();
    for k in suspects(work, &whole, there) {
        trial[k].left_out = true;
        if let Some(rest) = fit(&trial, &held, &start).filter(|f| f.freedom >= LEAST_FREEDOM) {
            let lost = whole.chi2 - rest.chi2;
            let freed = whole.freedom - rest.freedom;
            let chance = there * chance(lost, freed, rest.chi2, rest.freedom);
            found.push((k, chance, rest.freedom));
        }
        trial[k].left_out = false;
    }
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let &(k, chance, freedom) = found.first()?;
    let next = found.get(1).map_or(1.0, |(_, chance, _)| *chance);
    let clear = freedom >= PLENTY_OF_FREEDOM || next > CLEARLY * chance;
    (chance < CHANCE && clear).then_some((k, chance))
}

/// Probability that a deletion loses so much of χ² and of the degrees of
/// freedom when so much remains, the variance of the residuals estimated from
/// these and from what is usual.
fn chance(lost: f64, freed: f64, rest: f64, freedom: f64) -> f64 {
    let freed = freed.max(0.1);
    let (rest, freedom) = (rest + USUAL_FREEDOM * USUAL_CHI2, freedom + USUAL_FREEDOM);
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
