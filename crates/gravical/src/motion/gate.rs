//! Which rests are rests: at constant speed an accelerometer feels the same.
//!
//! From one quiet stretch on the velocity is integrated with its uncertainty σ_v, up to
//! the others and some way into them. Two of them can be neighbouring rests where the
//! velocity comes back to zero, to four σ_v, at the second and stays there. Of all
//! chains of rests in which every neighbour agrees so, the one with the most and longest
//! rests is taken: what lies between is constant speed, or constant acceleration. Where
//! a stretch agrees with none after it, the next is taken all the same if a drift of the
//! acceleration explains the velocity, and that is said.
//!
//! It fails where the velocity is nowhere known: without a gyroscope a tilt between two
//! rests explains nearly all of it.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::motion::FLOOR_MPS;

pub(super) use gravical_core::motion::FAR;
use gravical_core::strapdown::level;

use super::anchors::{Anchors, Side};
use super::leg::{Forward, Leg};
use super::parameters::{Direction, STEP};
use super::setup::Setup;
use super::still::Noise;
use super::unfollowed::missed_rad;

/// A velocity that an error of the acceleration of this size explains is no
/// motion when nothing after it comes to rest, m/s².
const DRIFT_MPS2: f64 = 0.15;
/// What lies still has no velocity but this, m/s: a table gives.
pub(super) const STEADY_MPS: f64 = 0.002;
/// The velocity is looked at where a stretch begins and so long after, s: what
/// accelerates evenly is quiet, too.
const INTO_S: [f64; 5] = [0.0, 0.25, 0.5, 1.0, 2.0];
/// Beyond a stretch that agrees, so many more are compared, and those that begin within so many
/// seconds after it: later the uncertainty of the velocity excludes nothing (2.6 m/s at 4 σ, with
/// the gyroscope of an MPU6050).
const BEYOND: (usize, f64) = (4, 120.0);
/// A velocity that is a little beyond that may be a model that knows too little of a long
/// move, where the rest after it agrees: what it takes off the rest's weight, and what for
/// each σ more.
const BEYOND_FAR: [f64; 2] = [0.5, 1.0];
/// A ride on which nothing agrees ends after so many stretches and seconds.
const LONGEST_RIDE: (usize, f64) = (50, 120.0);
/// Slow starts and ends are looked for so often: each may uncover another.
const MOST_LOOKS: usize = 3;
/// What a rest counts that only a drift explains.
const OVERRULED: f64 = 1e-3;
/// A recording begins at rest more often than not.
const FIRST: f64 = 0.25;
/// What of its weight a rest keeps that agrees only because the sensor may have been
/// tilted on the way, without a gyroscope: a tilt explains any velocity, so that a chain
/// in which nothing had to be tilted is the better one even where it has fewer rests.
const BY_WOBBLE: f64 = 0.1;

/// A quiet stretch that was judged.
#[derive(Debug, Clone)]
pub(super) struct Judged {
    /// Its samples.
    pub span: Range<usize>,
    /// Velocity there, m/s, where it is furthest from zero in σ.
    pub velocity: [f64; 3],
    /// Its standard uncertainty, m/s; of a rest that noise alone explains, by noise alone.
    pub sigma: [f64; 3],
    /// Time since the rest that it was integrated from, s.
    pub seconds: f64,
    /// How many σ that is, of the axis where it is most.
    sigmas: f64,
    /// Taken for a rest.
    pub rest: bool,
    /// … although the velocity is too far from zero.
    pub overruled: bool,
    /// It agrees only if the sensor was tilted on the way, of which no gyroscope tells.
    by_wobble: bool,
}

