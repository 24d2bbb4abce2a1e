//! Limits of static intervals, computed from short blocks.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::rounding;

use super::block::Block;
use super::runs::{join, split_run, trim};
use super::{block_rows, distance};
use crate::resolution::floors;

/// Smallest share of the blocks that is assumed to be static.
const QUIET_SHARE: f64 = 0.05;

/// A block is quiet below this multiple of the standard deviation of rounding: values that
/// alternate between neighbouring steps have less than twice that.
const ROUNDING_FACTOR: f64 = 6.0;
/// Shorter blocks, s, contain few independent samples after the low-pass filter of a typical
/// sensor, 20 Hz and more.
const SHORT_BLOCK_S: f64 = 0.1;
/// Largest deviation of block means, in multiples of their own scatter, which includes the
/// correlation of the samples.
const CORRELATED_FACTOR: f64 = 5.0;
/// Scatter of means over noise/√width above which it is motion: the root of the variance
/// inflation factor for a low-pass filter at a hundredth of the rate.
const MOST_CORRELATED: f64 = 6.0;
/// Median length of a vector with three standard normal components.
const MAXWELL_MEDIAN: f64 = 1.538;

/// A block is quiet below this multiple of the standard deviation of the quietest blocks; that of the
/// gyroscope measures more of the unsteadiness of a hand.
const NOISE_FACTOR: f64 = 3.0;
const GYRO_NOISE_FACTOR: f64 = 18.0;
/// Means of blocks agree within this multiple of noise/√width …
const MEAN_FACTOR: f64 = 10.0;
/// … or within this share of gravity, the vibration of a table.
const TREMOR: f64 = 0.004;
/// Shortest static interval, s, if it has fewer rows than this; in any case.
const SHORTEST_S: f64 = 1.0;
const ENOUGH_ROWS: f64 = 200.0;
const LEAST_S: f64 = 0.2;

/// Standard deviation of block means, the three axes together, from the steps between quiet
/// neighbours; 0 without any.
fn scatter_of_means(segments: &[Vec<Block>], quiet: impl Fn(&Block) -> bool) -> f64 {
    let mut steps: Vec<f64> = segments
        .iter()
        .flat_map(|blocks| blocks.windows(2))
        .filter(|pair| pair.iter().all(&quiet))
        .map(|pair| distance(pair[0].mean, pair[1].mean))
        .filter(|step| step.is_finite())
        .collect();
    // Each component of a step is √2 times that of a mean; the sum over the axes gives √3.
    let components = 3.0_f64.sqrt() / 2.0_f64.sqrt() / MAXWELL_MEDIAN;
    crate::stats::median(&mut steps).unwrap_or(0.0) * components
}

/// Limits of static intervals for the blocks of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Levels {
    /// Variance of the quietest blocks.
    floor: f64,
    /// Largest variances of a quiet block.
    most_accel: f64,
    most_gyro: f64,
    /// Largest deviation of block means within an interval.
    agree: f64,
    /// Smallest number of rows of a static interval.
    pub shortest: usize,
}

