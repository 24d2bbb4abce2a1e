//! A slow move fitted to a window of blocks.

use std::ops::Range;

use gravical_core::matrix3::{cross, norm};

use super::DOUBTED;
use super::blocks::Blocks;
use crate::motion::still::levels::Levels;

/// Rest that is looked at on either side of a move, s; and the least of it.
const SIDE_S: f64 = 5.0;
const LEAST_SIDE_S: f64 = 2.0;
/// It may begin later than a move by this share of its duration: an onset in noise is
/// not found to the second.
const BEYOND: f64 = 0.2;
/// A sensor that turns by more than this, rad, is not taken for resting in one pose.
const MOST_TURN_RAD: f64 = 0.05;

/// What a window says of a move in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    /// Start and end of the move, s.
    pub from_s: f64,
    pub to_s: f64,
    /// How far it went, each axis of the sensor, m.
    pub displacement_m: [f64; 3],
    /// χ² with three degrees of freedom that the move explains.
    pub gain: f64,
    /// The same against the accelerometer's noise alone, …
    white: f64,
    /// … what a single step of the force leaves, …
    left_by_step: f64,
    /// … what the move leaves, and its degrees of freedom.
    left: f64,
    freedom: f64,
}

impl Fit {
    /// True when a move explains the window, and better than a step: what is left is
    /// noise, or the difference between one shape of a move and another.
    pub fn is_move(&self) -> bool {
        self.left - self.freedom <= SHAPE * self.white + 5.0 * (2.0 * self.freedom).sqrt()
            && self.left + BETTER < self.left_by_step
    }

    pub fn seconds(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// A move of another shape leaves so much of what it is: 0.23 of constant
/// acceleration, constant speed and constant braking, a third of the time each.
const SHAPE: f64 = 0.5;
/// χ² by which a move has to leave less than a step does.
const BETTER: f64 = 10.0;

/// Acceleration of a move by 1 in unit time along the smoothest path from rest to
/// rest: a' of s³(10 − 15 s + 6 s²) (Flash and Hogan 1985).
fn template(s: f64) -> f64 {
    if (0.0..=1.0).contains(&s) {
        60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)
    } else {
        0.0
    }
}

/// A straight line taken off, by least squares: the bias and its drift.
struct Straight {
    middle: f64,
    squares: f64,
    count: f64,
}

impl Straight {
    fn new(t: &[f64]) -> Self {
        let count = t.len() as f64;
        let middle = t.iter().sum::<f64>() / count;
        Straight {
            middle,
            squares: t.iter().map(|t| (t - middle).powi(2)).sum(),
            count,
        }
    }

