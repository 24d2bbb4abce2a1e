//! The rest detector.

use std::ops::Range;

use nalgebra::Vector3;

use crate::blocks::{Block, block_len, blocks};
use crate::edges::with_edges;
use crate::partition::constant_segments;
use crate::quiet::{BLOCK_S, MIN_BLOCKS, Noise, quiet_level, quiet_runs, usual_steps};
use crate::samples::Samples;
use crate::steady::steady_parts;

/// Blocks of a second, from 25 Hz on.
const BLOCKS_PER_S: usize = 5;

/// How far means of blocks may be from the mean of a rest, beyond noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestTolerance {
    /// Of the specific force of a block, as a share of its magnitude, so that a scale that drifts counts like a tilt,
    /// rad.
    pub tilt_rad: f64,
    /// Of the rate of each whole second, rad/s: a hand trembles faster.
    pub rate_rad_s: f64,
    /// Where force steps there is a rest on either side: the rows between were few. Else, without a gyroscope, it may be
    /// a slow move.
    pub steps_are_turns: bool,
}

impl RestTolerance {
    /// Force and rate are constant.
    pub const CONSTANT: RestTolerance = RestTolerance {
        tilt_rad: 0.0,
        rate_rad_s: 0.0,
        steps_are_turns: false,
    };
    /// All that is quiet is one rest: it may turn evenly.
    pub const UNLIMITED: RestTolerance = RestTolerance {
        tilt_rad: f64::INFINITY,
        rate_rad_s: f64::INFINITY,
        steps_are_turns: false,
    };

    /// True if a run of one block or more does not go further.
    pub fn contains(&self, run: &[Block]) -> bool {
        if *self == Self::UNLIMITED {
            return true;
        }
        let mean = |blocks: &[Block], first: usize| -> Vector3<f64> {
            let means = blocks
                .iter()
                .map(|b| Vector3::from_column_slice(&b.mean[first..first + 3]));
            means.sum::<Vector3<f64>>() / blocks.len() as f64
        };
        let (force, rate) = (mean(run, 0), mean(run, 3));
        let max_force = self.tilt_rad * force.norm();
        let keeps_force = |block| (mean(block, 0) - force).norm() < max_force;
        let keeps_rate = |second| (mean(second, 3) - rate).norm() < self.rate_rad_s;
        run.chunks_exact(1).all(keeps_force) && run.chunks_exact(BLOCKS_PER_S).all(keeps_rate)
    }
}

/// Spans in which the sensor lay still, moved at constant velocity, or turned evenly: the samples alone cannot
/// tell these apart.
///
/// Means of blocks of 0.2 s are divided into segments of constant mean such that Σχ² and a penalty for
/// each segment are least (optimal partitioning, Jackson et al. 2005, doi 10.1109/LSP.2001.838216), force and
/// rate each on its own. Their noise is that of the stretch itself, at least white noise, resolution counted; what
/// exceeds 0.3 m/s² or 2 °/s rms is no rest. Edges are those of a ramp fitted to what follows (likelihood ratio
/// over its onset). Within them force and rate are constant on every scale from 31 ms to 4 s.
///
/// A run of quiet blocks that stays within `tolerance` is one rest as it is, whatever divides it: a hand that holds
/// the sensor, a bias that drifts with the temperature.
///
/// It finds rests of 0.8 s and more, in order and apart; of what is quiet for longer than 0.6 s some. Without a gyroscope a slow move may contain one.
pub fn detect_rests(samples: &Samples, tolerance: RestTolerance) -> Vec<Range<usize>> {
    let size = block_len(samples.period_s, BLOCK_S);
    let min_len = (MIN_BLOCKS - 1) * size;
    let blocks = blocks(samples, &(0..samples.time_s.len()), size);
    if blocks.len() < MIN_BLOCKS {
        return Vec::new();
    }
    let level = [0, 1].map(|sensor| quiet_level(&blocks, sensor));
    let may_be_slow = !samples.has_gyro() && !tolerance.steps_are_turns;
    let mut rests: Vec<Range<usize>> = Vec::new();
    let runs = quiet_runs(samples, &blocks, level);
    let usual = usual_steps(&runs);
    for run in runs {
        if tolerance.contains(run) {
            rests.push(run[0].span.start..run[run.len() - 1].span.end);
            continue;
        }
        let noise = Noise::new(samples, run, level, &usual);
        let mut segments = constant_segments(run, samples.count(), &noise);
        if may_be_slow {
            segments = longest_of_touching(segments, MIN_BLOCKS);
        }
        let spans = segments
            .iter()
            .map(|s| run[s.start].span.start..run[s.end - 1].span.end)
            .map(|span| with_edges(samples, &span, size, &noise.variance));
        let parts = spans.flat_map(|s| steady_parts(samples, &s, &noise, min_len));
        let mut parts: Vec<Range<usize>> = parts.collect();
        if may_be_slow {
            parts = longest_of_touching(parts, MIN_BLOCKS * size);
        }
        at_ends_of_piece(samples, run, &mut parts, MIN_BLOCKS * size);
        rests.extend(parts);
    }
    // Edges may overlap.
    for k in 1..rests.len() {
        rests[k].start = rests[k].start.max(rests[k - 1].end);
    }
    rests.retain(|rest| rest.len() >= min_len);
    rests
}

/// Without a gyroscope a step of the mean is a tilt, or a slow move: of two spans that are no more than `most` apart
/// the longer is the rest.
fn longest_of_touching(mut segments: Vec<Range<usize>>, most: usize) -> Vec<Range<usize>> {
    let mut k = 1;
    while k < segments.len() {
        let (last, next) = (&segments[k - 1], &segments[k]);
        if next.start.saturating_sub(last.end) > most {
            k += 1;
        } else {
            segments.remove(if next.len() < last.len() { k } else { k - 1 });
            k = k.saturating_sub(1).max(1);
        }
    }
    segments
}

/// What is shorter than `min` before the first rest of a piece, or after its last, belongs to it: a move does not
/// end as quietly.
fn at_ends_of_piece(samples: &Samples, run: &[Block], rests: &mut [Range<usize>], min: usize) {
    let piece = samples.piece(run[0].span.start);
    if let Some(first) = rests.first_mut()
        && first.start - piece.start < min
        && run[0].span.start == piece.start
    {
        first.start = piece.start;
    }
    // What is left at the end of a piece is no block.
    if let Some(last) = rests.last_mut()
        && piece.end - last.end < min
        && run[run.len() - 1].span.end + run[0].span.len() > piece.end
    {
        last.end = piece.end;
    }
}
