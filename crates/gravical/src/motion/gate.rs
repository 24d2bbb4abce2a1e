//! Which rests are rests: at constant speed an accelerometer feels the same.
//!
//! From one rest on the velocity is integrated with its uncertainty σ_v, forwards
//! and backwards: a recording may begin at constant speed. Where the velocity is more than four σ_v from zero, the sensor does not
//! stand still, however quiet it is.

use std::ops::Range;

use gravical_core::integrate::Trapezoid;
use gravical_core::matrix3::{add, norm, sub};
use gravical_core::strapdown::{Strapdown, rotate};

use super::leg::{Anchor, Leg, Removal};
use super::parameters::Direction;
use super::samples::Samples;

/// Standard deviations from zero that a velocity at rest may have.
const FAR: f64 = 4.0;

/// No velocity is known better than this, m/s: feet and hands are not quite still
/// where they rest.
const FLOOR_MPS: f64 = 0.01;

/// A velocity that an error of the acceleration of this size explains is no
/// motion when nothing after it comes to rest, m/s².
const DRIFT_MPS2: f64 = 0.15;

/// Step of the parameters, in standard deviations.
const STEP: f64 = 1e-3;

/// A quiet stretch that was judged.
#[derive(Debug, Clone)]
pub(super) struct Judged {
    /// Its samples.
    pub span: Range<usize>,
    /// Velocity there, m/s.
    pub velocity: [f64; 3],
    /// Its standard uncertainty, m/s.
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
pub(super) enum Way {
    Forwards,
    Backwards,
}

/// What the gate needs of a leg from a rest on.
pub(super) trait Departure {
    /// The leg that departs from the rest `k` of `rests`.
    fn leg(&self, rests: &[Range<usize>], k: usize, way: Way) -> Leg<'_>;
    /// Variance of the velocity `tau` seconds after it, by noise alone.
    fn variance(&self, leg: &Leg<'_>, tau: f64) -> [f64; 3];
}

/// Judges the candidates of one piece. One of them has to be believed: the first,
/// or the longest where that makes more of them rests (then the longer time).
pub(super) fn judge(
    samples: &Samples,
    candidates: &[Range<usize>],
    directions: &[Direction],
    departure: &impl Departure,
) -> Vec<Judged> {
    let seconds = |r: &Range<usize>| samples.t_s[r.end - 1] - samples.t_s[r.start];
    let longest = (0..candidates.len())
        .max_by(|&a, &b| seconds(&candidates[a]).total_cmp(&seconds(&candidates[b])));
    let Some(longest) = longest else {
        return Vec::new();
    };
    let gate = Gate {
        samples,
        candidates,
        directions,
        departure,
    };
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

struct Gate<'a, D> {
    samples: &'a Samples,
    candidates: &'a [Range<usize>],
    directions: &'a [Direction],
    departure: &'a D,
}

impl<D: Departure> Gate<'_, D> {
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
        (self.samples.t_s[far] - self.samples.t_s[near]).abs()
    }

    /// From the rest `from` on through all candidates beyond it, up to the first
    /// that is a rest.
    fn onward(&self, from: usize, way: Way) -> Vec<Judged> {
        let leg = self.departure.leg(self.candidates, from, way);
        let mut nominal = Runner::new(&leg, &Direction::NONE);
        let changes: Vec<Direction> = self.directions.iter().map(|d| d.times(STEP)).collect();
        let mut changed: Vec<Runner> = changes.iter().map(|c| Runner::new(&leg, c)).collect();
        let mut at = leg.near;
        let mut started = false;
        let mut out = Vec::new();
        let beyond: Vec<usize> = match way {
            Way::Forwards => (from + 1..self.candidates.len()).collect(),
            Way::Backwards => (0..from).rev().collect(),
        };
        for k in beyond {
            let span = &self.candidates[k];
            let (_, far) = self.edges(from, span, way);
            // Stretch by stretch, so that the samples stay in the cache.
            while at != far || !started {
                let left = at.abs_diff(far);
                let stretch = left.min(4096);
                let to = if far >= at {
                    at + stretch
                } else {
                    at - stretch
                };
                let order = |k: usize| if far >= at { at + k } else { at - k };
                let skip = usize::from(started);
                let samples = self.samples;
                let advance = |runner: &mut Runner, change: &Direction| {
                    (skip..=stretch).for_each(|k| runner.advance(samples, order(k), change));
                };
                advance(&mut nominal, &Direction::NONE);
                for (runner, change) in changed.iter_mut().zip(&changes) {
                    advance(runner, change);
                }
                (at, started) = (to, true);
            }
            let judged = self.compare(&leg, &nominal, &changed, span, far);
            let rest = judged.rest;
            out.push(judged);
            if rest {
                break;
            }
        }
        out
    }

    fn compare(
        &self,
        leg: &Leg<'_>,
        nominal: &Runner,
        changed: &[Runner],
        span: &Range<usize>,
        far: usize,
    ) -> Judged {
        let tau = (self.samples.t_s[far] - self.samples.t_s[leg.near]).abs();
        let velocity = nominal.way.velocity();
        let noise = self.departure.variance(leg, tau);
        let sigma: [f64; 3] = std::array::from_fn(|i| {
            let parameters: f64 = changed
                .iter()
                .map(|r| ((r.way.velocity()[i] - velocity[i]) / STEP).powi(2))
                .sum();
            (noise[i] + parameters + FLOOR_MPS * FLOOR_MPS).sqrt()
        });
        Judged {
            span: span.clone(),
            velocity,
            sigma,
            seconds: tau,
            rest: (0..3).all(|i| velocity[i].abs() <= FAR * sigma[i]),
            overruled: false,
        }
    }
}

/// Velocity from a rest on, one way in time.
struct Runner {
    strapdown: Option<Strapdown<f64>>,
    attitude: [f64; 4],
    bias: [f64; 3],
    down: [f64; 3],
    way: Trapezoid<f64>,
    before_s: f64,
}

impl Runner {
    fn new(leg: &Leg<'_>, change: &Direction) -> Self {
        let Anchor { force, bias, .. } = leg.start;
        let force = add(&force, &change.force(&force));
        let attitude = leg.levelled(&force);
        Runner {
            strapdown: matches!(leg.removal, Removal::Strapdown).then(|| Strapdown::new(attitude)),
            attitude,
            bias: add(&bias, &change.rate(&bias)),
            down: match leg.removal {
                Removal::Mean(mean) => add(&mean, &change.force(&mean)),
                _ => [0.0, 0.0, norm(&force)],
            },
            way: Trapezoid::new(leg.v0, [0.0; 3]),
            before_s: leg.samples.t_s[leg.near],
        }
    }

    #[inline]
    fn advance(&mut self, samples: &Samples, i: usize, change: &Direction) {
        let h = samples.t_s[i] - self.before_s;
        self.before_s = samples.t_s[i];
        if let Some(strapdown) = &mut self.strapdown {
            let w = samples.rate_at(i);
            let w = add(&w, &change.rate(&w));
            self.attitude = strapdown.update(sub(&w, &self.bias), h);
        }
        let f = samples.force_at(i);
        let f = add(&f, &change.force(&f));
        self.way
            .update(sub(&rotate(&self.attitude, &f), &self.down), h);
    }
}
