//! Rests while the temperature changes, as means of short blocks.

use std::ops::Range;

use gravical_core::matrix3::{norm, sub};
use gravical_signal::stats::{mean_of_finite, median, moments};

use crate::poses::rests::find_quiet;
use crate::recording::Recording;

/// Length of a block, s.
const BLOCK_S: f64 = 3.0;
/// Smallest number of rows of a block.
const MIN_ROWS: usize = 6;
/// Means of neighbouring blocks differ by less than this multiple of the usual step, by the median, …
const JUMP_FACTOR: f64 = 8.0;
/// … or by less than this share of gravity, 0.11°: the sensor was not tilted.
const JUMP_SHARE: f64 = 0.002;

/// Largest number of blocks between, in which the sensor was not quiet, for which the limit is increased
/// in proportion.
const MAX_MISSING: usize = 4;

/// Means of consecutive rows at rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct RestBlock {
    /// Its first row
    row: usize,
    /// Temperature, °C
    pub t_c: f64,
    /// Specific force and angular rate, in the units of the recording; NaN without a gyroscope
    pub readings: [f64; 6],
}

impl RestBlock {
    /// Length of the change of specific force.
    fn step_to(&self, other: &RestBlock) -> f64 {
        let [a, b] = [self, other].map(|block| [0, 1, 2].map(|i| block.readings[i]));
        norm(&sub(&a, &b))
    }
}

/// Rests of a recording, each as its blocks. They are those in which the sensor is quiet: the means of
/// a static interval agree, which excludes drift.
pub(super) fn detect_rests(recording: &Recording) -> Vec<Vec<RestBlock>> {
    let Some(temperature_c) = &recording.temperature_c else {
        return Vec::new();
    };
    let size = (BLOCK_S * recording.working_rate_hz()).round() as usize;
    let size = size.max(MIN_ROWS);
    let block = |row: usize| {
        let rows = row..row + size;
        let mean = |sensor: &[Vec<f64>; 3]| moments(sensor, rows.clone()).0;
        let [ax, ay, az] = mean(&recording.accel);
        let [gx, gy, gz] = recording.gyro.as_ref().map_or([f64::NAN; 3], mean);
        let block = RestBlock {
            row,
            t_c: mean_of_finite(&temperature_c[rows.clone()]),
            readings: [ax, ay, az, gx, gy, gz],
        };
        (block.t_c + ax + ay + az).is_finite().then_some(block)
    };
    let starts = |rest: Range<usize>| (0..rest.len() / size).map(move |k| rest.start + k * size);
    let rests = find_quiet(recording).into_iter();
    let blocks: Vec<RestBlock> = rests.flat_map(starts).filter_map(block).collect();
    let mut steps: Vec<f64> = blocks.windows(2).map(|b| b[0].step_to(&b[1])).collect();
    let usual = 1.4826 * median(&mut steps).unwrap_or(0.0);
    let continues = |a: &RestBlock, b: &RestBlock| {
        let missing = ((b.row - a.row) / size - 1).min(MAX_MISSING);
        let size_of_a = norm(&[0, 1, 2].map(|i| a.readings[i]));
        let max_step = (JUMP_FACTOR * usual).max(JUMP_SHARE * size_of_a);
        let is_near = a.step_to(b) <= max_step * (1 + missing) as f64;
        is_near && !recording.is_broken(&(a.row..b.row + 1))
    };
    blocks.chunk_by(continues).map(<[_]>::to_vec).collect()
}
