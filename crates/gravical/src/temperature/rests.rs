//! Rests while the temperature changes, as means of short blocks.
//!
//! The static intervals of [`crate::segment`] cannot be used here: their means must agree, which
//! excludes drift. A block is static if its variance is small; a rest ends at a break of the
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
const MAX_MISSING: usize = 4;

/// Rests of a recording, each as its blocks.
pub(super) fn detect_rests(recording: &Recording) -> Vec<Vec<TemperatureBlock>> {
    let candidates = cut(recording);
    let [accel_step, gyro_step]: [&[f64]; 2] = recording.resolution.split_at(3).into();
    let blocks = || candidates.iter().map(|c| &c.block);
    let Some(accel_floor) = quiet_level(blocks().map(|b| b.variance), accel_step) else {
        return Vec::new();
    };
    let gyro_floor = quiet_level(blocks().map(|b| b.gyro_variance), gyro_step);
    let max_gyro = QUIET_FACTOR_GYRO * gyro_floor.unwrap_or(f64::INFINITY);
    let is_static = |c: &TemperatureBlock| {
        let gyro = c.block.gyro_variance;
        c.block.variance <= QUIET_FACTOR * accel_floor && (gyro.is_nan() || gyro <= max_gyro)
    };
    let blocks: Vec<TemperatureBlock> = candidates.into_iter().filter(is_static).collect();
    let mut steps: Vec<f64> = blocks.windows(2).map(|w| step(&w[0], &w[1])).collect();
    let mut norms: Vec<f64> = blocks.iter().map(|c| norm(&c.block.mean)).collect();
    let usual = 1.4826 * median(&mut steps).unwrap_or(0.0);
    let gravity = median(&mut norms).unwrap_or(0.0);
    let max_step =
        (JUMP_FACTOR * usual).max(JUMP_SHARE * gravity) + step_of_means(accel_floor, accel_step);
    let continues = |a: &TemperatureBlock, b: &TemperatureBlock| {
        let missing = b.number.saturating_sub(a.number + 1).min(MAX_MISSING);
        a.segment == b.segment && step(a, b) <= max_step * (1 + missing) as f64
    };
    blocks.chunk_by(continues).map(<[_]>::to_vec).collect()
}

fn cut(recording: &Recording) -> Vec<TemperatureBlock> {
    let Some(temperature) = &recording.temperature_c else {
        return Vec::new();
    };
    let gyro = recording.gyro.as_ref();
    let mut cutter = TemperatureCutter::new(recording.working_rate_hz().0, gyro.is_some());
    for rows in recording.segments() {
        for row in rows.clone() {
            let rate = gyro.map_or([f64::NAN; 3], |g| g.each_ref().map(|c| c[row]));
            let is_break = row == rows.start;
            cutter.push(temperature[row], recording.accel_at(row), rate, is_break);
        }
    }
    cutter.blocks()
}

fn step(a: &TemperatureBlock, b: &TemperatureBlock) -> f64 {
    norm(&sub(&a.block.mean, &b.block.mean))
}
