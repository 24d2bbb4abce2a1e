//! Rests that are one after all, and candidates that are none.
//!
//! A knock or a hand that trembles ends a rest for a moment, and the test finds
//! it. And in a slow move there are seconds of nearly constant acceleration,
//! which look like rest by themselves. What the rests around them read tells:
//! force at rest is gravity, and it changes only with the attitude.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::still::Plan;

use super::levels::{Coarse, Levels};
use super::view::mean_of;
use crate::motion::samples::Samples;

/// χ² with 3 degrees of freedom at 1 − 10⁻⁷: beyond it one of two rests is none.
const CONTRADICTION: f64 = 35.405_751_58;
/// At 1 − 10⁻³: up to it two rests are one.
const AGREEMENT: f64 = 16.266_236_20;
/// Further apart, s, two rests say nothing about each other.
const FARTHEST_S: f64 = 10.0;
/// Rests to go to find a long one.
const MOST_STEPS: usize = 20;
/// A break that moves the sensor, or leaves it with a speed, by less than so many
/// standard deviations is none.
const PUSH: f64 = 4.0;
/// Nor one that turns it by less than this angle, rad (1°).
const KNOCK_TURN_RAD: f64 = 0.017;
/// Longest break that can be none, s.
const LONGEST_KNOCK_S: f64 = 3.0;

/// What is known of a piece.
pub(super) struct Context<'a> {
    pub samples: &'a Samples,
    pub levels: &'a Levels,
    pub plan: &'a Plan,
}