    fn take_off(&self, t: &[f64], y: &mut [f64]) {
        let mean = y.iter().sum::<f64>() / self.count;
        let moment: f64 = t.iter().zip(&*y).map(|(t, y)| (t - self.middle) * y).sum();
        for (y, t) in y.iter_mut().zip(t) {
            *y -= mean + moment / self.squares * (t - self.middle);
        }
    }
}

/// Fits a move from `from_s` for `seconds`; none where it does not lie between two
/// rests, or where the sensor turns.
///
/// The force, with the turn by the gyroscope taken off, is a straight line and the
/// template, each axis by itself. The noise of the template's size is that of the
/// accelerometer and of the tilt that the gyroscope's noise walks to.
pub(super) fn fit(
    blocks: &Blocks,
    levels: &Levels,
    block: usize,
    from_s: f64,
    seconds: f64,
) -> Option<Fit> {
    let window = window(blocks, from_s, from_s + seconds)?;
    let t = &blocks.t_s[window.whole.clone()];
    let force = turned_back(blocks, &window)?;
    let level = levels.nearest(&(blocks.edges[window.whole.start]..blocks.edges[window.whole.end]));
    if level.held {
        return None;
    }
    let variance = level.noise.mean_variance[0].map(|v| v / block as f64);
    let straight = Straight::new(t);
    let mut shape: Vec<f64> = t.iter().map(|t| template((t - from_s) / seconds)).collect();
    straight.take_off(t, &mut shape);
    let energy: f64 = shape.iter().map(|k| k * k).sum();
    if energy <= 0.0 {
        return None;
    }
    // What a step of the tilt in each block, and all that follow, adds to the size.
    let mut later = 0.0;
    let mut by_tilt = 0.0;
    let steps = &blocks.step_s[window.whole.clone()];
    for (k, h) in shape.iter().zip(steps).rev() {
        later += k;
        by_tilt += (later * h).powi(2);
    }
    let gravity = mean(&blocks.force[window.before.clone()]);
    let size = norm(&gravity);
    let tilt = by_tilt * size * size * (variance[3] + variance[4] + variance[5]) / 3.0;

    let mut out = Fit {
        from_s,
        to_s: from_s + seconds,
        displacement_m: [0.0; 3],
        gain: 0.0,
        white: 0.0,
        left_by_step: 0.0,
        left: 0.0,
        freedom: 3.0 * (t.len() as f64 - 3.0),
    };
    for c in 0..3 {
        let mut y: Vec<f64> = force.iter().map(|f| f[c]).collect();
        straight.take_off(t, &mut y);
        let product: f64 = shape.iter().zip(&y).map(|(k, y)| k * y).sum();
        let across = 1.0 - (gravity[c] / size).powi(2);
        out.gain += product * product / (variance[c] * energy + tilt * across);
        out.white += product * product / (variance[c] * energy);
        out.left += y.iter().map(|y| y * y).sum::<f64>() / variance[c];
        out.displacement_m[c] = product / energy * seconds * seconds;
    }
    out.left -= out.white;
    // Nobody asks for it of what is no more than noise.
    if out.gain > DOUBTED {
        out.left_by_step = left_by_step(&force, &variance);
    }
    Some(out)
}

/// What is left at least of the force when it is taken for two constants, one before
/// and one after any block.
fn left_by_step(force: &[[f64; 3]], variance: &[f64; 6]) -> f64 {
    let count = force.len() as f64;
    let centre = mean(force);
    let (mut best, mut all, mut later) = (0.0_f64, 0.0, 0.0);
    let mut sums = [0.0; 3];
    for f in force.iter().rev() {
        later += 1.0;
        let mut gain = 0.0;
        for c in 0..3 {
            let off = f[c] - centre[c];
            sums[c] += off;
            gain += sums[c] * sums[c] / variance[c];
            all += off * off / variance[c];
        }
        let energy = later * (count - later) / count;
        if energy > 0.5 {
            best = best.max(gain / energy);
        }
    }
    all - best
}

struct Window {
    before: Range<usize>,
    after: Range<usize>,
    whole: Range<usize>,
}

/// The blocks of a move with the rest on either side of it.
fn window(blocks: &Blocks, from_s: f64, to_s: f64) -> Option<Window> {
    let first = blocks.t_s.partition_point(|t| *t < from_s);
    let last = blocks.t_s.partition_point(|t| *t <= to_s);
    // What was found moving there may reach beyond.
    let aside = BEYOND * (to_s - from_s);
    let mut near = first;
    while near > 0 && !blocks.rest[near - 1] && blocks.t_s[near - 1] >= from_s - aside {
        near -= 1;
    }
    let mut start = near;
    while start > 0 && blocks.rest[start - 1] && blocks.t_s[start - 1] >= from_s - SIDE_S {
        start -= 1;
    }
    let mut far = last;
    while far < blocks.len() && !blocks.rest[far] && blocks.t_s[far] <= to_s + aside {
        far += 1;
    }
    let mut end = far;
    while end < blocks.len() && blocks.rest[end] && blocks.t_s[end] <= to_s + SIDE_S {
        end += 1;
    }
    let least = |r: &Range<usize>| {
        !r.is_empty() && blocks.step_s[r.clone()].iter().sum::<f64>() >= LEAST_SIDE_S - 1e-6
    };
    let (before, after) = (start..near, far..end);
    (first < last && least(&before) && least(&after)).then_some(Window {
        before,
        after,
        whole: start..end,
    })
}

fn mean(of: &[[f64; 3]]) -> [f64; 3] {
    let count = of.len().max(1) as f64;
    std::array::from_fn(|c| of.iter().map(|v| v[c]).sum::<f64>() / count)
}

/// The force of each block in the axes at the start of the window, by the gyroscope
/// with the mean rate of the rests taken off; none where it turns too far.
fn turned_back(blocks: &Blocks, window: &Window) -> Option<Vec<[f64; 3]>> {
    let (a, b) = (&window.before, &window.after);
    let (early, late) = (mean(&blocks.rate[a.clone()]), mean(&blocks.rate[b.clone()]));
    let (n, m) = (a.len() as f64, b.len() as f64);
    let bias: [f64; 3] = std::array::from_fn(|c| (early[c] * n + late[c] * m) / (n + m));
    let gravity = mean(&blocks.force[a.clone()]);
    let mut angle = [0.0; 3];
    let mut out = Vec::with_capacity(window.whole.len());
    for j in window.whole.clone() {
        let (rate, h) = (&blocks.rate[j], blocks.step_s[j]);
        let half: [f64; 3] = std::array::from_fn(|c| 0.5 * h * (rate[c] - bias[c]));
        let middle: [f64; 3] = std::array::from_fn(|c| angle[c] + half[c]);
        angle = std::array::from_fn(|c| angle[c] + 2.0 * half[c]);
        if norm(&angle) > MOST_TURN_RAD {
            return None;
        }
        // A force fixed in space turns the other way round in the sensor.
        let turn = cross(&middle, &gravity);
        let force = &blocks.force[j];
        out.push(std::array::from_fn(|c| force[c] + turn[c]));
    }
    Some(out)
}
