//! The rest detector.

use std::ops::Range;

use crate::blocks::{Block, block_len, blocks};
use crate::resolutions::quantile;
use crate::samples::Samples;
use crate::steady::steady_parts;

/// Duration of a block, s: longer than the correlation behind any low-pass in use, shorter than a pause of a hand.
pub const BLOCK_S: f64 = 0.2;
/// Fewer blocks are no rest: the variance of their means would have two degrees of freedom.
const MIN_BLOCKS: usize = 4;
/// Blocks that one segment may have, 60 s: over longer ones the drift of a bias is a step.
const MAX_BLOCKS: usize = 300;
/// Variance within a block, three axes, up to which a hand or a foot may be at rest whatever the
/// sensor's noise: (0.14 m/s²)² and (2 °/s)².
const TREMOR: [f64; 2] = [0.02, 1.2e-3];
/// Variance of three axes above which nothing is a rest: 0.3 m/s² and 2 °/s rms of each.
pub const MAX_VARIANCE: [f64; 2] = [0.27, 3.7e-3];
/// Factor of the variance of a quiet block above which it trembles.
const TREMBLES: f64 = 3.0;
/// Variance of a block over that of the quietest ones: white noise in five samples and three axes never
/// reaches it, other noise of a sensor rarely.
const MAX_EXCESS: f64 = 5.0;
/// Variance of the mean of a block, or of a sample, that no data sheet undercuts: (m/s²)² and (rad/s)².
pub const MIN_VARIANCE: [f64; 2] = [1e-8, 1e-12];
/// Cost of one segment more in the sum of χ²: about ln n for each of its means
/// (Killick et al. 2012, doi 10.1080/01621459.2012.734741), n some 200 blocks.
const PENALTY: [f64; 2] = [16.0, 20.0];
/// What a bias drifts within a rest, m/s² and rad/s, in [`DRIFT_S`]: an MPU-6050 that warms up.
pub(crate) const DRIFT: [f64; 2] = [2e-3, 2e-4];
const DRIFT_S: f64 = 4.0;
/// Two segments are one rest if what separates their means is less likely than this fraction of a
/// penalty: it pays for the means, but not for the place.
const SAME_REST: f64 = 0.65;
/// Blocks next to an edge that say what the rest is: 3 s.
const NEAR_BLOCKS: usize = 15;
/// A motion begins more gently than its fitted onset: a rest ends this long before it.
const MARGIN_S: f64 = 0.03;

