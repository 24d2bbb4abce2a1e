//! Poses that do not fit: moved, bumped, clipped.

use gravical_core::matrix3;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::estimate::reliability::{USUAL_CHI2, USUAL_FREEDOM};
use crate::predicted;
use crate::segment::face::angle_deg;

use super::Held;
use super::fit::{Fit, Pose, rough_fit};
use super::leave_out::NEIGHBOUR_DEG;
use super::reduced::Reduced;

/// A pose is bad when one as far off is rarer than this among all poses.
const CHANCE: f64 = 1e-3;
/// Poses that the linearised deletion finds this rare are tried in earnest.
const SUSPECT: f64 = 0.05;
/// … so many of them at a time: the others have their turn when these are gone.
const MOST_TRIALS: usize = 12;
/// Degrees of freedom that have to remain to judge by.
const LEAST_FREEDOM: f64 = 1.0;
/// With fewer than this one bad pose can look like another: then the worst has
/// to be so many times rarer than the next. Repeats that contradict each other
/// must be distinguished as clearly, however many other poses there are.
const PLENTY_OF_FREEDOM: f64 = 3.0;
const CLEARLY: f64 = 100.0;
/// A pose shares the error of another when it misses as much as this share of it.
const SHARED_ERROR: f64 = 0.5;
/// At most this share of the poses is left out.
const MOST_SHARE: f64 = 0.2;

/// What poses that do not fit come to.
#[derive(Debug, Default)]
pub(super) struct Misfits {
    /// The worst, and the chance that a good one misses as much.
    pub bad: Option<(usize, f64)>,
    /// Of each disputed direction the poses that contradict each other, on two sides:
    /// nothing tells which are right, and all of them stay.
    pub disputed: Vec<[Vec<usize>; 2]>,
}

/// A pose, tried without.
#[derive(Debug, Clone, Copy)]
struct Deletion {
    pose: usize,
    /// That a good one would be missed as little.
    chance: f64,
    /// Degrees of freedom of what remains.
    freedom: f64,
}

/// The pose whose deletion lowers χ² most, when that is more than chance: an F
/// test of the deletion against what remains, with Bonferroni's correction for
/// having picked the worst. Repeats that contradict each other stay where nothing
/// tells which of them are right.
pub(super) fn worst(work: &[Pose], found: &Fit, held: &Held, bad: &[Option<f64>]) -> Misfits {
    let gone = bad.iter().filter(|b| b.is_some()).count();
    if (gone + 1) as f64 > MOST_SHARE * work.len() as f64 {
        return Misfits::default();
    }
    // Without a model error.
    let held = Held {
        model_error: 0.0,
        ..*held
    };
    match rough_fit(work, &held, &found.start()) {
        Some(whole) if whole.freedom >= LEAST_FREEDOM => judge(work, &whole, &held),
        _ => Misfits::default(),
    }
}

fn judge(work: &[Pose], whole: &Fit, held: &Held) -> Misfits {
    let there = work.iter().filter(|p| !p.left_out).count() as f64;
    let start = whole.start();
    let mut tried: Vec<Deletion> = Vec::new();
    let mut trial = work.to_vec();
    for k in suspects(work, whole, there) {
        trial[k].left_out = true;
        if let Some(rest) = rough_fit(&trial, held, &start).filter(|f| f.freedom >= LEAST_FREEDOM) {
            let lost = whole.chi2 - rest.chi2;
            let freed = whole.freedom - rest.freedom;
            tried.push(Deletion {
                pose: k,
                chance: there * chance(lost, freed, rest.chi2, rest.freedom),
                freedom: rest.freedom,
            });
        }
        trial[k].left_out = false;
    }
    tried.sort_by(|a, b| a.chance.total_cmp(&b.chance));
    let mut out = Misfits::default();
    for (at, one) in tried.iter().enumerate() {
        if one.chance >= CHANCE {
            break;
        }
        if out
            .disputed
            .iter()
            .flatten()
            .flatten()
            .any(|&k| k == one.pose)
        {
            continue;
        }
        if let Some(sides) = dispute(work, whole, held, one.pose) {
            out.disputed.push(sides);
            continue;
        }
        let next = tried.get(at + 1).map_or(1.0, |next| next.chance);
        if one.freedom >= PLENTY_OF_FREEDOM || next > CLEARLY * one.chance {
            out.bad = Some((one.pose, one.chance));
        }
        break;
    }
    out
}

