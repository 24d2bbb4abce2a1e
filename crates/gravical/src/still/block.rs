//! Short blocks of rows with their statistics.

use std::ops::Range;

use super::{Channels, moments};

/// Statistics of consecutive rows.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub rows: Range<usize>,
    pub mean: [f64; 3],
    /// Sum over the axes.
    pub variance: f64,
    /// The same for the gyroscope; NaN without one.
    pub gyro_mean: [f64; 3],
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
        let (gyro_mean, gyro_variance) = gyro.map_or(([f64::NAN; 3], f64::NAN), |g| moments(g, at));
        Block {
            rows,
            mean,
            variance,
            gyro_mean,
            gyro_variance,
        }
    }
}

/// Divides rows into blocks of `width` rows.
pub(super) fn blocks(recording: &Channels<'_>, rows: Range<usize>, width: usize) -> Vec<Block> {
    let mut out = Vec::with_capacity(rows.len() / width);
    let mut from = rows.start;
    while from + width <= rows.end {
        // The remainder joins the last block.
        let to = if from + 2 * width > rows.end {
            rows.end
        } else {
            from + width
        };
        out.push(Block::of(
            recording.accel,
            recording.gyro,
            from..to,
            from..to,
        ));
        from = to;
    }
    out
}
