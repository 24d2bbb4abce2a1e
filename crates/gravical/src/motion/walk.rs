//! Which pauses of a walking foot are rests, and which are stances.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::motion::LEAST_FOR_BIAS_S;

use super::anchors::{Anchors, Side};
use super::options::MotionOptions;
use super::setup::Setup;
use super::stance::LONGEST_STEP_S;

/// A rest in a walk is told by the steps before and after it within so many seconds: three of
/// the longest, and their stances.
const LOOKED_BACK_S: f64 = 30.0;
const LOOKED_ON_S: f64 = 10.0;

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
    let Some(rate_rad_s) = options.stance_rate_rad_s else {
        return Vec::new();
    };
    let t = &setup.view.samples.t_s;
    let legs = Legs {
        setup,
        anchors: Anchors::new(setup.view, setup.walk),
        step_s: setup.view.samples.median_step_s(),
        rate_rad_s,
    };
    let mut k = 1;
    while options.rests_s.is_none() && k + 1 < rests.len() {
        let rest = rests[k].clone();
        if t[rest.end - 1] - t[rest.start] < LEAST_FOR_BIAS_S {
            rests.remove(k);
            let recent = |t_s: f64| t[rest.start] - t_s <= LONGEST_STEP_S;
            // Of a long walk its last steps are enough.
            let near = t[rest.start] - LOOKED_BACK_S;
            let until = rest
                .end
                .saturating_add((LOOKED_ON_S / legs.step_s) as usize);
            let near = t.partition_point(|t_s| *t_s < near)..until;
            // The leg that the rest would lie in, and those before it that reach as far.
            let walked = (0..k)
                .rev()
                .take_while(|&j| j + 1 == k || recent(t[rests[j + 1].start]))
                .flat_map(|j| legs.stances(rests, j, &near))
                .any(|s| s.start < rest.end && recent(t[s.start]));
            if walked {
                continue;
            }
            rests.insert(k, rest);
        }
        k += 1;
    }
    (0..rests.len())
        .flat_map(|k| legs.stances(rests, k, &(0..t.len())))
        .collect()
}

/// Where stances are looked for: from a rest to the next, and after the last.
struct Legs<'a> {
    setup: &'a Setup<'a>,
    anchors: Anchors<'a>,
    step_s: f64,
    rate_rad_s: f64,
}

impl Legs<'_> {
    /// Stances after rest `k` of `rests`, in that part of the recording; none across a break.
    fn stances(
        &self,
        rests: &[Range<usize>],
        k: usize,
        within: &Range<usize>,
    ) -> Vec<Range<usize>> {
        let samples = self.setup.view.samples;
        let next = rests.get(k + 1).map_or(samples.len(), |r| r.start + 1);
        let leg = rests[k].end - 1..next;
        let at = samples.breaks.partition_point(|b| *b < leg.start);
        if samples.breaks.get(at).is_some_and(|b| *b < leg.end) {
            return Vec::new();
        }
        let leg = leg.start.max(within.start)..leg.end.min(within.end);
        let anchor = self.anchors.at(rests, k, Side::Last);
        super::stance::stances(
            samples,
            leg,
            &anchor.bias,
            norm(&anchor.force),
            self.step_s,
            self.rate_rad_s,
        )
    }
}

#[cfg(test)]
// One rest is a range in a list.
#[allow(clippy::single_range_in_vec_init)]
mod tests {
    use super::*;
    use crate::motion::hidden::Hidden;
    use crate::motion::options::GravityRemoval;
    use crate::motion::samples::{Samples, View};
    use crate::motion::{MotionOptions, anchors::RandomWalk};

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
            breaks: Vec::new(),
            resolution: [0.0; 6],
            clipped: Vec::new(),
        };
        let setup = Setup {
            view: View::calibrated(&samples),
            stances: &[],
            walk: RandomWalk::default(),
            rides: &[],
            directions: &[],
            removal: GravityRemoval::Strapdown,
            mean: None,
            wobble: 0.0,
            clock_error: 0.0,
            v0: [0.0; 3],
            p0: [0.0; 3],
            hidden: Hidden::new(&RandomWalk::default(), &samples, &[]),
            bands: false,
            meter: None,
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