/// The poses in the direction of `pose` that share its error and those that do not, where
/// these are no majority, and the poses of other directions do not tell who is right.
/// None when `pose` is the one that does not fit.
fn dispute(work: &[Pose], whole: &Fit, held: &Held, pose: usize) -> Option<[Vec<usize>; 2]> {
    let inverse = matrix3::inverse(&whole.state.m)?;
    let force = |k: usize| whole.force(&inverse, &work[k]);
    let here: Vec<usize> = (0..work.len())
        .filter(|&k| !work[k].left_out && angle_deg(force(k), force(pose)) <= NEIGHBOUR_DEG)
        .collect();
    let error = |k: usize| matrix3::norm(&force(k)) - held.gravity;
    let (like, others): (Vec<usize>, Vec<usize>) = here
        .iter()
        .partition(|&&k| error(k) / error(pose) >= SHARED_ERROR);
    if others.is_empty() || others.len() > like.len() {
        return None;
    }
    let mut rest = work.to_vec();
    here.iter().for_each(|&k| rest[k].left_out = true);
    let agrees = rough_fit(&rest, held, &whole.start())
        .and_then(|rest| {
            let off = square_off(work, &rest, &like)?;
            Some(off - square_off(work, &rest, &others)? > 2.0 * CLEARLY.ln())
        })
        .unwrap_or(false);
    (!agrees).then_some([like, others])
}

/// Squared error of ‖a‖, mean of a few poses that the fit does not know, over its
/// variance by fit and readings.
fn square_off(work: &[Pose], fit: &Fit, of: &[usize]) -> Option<f64> {
    let inverse = matrix3::inverse(&fit.state.m)?;
    let covariance = fit.full_covariance()?;
    let count = of.len() as f64;
    let (mut error, mut h, mut noise) = (0.0, [0.0; 12], 0.0);
    for pose in of.iter().map(|&k| &work[k]) {
        let force = fit.force(&inverse, pose);
        error += (matrix3::norm(&force) - fit.model.gravity) / count;
        let own = predicted::sensitivity(&inverse, matrix3::unit(&force), fit.model.gravity);
        for (sum, own) in h.iter_mut().zip(own) {
            *sum += own / count;
        }
        // The last three are the derivatives by the reading, too.
        noise += (0..3)
            .map(|i| (own[9 + i] * pose.sd[i] / count).powi(2))
            .sum::<f64>();
    }
    let variance = predicted::variance(&covariance, &h) + noise;
    let usual = (fit.chi2 + USUAL_FREEDOM * USUAL_CHI2) / (fit.freedom + USUAL_FREEDOM);
    Some(error * error / (usual * variance))
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

/// Poses that may be bad by the linearised deletion, the likeliest first and
/// [`MOST_TRIALS`] at the most. The cost that it speaks of holds the priors too,
/// which errs on the side of trying.
fn suspects(work: &[Pose], whole: &Fit, there: f64) -> Vec<usize> {
    let reduced = Reduced::new(whole);
    let mut out: Vec<(usize, f64)> = (0..work.len())
        .filter_map(|k| Some((k, suspicion(&reduced, whole, whole.place_of[k]?))))
        .map(|(k, chance)| (k, there * chance))
        .filter(|(_, chance)| *chance < SUSPECT)
        .collect();
    out.sort_by(|a, b| a.1.total_cmp(&b.1));
    out.truncate(MOST_TRIALS);
    out.into_iter().map(|(k, _)| k).collect()
}

/// Chance of a place, linearised; 0 where its deletion cannot be.
fn suspicion(reduced: &Reduced, whole: &Fit, place: usize) -> f64 {
    let Some((lost, mut freed)) = reduced.deletion(place) else {
        return 0.0;
    };
    // One of several readings loses no more than all of them.
    if whole.model.places[place].readings.len() > 1 {
        freed = freed.min(1.0);
    }
    let freedom = whole.freedom - freed;
    if freedom < LEAST_FREEDOM {
        return 0.0;
    }
    let rest = (whole.chi2 - lost).max(1e-3 * whole.chi2);
    chance(lost, freed, rest, freedom)
}
