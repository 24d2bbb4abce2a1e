//! Which rests are rests: at constant speed an accelerometer feels the same.
//!
//! From one rest on the velocity is integrated with its uncertainty σ_v, forwards
//! and backwards: a recording may begin at constant speed. Where the velocity is more than four σ_v from zero, the sensor does not
//! stand still, however quiet it is.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::motion::{FAR, FLOOR_MPS};
use gravical_core::strapdown::level;

use super::anchors::{Anchors, Side};
use super::leg::{Forward, Leg};
use super::parameters::{Direction, STEP};
use super::setup::Setup;

/// A velocity that an error of the acceleration of this size explains is no
/// motion when nothing after it comes to rest, m/s².
const DRIFT_MPS2: f64 = 0.15;

/// A quiet stretch that was judged.
#[derive(Debug, Clone)]
pub(super) struct Judged {
    /// Its samples.
    pub span: Range<usize>,
    /// Velocity there, m/s.
    pub velocity: [f64; 3],
    /// Its standard uncertainty, m/s; of a rest that noise alone explains, by noise alone.
    pub sigma: [f64; 3],
    /// Time since the rest that it was integrated from, s.
    pub seconds: f64,
    /// Taken for a rest.
    pub rest: bool,
    /// … although the velocity is too far from zero.
    pub overruled: bool,
}

/// Which way in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    Forwards,
    Backwards,
}

/// Judges the candidates of one piece. One of them has to be believed: the first,
/// or the longest where that makes more of them rests (then the longer time).
pub(super) fn judge(setup: &Setup<'_>, candidates: &[Range<usize>]) -> Vec<Judged> {
    let t_s = setup.view.t_s();
    let seconds = |r: &Range<usize>| t_s[r.end - 1] - t_s[r.start];
    let longest = (0..candidates.len())
        .max_by(|&a, &b| seconds(&candidates[a]).total_cmp(&seconds(&candidates[b])));
    let Some(longest) = longest else {
        return Vec::new();
    };
    let gate = Gate { setup, candidates };
    let by_first = gate.from(0);
    if longest == 0 || by_first.iter().all(|j| j.rest && !j.overruled) {
        return by_first;
    }
    let by_longest = gate.from(longest);
    let weight = |all: &[Judged]| {
        let rests = || all.iter().filter(|j| j.rest && !j.overruled);
        (
            rests().count(),
            rests().map(|j| seconds(&j.span)).sum::<f64>(),
        )
    };
    if weight(&by_longest) > weight(&by_first) {
        by_longest
    } else {
        by_first
    }
}

struct Gate<'a> {
    setup: &'a Setup<'a>,
    candidates: &'a [Range<usize>],
}

impl Gate<'_> {
    /// All candidates in order, that one believed.
    fn from(&self, believed: usize) -> Vec<Judged> {
        let mut out = self.side(believed, Way::Backwards);
        out.reverse();
        out.push(Judged {
            span: self.candidates[believed].clone(),
            velocity: [0.0; 3],
            sigma: [FLOOR_MPS; 3],
            seconds: 0.0,
            rest: true,
            overruled: false,
        });
        out.extend(self.side(believed, Way::Forwards));
        out
    }

    /// All candidates on one side of `from`, in the order in which they are met.
    fn side(&self, mut from: usize, way: Way) -> Vec<Judged> {
        let mut out: Vec<Judged> = Vec::new();
        loop {
            let mut judged = self.onward(from, way);
            let met = match judged.iter().position(|j| j.rest) {
                Some(next) => next + 1,
                // Nothing beyond comes to rest: does drift explain that?
                None => {
                    let drifted = judged.first().is_some_and(|j| {
                        norm(&j.velocity) <= DRIFT_MPS2 * self.seconds_to(from, &j.span, way)
                    });
                    if !drifted {
                        out.append(&mut judged);
                        return out;
                    }
                    if let Some(first) = judged.first_mut() {
                        (first.rest, first.overruled) = (true, true);
                    }
                    1
                }
            };
            out.extend(judged.into_iter().take(met));
            from = match way {
                Way::Forwards => from + met,
                Way::Backwards => from - met,
            };
        }
    }

    /// Where a leg from the candidate `from` begins, and where it meets `span`.
    fn edges(&self, from: usize, span: &Range<usize>, way: Way) -> (usize, usize) {
        let own = &self.candidates[from];
        match way {
            Way::Forwards => (own.end - 1, span.start),
            Way::Backwards => (own.start, span.end - 1),
        }
    }

    fn seconds_to(&self, from: usize, span: &Range<usize>, way: Way) -> f64 {
        let (near, far) = self.edges(from, span, way);
        let t_s = self.setup.view.t_s();
        (t_s[far] - t_s[near]).abs()
    }

    /// The leg that departs from the candidate `k`.
    fn leg(&self, k: usize, way: Way) -> Leg<'_> {
        let own = &self.candidates[k];
        let (side, near, far) = match way {
            Way::Forwards => (Side::Last, own.end - 1, self.setup.view.samples.len() - 1),
            Way::Backwards => (Side::First, own.start, 0),
        };
        let anchors = Anchors::new(self.setup.view, self.setup.walk);
        let start = anchors.at(self.candidates, k, side);
        self.setup
            .leg(near, far, start, None, level(start.force, 0.0))
    }

    /// From the rest `from` on through all candidates beyond it, up to the first
    /// that is a rest.
    fn onward(&self, from: usize, way: Way) -> Vec<Judged> {
        let leg = self.leg(from, way);
        let noise = self.setup.noise(&leg);
        let mut nominal = Forward::new(&leg, Direction::NONE);
        // Most rests are so near to zero that noise alone allows it.
        let mut changed: Vec<Forward<'_>> = Vec::new();
        let mut out = Vec::new();
        let mut next = Some(from);
        loop {
            next = match way {
                Way::Forwards => next.map(|k| k + 1),
                Way::Backwards => next.and_then(|k| k.checked_sub(1)),
            };
            let Some(span) = next.and_then(|k| self.candidates.get(k)) else {
                return out;
            };
            let (near, far) = self.edges(from, span, way);
            let count = near.abs_diff(far) + 1;
            nominal.advance_to(count);
            let velocity = nominal.propagator.velocity();
            let seconds = self.seconds_to(from, span, way);
            let (by_noise, _) = noise.open(seconds);
            let mut variance: [f64; 3] = std::array::from_fn(|i| {
                by_noise.noise[i] + by_noise.tilt[i] + FLOOR_MPS * FLOOR_MPS
            });
            let near =
                |variance: &[f64; 3]| (0..3).all(|i| velocity[i].abs() <= FAR * variance[i].sqrt());
            if !near(&variance) {
                if changed.is_empty() {
                    let directions = self.setup.directions.iter();
                    changed.extend(directions.map(|d| Forward::new(&leg, d.times(STEP))));
                }
                for one in &mut changed {
                    one.advance_to(count);
                    let other = one.propagator.velocity();
                    (0..3).for_each(|i| variance[i] += ((other[i] - velocity[i]) / STEP).powi(2));
                }
            }
            let rest = near(&variance);
            out.push(Judged {
                span: span.clone(),
                velocity,
                sigma: variance.map(f64::sqrt),
                seconds,
                rest,
                overruled: false,
            });
            if rest {
                return out;
            }
        }
    }
}
