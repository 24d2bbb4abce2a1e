//! Means of short static blocks, grouped into intervals in one pose.
//!
//! The static intervals of [`crate::segment`] cannot be used here: their means must agree, which
//! excludes drift. A block is static if its variance is small; an interval ends at a break of the
//! recording and where the mean of the accelerometer jumps.

use gravical_core::matrix3::{norm, sub};

use crate::recording::Recording;
use crate::stats::median;
use crate::still::{TemperatureBlock, TemperatureCutter, quiet_level, step_of_means};

/// Variances of static blocks are below this multiple of the noise floor …
const QUIET_FACTOR: f64 = 9.0;
/// … and this multiple for the gyroscope, which measures every vibration.
const QUIET_FACTOR_GYRO: f64 = 81.0;
/// Means of neighbouring blocks differ by less than this multiple of the usual step (1.4826 × the
/// median) …
const JUMP_FACTOR: f64 = 8.0;
/// … or by less than this share of gravity, 0.11°.
const JUMP_SHARE: f64 = 0.002;
/// Largest number of removed blocks for which the limit is increased in proportion.
const MOST_MISSING: usize = 4;

/// Mean of a block.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub t_c: f64,
    /// Accelerometer and gyroscope; NaN without one.
    pub values: [f64; 6],
}

impl Block {
    fn of(one: &TemperatureBlock) -> Self {
        let [x, y, z] = one.block.mean;
        let [p, q, r] = one.block.gyro_mean;
        Block {
            t_c: one.t_c,
            values: [x, y, z, p, q, r],
        }
    }
}

/// An interval in one pose.
#[derive(Debug, Clone)]
pub(super) struct PoseInterval {
    pub recording: usize,
    pub blocks: Vec<Block>,
}

impl PoseInterval {
    /// Lowest and highest temperature.
    pub fn range_c(&self) -> [f64; 2] {
        self.blocks
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], b| {
                [low.min(b.t_c), high.max(b.t_c)]
            })
    }
}

/// Intervals of `recording`, which has temperatures; `index` is its number.
pub(super) fn intervals(recording: &Recording, index: usize) -> Vec<PoseInterval> {
    let candidates = cut(recording);
    let steps: [&[f64]; 2] = recording.resolution.split_at(3).into();
    let blocks = || candidates.iter().map(|c| &c.block);
    let Some(accel_floor) = quiet_level(blocks().map(|b| b.variance), steps[0]) else {
        return Vec::new();
    };
    let gyro_floor = quiet_level(blocks().map(|b| b.gyro_variance), steps[1]);
    let gyro_floor = gyro_floor.unwrap_or(f64::INFINITY);
    let still: Vec<&TemperatureBlock> = candidates
        .iter()
        .filter(|c| {
            let (accel, gyro) = (c.block.variance, c.block.gyro_variance);
            accel <= QUIET_FACTOR * accel_floor
                && (gyro.is_nan() || gyro <= QUIET_FACTOR_GYRO * gyro_floor)
        })
        .collect();
    let mut jumps: Vec<f64> = still.windows(2).map(|w| step(w[0], w[1])).collect();
    let mut norms: Vec<f64> = still.iter().map(|c| norm(&c.block.mean)).collect();
    let usual = 1.4826 * median(&mut jumps).unwrap_or(0.0);
    let gravity = median(&mut norms).unwrap_or(0.0);
    let most =
        (JUMP_FACTOR * usual).max(JUMP_SHARE * gravity) + step_of_means(accel_floor, steps[0]);

    let mut out: Vec<PoseInterval> = Vec::new();
    let mut last: Option<&TemperatureBlock> = None;
    for candidate in still {
        let follows = last.is_some_and(|before| {
            let missing = (candidate.number - before.number - 1).min(MOST_MISSING);
            candidate.segment == before.segment
                && step(before, candidate) <= most * (1 + missing) as f64
        });
        match out.last_mut() {
            Some(pose) if follows => pose.blocks.push(Block::of(candidate)),
            _ => out.push(PoseInterval {
                recording: index,
                blocks: vec![Block::of(candidate)],
            }),
        }
        last = Some(candidate);
    }
    out
}

fn cut(recording: &Recording) -> Vec<TemperatureBlock> {
    if let Some(excerpt) = &recording.excerpt {
        return excerpt.thermal.clone();
    }
    let Some(temperature) = &recording.temperature_c else {
        return Vec::new();
    };
    let gyro = recording.gyro.as_ref();
    let mut cutter = TemperatureCutter::new(recording.working_rate_hz().0, gyro.is_some());
    for rows in recording.segments() {
        for row in rows.clone() {
            let rate = gyro.map_or([f64::NAN; 3], |g| g.each_ref().map(|c| c[row]));
            let parts = row == rows.start;
            cutter.push(temperature[row], recording.accel_at(row), rate, parts);
        }
    }
    cutter.blocks()
}

fn step(a: &TemperatureBlock, b: &TemperatureBlock) -> f64 {
    norm(&sub(&a.block.mean, &b.block.mean))
}
