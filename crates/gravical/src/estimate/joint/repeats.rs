//! Which repeats of a face lay the same way.

use gravical_core::matrix3;

use crate::segment::face::Face;

use super::fit::{Fit, Pose};

/// Twice the gain of the log-likelihood that repeats which lay the same way have
/// to bring: χ² of two parameters exceeds it in 1 % of sessions without any.
const LEAST_GAIN: f64 = 9.2;
/// Placements that lay the same way scatter by at most this share of the tilt.
const MOST_SHARE: f64 = 0.3;
/// Scatters that are tried below that, each two thirds of the last.
const STEPS: i32 = 12;
/// Rounds of expectation and maximisation for the share of such pairs.
const ROUNDS: usize = 30;

/// Two placements of one face, neighbours by direction.
struct Pair {
    poses: [usize; 2],
    /// Squared distance of their directions, rad².
    square: f64,
    /// Variance of each of its two components by noise.
    noise: f64,
    /// Pairs of the face for each that is looked at: a neighbour is the nearest
    /// of several.
    rivals: f64,
}

impl Pair {
    /// Density of the squared distance when each component of it has this
    /// variance.
    fn density(&self, variance: f64) -> f64 {
        (-self.square / (2.0 * variance)).exp() / (2.0 * variance)
    }

    /// … of placements that lay the same way but for a scatter.
    fn same(&self, scatter: f64) -> f64 {
        self.density(self.noise + 2.0 * scatter * scatter)
    }

    /// … of placements with tilts of their own: the least of several
    /// exponential variables is one with the sum of their rates.
    fn apart(&self, tilt: f64) -> f64 {
        self.density((self.noise + 2.0 * tilt * tilt) / self.rivals)
    }
}

/// Puts poses that lay the same way into one group, pair by pair, and returns
/// how far they scatter about the tilt that they share, rad for each component;
/// none when every pose lay its own way.
///
/// A table that is not level tilts a face by the same angle each time; put down
/// again, it comes back to a small scatter ω. The distance between two
/// placements of a face is made of noise and 2ω² then, else of noise and two
/// tilts. The likeliest ω and share of such pairs are looked for over the pairs
/// of neighbours (the shortest tree that joins the placements of a face), and
/// each pair is judged by them.
pub(super) fn group(work: &mut [Pose], found: &Fit, tilt: f64) -> Option<f64> {
    let pairs = pairs(work, found)?;
    let apart: f64 = pairs.iter().map(|p| p.apart(tilt).ln()).sum();
    let scatters = (0..STEPS).map(|i| MOST_SHARE * tilt * 1.5_f64.powi(-i));
    let (scatter, likelihood, share) = scatters
        .chain([0.0])
        .map(|scatter| {
            let (likelihood, share) = likeliest(&pairs, scatter, tilt);
            (scatter, likelihood, share)
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    if 2.0 * (likelihood - apart) < LEAST_GAIN {
        return None;
    }
    for pair in &pairs {
        if share * pair.same(scatter) > (1.0 - share) * pair.apart(tilt) {
            let [from, to] = pair.poses.map(|k| work[k].group);
            for pose in work.iter_mut().filter(|p| p.group == from) {
                pose.group = to;
            }
        }
    }
    Some(scatter)
}

/// Log-likelihood of the pairs with the likeliest share of such that lay the
/// same way, and that share.
fn likeliest(pairs: &[Pair], scatter: f64, tilt: f64) -> (f64, f64) {
    let densities: Vec<(f64, f64)> = pairs
        .iter()
        .map(|p| (p.same(scatter), p.apart(tilt)))
        .collect();
    let mut share = 0.5;
    for _ in 0..ROUNDS {
        let sum: f64 = densities
            .iter()
            .map(|(same, apart)| share * same / (share * same + (1.0 - share) * apart))
            .sum();
        share = sum / pairs.len() as f64;
    }
    let likelihood = densities
        .iter()
        .map(|(same, apart)| (share * same + (1.0 - share) * apart).ln())
        .sum();
    (likelihood, share)
}

/// Neighbours among the placements of each face; none without any.
fn pairs(work: &[Pose], found: &Fit) -> Option<Vec<Pair>> {
    let inverse = matrix3::inverse(&found.state.m)?;
    let length = matrix3::norm(&found.state.m[0]) * found.model.gravity;
    let direction = |k: usize| matrix3::unit(&found.force(&inverse, &work[k]));
    // Mean square of a component over the length of the reading.
    let noise = |k: usize| {
        let place = &found.model.places[found.place_of[k]?];
        let variance: f64 = place.readings[0].sd.iter().map(|s| s * s).sum();
        Some(variance / 3.0 / (length * length))
    };
    let mut out = Vec::new();
    for face in Face::all() {
        let all: Vec<(usize, [f64; 3], f64)> = (0..work.len())
            .filter(|&k| work[k].face == Some(face))
            .filter_map(|k| Some((k, direction(k), noise(k)?)))
            .collect();
        let square =
            |i: usize, j: usize| matrix3::norm(&matrix3::sub(&all[i].1, &all[j].1)).powi(2);
        // The shortest tree (Prim): of every pose outside, the nearest one inside.
        let mut outside: Vec<(usize, usize, f64)> =
            (1..all.len()).map(|i| (i, 0, square(i, 0))).collect();
        while let Some(nearest) =
            (0..outside.len()).min_by(|&a, &b| outside[a].2.total_cmp(&outside[b].2))
        {
            let (i, j, distance) = outside.swap_remove(nearest);
            out.push(Pair {
                poses: [all[i].0, all[j].0],
                square: distance,
                noise: all[i].2 + all[j].2,
                rivals: all.len() as f64 / 2.0,
            });
            for other in &mut outside {
                let by = square(other.0, i);
                if by < other.2 {
                    *other = (other.0, i, by);
                }
            }
        }
    }
    (!out.is_empty()).then_some(out)
}