impl Levels {
    /// Computes the limits from blocks that are consecutive within each of the `groups`, for
    /// values of the given `resolution`; `None` if all values are zero.
    pub fn of(groups: &[Vec<Block>], rate: f64, resolution: &[f64; 6]) -> Option<Self> {
        let width = block_rows(rate);
        let all = || groups.iter().flatten();
        let (accel_step, gyro_step) = resolution.split_at(3);
        let floor = quiet_level(all().map(|b| b.variance), accel_step)?;
        let gyro_floor =
            quiet_level(all().map(|b| b.gyro_variance), gyro_step).unwrap_or(f64::INFINITY);
        // The contribution of rounding is known: only the rest is multiplied.
        let most = |level: f64, factor: f64, step: &[f64]| {
            let rounding = floors(step).min(level);
            (level - rounding) * factor * factor + rounding * ROUNDING_FACTOR.min(factor).powi(2)
        };
        let mut levels = Levels {
            floor,
            most_accel: most(floor, NOISE_FACTOR, accel_step),
            most_gyro: most(gyro_floor, GYRO_NOISE_FACTOR, gyro_step),
            agree: f64::NAN,
            shortest: ((SHORTEST_S * rate).min(ENOUGH_ROWS) as usize)
                .max((LEAST_S * rate) as usize)
                .max(10),
        };
        let gravity = typical_magnitude(all());
        // Means of blocks scatter by noise/√width, for correlated noise by a multiple of it.
        let white = (floor / width as f64).sqrt();
        let mut scatter = MEAN_FACTOR * white;
        if (width as f64) < SHORT_BLOCK_S * rate {
            let means =
                scatter_of_means(groups, |b| levels.is_quiet(b)).min(MOST_CORRELATED * white);
            scatter = scatter.max(CORRELATED_FACTOR * means);
        }
        levels.agree = scatter.max(TREMOR * gravity) + step_of_means(floor, accel_step);
        Some(levels)
    }

    /// Standard deviation of the quietest blocks, the three axes together.
    pub fn noise(&self) -> f64 {
        self.floor.sqrt()
    }

    /// Largest scatter of a quiet block, root of the sum over the axes: of the accelerometer and
    /// of the gyroscope.
    pub fn most(&self) -> [f64; 2] {
        [self.most_accel.sqrt(), self.most_gyro.sqrt()]
    }

    /// Largest deviation of block means within an interval.
    pub fn agree(&self) -> f64 {
        self.agree
    }

    pub fn is_quiet(&self, block: &Block) -> bool {
        block.variance <= self.most_accel
            && (block.gyro_variance.is_nan() || block.gyro_variance <= self.most_gyro)
    }

    /// Rows of the runs of quiet blocks of a segment whose means agree.
    pub fn quiet_rows(&self, segment: &[Block]) -> Vec<Range<usize>> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        let mut at = 0;
        while at < segment.len() {
            let end = segment[at..]
                .iter()
                .position(|b| !self.is_quiet(b))
                .map_or(segment.len(), |n| at + n);
            if end > at {
                split_run(segment, at..end, self.agree, &mut runs);
            }
            at = end + 1;
        }
        let whole = 0..segment.len();
        let joined = join(segment, runs, self.agree);
        joined
            .iter()
            .map(|run| trim(segment, run, &whole))
            .collect()
    }
}

/// The level below which the variances of the quietest twentieth of the blocks are, at least that
/// of rounding to `step`. `None` if all values are zero and the resolution is unknown.
fn quiet_level(variances: impl Iterator<Item = f64>, step: &[f64]) -> Option<f64> {
    let least = floors(step);
    let mut some: Vec<f64> = variances
        .filter(|v| *v > 0.0 || least > 0.0 && *v >= 0.0)
        .collect();
    if some.is_empty() {
        return None;
    }
    let at = ((some.len() as f64 * QUIET_SHARE) as usize).min(some.len() - 1);
    let (_, level, _) = some.select_nth_unstable_by(at, f64::total_cmp);
    Some(level.max(least))
}

/// Largest difference of two means of one reading caused by rounding: if noise is less than a
/// step, means change by a whole step.
fn step_of_means(floor: f64, step: &[f64]) -> f64 {
    // A level as low as that of rounding may contain no noise.
    let left: f64 = step
        .iter()
        .map(|q| rounding::mean_variance(floor / 3.0 - rounding::floor(*q), *q))
        .sum();
    (12.0 * left).sqrt()
}

fn typical_magnitude<'a>(blocks: impl Iterator<Item = &'a Block>) -> f64 {
    let mut norms: Vec<f64> = blocks
        .map(|b| norm(&b.mean))
        .filter(|n| n.is_finite())
        .collect();
    crate::stats::median(&mut norms).unwrap_or(0.0)
}
