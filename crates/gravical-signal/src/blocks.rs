//! Statistics of short blocks of samples.

use std::ops::Range;

use crate::samples::Samples;

/// No IMU is read more often in a second.
const MAX_BLOCK_LEN: usize = 1_000_000;

/// Statistics of a few neighbouring samples.
#[derive(Debug, Clone)]
pub struct Block {
    /// Its samples.
    pub span: Range<usize>,
    /// Mean of each channel.
    pub mean: [f64; 6],
    /// Variance of each channel (n − 1).
    pub variance: [f64; 6],
    /// Largest minus smallest value of each channel.
    pub range: [f64; 6],
}

impl Block {
    /// Variance of the three axes of a sensor together: 0 accelerometer, 1 gyroscope.
    pub fn total_variance(&self, sensor: usize) -> f64 {
        self.variance[3 * sensor..3 * sensor + 3].iter().sum()
    }

    /// Mean of the three axes of a sensor: 0 accelerometer, 1 gyroscope.
    pub fn sensor_mean(&self, sensor: usize) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.mean[3 * sensor + axis])
    }

    /// Of rows of specific force and angular rate, in any unit; of the first `channels`. Values that are not
    /// finite are left out; a channel without any has mean and variance 0.
    pub fn new(
        span: Range<usize>,
        channels: usize,
        rows: impl Iterator<Item = [f64; 6]> + Clone,
    ) -> Block {
        let (mut mean, mut count) = ([0.0; 6], [0.0; 6]);
        for x in rows.clone() {
            for c in (0..channels).filter(|c| x[*c].is_finite()) {
                mean[c] += x[c];
                count[c] += 1.0;
            }
        }
        (0..6).for_each(|c| mean[c] /= f64::max(count[c], 1.0));
        let mut variance = [0.0; 6];
        let (mut low, mut high) = ([f64::MAX; 6], [f64::MIN; 6]);
        for x in rows {
            for c in (0..channels).filter(|c| x[*c].is_finite()) {
                variance[c] += (x[c] - mean[c]).powi(2);
                (low[c], high[c]) = (low[c].min(x[c]), high[c].max(x[c]));
            }
        }
        Block {
            span,
            mean,
            variance: std::array::from_fn(|c| variance[c] / f64::max(count[c] - 1.0, 1.0)),
            range: std::array::from_fn(|c| f64::max(high[c] - low[c], 0.0)),
        }
    }
}

impl Block {
    /// Of neighbouring blocks of the same number of samples.
    pub fn joined(blocks: &[Block]) -> Block {
        let span = blocks[0].span.start..blocks[blocks.len() - 1].span.end;
        let (count, each) = (blocks.len() as f64, blocks[0].span.len() as f64);
        let mean: [f64; 6] =
            std::array::from_fn(|c| blocks.iter().map(|b| b.mean[c]).sum::<f64>() / count);
        let variance = std::array::from_fn(|c| {
            let squares = blocks
                .iter()
                .map(|b| (each - 1.0) * b.variance[c] + each * (b.mean[c] - mean[c]).powi(2));
            squares.sum::<f64>() / (count * each - 1.0)
        });
        Block {
            span,
            mean,
            variance,
            range: [f64::NAN; 6],
        }
    }
}

/// Samples in a block of `seconds`, at least five: a variance of fewer says little.
pub fn block_len(period_s: f64, seconds: f64) -> usize {
    rounded(seconds / period_s.max(f64::MIN_POSITIVE)).clamp(5, MAX_BLOCK_LEN)
}

/// The nearest number of steps; halves are rounded up, however the last digit of a rate is written.
pub(crate) fn rounded(steps: f64) -> usize {
    (steps + 1e-6).round() as usize
}

/// Whole blocks of `size` samples inside `span`, none of them across a gap.
pub fn blocks(samples: &Samples, span: &Range<usize>, size: usize) -> Vec<Block> {
    let mut out = Vec::new();
    let first = samples.pieces.partition_point(|p| p.end <= span.start);
    for piece in &samples.pieces[first..] {
        if piece.start >= span.end {
            break;
        }
        let (mut from, end) = (piece.start.max(span.start), piece.end.min(span.end));
        while from + size <= end {
            let span = from..from + size;
            let rows = span.clone().map(|i| samples.sample(i));
            out.push(Block::new(span, samples.count(), rows));
            from += size;
        }
    }
    out
}
