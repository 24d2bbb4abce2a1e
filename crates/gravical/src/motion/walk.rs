//! Which pauses of a walking foot are rests, and which are stances.

use std::ops::Range;

use gravical_core::matrix3::norm;

use super::anchors::{Anchors, LEAST_FOR_BIAS_S, Side};
use super::options::MotionOptions;
use super::path::Setup;
use super::stance::{LONGEST_STEP_S, StanceOptions};

/// Stances of a walking foot between `rests` and after the last.
///
/// A rest between others that is shorter than 1 s, and comes within 3 s after a stance
/// of a walk, is no rest: a foot that has just come to stand still settles, and half a
/// second of it tells no tilt to level by. It is taken out of `rests`.
pub(super) fn stances(
    setup: &Setup<'_>,
    rests: &mut Vec<Range<usize>>,
    options: &MotionOptions,
) -> Vec<Range<usize>> {
    let t = &setup.samples.t_s;
    let mut all = between(setup, rests, &options.stance);
    if options.rests.given_s.is_some() {
        return all;
    }
    let mut k = 1;
    while k + 1 < rests.len() {
        let rest = rests[k].clone();
        if t[rest.end - 1] - t[rest.start] < LEAST_FOR_BIAS_S {
            let mut others = rests.clone();
            others.remove(k);
            let with = between(setup, &others, &options.stance);
            let walked = with
                .iter()
                .any(|s| s.start < rest.end && t[rest.start] - t[s.start] <= LONGEST_STEP_S);
            if walked {
                (*rests, all) = (others, with);
                continue;
            }
        }
        k += 1;
    }
    all
}

/// Stances of a walking foot between the rests, and after the last.
fn between(
    setup: &Setup<'_>,
    rests: &[Range<usize>],
    options: &StanceOptions,
) -> Vec<Range<usize>> {
    let anchors = Anchors::new(setup.samples, setup.walk);
    let mut out = Vec::new();
    for (k, rest) in rests.iter().enumerate() {
        let next = rests
            .get(k + 1)
            .map_or(setup.samples.len(), |r| r.start + 1);
        let leg = rest.end - 1..next;
        if setup.samples.breaks.iter().any(|b| leg.contains(b)) {
            continue;
        }
        let anchor = anchors.at(rests, k, Side::Last);
        let gravity = norm(&anchor.force);
        out.extend(super::stance::stances(
            setup.samples,
            leg,
            &anchor.bias,
            gravity,
            options,
        ));
    }
    out
}

#[cfg(test)]
// One rest is a range in a list.
#[allow(clippy::single_range_in_vec_init)]
mod tests {
    use super::*;
    use crate::motion::options::GravityRemoval;
    use crate::motion::samples::Samples;
    use crate::motion::{MotionOptions, anchors::Walk};

    /// 3 s of rest, six steps of a second with swings of `peak` rad/s, a pause of
    /// `pause` samples, half a second of shuffling, 3 s of rest; rests as they would
    /// be found.
    fn rests_after(peak: f64, pause: usize) -> Vec<Range<usize>> {
        let walked = 900;
        let end = walked + pause + 50;
        let rate = |i: usize| {
            let at = i % 100;
            if (300..walked).contains(&i) && at < 60 {
                peak * (std::f64::consts::PI * at as f64 / 60.0).sin()
            } else if (walked + pause..end).contains(&i) {
                0.3
            } else {
                0.0
            }
        };
        let n = end + 300;
        let samples = Samples {
            t_s: (0..n).map(|i| 0.01 * i as f64).collect(),
            force_mps2: [vec![0.0; n], vec![0.0; n], vec![9.8; n]],
            rate_rad_s: Some([vec![0.0; n], (0..n).map(rate).collect(), vec![0.0; n]]),
            row: (0..n).collect(),
            breaks: Vec::new(),
            resolution: [0.0; 6],
        };
        let setup = Setup {
            samples: &samples,
            stances: &[],
            walk: Walk::default(),
            directions: &[],
            removal: GravityRemoval::Strapdown,
            mean: None,
            wobble: 0.0,
            clock_error: 0.0,
            v0: [0.0; 3],
            p0: [0.0; 3],
            bands: false,
        };
        let mut rests = vec![0..300, walked..walked + pause, end..n];
        stances(&setup, &mut rests, &MotionOptions::default());
        rests
    }

    #[test]
    fn a_short_pause_after_steps_is_no_rest() {
        assert_eq!(rests_after(6.0, 57), [0..300, 1007..1307]);
        // A long one is, and one that comes after no walk.
        assert_eq!(rests_after(6.0, 150).len(), 3);
        assert_eq!(rests_after(1.5, 57).len(), 3);
    }
}
