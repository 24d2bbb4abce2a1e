//! Moves so slow that their acceleration hides in the noise of a second.
//!
//! 0.7 m in 12 s never exceed 3 mg. A test of neighbouring seconds loses such a move
//! in parts, for in the middle of each half the acceleration is constant. The whole of
//! it shows well: it speeds up and brakes, and afterwards force and tilt are what they
//! were. So every stretch between two rests is held against the shape of a move, over
//! 1.25 to 20 s, beside a bias that drifts evenly (`fit`).
//!
//! Without a gyroscope a tilt that comes and goes is the same, so nothing is looked
//! for.

mod blocks;
mod fit;

use std::ops::Range;

use gravical_core::still::Plan;

use super::levels::Levels;
use super::noise::beyond_chance;
use crate::motion::samples::Samples;
use blocks::Blocks;
use fit::{Fit, fit};

/// χ² with 3 degrees of freedom at 1 − 10⁻⁷/3, as for the windows of a second.
const SEEN: f64 = 37.661_609_22;
/// At 1 − 10⁻⁵: that much is reported.
const DOUBTED: f64 = 25.901_749_75;
/// Durations, s: each a quarter longer than the one before.
const DURATIONS_S: [f64; 13] = [
    1.25, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.3, 8.0, 10.0, 12.5, 16.0, 20.0,
];
/// A move starts anywhere, to this share of its duration …
const STRIDE: f64 = 1.0 / 16.0;
/// … and to what means of 0.2 s tell, s.
const LEAST_STRIDE_S: f64 = 0.2;
/// Windows that tell how much more than noise a recording at rest has.
const FEWEST: usize = 8;

/// Something that may have been a slow move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowMove {
    /// When it began, s.
    pub start_s: f64,
    /// When it ended, s.
    pub end_s: f64,
    /// How far it went, by the shape that fits best, m.
    pub distance_m: f64,
    /// How far it stands out from the noise, as a χ² with three degrees of freedom.
    pub chi2: f64,
}

/// Takes slow moves out of `rests`, which are those of `piece`, and returns what is
/// not certain enough for that.
pub(super) fn take_out(
    samples: &Samples,
    levels: &Levels,
    plan: &Plan,
    piece: &Range<usize>,
    rests: &mut Vec<Range<usize>>,
) -> Vec<SlowMove> {
    if samples.rate_rad_s.is_none() || rests.is_empty() {
        return Vec::new();
    }
    let blocks = Blocks::new(samples, piece, rests, plan);
    let search = Search {
        blocks: &blocks,
        levels,
        plan,
    };
    let mut doubts = Vec::new();
    for found in search.all() {
        if found.gain > SEEN {
            let (from, to) = search.edges(&found, rests);
            remove(rests, &(from..to), Plan::SEED_BLOCKS * plan.block);
        } else {
            doubts.push(SlowMove {
                start_s: found.from_s,
                end_s: found.to_s,
                distance_m: gravical_core::matrix3::norm(&found.displacement_m),
                chi2: found.gain,
            });
        }
    }
    doubts
}

/// Standard deviations above the limit at which hardly any move is lost.
const SURELY: f64 = 2.0;
/// Of the square of a move so much is left beside a drift that fits it, with 5 s of
/// rest on either side.
const BESIDE_DRIFT: f64 = 0.8;
/// Σ of the squared acceleration of a move by 1 in unit time: 120/7; and its
/// greatest acceleration, 10/√3.
const SQUARES: f64 = 120.0 / 7.0;
const GREATEST: f64 = 5.773_503;

/// How far a move of `seconds` goes that may be taken for rest, m, with `accel` N² of
/// the accelerometer (m²/s³) and `gyro` N_g² (rad²/s); `whole` says whether moves are
/// looked for by the whole of them there.
///
/// The noise of the shape's size has the variance (N² + g² N_g² T²/12) T³/(120/7): the
/// gyroscope's noise walks to a tilt. The windows of w = T/4, 0.2 to 1 s, see a mean
/// force of √37.7·N·√(1/w + 1/5).
pub(in crate::motion) fn may_hide_m(
    seconds: f64,
    accel: f64,
    gyro: Option<f64>,
    gravity: f64,
    whole: bool,
) -> f64 {
    let far = SEEN.sqrt() + SURELY;
    let window_s = (0.25 * seconds).clamp(Plan::BLOCK_S, 1.0);
    let by_windows = far * ((1.0 / window_s + 0.2) * accel).sqrt() * seconds * seconds / GREATEST;
    let searched = gyro.filter(|_| whole && seconds >= DURATIONS_S[0]);
    searched.map_or(by_windows, |gyro| {
        let density = accel + gravity * gravity * gyro * seconds * seconds / 12.0;
        let by_whole = far * (density * seconds.powi(3) / SQUARES / BESIDE_DRIFT).sqrt();
        by_whole.min(by_windows)
    })
}

struct Search<'a> {
    blocks: &'a Blocks,
    levels: &'a Levels,
    plan: &'a Plan,
}

