//! Runs of blocks, divided into segments of constant force and rate.

use std::ops::Range;

use crate::blocks::Block;
use crate::quiet::{MIN_BLOCKS, Noise};

/// Blocks that one segment may have, 60 s from 25 Hz on: over longer ones the drift of a bias is a step.
const MAX_BLOCKS: usize = 300;
/// Cost of one segment more in the sum of χ², without and with a gyroscope: about ln n for each of its three means
/// (Killick et al. 2012, doi 10.1080/01621459.2012.734741), n some 200 blocks; and for its place where the
/// other sensor divides as well.
const PENALTY: [f64; 2] = [16.0, 20.0];
/// Two segments are one rest if what separates their means is less likely than this fraction of a
/// penalty: it pays for the means, but not for the place.
const SAME_REST: f64 = 0.65;

/// Segments of a run in which force and rate are constant, each sensor divided on its own: a ramp of one is no news
/// of the other. In blocks.
pub(crate) fn constant_segments(
    run: &[Block],
    channels: usize,
    noise: &Noise,
) -> Vec<Range<usize>> {
    let sensors = channels / 3;
    let new = |sensor| Partition::new(3 * sensor, PENALTY[sensors - 1]);
    let mut partitions: Vec<Partition> = (0..sensors).map(new).collect();
    for block in run {
        let mean = noise.scaled(&block.mean, &run[0].mean);
        partitions.iter_mut().for_each(|p| p.push(&mean));
    }
    merge_segments(&partitions, segments(&partitions), noise)
}

/// Optimal partition of the means of one sensor in units of their standard deviation, one block at a time.
struct Partition {
    first: usize,
    penalty: f64,
    sum: Vec<[f64; 3]>,
    squares: Vec<f64>,
    cost: Vec<f64>,
    /// Where the last segment of the blocks up to each begins.
    start: Vec<usize>,
}

impl Partition {
    /// Of three channels from `first` on.
    fn new(first: usize, penalty: f64) -> Self {
        Partition {
            first,
            penalty,
            sum: vec![[0.0; 3]],
            squares: vec![0.0],
            cost: vec![0.0],
            start: vec![0],
        }
    }

    fn push(&mut self, mean: &[f64; 6]) {
        let k = self.cost.len();
        let (mut sum, mut squares) = (self.sum[k - 1], self.squares[k - 1]);
        for c in 0..3 {
            let mean = mean[self.first + c];
            sum[c] += mean;
            squares += mean * mean;
        }
        let (mut best, mut start) = (f64::INFINITY, k - 1);
        for j in k.saturating_sub(MAX_BLOCKS)..k {
            let before = &self.sum[j];
            let square: f64 = (0..3).map(|c| (sum[c] - before[c]).powi(2)).sum();
            let cost = self.cost[j] + squares - self.squares[j] - square / (k - j) as f64;
            if cost < best {
                (best, start) = (cost, j);
            }
        }
        self.sum.push(sum);
        self.squares.push(squares);
        self.cost.push(best + self.penalty);
        self.start.push(start);
    }

    fn mean(&self, segment: &Range<usize>, c: usize) -> f64 {
        (self.sum[segment.end][c] - self.sum[segment.start][c]) / segment.len() as f64
    }

    /// Where the best segments of all blocks begin and end.
    fn edges(&self) -> Vec<usize> {
        let mut edges = vec![self.start.len() - 1];
        while let Some(end) = edges.last().filter(|end| **end > 0) {
            edges.push(self.start[*end]);
        }
        edges
    }

    /// True if the means of neighbouring segments differ by what a bias drifts, at most that in 4 s,
    /// and a value flips.
    fn same(&self, last: &Range<usize>, next: &Range<usize>, noise: &Noise) -> bool {
        let apart = 0.5 * (next.end - last.start) as f64;
        let chance = 1.0 / last.len() as f64 + 1.0 / next.len() as f64;
        let chi2: f64 = (0..3)
            .map(|c| {
                let i = self.first + c;
                let slack = noise.of_slow_drift(i, apart) + noise.flips[i];
                let variance = chance + slack / noise.variance[i];
                (self.mean(last, c) - self.mean(next, c)).powi(2) / variance
            })
            .sum();
        chi2 < SAME_REST * self.penalty
    }
}

/// Segments of which force and rate are constant.
fn segments(partitions: &[Partition]) -> Vec<Range<usize>> {
    let mut edges: Vec<usize> = partitions.iter().flat_map(Partition::edges).collect();
    edges.sort_unstable();
    edges.dedup();
    edges.windows(2).map(|e| e[0]..e[1]).collect()
}

/// Touching segments that are the same rest are one; those that are too short are left out.
fn merge_segments(
    partitions: &[Partition],
    mut segments: Vec<Range<usize>>,
    noise: &Noise,
) -> Vec<Range<usize>> {
    segments.dedup_by(|next, last| {
        let same = partitions.iter().all(|p| p.same(last, next, noise));
        if same {
            last.end = next.end;
        }
        same
    });
    segments.retain(|s| s.len() >= MIN_BLOCKS);
    segments
}
