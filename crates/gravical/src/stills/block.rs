//! Short blocks of rows with their statistics.

use std::ops::Range;

use crate::stats::moments;

/// Statistics of consecutive rows.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub rows: Range<usize>,
    pub mean: [f64; 3],
    /// Sum over the axes.
    pub variance: f64,
    /// The same for the gyroscope; NaN without one.
    pub gyro_variance: f64,
}

impl Block {
    /// Statistics of `rows`, whose values are at `at` in the channels.
    pub fn of(
        accel: &[Vec<f64>; 3],
        gyro: Option<&[Vec<f64>; 3]>,
        at: Range<usize>,
        rows: Range<usize>,
    ) -> Self {
        let (mean, variance) = moments(accel, at.clone());
        let gyro_variance = gyro.map_or(f64::NAN, |g| moments(g, at).1);
        Block {
            rows,
            mean,
            variance,
            gyro_variance,
        }
    }
}
