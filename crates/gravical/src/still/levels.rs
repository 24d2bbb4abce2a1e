//! What tells a still, by short blocks of the channels.

use std::ops::Range;

use gravical_core::rounding;

use super::block::Block;
use super::runs::{Stretches, join, settle, trim};
use super::{StillOptions, block_rows, distance, floors, moments, turning};

/// Which share of the blocks is taken to be still at least.
const QUIET_SHARE: f64 = 0.05;

/// A block is quiet under this many times the standard deviation of rounding: values
/// that go from one step to the next and the one after scatter by less than two.
const ROUNDING_FACTOR: f64 = 6.0;
/// Shorter blocks, s, hold few independent samples behind the low-pass of a usual
/// sensor, 20 Hz and more.
const SHORT_BLOCK_S: f64 = 0.1;
/// Means of blocks agree within this many times their own scatter, which holds
/// the correlation of the samples.
const CORRELATED_FACTOR: f64 = 5.0;
/// Scatter of means over noise/√width beyond which it is motion: the root of the
/// variance inflation factor behind a low-pass of a hundredth of the rate.
const MOST_CORRELATED: f64 = 6.0;
/// Median length of a vector whose three components are normal.
const MAXWELL_MEDIAN: f64 = 1.538;

/// The mean angular rates of stills that follow each other are within so many times the
/// scatter that a quiet block may have …
const MOST_RATE_STEP: f64 = 3.0;
/// … or within this share of the fastest turn: the bias drifts by less from one to the
/// next, and in another pose reacts to gravity by less.
const TURNING_SHARE: f64 = 0.1;

/// The angular rate of the block that turns fastest, less the usual one.
fn fastest(groups: &[Vec<Block>]) -> f64 {
    let blocks = || groups.iter().flatten().map(|b| b.gyro_mean);
    let usual: [f64; 3] = std::array::from_fn(|axis| {
        let mut all: Vec<f64> = blocks().map(|rate| rate[axis]).collect();
        crate::stats::median(&mut all).unwrap_or(f64::NAN)
    });
    let off = blocks().map(|rate| distance(rate, usual));
    off.filter(|rate| rate.is_finite()).fold(0.0, f64::max)
}

/// How far means of blocks scatter, the three axes together, by the steps between
/// quiet neighbours; 0 without any.
fn scatter_of_means(segments: &[Vec<Block>], quiet: impl Fn(&Block) -> bool) -> f64 {
    let mut steps: Vec<f64> = segments
        .iter()
        .flat_map(|blocks| blocks.windows(2))
        .filter(|pair| pair.iter().all(&quiet))
        .map(|pair| distance(pair[0].mean, pair[1].mean))
        .filter(|step| step.is_finite())
        .collect();
    // Each component of a step is √2 of that of a mean; together they are √3.
    let components = 3.0_f64.sqrt() / 2.0_f64.sqrt() / MAXWELL_MEDIAN;
    crate::stats::median(&mut steps).unwrap_or(0.0) * components
}

/// What tells a still, by the blocks of a recording.
#[derive(Debug, Clone)]
pub(crate) struct Levels {
    /// Variance that the quietest blocks stay under.
    floor: f64,
    /// A block is quiet up to these variances.
    most_accel: f64,
    most_gyro: f64,
    /// Means of blocks agree within this.
    agree: f64,
    /// Angular rates of stills that follow each other agree within this.
    agree_rate: f64,
    /// Rows of a block.
    width: usize,
    /// Rows of the shortest still.
    pub shortest: usize,
    grows: bool,
}

impl Levels {
    /// By blocks that follow each other in each of the `groups`, of a recording whose
    /// values come in steps of `resolution`; none where nothing but zeros is there.
    pub fn of(
        groups: &[Vec<Block>],
        rate: f64,
        resolution: &[f64; 6],
        options: &StillOptions,
    ) -> Option<Self> {
        let width = block_rows(rate, options);
        let all = || groups.iter().flatten();
        let (accel_step, gyro_step) = resolution.split_at(3);
        let floor = quiet_level(all().map(|b| b.variance), accel_step)?;
        let gyro_floor =
            quiet_level(all().map(|b| b.gyro_variance), gyro_step).unwrap_or(f64::INFINITY);
        // What rounding makes of a level is known: only the rest of it is multiplied.
        let most = |level: f64, factor: f64, step: &[f64]| {
            let rounding = floors(step).min(level);
            (level - rounding) * factor * factor + rounding * ROUNDING_FACTOR.min(factor).powi(2)
        };
        let mut levels = Levels {
            floor,
            most_accel: most(floor, options.noise_factor, accel_step),
            most_gyro: most(gyro_floor, options.gyro_noise_factor, gyro_step),
            agree: f64::NAN,
            agree_rate: f64::INFINITY,
            width,
            shortest: ((options.shortest_s * rate).min(options.enough_rows as f64) as usize)
                .max((options.least_s * rate) as usize)
                .max(10),
            grows: options.grow_edges,
        };
        let gravity = typical_magnitude(all());
        // Means of blocks scatter by noise/√width, correlated noise by some times
        // that: many samples behind a low-pass, by a multiple.
        let white = (floor / width as f64).sqrt();
        let mut scatter = options.mean_factor * white;
        if (width as f64) < SHORT_BLOCK_S * rate {
            let means =
                scatter_of_means(groups, |b| levels.is_quiet(b)).min(MOST_CORRELATED * white);
            scatter = scatter.max(CORRELATED_FACTOR * means);
        }
        levels.agree = scatter.max(options.tremor * gravity) + step_of_means(floor, accel_step);
        if levels.most_gyro.is_finite() {
            let within = MOST_RATE_STEP * levels.most_gyro.sqrt();
            levels.agree_rate = within.max(TURNING_SHARE * fastest(groups));
        }
        Some(levels)
    }