/// Spans in which the sensor lay still, or moved at constant velocity without turning: the samples
/// alone cannot tell these apart.
///
/// Means of blocks of 0.2 s are divided into segments of constant mean such that Σχ² and a penalty for
/// each segment are least (optimal partitioning, Jackson et al. 2005, doi 10.1109/LSP.2001.838216).
/// Their noise is that of the stretch itself, at least white noise, resolution counted; what exceeds
/// 0.3 m/s² or 2 °/s rms is no rest. Edges are those of a ramp fitted to what follows (likelihood ratio
/// over its onset). It is also searched for moves that no single block shows, by matched
/// filters of 0.35 to 8 s: they part a rest.
///
/// It finds rests of 0.8 s and more, in order, in recordings of more than a second; of what is quiet for
/// longer than 0.6 s some. Without a gyroscope a slow move may contain one.
pub fn detect_rests(samples: &Samples) -> Vec<Range<usize>> {
    let size = block_len(samples.period_s, BLOCK_S);
    let min_len = (MIN_BLOCKS - 1) * size;
    let blocks = blocks(samples, &(0..samples.time_s.len()), size);
    if blocks.len() <= MIN_BLOCKS {
        return Vec::new();
    }
    let level = [0, 1].map(|sensor| quiet_level(&blocks, sensor));
    let penalty = PENALTY[usize::from(samples.has_gyro())];
    let mut rests: Vec<Range<usize>> = Vec::new();
    for run in quiet_runs(samples, &blocks, level) {
        let noise = Noise::new(run, level, size, &samples.resolution);
        let mut partitions: Vec<Partition> = (0..samples.count() / 3)
            .map(|s| Partition::new(3 * s, penalty))
            .collect();
        for block in run {
            let mean = noise.scaled(&block.mean, &run[0].mean);
            partitions.iter_mut().for_each(|p| p.push(&mean));
        }
        let joined = joined(&partitions, segments(&partitions), &noise);
        let segments = if samples.count() == 3 {
            longest_of_touching(joined, MIN_BLOCKS)
        } else {
            joined
        };
        let spans = segments
            .iter()
            .map(|s| run[s.start].span.start..run[s.end - 1].span.end)
            .map(|span| with_edges(samples, &span, size, &noise.variance));
        let parts = spans.flat_map(|s| steady_parts(samples, &s, size, &noise, min_len));
        let mut parts: Vec<Range<usize>> = parts.collect();
        if samples.count() == 3 {
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

/// Spans of 0.8 s and more in which every block is quiet enough for a rest, whether or not its mean stays
/// the same: rests, and what a hand holds or turns slowly.
pub fn detect_quiet(samples: &Samples) -> Vec<Range<usize>> {
    let size = block_len(samples.period_s, BLOCK_S);
    let blocks = blocks(samples, &(0..samples.time_s.len()), size);
    let level = [0, 1].map(|sensor| quiet_level(&blocks, sensor));
    quiet_runs(samples, &blocks, level)
        .iter()
        .map(|run| run[0].span.start..run[run.len() - 1].span.end)
        .collect()
}

/// Noise of blocks.
pub(crate) struct Noise {
    /// Variances of the mean of a block.
    variance: [f64; 6],
    /// … of a sample, and what a value flips.
    sample: [f64; 6],
    flips: [f64; 6],
}

impl Noise {
    fn new(run: &[Block], level: [f64; 2], size: usize, resolution: &[f64; 6]) -> Noise {
        let flips = flips(run, resolution);
        let mut variance = variance_of_means(run, level, size);
        (0..6).for_each(|c| variance[c] += flips[c]);
        let sample = std::array::from_fn(|c| {
            let median = quantile(run.iter().map(|b| b.variance[c]).collect(), 0.5);
            median.max(MIN_VARIANCE[c / 3])
        });
        Noise {
            variance,
            sample,
            flips,
        }
    }

    /// Variance of the mean of so many samples: white from block to block, within a block at most that of a sample.
    pub fn of_mean(&self, c: usize, samples: usize, size: usize) -> f64 {
        let white = (self.variance[c] - self.flips[c]) * size as f64 / samples as f64;
        white.min(self.sample[c]) + self.flips[c]
    }

    /// Variance of what a bias drifts in so many blocks.
    pub fn of_drift(&self, c: usize, blocks: f64) -> f64 {
        (DRIFT[c / 3] * blocks * BLOCK_S / DRIFT_S).powi(2)
    }

    /// A mean in units of its standard deviation.
    fn scaled(&self, mean: &[f64; 6], origin: &[f64; 6]) -> [f64; 6] {
        std::array::from_fn(|c| (mean[c] - origin[c]) / self.variance[c].sqrt())
    }
}

/// True if a block is quiet enough for a rest.
fn is_quiet(block: &Block, level: [f64; 2]) -> bool {
    let limit = |s: usize| (MAX_EXCESS * level[s]).clamp(TREMOR[s], MAX_VARIANCE[s]);
    (0..2).all(|s| block.total_variance(s) < limit(s))
}

/// Variance of three axes in the quietest second or so.
fn quiet_level(blocks: &[Block], sensor: usize) -> f64 {
    let medians = blocks
        .windows(MIN_BLOCKS)
        .map(|w| quantile(w.iter().map(|b| b.total_variance(sensor)).collect(), 0.5));
    let (floor, ceiling) = ([1e-5, 1e-7][sensor], MAX_VARIANCE[sensor]);
    quantile(medians.collect(), 0.05).clamp(floor, ceiling)
}

/// Runs of adjacent blocks of a piece that are quiet enough.
fn quiet_runs<'b>(samples: &Samples, blocks: &'b [Block], level: [f64; 2]) -> Vec<&'b [Block]> {
    let quiet = |b: &Block| is_quiet(b, level);
    let adjacent = |a: &Block, b: &Block| {
        a.span.end == b.span.start && samples.piece(a.span.start).contains(&b.span.start)
    };
    blocks
        .chunk_by(|a, b| adjacent(a, b) && quiet(a) == quiet(b))
        .filter(|run| run.len() >= MIN_BLOCKS && quiet(&run[0]))
        .collect()
}

/// Variance of the mean of a block: by successive differences, at least that of white noise.
fn variance_of_means(run: &[Block], level: [f64; 2], size: usize) -> [f64; 6] {
    std::array::from_fn(|c| {
        let median = |values: Vec<f64>| quantile(values, 0.5);
        let total = median(run.iter().map(|b| b.total_variance(c / 3)).collect());
        // What trembles, as a hand or a foot, wanders too.
        let lag = if total > TREMBLES * level[c / 3] {
            MIN_BLOCKS - 1
        } else {
            1
        };
        let squares = run
            .windows(lag + 1)
            .map(|w| (w[lag].mean[c] - w[0].mean[c]).powi(2));
        // The median of χ² with one degree of freedom is 0.4549.
        let wander = median(squares.collect()) / (2.0 * 0.4549);
        let white = median(run.iter().map(|b| b.variance[c]).collect()) / size as f64;
        wander
            .min(TREMOR[c / 3] / 3.0)
            .max(white)
            .max(MIN_VARIANCE[c / 3])
    })
}

/// Variance by which means may flip between two steps of the resolution within a rest: noise that
/// stays within a step dithers nothing.
fn flips(run: &[Block], resolution: &[f64; 6]) -> [f64; 6] {
    std::array::from_fn(|c| {
        let range = quantile(run.iter().map(|b| b.range[c]).collect(), 0.5);
        if range < 1.5 * resolution[c] {
            resolution[c].powi(2)
        } else {
            0.0
        }
    })
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

    /// True if the means of neighbouring segments differ by what a bias drifts, at most that in [`DRIFT_S`],
    /// and a value flips.
    fn same(&self, last: &Range<usize>, next: &Range<usize>, noise: &Noise) -> bool {
        let apart = (0.5 * (next.end - last.start) as f64).min(DRIFT_S / BLOCK_S);
        let chance = 1.0 / last.len() as f64 + 1.0 / next.len() as f64;
        let chi2: f64 = (0..3)
            .map(|c| {
                let i = self.first + c;
                let slack = noise.of_drift(i, apart) + noise.flips[i];
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
fn joined(
    partitions: &[Partition],
    mut segments: Vec<Range<usize>>,
    noise: &Noise,
) -> Vec<Range<usize>> {
    segments.dedup_by(|next, last| {
        let same = next.start == last.end && partitions.iter().all(|p| p.same(last, next, noise));
        if same {
            last.end = next.end;
        }
        same
    });
    segments.retain(|s| s.len() >= MIN_BLOCKS);
    segments
}

/// Without a gyroscope a step of the mean is a tilt, or a slow move: of two segments that touch the
/// longer is the rest.
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

/// What is shorter than a rest before the first in a piece, or after its last, belongs to it: a move does not
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

/// The span with ends to the sample, by the seconds of rest next to each.
fn with_edges(
    samples: &Samples,
    span: &Range<usize>,
    size: usize,
    variance: &[f64; 6],
) -> Range<usize> {
    let piece = samples.piece(span.start);
    let start = start_edge(samples, span, size, variance);
    let end = if span.end + size < piece.end {
        end_edge(samples, span, span.end + size, size, variance)
    } else {
        span.end
    };
    if start < end {
        start..end
    } else {
        span.clone()
    }
}

/// Samples that a rest near `near` samples long is looked for its edge in: far enough that the ramp finds
/// its foot, from a block beyond it.
fn reach(near: usize, size: usize) -> usize {
    near / 3 + 2 * size
}

fn margin(size: usize) -> usize {
    (MARGIN_S / BLOCK_S * size as f64).ceil() as usize
}

/// Where a rest begins, to the sample.
fn start_edge(samples: &Samples, span: &Range<usize>, size: usize, variance: &[f64; 6]) -> usize {
    let piece = samples.piece(span.start);
    if span.start <= piece.start + size {
        return span.start;
    }
    let near = span.len().min(NEAR_BLOCKS * size);
    let rest = span.start..span.start + near;
    let first = span.start.saturating_sub(size).max(piece.start);
    let most = samples.time_s.len() - 1 - first;
    let reach = reach(near, size).min(most);
    let onset = onset(samples, &rest, variance, reach, |u| first + u);
    first + onset + margin(size)
}

/// Where a rest ends, to the sample, looked for from sample `last` back.
fn end_edge(
    samples: &Samples,
    span: &Range<usize>,
    last: usize,
    size: usize,
    variance: &[f64; 6],
) -> usize {
    let near = span.len().min(NEAR_BLOCKS * size);
    let (rest, reach) = (span.end - near..span.end, reach(near, size).min(last));
    let onset = onset(samples, &rest, variance, reach, |u| last - u);
    (last + 1).saturating_sub(onset + margin(size))
}

/// Samples from the first of `at` to the onset of a ramp: the one that explains most of what leaves the mean
/// of `rest`.
fn onset(
    samples: &Samples,
    rest: &Range<usize>,
    variance: &[f64; 6],
    reach: usize,
    at: impl Fn(usize) -> usize,
) -> usize {
    let mean = samples.mean(rest);
    let (mut total, mut moment, mut squares) = ([0.0; 6], [0.0; 6], 0.0);
    let (mut best, mut onset) = (f64::MIN, 0);
    for u in 1..reach {
        let x = samples.sample(at(u - 1));
        squares += (u * u) as f64;
        let mut gain = 0.0;
        for c in 0..6 {
            total[c] += x[c] - mean[c];
            moment[c] += total[c];
            gain += moment[c] * moment[c] / variance[c];
        }
        if gain / squares > best {
            (best, onset) = (gain / squares, u);
        }
    }
    onset
}