/// Judges the candidates of one piece; `noise` is that of the accelerometer at rest.
///
/// A velocity that nothing explains may have come slowly, before or after what was
/// noticed: where the force of the rest at either end steps late or early, and the
/// neighbours agree without that part, it is none of the rest.
pub(super) fn judge(
    setup: &Setup<'_>,
    candidates: &[Range<usize>],
    noise: Option<&Noise>,
) -> Vec<Judged> {
    let chain = |candidates: &[Range<usize>]| {
        Gate {
            setup,
            candidates,
            floors: candidates
                .iter()
                .map(|span| floor(setup, span, noise))
                .collect(),
        }
        .chain()
    };
    let unexplained = |all: &[Judged]| unexplained(all).len();
    let mut judged = chain(candidates);
    let Some(noise) = noise else { return judged };
    for _ in 0..MOST_LOOKS {
        if unexplained(&judged) == 0 {
            break;
        }
        let again = chain(&without_slow_ends(setup, &judged, noise));
        if unexplained(&again) >= unexplained(&judged) {
            break;
        }
        judged = again;
    }
    judged
}

/// Neighbours of which nothing says how both can be rests: those that only a drift
/// explains, and what is quiet beyond the first rest and the last.
fn unexplained(judged: &[Judged]) -> Vec<(usize, usize)> {
    let mut out = Vec::new();
    let mut before: Option<usize> = None;
    for (k, one) in judged.iter().enumerate() {
        match before {
            Some(before) if one.overruled => out.push((before, k)),
            None if one.rest && k > 0 => out.push((k - 1, k)),
            _ => {}
        }
        if one.rest {
            before = Some(k);
        }
    }
    out.extend(before.filter(|k| k + 1 < judged.len()).map(|k| (k, k + 1)));
    out
}

/// χ² with three degrees of freedom by which the force has to step: 5 σ.
const STEP_CHI2: f64 = 25.0;
/// So much of a rest is looked at for a slow start or end of a move, s …
const SLOW_S: f64 = 20.0;
/// … and so much stays of it, s.
const LEFT_S: f64 = 0.5;

/// The stretches, those at either end of a velocity that nothing explains without what
/// comes after the step in their force, or before it.
fn without_slow_ends(setup: &Setup<'_>, judged: &[Judged], noise: &Noise) -> Vec<Range<usize>> {
    let mut spans: Vec<Range<usize>> = judged.iter().map(|j| j.span.clone()).collect();
    for (before, k) in unexplained(judged) {
        let late = step_of_force(setup, &judged[before].span, noise, false);
        let early = step_of_force(setup, &judged[k].span, noise, true);
        let gain = |of: Option<(f64, usize)>| of.map_or(0.0, |(gain, _)| gain);
        match (late, early) {
            // Its start may have been cut already, further on than that.
            (Some((_, at)), _) if gain(late) >= gain(early) && at > spans[before].start => {
                spans[before].end = at;
            }
            (_, Some((_, at))) => spans[k].start = at,
            _ => {}
        }
    }
    spans
}

/// Where the mean force of a stretch steps most, in its last seconds or its first ones,
/// and by which χ²; none where it steps by less than noise may.
fn step_of_force(
    setup: &Setup<'_>,
    span: &Range<usize>,
    noise: &Noise,
    early: bool,
) -> Option<(f64, usize)> {
    let samples = setup.view.samples;
    let t = &samples.t_s[span.clone()];
    let (first, last) = (*t.first()?, *t.last()?);
    let (from, to) = if early {
        (0, t.partition_point(|t| *t < first + 2.0 * SLOW_S))
    } else {
        (t.partition_point(|t| *t < last - 2.0 * SLOW_S), t.len())
    };
    let count = (to - from) as f64;
    let inside = |k: usize| {
        let at = t[from + k];
        let (done, left) = (at - t[from], t[to - 1] - at);
        let (part, rest) = if early { (done, left) } else { (left, done) };
        part <= SLOW_S && rest >= LEFT_S
    };
    let mut gains = vec![0.0; to - from];
    for (channel, sigma) in samples.force_mps2.iter().zip(noise.sigma) {
        let values = &channel[span.start + from..span.start + to];
        let centre = values.iter().sum::<f64>() / count;
        let mut sum = 0.0;
        for (k, gain) in gains.iter_mut().enumerate() {
            // Samples before k against the others.
            let n = k as f64;
            if k > 0 {
                *gain += sum * sum * count / (n * (count - n)) / (sigma * sigma * noise.vif);
            }
            sum += values[k] - centre;
        }
    }
    let best = (1..gains.len())
        .filter(|k| inside(*k))
        .max_by(|a, b| gains[*a].total_cmp(&gains[*b]))?;
    (gains[best] > STEP_CHI2).then(|| (gains[best], span.start + from + best))
}