    /// Standard deviation of the quietest blocks, the three axes together.
    pub fn noise(&self) -> f64 {
        self.floor.sqrt()
    }

    pub fn is_quiet(&self, block: &Block) -> bool {
        block.variance <= self.most_accel
            && (block.gyro_variance.is_nan() || block.gyro_variance <= self.most_gyro)
    }

    /// Rows of the runs of quiet blocks of a segment whose means agree, before they
    /// [grow](Self::grow).
    pub fn quiet_rows(&self, segment: &[Block]) -> Vec<Range<usize>> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        let stretches = Stretches::new(segment);
        let mut at = 0;
        while at < segment.len() {
            let end = segment[at..]
                .iter()
                .position(|b| !self.is_quiet(b))
                .map_or(segment.len(), |n| at + n);
            if end > at {
                settle(segment, &stretches, at..end, self.agree, &mut runs);
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

    /// Those of the stills that do not turn evenly.
    pub fn without_turning(
        &self,
        gyro: Option<&[Vec<f64>; 3]>,
        stills: Vec<Range<usize>>,
    ) -> Vec<Range<usize>> {
        match gyro {
            Some(gyro) if self.agree_rate.is_finite() => {
                turning::without_turning(gyro, self.agree_rate, stills)
            }
            _ => stills,
        }
    }

    /// Whether quiet rows may be a still, once they have grown.
    pub fn may_be_still(&self, rows: &Range<usize>) -> bool {
        let grown = if self.grows { 2 * self.width } else { 0 };
        rows.len() + grown >= self.shortest
    }

    /// Takes rows on at both ends, where that is asked for: at most a block each and not
    /// beyond `within`, up to the first that is off by more than [`EDGE_SIGMAS`].
    pub fn grow(
        &self,
        accel: &[Vec<f64>; 3],
        rows: Range<usize>,
        within: Range<usize>,
    ) -> Range<usize> {
        if !self.grows {
            return rows;
        }
        let (mean, _) = moments(accel, rows.clone());
        // The floor is the sum over the three axes.
        let far = EDGE_SIGMAS * (self.floor / 3.0).sqrt();
        let at = |row: usize| std::array::from_fn(|axis| accel[axis][row]);
        let belongs = |row: &usize| distance(at(*row), mean) <= far;
        let before = (within.start..rows.start).rev().take(self.width);
        let after = (rows.end..within.end).take(self.width);
        let from = before.take_while(belongs).last().unwrap_or(rows.start);
        let to = after.take_while(belongs).last().map_or(rows.end, |r| r + 1);
        from..to
    }
}

/// A row further than this many standard deviations of an axis from the mean of
/// a still does not belong to it: one in 65,000 of those that do.
const EDGE_SIGMAS: f64 = 5.0;

/// The level that the quietest twentieth of the blocks stays under, and no less than
/// rounding to `step` makes. None where nothing but zeros is there and the steps are
/// not known either.
pub(crate) fn quiet_level(variances: impl Iterator<Item = f64>, step: &[f64]) -> Option<f64> {
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

/// How far two means of one reading may be apart by rounding alone: where noise is
/// less than a step, they go from one step to the next at once.
pub(crate) fn step_of_means(floor: f64, step: &[f64]) -> f64 {
    // Of a level as low as rounding itself nothing has to be noise.
    let left: f64 = step
        .iter()
        .map(|q| rounding::mean_variance(floor / 3.0 - rounding::floor(*q), *q))
        .sum();
    (12.0 * left).sqrt()
}

fn typical_magnitude<'a>(blocks: impl Iterator<Item = &'a Block>) -> f64 {
    let mut norms: Vec<f64> = blocks
        .map(|b| b.mean.iter().map(|m| m * m).sum::<f64>().sqrt())
        .filter(|n| n.is_finite())
        .collect();
    crate::stats::median(&mut norms).unwrap_or(0.0)
}
