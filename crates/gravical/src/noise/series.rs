//! From the rows of a recording at rest to evenly spaced samples without gaps.

use std::ops::Range;

use super::TemperatureDrift;
use crate::recording::Recording;
use crate::stats::{mean_of_finite, pooled_deviation, standard_deviation};

/// Up to this many consecutive samples that are missing are replaced by earlier ones.
const MAX_FILLED: usize = 8;
/// A missing sample is replaced by the one so many samples before it.
const BACK: usize = 64;
/// Stands for the row of a missing sample.
const MISSING: u32 = u32::MAX;
/// Length of the means that are compared with the temperature, and of those about which samples
/// scatter, s.
const MEAN_S: f64 = 1.0;
/// Fewest means that show a dependence on the temperature.
const MIN_MEANS: usize = 10;
/// Fraction of slow changes that the temperature explains, and the deviation from no dependence.
const EXPLAINED: f64 = 0.5;
const SIGNIFICANT: f64 = 5.0;

/// What was used of a recording.
#[derive(Debug, Clone, Default)]
pub(super) struct Counts {
    /// Rows in quiet blocks.
    pub used: u64,
    /// Samples that were replaced, and segments between gaps: of the channel with most.
    pub filled: u64,
    pub segments: u64,
    pub temperature_c: Option<[f64; 2]>,
}

/// Rows at rest in pieces without a gap, one for each sampling period or [`MISSING`].
pub(super) struct Pieces {
    pieces: Vec<Vec<u32>>,
    pub counts: Counts,
    /// Sampling period, s: the mean over the samples that follow each other.
    pub period_s: f64,
}

impl Pieces {
    /// Of the rows in `ranges`, at about `period_s`.
    pub fn new(recording: &Recording, ranges: &[Range<usize>], period_s: f64) -> Self {
        let mut pieces: Vec<Vec<u32>> = Vec::new();
        let mut counts = Counts::default();
        let (mut time_s, mut periods) = (0.0, 0.0);
        let stamp = |row: usize| recording.time_s.as_ref().map_or(f64::NAN, |t| t[row]);
        for range in ranges {
            let mut piece = Vec::with_capacity(range.len());
            // Stamps that repeat are made up for by the next gap.
            let mut repeated = 0;
            for row in range.clone() {
                counts.used += 1;
                let step_s = if row > range.start {
                    stamp(row) - stamp(row - 1)
                } else {
                    f64::NAN
                };
                let steps = (step_s / period_s).round();
                let is_break = recording.breaks.binary_search(&row).is_ok();
                if row > range.start && is_break || steps < 0.0 || steps > (MAX_FILLED + 1) as f64 {
                    pieces.push(std::mem::take(&mut piece));
                    repeated = 0;
                } else if steps == 0.0 {
                    repeated = (repeated + 1).min(MAX_FILLED);
                    time_s += step_s;
                    periods += 1.0;
                } else if steps.is_finite() {
                    let lost = steps as usize - 1;
                    let missing = lost.saturating_sub(repeated);
                    repeated -= lost - missing;
                    piece.extend(std::iter::repeat_n(MISSING, missing));
                    time_s += step_s;
                    periods += 1.0 + missing as f64;
                }
                piece.push(row as u32);
            }
            pieces.push(piece);
        }
        let rows = ranges.iter().flat_map(Clone::clone);
        let temperature = recording.temperature_c.as_deref();
        counts.temperature_c = temperature.and_then(|t| extent(rows.map(|row| t[row])));
        Pieces {
            pieces,
            counts,
            period_s: if periods > 0.0 {
                time_s / periods
            } else {
                period_s
            },
        }
    }

    /// Leaves out blocks of `width` samples in which the variance of the accelerometer, sum of the
    /// axes, is larger than this.
    pub fn leave_out_disturbances(&mut self, accel: &[Vec<f64>; 3], width: usize, max: f64) {
        let mut quiet = Vec::new();
        for piece in std::mem::take(&mut self.pieces) {
            let mut part = Vec::with_capacity(piece.len());
            for block in piece.chunks(width) {
                let variance = |axis: &Vec<f64>| {
                    let values = cells(axis, block).filter(|v| v.is_finite());
                    standard_deviation(&values.collect::<Vec<f64>>()).powi(2)
                };
                if accel.iter().map(variance).sum::<f64>() > max {
                    self.counts.used -= block.iter().filter(|r| **r != MISSING).count() as u64;
                    quiet.push(std::mem::take(&mut part));
                } else {
                    part.extend_from_slice(block);
                }
            }
            quiet.push(part);
        }
        self.pieces = quiet;
    }

