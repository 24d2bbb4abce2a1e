//! Rests while the temperature changes, as means of short blocks.

use std::ops::Range;

use crate::poses::rests::find_quiet;
use crate::recording::Recording;
use crate::stats::{mean_of_finite, moments};

/// Length of a block, s.
const BLOCK_S: f64 = 3.0;
/// Smallest number of rows of a block.
const MIN_ROWS: usize = 6;

/// Means of consecutive rows at rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct RestBlock {
    /// Temperature, °C
    pub t_c: f64,
    /// Specific force, in the unit of the recording
    pub accel: [f64; 3],
    /// Angular rate, in the unit of the recording; NaN without a gyroscope
    pub gyro: [f64; 3],
}

/// Rests of a recording, each as its blocks. They are those in which the sensor is quiet: the means of
/// a static interval agree, which excludes drift.
pub(super) fn detect_rests(recording: &Recording) -> Vec<Vec<RestBlock>> {
    let Some(temperature_c) = &recording.temperature_c else {
        return Vec::new();
    };
    let size = (BLOCK_S * recording.working_rate_hz().0).round() as usize;
    let size = size.max(MIN_ROWS);
    let block = |start: usize| {
        let rows = start..start + size;
        let mean = |sensor: &[Vec<f64>; 3]| moments(sensor, rows.clone()).0;
        let block = RestBlock {
            t_c: mean_of_finite(&temperature_c[rows.clone()]),
            accel: mean(&recording.accel),
            gyro: recording.gyro.as_ref().map_or([f64::NAN; 3], mean),
        };
        let is_whole = block.t_c.is_finite() && block.accel.iter().all(|v| v.is_finite());
        is_whole.then_some(block)
    };
    let blocks = |rest: Range<usize>| -> Vec<RestBlock> {
        let count = rest.len() / size;
        (0..count)
            .filter_map(|k| block(rest.start + k * size))
            .collect()
    };
    let mut rests: Vec<_> = find_quiet(recording).into_iter().map(blocks).collect();
    rests.retain(|rest| !rest.is_empty());
    rests
}