/// Velocity that a rest may have, m/s: more in a hand than on a table, as its noise is.
fn floor(setup: &Setup<'_>, span: &Range<usize>, noise: Option<&Noise>) -> f64 {
    let Some(noise) = noise else {
        return FLOOR_MPS;
    };
    let (mut own, mut usual) = (0.0, 0.0);
    for (channel, sigma) in setup.view.samples.force_mps2.iter().zip(noise.sigma) {
        own += crate::stats::standard_deviation(&channel[span.clone()]).powi(2);
        usual += sigma * sigma;
    }
    let density = setup.walk.accel_mean();
    let more = density.sqrt() * (own / usual - 1.0).max(0.0).sqrt();
    more.clamp(STEADY_MPS, FLOOR_MPS)
}

struct Gate<'a> {
    setup: &'a Setup<'a>,
    candidates: &'a [Range<usize>],
    floors: Vec<f64>,
}

/// The best chain that ends with a candidate.
#[derive(Clone, Copy)]
struct Best {
    /// What its rests count together, and what those of them that need no tilt do.
    weight: f64,
    sure: f64,
    before: Option<usize>,
    overruled: bool,
}

impl Gate<'_> {
    /// What a rest counts: how many agree says more than how long one is, since constant
    /// speed may last.
    fn weight(&self, k: usize) -> f64 {
        let t_s = self.setup.view.t_s();
        let span = &self.candidates[k];
        let seconds = t_s[span.end - 1] - t_s[span.start];
        let first = if k == 0 { FIRST } else { 0.0 };
        1.0 + 0.5 * seconds.min(2.0) + 1e-3 * seconds + first
    }

    fn chain(&self) -> Vec<Judged> {
        let count = self.candidates.len();
        let alone = |k| Best {
            weight: self.weight(k),
            sure: self.weight(k),
            before: None,
            overruled: false,
        };
        let mut best: Vec<Best> = (0..count).map(alone).collect();
        let mut seen: Vec<Vec<Judged>> = Vec::with_capacity(count);
        for k in 0..count {
            let judged = self.onward(k);
            let agrees = judged.iter().any(|j| j.rest);
            for (step, one) in judged.iter().enumerate() {
                let next = k + 1 + step;
                let far = one.sigmas > FAR;
                let less = BEYOND_FAR[0] + BEYOND_FAR[1] * (one.sigmas - FAR);
                let drifts = !agrees && step == 0 && one.overruled;
                let own = match far {
                    false => self.weight(next),
                    true if self.weight(next) > less => self.weight(next) - less,
                    true if drifts => OVERRULED,
                    true => continue,
                };
                // A rest that needs no tilt gains nothing by others that need one.
                let (weight, sure) = match one.by_wobble && !far {
                    true => (best[k].weight + BY_WOBBLE * own, best[k].sure),
                    false => (best[k].sure + own, best[k].sure + own),
                };
                if weight > best[next].weight {
                    best[next] = Best {
                        weight,
                        sure,
                        before: Some(k),
                        overruled: far,
                    };
                }
            }
            seen.push(judged);
        }
        let last = (0..count).max_by(|&a, &b| best[a].weight.total_cmp(&best[b].weight));
        let Some(last) = last else {
            return Vec::new();
        };
        let mut rests: Vec<usize> =
            std::iter::successors(Some(last), |&k| best[k].before).collect();
        rests.reverse();
        self.verdicts(&rests, &best, seen)
    }

    /// All candidates in order, those of `rests` being rests.
    fn verdicts(&self, rests: &[usize], best: &[Best], seen: Vec<Vec<Judged>>) -> Vec<Judged> {
        let mut out: Vec<Judged> = Vec::with_capacity(self.candidates.len());
        let itself = |k: usize| Judged {
            span: self.candidates[k].clone(),
            velocity: [0.0; 3],
            sigma: [self.floors[k]; 3],
            seconds: 0.0,
            sigmas: 0.0,
            rest: true,
            overruled: false,
            by_wobble: false,
        };
        let first = rests.first().copied().unwrap_or(0);
        for k in 0..first {
            // The recording begins in motion: seen from there the rest moves.
            let towards = seen[k].get(first - k - 1).cloned();
            let mut one = towards.unwrap_or_else(|| itself(k));
            one.velocity = one.velocity.map(|v| -v);
            one.span = self.candidates[k].clone();
            (one.rest, one.overruled) = (false, false);
            out.push(one);
        }
        for (n, &k) in rests.iter().enumerate() {
            if n == 0 {
                out.push(itself(k));
            }
            let next = rests.get(n + 1).copied().unwrap_or(self.candidates.len());
            for j in k + 1..=next.min(self.candidates.len() - 1) {
                let mut one = seen[k].get(j - k - 1).cloned().unwrap_or_else(|| itself(j));
                one.rest = j == next;
                one.overruled = one.rest && best[j].overruled;
                out.push(one);
            }
        }
        out
    }

    /// From the rest `from` on through the candidates after it, until one agrees and
    /// some more. Of those that do not, `overruled` says whether a drift explains the
    /// velocity.
    fn onward(&self, from: usize) -> Vec<Judged> {
        let setup = self.setup;
        if setup.is_stopped() {
            return Vec::new();
        }
        let t_s = setup.view.t_s();
        let own = &self.candidates[from];
        let near = own.end - 1;
        let anchors = Anchors::new(setup.view, setup.walk);
        let start = anchors.at(self.candidates, from, Side::Last);
        let far = setup.view.samples.len() - 1;
        let leg = setup.leg(near, far, start, None, level(start.force, 0.0));
        // Of the rest alone: what is missed on the way comes with each hop.
        let alone = Leg {
            far: near,
            ..leg.clone()
        };
        let mut noise = setup.noise(&alone);
        // Turn that was missed so far, rad, and the sample up to which.
        let (mut missed, mut told) = (0.0, near);
        let wobble = noise.open.tilt_change * noise.open.gravity.powi(2);
        let mut nominal = Forward::new(&leg, Direction::NONE);
        // Most rests are so near to zero that noise alone allows it.
        let mut changed: Vec<Forward<'_>> = Vec::new();
        let mut out: Vec<Judged> = Vec::new();
        let mut agreed: Option<usize> = None;
        for next in from + 1..self.candidates.len() {
            let span = &self.candidates[next];
            let (more, beyond_s) = BEYOND;
            if agreed.is_some_and(|first| {
                let agreed_s = t_s[self.candidates[first].start];
                next > first + more || t_s[span.start] - agreed_s > beyond_s
            }) {
                break;
            }
            let (most, longest_s) = LONGEST_RIDE;
            if out.len() >= most && t_s[span.start] - t_s[near] > longest_s {
                break;
            }
            let floor = self.floors[next].hypot(self.floors[from]);
            let mut judged = Judged {
                span: span.clone(),
                velocity: [0.0; 3],
                sigma: [floor; 3],
                seconds: t_s[span.start] - t_s[near],
                sigmas: 0.0,
                rest: true,
                overruled: false,
                by_wobble: false,
            };
            let mut worst = -1.0;
            let mut done = 0;
            for into_s in INTO_S {
                let inside = &t_s[span.clone()];
                let at = inside.partition_point(|t| t - inside[0] <= into_s).max(1) - 1;
                if at < done {
                    continue;
                }
                done = at + 1;
                let count = span.start + at - near + 1;
                nominal.advance_to(count);
                let velocity = nominal.propagator.velocity();
                let here = span.start + at + 1;
                missed += missed_rad(setup.view.samples, told..here);
                told = here;
                noise.open.gyro = setup.tilt_density(missed, inside[at] - t_s[near]);
                let (by_noise, _) = noise.open(inside[at] - t_s[near]);
                let mut variance: [f64; 3] =
                    std::array::from_fn(|i| by_noise.noise[i] + by_noise.tilt[i] + floor * floor);
                let off = |variance: &[f64; 3]| {
                    let each = (0..3).map(|i| velocity[i].abs() / variance[i].sqrt());
                    each.fold(0.0, f64::max)
                };
                // A tilt on the way explains what is horizontal, and nothing upright.
                let tilted = wobble * (inside[at] - t_s[near]).powi(2);
                let untilted = |variance: &[f64; 3]| {
                    let [x, y, z] = *variance;
                    off(&[x - tilted, y - tilted, z]) > FAR
                };
                if untilted(&variance) {
                    if changed.is_empty() {
                        let directions = setup.directions.iter();
                        changed.extend(directions.map(|d| Forward::new(&leg, d.times(STEP))));
                    }
                    for one in &mut changed {
                        one.advance_to(count);
                        let other = one.propagator.velocity();
                        (0..3)
                            .for_each(|i| variance[i] += ((other[i] - velocity[i]) / STEP).powi(2));
                    }
                }
                judged.by_wobble |= untilted(&variance);
                if off(&variance) > worst {
                    worst = off(&variance);
                    judged.velocity = velocity;
                    judged.sigma = variance.map(f64::sqrt);
                }
            }
            judged.sigmas = worst;
            judged.rest = worst <= FAR;
            judged.overruled =
                !judged.rest && norm(&judged.velocity) <= DRIFT_MPS2 * judged.seconds;
            if judged.rest && !judged.by_wobble && agreed.is_none() {
                agreed = Some(next);
            }
            out.push(judged);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::motion::anchors::RandomWalk;
    use crate::motion::hidden::Hidden;
    use crate::motion::options::GravityRemoval;
    use crate::motion::samples::{Samples, View};

    /// 100 Hz for 200 s: swings to and fro about y for 2 s from each of `starts` on, 2.5 rad/s
    /// of which the gyroscope tells 2.4; at rest before, between and after them.
    fn judged(starts: &[usize]) -> Vec<Judged> {
        const N: usize = 20_000;
        let (most, end) = (2.5, 2.4);
        let since = |i: usize| {
            starts
                .iter()
                .find(|s| (**s..**s + 200).contains(&i))
                .map(|s| i - s)
        };
        let phase = |i: usize| since(i).map_or(0.0, |k| PI * 0.01 * k as f64);
        let rate = |i: usize| most * phase(i).sin();
        let angle = |i: usize| most / PI * (1.0 - phase(i).cos());
        let samples = Samples {
            t_s: (0..N).map(|i| 0.01 * i as f64).collect(),
            force_mps2: [
                (0..N).map(|i| -9.81 * angle(i).sin()).collect(),
                vec![0.0; N],
                (0..N).map(|i| 9.81 * angle(i).cos()).collect(),
            ],
            rate_rad_s: Some([
                vec![0.0; N],
                (0..N).map(|i| rate(i).clamp(-end, end)).collect(),
                vec![0.0; N],
            ]),
            clipped: (0..N).filter(|i| rate(*i).abs() >= end).collect(),
            ..Samples::default()
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
        let mut rests = Vec::new();
        let mut from = 0;
        for start in starts {
            rests.push(from..*start);
            from = start + 201;
        }
        rests.push(from..N);
        judge(&setup, &rests, None)
    }

    #[test]
    fn a_hop_allows_for_the_turn_that_it_missed_itself() {
        // However long it rests afterwards.
        let one = judged(&[500]);
        assert!(norm(&one[1].velocity) > 0.1, "{:?}", one[1]);
        assert!(one[1].rest && !one[1].overruled, "{:?}", one[1]);
        // A third of g φ T at the least, and no more for what swings later.
        assert!(one[1].sigma[0] > norm(&one[1].velocity) / 3.0);
        let many = judged(&[500, 5000, 6000, 7000, 8000, 9000]);
        assert_eq!(many[1].sigma, one[1].sigma);
        assert!(many.iter().all(|j| j.rest && !j.overruled));
    }
}