    /// The samples of a column in segments. Missing ones are replaced by earlier ones: they have the
    /// noise of the sensor, which an interpolation does not have. After too many a new segment begins.
    pub fn samples(&mut self, column: &[f64]) -> Vec<Vec<f64>> {
        let (mut segments, mut filled) = (Vec::new(), 0);
        for piece in &self.pieces {
            let mut samples: Vec<f64> = Vec::with_capacity(piece.len());
            let mut missing = 0;
            for value in cells(column, piece) {
                if !value.is_finite() {
                    missing += 1;
                    continue;
                }
                if missing > MAX_FILLED && !samples.is_empty() {
                    segments.push(std::mem::take(&mut samples));
                } else if !samples.is_empty() {
                    for _ in 0..missing {
                        samples.push(samples[samples.len().saturating_sub(BACK)]);
                    }
                    filled += missing as u64;
                }
                missing = 0;
                samples.push(value);
            }
            segments.push(samples);
        }
        segments.retain(|samples| !samples.is_empty());
        let counts = &mut self.counts;
        counts.filled = counts.filled.max(filled);
        counts.segments = counts.segments.max(segments.len() as u64);
        segments
    }

    /// The dependence of a column on the temperature, if it explains most of the slow changes; `n` is the
    /// noise density of the column.
    pub fn temperature_drift(
        &self,
        column: &[f64],
        temperature_c: &[f64],
        n: f64,
    ) -> Option<TemperatureDrift> {
        let chunk = (MEAN_S / self.period_s).ceil() as usize;
        let chunks = self.pieces.iter().flat_map(|piece| piece.chunks(chunk));
        let mean = |column: &[f64], rows: &[u32]| {
            mean_of_finite(&cells(column, rows).collect::<Vec<f64>>())
        };
        let means: Vec<(f64, f64)> = chunks
            .filter(|rows| 2 * rows.len() > chunk)
            .map(|rows| (mean(temperature_c, rows), mean(column, rows)))
            .filter(|(t_c, value)| t_c.is_finite() && value.is_finite())
            .collect();
        let count = means.len() as f64;
        if means.len() < MIN_MEANS {
            return None;
        }
        let centre = |of: fn(&(f64, f64)) -> f64| means.iter().map(of).sum::<f64>() / count;
        let (mean_c, mean) = (centre(|m| m.0), centre(|m| m.1));
        let sum = |of: &dyn Fn(f64, f64) -> f64| {
            means
                .iter()
                .map(|(t, v)| of(t - mean_c, v - mean))
                .sum::<f64>()
        };
        let squares_c = sum(&|t, _| t * t);
        let slope = sum(&|t, v| t * v) / squares_c;
        // White noise of the means is no slow change; its sum of squares is known up to chance.
        let white = n * n / MEAN_S;
        let slow = (sum(&|_, v| v * v) - white * count).max(white * (2.0 * count).sqrt());
        let by_temperature = slope * slope * squares_c;
        let is_significant = by_temperature.sqrt() > SIGNIFICANT * white.sqrt();
        let explained = (by_temperature / slow).min(1.0);
        (slope.is_finite() && is_significant && explained > EXPLAINED).then_some(TemperatureDrift {
            slope_per_c: slope,
            explained,
        })
    }
}

/// Standard deviation of the samples about their means over a second; NaN without two samples that
/// follow each other.
pub(super) fn scatter(segments: &[Vec<f64>], period_s: f64) -> f64 {
    let length = (MEAN_S / period_s).max(2.0) as usize;
    pooled_deviation(segments.iter().flat_map(|s| s.chunks(length)))
}

/// Cells of a column; NaN for missing samples.
fn cells<'a>(column: &'a [f64], rows: &'a [u32]) -> impl Iterator<Item = f64> + 'a {
    rows.iter()
        .map(|row| column.get(*row as usize).copied().unwrap_or(f64::NAN))
}

/// Lowest and highest of the values that are finite.
fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.filter(|v| v.is_finite()).fold(None, |extent, v| {
        let [low, high] = extent.unwrap_or([v; 2]);
        Some([v.min(low), v.max(high)])
    })
}