impl Context<'_> {
    /// Joins and removes; `rests` are those of one piece, in order.
    pub(super) fn merge(
        &self,
        rests: Vec<Range<usize>>,
        piece: &Range<usize>,
    ) -> Vec<Range<usize>> {
        let joined = self.join_knocks(rests);
        let all = self.with_coarse(joined, piece);
        self.without_accelerated(all)
    }

    fn join_knocks(&self, rests: Vec<Range<usize>>) -> Vec<Range<usize>> {
        let mut out: Vec<Range<usize>> = Vec::new();
        for rest in rests {
            if let Some(last) = out.last_mut()
                && self.is_knock(last, &rest)
            {
                last.end = rest.end;
                continue;
            }
            out.push(rest);
        }
        out
    }

    /// True when nothing happened between two rests but a knock.
    fn is_knock(&self, before: &Range<usize>, after: &Range<usize>) -> bool {
        let t = &self.samples.t_s;
        let length_s = t[after.start] - t[before.end - 1];
        if length_s > LONGEST_KNOCK_S
            || self.turned_rad(before, after) > KNOCK_TURN_RAD
            || self.difference(before, after) > AGREEMENT
        {
            return false;
        }
        let (moved_m, speed_mps, greatest) = self.moved(before, after);
        let density = self.density(before);
        // What noise makes of way and speed, and what a blow of which samples show a
        // part may: it is off by half a step where it begins and ends.
        let noise = (density * length_s * (1.0 + length_s)).sqrt();
        let blow = greatest * self.step_s();
        speed_mps <= PUSH * noise + blow
            && moved_m <= length_s * (PUSH * noise / 12.0_f64.sqrt() + 0.5 * blow)
    }

    /// N², the axes together, m²/s³.
    fn density(&self, rest: &Range<usize>) -> f64 {
        let variance = &self.level(rest).noise.mean_variance[0];
        variance[..3].iter().sum::<f64>() * self.step_s()
    }

    pub(super) fn step_s(&self) -> f64 {
        Plan::BLOCK_S / self.plan.block as f64
    }

    /// How far the sensor went between two rests, m: twice integrated, with the
    /// velocity zero at both ends; the velocity that was not zero, m/s; and the greatest
    /// acceleration, m/s².
    fn moved(&self, before: &Range<usize>, after: &Range<usize>) -> (f64, f64, f64) {
        let near = Plan::SEED_BLOCKS * self.plan.block;
        let a = mean_of(
            self.samples,
            before.end - near.min(before.len())..before.end,
        );
        let b = mean_of(
            self.samples,
            after.start..after.start + near.min(after.len()),
        );
        let (from, to) = (before.end - 1, after.start);
        let t = &self.samples.t_s;
        let whole = t[to] - t[from];
        if whole <= 0.0 {
            return (0.0, 0.0, 0.0);
        }
        let mut velocity = [0.0; 3];
        let mut way = [0.0; 3];
        let mut last = [0.0; 3];
        let mut greatest = 0.0_f64;
        for i in from..=to {
            let share = (t[i] - t[from]) / whole;
            let force = self.samples.force_at(i);
            let h = if i > from { t[i] - t[i - 1] } else { 0.0 };
            for c in 0..3 {
                let off = force[c] - a[c] - share * (b[c] - a[c]);
                let next = velocity[c] + 0.5 * h * (off + last[c]);
                way[c] += 0.5 * h * (velocity[c] + next);
                velocity[c] = next;
                last[c] = off;
            }
            greatest = greatest.max(norm(&last));
        }
        let moved: [f64; 3] = std::array::from_fn(|c| way[c] - 0.5 * whole * velocity[c]);
        (norm(&moved), norm(&velocity), greatest)
    }

    pub(super) fn level(&self, rest: &Range<usize>) -> &Coarse {
        self.levels.nearest(rest)
    }

    /// Takes out candidates whose force is not gravity by the longer rests on both
    /// sides of them, the shortest first. By one side alone nobody knows which of
    /// the two accelerates: the rest after a lift has stopped is shorter than the
    /// braking. Without a gyroscope a turn explains everything.
    fn without_accelerated(&self, rests: Vec<Range<usize>>) -> Vec<Range<usize>> {
        let count = rests.len();
        let mut before: Vec<Option<usize>> = (0..count).map(|i| i.checked_sub(1)).collect();
        let mut after: Vec<Option<usize>> = (0..count)
            .map(|i| (i + 1 < count).then_some(i + 1))
            .collect();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|&i| rests[i].len());
        let mut kept = vec![true; count];
        for i in order {
            let rest = &rests[i];
            let contradicted = self
                .witnesses(&rests, &before, i)
                .any(|k| self.contradict(&rests[k], rest))
                && self
                    .witnesses(&rests, &after, i)
                    .any(|k| self.contradict(rest, &rests[k]));
            if contradicted {
                kept[i] = false;
                if let Some(k) = before[i] {
                    after[k] = after[i];
                }
                if let Some(k) = after[i] {
                    before[k] = before[i];
                }
            }
        }
        let mut kept = kept.into_iter();
        rests
            .into_iter()
            .filter(|_| kept.next().unwrap_or(false))
            .collect()
    }

    /// The next rest on one side, and the next one that is long: two stretches of
    /// one acceleration agree with each other.
    fn witnesses<'b>(
        &'b self,
        rests: &'b [Range<usize>],
        links: &'b [Option<usize>],
        i: usize,
    ) -> impl Iterator<Item = usize> + 'b {
        let long = Plan::LEAST_REFERENCE * self.plan.block;
        let next = links[i];
        let farther = std::iter::successors(next, |&k| links[k])
            .take(MOST_STEPS)
            .find(|&k| rests[k].len() >= long);
        next.into_iter().chain(farther.filter(|k| Some(*k) != next))
    }

    fn contradict(&self, before: &Range<usize>, after: &Range<usize>) -> bool {
        let t = &self.samples.t_s;
        let apart_s = t[after.start] - t[before.end - 1];
        self.samples.rate_rad_s.is_some()
            && apart_s <= FARTHEST_S
            && !(self.level(before).held || self.level(after).held)
            && self.difference(before, after) > CONTRADICTION
    }

    /// A rest that is held in a hand, or too short for a reference, is as long as it
    /// is quiet: the test of a sensor that lies still does not fit it. One in which
    /// no five blocks agree is recognised by being quiet alone. Where the piece begins or
    /// ends no slow move is taken for quiet: as far as there a short rest is believed.
    fn with_coarse(&self, rests: Vec<Range<usize>>, piece: &Range<usize>) -> Vec<Range<usize>> {
        let coarse = &self.levels.rests;
        let first = coarse.partition_point(|c| c.span.start < piece.start);
        let short = Plan::SEED_BLOCKS * self.plan.block;
        let mut all = rests.clone();
        for coarse in coarse
            .iter()
            .skip(first)
            .take_while(|c| c.span.end <= piece.end)
        {
            let span = &coarse.span;
            let next = rests.partition_point(|r| r.end <= span.start);
            let alone = rests.get(next).is_none_or(|r| r.start >= span.end);
            // Else a move would begin later for what is quiet at its start.
            let same = rests.get(next).is_some_and(|r| {
                let both = r.start.max(span.start)..r.end.min(span.end);
                2 * both.len() > span.len()
            });
            if coarse.held || alone || span.len() < short && same {
                all.push(span.clone());
            } else if span.len() < Plan::LEAST_REFERENCE * self.plan.block && same {
                let found = &rests[next];
                let begins = span.start < piece.start + self.plan.block;
                let ends = span.end + self.plan.block > piece.end;
                let from = if begins { span.start } else { found.start };
                let to = if ends { span.end } else { found.end };
                all.push(from.min(found.start)..to.max(found.end));
            }
        }
        all.sort_by_key(|r| (r.start, r.end));
        let mut out: Vec<Range<usize>> = Vec::new();
        for rest in all {
            match out.last_mut() {
                Some(last) if rest.start < last.end => last.end = last.end.max(rest.end),
                _ => out.push(rest),
            }
        }
        out
    }
}
