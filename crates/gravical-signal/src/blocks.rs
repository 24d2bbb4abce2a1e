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

    /// Of the samples of a span.
    pub fn new(samples: &Samples, span: Range<usize>) -> Block {
        let mean = samples.mean(&span);
        let mut variance = [0.0; 6];
        let (mut low, mut high) = ([f64::MAX; 6], [f64::MIN; 6]);
        for i in span.clone() {
            let x = samples.sample(i);
            for c in 0..6 {
                variance[c] += (x[c] - mean[c]).powi(2);
                (low[c], high[c]) = (low[c].min(x[c]), high[c].max(x[c]));
            }
        }
        let freedom = span.len().saturating_sub(1).max(1) as f64;
        Block {
            mean,
            variance: variance.map(|v| v / freedom),
            range: std::array::from_fn(|c| high[c] - low[c]),
            span,
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
            out.push(Block::new(samples, from..from + size));
            from += size;
        }
    }
    out
}
