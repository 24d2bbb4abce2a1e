//! Which rests are rests: at constant speed an accelerometer feels the same.
//!
//! From the last rest on the velocity is integrated with its uncertainty σ_v.
//! Where it is more than four of them from zero, the sensor does not stand still,
//! however quiet it is.

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
    /// Taken for a rest.
    pub rest: bool,
    /// … although the velocity is too far from zero.
    pub overruled: bool,
}

/// What the gate needs of a leg from a rest on.
pub(super) trait Departure {
    /// The leg that departs from the rest `k` of `rests`.
    fn leg(&self, rests: &[Range<usize>], k: usize) -> Leg<'_>;
    /// Variance of the velocity `tau` seconds after it, by noise alone.
    fn variance(&self, leg: &Leg<'_>, tau: f64) -> [f64; 3];
}

/// Judges the candidates of one piece; the first is a rest.
pub(super) fn judge(
    samples: &Samples,
    candidates: &[Range<usize>],
    directions: &[Direction],
    departure: &impl Departure,
) -> Vec<Judged> {
    let mut out: Vec<Judged> = Vec::new();
    let mut from = 0;
    let Some(first) = candidates.first() else {
        return out;
    };
    out.push(Judged {
        span: first.clone(),
        velocity: [0.0; 3],
        sigma: [FLOOR_MPS; 3],
        rest: true,
        overruled: false,
    });
    while from + 1 < candidates.len() {
        let leg = departure.leg(candidates, from);
        let judged = onward(samples, candidates, from, directions, &leg, departure);
        match judged.iter().position(|j| j.rest) {
            Some(next) => {
                out.extend(judged.into_iter().take(next + 1));
                from += next + 1;
            }
            None => {
                // Nothing after it comes to rest: does drift explain that?
                let mut judged = judged;
                let drifted = judged.first().is_some_and(|j| {
                    let t = samples.t_s[j.span.start] - samples.t_s[candidates[from].end - 1];
                    norm(&j.velocity) <= DRIFT_MPS2 * t.max(0.0)
                });
                if !drifted {
                    out.append(&mut judged);
                    break;
                }
                judged.truncate(1);
                for j in &mut judged {
                    (j.rest, j.overruled) = (true, true);
                }
                out.append(&mut judged);
                from += 1;
            }
        }
    }
    out
}

/// From the rest `from` on through all candidates after it, up to the first that
/// is a rest.
fn onward(
    samples: &Samples,
    candidates: &[Range<usize>],
    from: usize,
    directions: &[Direction],
    leg: &Leg<'_>,
    departure: &impl Departure,
) -> Vec<Judged> {
    let mut nominal = Runner::new(leg, &Direction::NONE);
    let changes: Vec<Direction> = directions.iter().map(|d| d.times(STEP)).collect();
    let mut changed: Vec<Runner> = changes.iter().map(|c| Runner::new(leg, c)).collect();
    let near = candidates[from].end - 1;
    let mut at = near;
    let mut out = Vec::new();
    for span in &candidates[from + 1..] {
        // Stretch by stretch, so that the samples stay in the cache.
        while at <= span.start {
            let to = (at + 4096).min(span.start + 1);
            nominal.advance(samples, at..to, &Direction::NONE);
            for (runner, change) in changed.iter_mut().zip(&changes) {
                runner.advance(samples, at..to, change);
            }
            at = to;
        }
        let tau = samples.t_s[span.start] - samples.t_s[near];
        let velocity = nominal.way.velocity();
        let noise = departure.variance(leg, tau);
        let sigma: [f64; 3] = std::array::from_fn(|i| {
            let parameters: f64 = changed
                .iter()
                .map(|r| ((r.way.velocity()[i] - velocity[i]) / STEP).powi(2))
                .sum();
            (noise[i] + parameters + FLOOR_MPS * FLOOR_MPS).sqrt()
        });
        let rest = (0..3).all(|i| velocity[i].abs() <= FAR * sigma[i]);
        out.push(Judged {
            span: span.clone(),
            velocity,
            sigma,
            rest,
            overruled: false,
        });
        if rest {
            break;
        }
    }
    out
}

/// Velocity from a rest on, forwards only.
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

    fn advance(&mut self, samples: &Samples, rows: Range<usize>, change: &Direction) {
        for i in rows {
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
}
