//! Limits of static intervals, computed from short blocks.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::rounding;

use super::block::Block;
use super::runs::{join, split_run, trim};
use super::{StillOptions, block_rows, distance, floors, moments, turning};

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
/// A recording of so many hours may be one of daily life: nobody turns a sensor by hand for longer.
const WORN_HOURS: f64 = 12.0;
/// Limits of van Hees et al., J. Appl. Physiol. 117 (2014) 738, for a sensor that is worn: the
/// standard deviation of each axis at rest, g, and the shortest rest, s. Breath and pulse move a
/// wrist by some mg, many times the noise of a good sensor.
const WORN_SD_G: f64 = 0.013;
const WORN_SHORTEST_S: f64 = 10.0;
/// It is worn if these limits make so many times more of it static than its noise does.
const WORN_GAIN: f64 = 2.0;
/// Median length of a vector with three standard normal components.
const MAXWELL_MEDIAN: f64 = 1.538;

/// The mean angular rates of consecutive static intervals differ by at most this multiple of the
/// scatter allowed in a quiet block …
const MOST_RATE_STEP: f64 = 3.0;
/// … or by this share of the fastest turn: drift of the bias between the intervals, and
/// g-sensitivity in another pose, are smaller.
const TURNING_SHARE: f64 = 0.1;

/// The highest angular rate of a block, relative to the median.
fn fastest(groups: &[Vec<Block>]) -> f64 {
    let blocks = || groups.iter().flatten().map(|b| b.gyro_mean);
    let usual: [f64; 3] = std::array::from_fn(|axis| {
        let mut all: Vec<f64> = blocks().map(|rate| rate[axis]).collect();
        crate::stats::median(&mut all).unwrap_or(f64::NAN)
    });
    let off = blocks().map(|rate| distance(rate, usual));
    off.filter(|rate| rate.is_finite()).fold(0.0, f64::max)
}

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
    /// Largest difference of the angular rates of consecutive intervals.
    agree_rate: f64,
    /// Rows of a block.
    width: usize,
    /// Smallest number of rows of a static interval.
    pub shortest: usize,
    grows: bool,
    /// The limits are those for a sensor that is worn.
    pub worn: bool,
}

impl Levels {
    /// Computes the limits from blocks that are consecutive within each of the `groups`, for
    /// values of the given `resolution`; `None` if all values are zero.
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
        // The contribution of rounding is known: only the rest is multiplied.
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
            worn: false,
        };
        let gravity = typical_magnitude(all());
        // Means of blocks scatter by noise/√width, for correlated noise by a multiple of it.
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
        // Of many blocks only some are there, but their rows are those of the file.
        let rows = groups
            .last()
            .and_then(|g| g.last())
            .map_or(0, |b| b.rows.end);
        if rows as f64 >= WORN_HOURS * 3600.0 * rate {
            let worn = levels.worn(gravity, rate);
            let static_by = |levels: &Levels| all().filter(|b| levels.is_quiet(b)).count() as f64;
            if static_by(&worn) > WORN_GAIN * static_by(&levels) {
                return Some(worn);
            }
        }
        Some(levels)
    }

    /// The same for a sensor that is worn; `gravity` in the unit of the file. The gyroscope, whose
    /// noise is far less than the unrest of a wrist, tells nothing more.
    fn worn(&self, gravity: f64, rate: f64) -> Levels {
        let sd = WORN_SD_G * gravity;
        Levels {
            most_accel: self.most_accel.max(3.0 * sd * sd),
            most_gyro: f64::INFINITY,
            agree: self.agree.max(sd),
            agree_rate: f64::INFINITY,
            shortest: self.shortest.max((WORN_SHORTEST_S * rate) as usize),
            worn: true,
            ..self.clone()
        }
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

    /// Rows of the runs of quiet blocks of a segment whose means agree, before they are
    /// [extended](Self::grow).
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

    /// Removes the intervals in which the sensor turns evenly.
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

    /// True if quiet rows may be a static interval after they are extended.
    pub fn may_be_still(&self, rows: &Range<usize>) -> bool {
        let grown = if self.grows { 2 * self.width } else { 0 };
        rows.len() + grown >= self.shortest
    }

    /// Extends rows at both ends, if the options ask for it: by at most one block each, within
    /// `within`, up to the first row that deviates by more than [`EDGE_SIGMAS`].
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

/// A row that deviates more than this many standard deviations of an axis from the mean is
/// outside the interval; this excludes one in 65,000 rows inside it.
const EDGE_SIGMAS: f64 = 5.0;

/// The level below which the variances of the quietest twentieth of the blocks are, at least that
/// of rounding to `step`. `None` if all values are zero and the resolution is unknown.
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

/// Largest difference of two means of one reading caused by rounding: if noise is less than a
/// step, means change by a whole step.
pub(crate) fn step_of_means(floor: f64, step: &[f64]) -> f64 {
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
