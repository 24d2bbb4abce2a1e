//! From the rows of a recording at rest to evenly spaced samples without gaps.

use std::ops::Range;

use crate::recording::Recording;
use gravical_signal::quantile;
use gravical_signal::stats::{floors, pooled_deviation};

/// Up to this many consecutive samples that are missing are replaced by earlier ones.
const MAX_FILLED: usize = 8;
/// A missing sample is replaced by the one so many samples before it.
const BACK: usize = 64;
/// Stands for the row of a missing sample.
const MISSING: u32 = u32::MAX;
/// A block whose standard deviation is this multiple of that of the median one is disturbed.
const DISTURBED: f64 = 3.0;

/// Rows at rest in pieces without a gap, one for each sampling period or [`MISSING`].
pub(super) struct Pieces {
    pieces: Vec<Vec<u32>>,
    /// Sampling period, s: the mean over the samples that follow each other.
    pub period_s: f64,
}

impl Pieces {
    /// Of the rows in `ranges`, at about `period_s`.
    pub fn new(recording: &Recording, ranges: &[Range<usize>], period_s: f64) -> Self {
        let mut pieces = Vec::new();
        let (mut time_s, mut periods) = (0.0, 0.0);
        let stamp = |row: usize| recording.time_s.as_ref().map_or(f64::NAN, |t| t[row]);
        for range in ranges {
            let mut piece = vec![range.start as u32];
            // Stamps that repeat are made up for by the next gap.
            let mut repeated = 0;
            for row in range.start + 1..range.end {
                let step_s = stamp(row) - stamp(row - 1);
                let steps = (step_s / period_s).round();
                let is_break = recording.breaks.binary_search(&row).is_ok();
                if is_break || steps < 0.0 || steps > (MAX_FILLED + 1) as f64 {
                    pieces.push(std::mem::take(&mut piece));
                    repeated = 0;
                } else if steps.is_finite() {
                    let steps = steps as usize;
                    let missing = steps.saturating_sub(1 + repeated);
                    repeated = (1 + repeated).saturating_sub(steps).min(MAX_FILLED);
                    piece.extend(std::iter::repeat_n(MISSING, missing));
                    time_s += step_s;
                    periods += 1.0 + missing as f64;
                }
                piece.push(row as u32);
            }
            pieces.push(piece);
        }
        let measured = periods > 0.0;
        Pieces {
            pieces,
            period_s: if measured { time_s / periods } else { period_s },
        }
    }

    /// Leaves out blocks of `width` samples in which the accelerometer is disturbed: a knock, a footstep.
    pub fn leave_out_disturbances(&mut self, recording: &Recording, width: usize) {
        let variance = |block: &[u32]| -> f64 {
            let of_axis = |axis: &Vec<f64>| {
                let values: Vec<f64> = cells(axis, block).collect();
                pooled_deviation(std::iter::once(&values[..])).powi(2)
            };
            recording.accel.iter().map(of_axis).sum()
        };
        let floor = floors(&recording.units.resolution[0]);
        let blocks = self.pieces.iter().flat_map(|piece| piece.chunks(width));
        let variances = blocks.map(variance).filter(|v| v.is_finite());
        let usual = quantile(variances.collect(), 0.5).max(floor);
        let quiet = |piece: &Vec<u32>| -> Vec<Vec<u32>> {
            let blocks: Vec<&[u32]> = piece.chunks(width).collect();
            let parts = blocks.split(|block| variance(block) > DISTURBED.powi(2) * usual);
            parts.map(<[&[u32]]>::concat).collect()
        };
        self.pieces = self.pieces.iter().flat_map(quiet).collect();
    }

    /// The rows that are used.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        let rows = self.pieces.iter().flatten().filter(|row| **row != MISSING);
        rows.map(|row| *row as usize)
    }

    /// The samples of a column in segments. Missing ones are replaced by earlier ones: they have the noise of
    /// the sensor, which an interpolation does not have. After too many a new segment begins.
    pub fn samples(&self, column: &[f64]) -> Vec<Vec<f64>> {
        let mut segments = Vec::new();
        for piece in &self.pieces {
            let mut samples: Vec<f64> = Vec::with_capacity(piece.len());
            let mut missing = 0;
            for value in cells(column, piece) {
                if !value.is_finite() {
                    missing += 1;
                    continue;
                }
                if missing > MAX_FILLED {
                    segments.push(std::mem::take(&mut samples));
                }
                for _ in 0..std::mem::take(&mut missing) {
                    let earlier = samples.get(samples.len().saturating_sub(BACK)).copied();
                    samples.extend(earlier);
                }
                samples.push(value);
            }
            segments.push(samples);
        }
        segments.retain(|samples| !samples.is_empty());
        segments
    }
}

/// Cells of a column; NaN for missing samples.
fn cells<'a>(column: &'a [f64], rows: &'a [u32]) -> impl Iterator<Item = f64> + 'a {
    rows.iter()
        .map(|row| column.get(*row as usize).copied().unwrap_or(f64::NAN))
}