impl Search<'_> {
    fn fit(&self, from_s: f64, seconds: f64) -> Option<Fit> {
        fit(self.blocks, self.levels, self.plan.block, from_s, seconds)
    }

    /// The moves that stand out, none overlapping another, the clearest first.
    fn all(&self) -> Vec<Fit> {
        let mut found: Vec<Fit> = DURATIONS_S
            .iter()
            .flat_map(|seconds| self.of_duration(*seconds))
            .collect();
        found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let mut out: Vec<Fit> = Vec::new();
        for one in found {
            if out
                .iter()
                .any(|o| one.from_s < o.to_s && o.from_s < one.to_s)
            {
                continue;
            }
            out.push(self.refined(one));
        }
        out
    }

    fn of_duration(&self, seconds: f64) -> Vec<Fit> {
        let (Some(first), Some(last)) = (self.blocks.t_s.first(), self.blocks.t_s.last()) else {
            return Vec::new();
        };
        let stride = (STRIDE * seconds).max(LEAST_STRIDE_S);
        let count = ((last - first - seconds) / stride).max(0.0) as usize;
        let mut all = Vec::new();
        let mut quiet = Vec::new();
        let mut free_s = f64::NEG_INFINITY;
        let mut next = 0;
        while next <= count {
            let from_s = first + next as f64 * stride;
            next = self.behind_gap(next + 1, *first, stride, seconds);
            let Some(one) = self.fit(from_s, seconds) else {
                continue;
            };
            if from_s >= free_s && self.is_rest(from_s, from_s + seconds) {
                quiet.push(one.gain);
                free_s = from_s + seconds;
            }
            if one.gain > DOUBTED && one.is_move() && self.hides(&one) {
                all.push(one);
            }
        }
        // More than noise: the bias wanders, or the floor moves.
        if quiet.len() >= FEWEST {
            let more = beyond_chance(&mut quiet);
            all.iter_mut().for_each(|f| f.gain /= more);
            all.retain(|f| f.gain > DOUBTED);
        }
        all
    }

    /// The first place from the `k`-th on whose `seconds` hold a block: a gap may be years long, where
    /// a clock was set.
    fn behind_gap(&self, k: usize, first_s: f64, stride: f64, seconds: f64) -> usize {
        let t = &self.blocks.t_s;
        let from_s = first_s + k as f64 * stride;
        match t.get(t.partition_point(|t| *t < from_s)) {
            Some(block_s) if *block_s > from_s + seconds => {
                k.max(((block_s - seconds - first_s) / stride) as usize)
            }
            _ => k,
        }
    }

    fn inside(&self, from_s: f64, to_s: f64) -> &[bool] {
        let t = &self.blocks.t_s;
        let to = t.partition_point(|t| *t <= to_s);
        &self.blocks.rest[t.partition_point(|t| *t < from_s).min(to)..to]
    }

    fn is_rest(&self, from_s: f64, to_s: f64) -> bool {
        self.inside(from_s, to_s).iter().all(|r| *r)
    }

    /// True when a part of it was taken for rest: else it was found already.
    fn hides(&self, one: &Fit) -> bool {
        let aside = 0.2 * one.seconds();
        self.inside(one.from_s + aside, one.to_s - aside)
            .iter()
            .any(|r| *r)
    }

    /// The best start and duration near those of `coarse`.
    fn refined(&self, coarse: Fit) -> Fit {
        let scale = coarse.gain;
        let Some(start) = self.fit(coarse.from_s, coarse.seconds()) else {
            return coarse;
        };
        let mut best = start;
        for d in -4..=4 {
            for s in -4..=4 {
                let seconds = coarse.seconds() * (1.0 + 0.03 * f64::from(d));
                let middle = 0.5 * (coarse.from_s + coarse.to_s)
                    + (coarse.seconds() * STRIDE).max(LEAST_STRIDE_S) * 0.25 * f64::from(s);
                if let Some(one) = self.fit(middle - 0.5 * seconds, seconds)
                    && one.gain > best.gain
                {
                    best = one;
                }
            }
        }
        best.gain *= scale / start.gain;
        best
    }

    /// The samples that a move takes, with what was found moving about its ends. Of one in
    /// which nothing was, with the block on either side: its ends are known to no less,
    /// and what is cut off is lost.
    fn edges(&self, one: &Fit, rests: &[Range<usize>]) -> (usize, usize) {
        let t = &self.blocks.t_s;
        let wider = |by_s: f64| {
            let from = self.blocks.edges[t.partition_point(|t| *t < one.from_s - by_s)];
            let to = self.blocks.edges[t.partition_point(|t| *t <= one.to_s + by_s)];
            (from, to)
        };
        let (mut from, mut to) = wider(0.0);
        let mut seen = false;
        for pair in rests.windows(2) {
            let gap = pair[0].end..pair[1].start;
            if gap.start < to && from < gap.end {
                from = from.min(gap.start);
                to = to.max(gap.end);
                seen = true;
            }
        }
        if seen {
            (from, to)
        } else {
            wider(Plan::BLOCK_S)
        }
    }
}

/// Takes `gone` out of `rests`; of one that it cuts nothing under `least` samples
/// stays.
fn remove(rests: &mut Vec<Range<usize>>, gone: &Range<usize>, least: usize) {
    *rests = rests
        .iter()
        .flat_map(|r| {
            if r.end <= gone.start || r.start >= gone.end {
                return [Some(r.clone()), None];
            }
            [r.start..r.end.min(gone.start), r.start.max(gone.end)..r.end]
                .map(|part| (part.len() >= least).then_some(part))
        })
        .flatten()
        .collect();
}
