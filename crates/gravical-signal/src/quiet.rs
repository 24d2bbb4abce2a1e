//! Where every block is quiet, and the noise of blocks.

use crate::blocks::Block;
use crate::quantile::quantile;
use crate::samples::Samples;

/// Duration of a block, s: longer than the correlation behind any low-pass in use, shorter than a pause of a hand.
pub const BLOCK_S: f64 = 0.2;
/// Fewer blocks are no rest: the variance of their means would have two degrees of freedom.
pub(crate) const MIN_BLOCKS: usize = 4;
/// Variance within a block, three axes, up to which a hand or a foot may be at rest whatever the
/// sensor's noise: (0.14 m/s²)² and (2 °/s)².
pub const TREMOR: [f64; 2] = [0.02, 1.2e-3];
/// Variance of three axes above which nothing is a rest: 0.3 m/s² and 2 °/s rms of each.
pub const MAX_VARIANCE: [f64; 2] = [0.27, 3.7e-3];
/// Factor of the variance of a quiet block above which it trembles.
const TREMBLES: f64 = 3.0;
/// The variance of the means of a few blocks may be too low by this factor by chance.
const MAX_BY_CHANCE: f64 = 2.0;
/// Variance of a block over that of the quietest ones: white noise in five samples and three axes never
/// reaches it, other noise of a sensor rarely.
pub const MAX_EXCESS: f64 = 5.0;
/// Variance of the mean of a block, or of a sample, that no data sheet undercuts: (m/s²)² and (rad/s)².
pub const MIN_VARIANCE: [f64; 2] = [1e-8, 1e-12];
/// What a bias drifts within a rest, m/s² and rad/s, in [`DRIFT_S`]: an MPU-6050 that warms up.
const DRIFT: [f64; 2] = [2e-3, 2e-4];
const DRIFT_S: f64 = 4.0;

/// Noise of blocks.
pub(crate) struct Noise {
    /// Variances of the mean of a block.
    pub variance: [f64; 6],
    /// … of a sample, and of what a value flips.
    sample: [f64; 6],
    pub flips: [f64; 6],
    /// Samples of a block, and their distance, s.
    size: usize,
    period_s: f64,
}

impl Noise {
    /// Of the blocks of a run.
    pub fn new(samples: &Samples, run: &[Block], level: [f64; 2], usual: &[f64; 6]) -> Noise {
        let size = run[0].span.len();
        let flips = flips(run, &samples.resolution);
        let mut variance = variance_of_means(run, level, size);
        for c in 0..6 {
            // Few blocks may be quieter than the others by chance.
            variance[c] = usual[c].clamp(variance[c], MAX_BY_CHANCE * variance[c]) + flips[c];
        }
        let sample = std::array::from_fn(|c| {
            let median = quantile(run.iter().map(|b| b.variance[c]).collect(), 0.5);
            median.max(MIN_VARIANCE[c / 3])
        });
        Noise {
            variance,
            sample,
            flips,
            size,
            period_s: samples.period_s,
        }
    }

    /// Variance of the mean of so many samples: white from block to block, within a block at most that of a sample.
    pub fn of_mean(&self, c: usize, samples: usize) -> f64 {
        let white = (self.variance[c] - self.flips[c]) * self.size as f64 / samples as f64;
        white.min(self.sample[c]) + self.flips[c]
    }

    /// Variance of what a bias drifts in so many samples.
    pub fn of_drift(&self, c: usize, samples: f64) -> f64 {
        (DRIFT[c / 3] * samples * self.period_s / DRIFT_S).powi(2)
    }

    /// The same in so many blocks, but no more than in [`DRIFT_S`].
    pub fn of_slow_drift(&self, c: usize, blocks: f64) -> f64 {
        let samples = blocks * self.size as f64;
        self.of_drift(c, samples.min(DRIFT_S / self.period_s))
    }

    /// A mean in units of its standard deviation.
    pub fn scaled(&self, mean: &[f64; 6], origin: &[f64; 6]) -> [f64; 6] {
        std::array::from_fn(|c| (mean[c] - origin[c]) / self.variance[c].sqrt())
    }
}

/// Variance of three axes below which a block is quiet enough for a rest, (m/s²)² and (rad/s)², where that of the
/// quietest is `level`.
pub fn quiet_limit(level: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|s| (MAX_EXCESS * level[s]).clamp(TREMOR[s], MAX_VARIANCE[s]))
}

/// True if a block is below these limits.
pub fn is_quiet(block: &Block, limit: [f64; 2]) -> bool {
    (0..2).all(|s| block.total_variance(s) < limit[s])
}

/// Variance of three axes in the quietest second or so, (m/s²)² or (rad/s)²: 0 accelerometer, 1 gyroscope.
pub fn quiet_level(blocks: &[Block], sensor: usize) -> f64 {
    let medians = blocks
        .windows(MIN_BLOCKS)
        .map(|w| quantile(w.iter().map(|b| b.total_variance(sensor)).collect(), 0.5));
    let (floor, ceiling) = ([1e-5, 1e-7][sensor], MAX_VARIANCE[sensor]);
    quantile(medians.collect(), 0.05).clamp(floor, ceiling)
}

/// Runs of adjacent blocks of a piece that are quiet enough.
pub(crate) fn quiet_runs<'b>(
    samples: &Samples,
    blocks: &'b [Block],
    level: [f64; 2],
) -> Vec<&'b [Block]> {
    let limit = quiet_limit(level);
    let quiet = |b: &Block| is_quiet(b, limit);
    let adjacent = |a: &Block, b: &Block| {
        a.span.end == b.span.start && samples.piece(a.span.start).contains(&b.span.start)
    };
    blocks
        .chunk_by(|a, b| adjacent(a, b) && quiet(a) == quiet(b))
        .filter(|run| run.len() >= MIN_BLOCKS && quiet(&run[0]))
        .collect()
}

/// Variance of the mean of a block, by the successive differences of all runs.
pub(crate) fn usual_steps(runs: &[&[Block]]) -> [f64; 6] {
    std::array::from_fn(|c| {
        let pairs = runs.iter().flat_map(|run| run.windows(2));
        let squares = pairs.map(|w| (w[1].mean[c] - w[0].mean[c]).powi(2));
        quantile(squares.collect(), 0.5) / (2.0 * 0.4549)
    })
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

/// Variance by which means may flip between two steps of the resolution within a rest, in the unit of the
/// blocks squared: noise that stays within a step dithers nothing.
pub fn flips(run: &[Block], resolution: &[f64; 6]) -> [f64; 6] {
    std::array::from_fn(|c| {
        let range = quantile(run.iter().map(|b| b.range[c]).collect(), 0.5);
        if range < 1.5 * resolution[c] {
            resolution[c].powi(2)
        } else {
            0.0
        }
    })
}
