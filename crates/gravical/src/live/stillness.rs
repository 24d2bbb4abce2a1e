//! Whether the sensor lies still, block by block.
//!
//! A guided session decides while the sensor still lies there, so it knows its noise from what came
//! before: a block of 0.2 s is quiet up to three times the scatter of the quietest blocks (gyroscope:
//! 18 times, which shows more of the unsteadiness of a hand), and a hold is a run of quiet blocks whose
//! means agree. A recording is judged by [`crate::poses::rests::find_rests`], which knows what follows.

use std::collections::VecDeque;
use std::ops::Range;

use gravical_core::matrix3::{norm, sub};
use gravical_core::rounding;
use gravical_recording::Sample;
use gravical_signal::{BLOCK_S, block_len};

use super::judge::Means;
use crate::stats::SortedWindow;
use crate::stats::floors;

/// Noise at rest over the magnitude at most, three axes together: twice that of a bad MPU6050
/// without low-pass. Where the quietest blocks scatter more, the sensor has not rested yet.
pub(super) const MAX_NOISE_AT_REST: f64 = 0.035;

/// Fraction of the blocks that is quiet in any session.
const QUIET_SHARE: f64 = 0.05;
/// A block is quiet up to this multiple of the scatter of the quietest: of accelerometer, gyroscope …
const MAX_EXCESS: [f64; 2] = [3.0, 18.0];
/// … and of rounding: values that alternate between neighbouring steps have less than twice that.
const MAX_ROUNDING: f64 = 6.0;
/// Means of blocks agree within this multiple of noise/√rows …
const MAX_MEAN: f64 = 10.0;
/// … or within this fraction of gravity, the vibration of a table.
const TREMOR: f64 = 0.004;

/// The state after a whole block. Values are in the unit of the rows, scatters roots of the sum of the
/// variances of three axes; NaN without a gyroscope.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stillness {
    /// Rows of the block.
    pub block: Range<usize>,
    /// Rows up to its end that were quiet without interruption and whose means agree; none if it is not
    /// quiet.
    pub run: Option<Range<usize>>,
    /// Scatter of the block, and the largest of a quiet one: of accelerometer and gyroscope.
    pub scatter: [f64; 2],
    pub max_scatter: [f64; 2],
    /// Scatter of the quietest blocks.
    pub noise: f64,
}

struct Block {
    rows: Range<usize>,
    mean: [f64; 3],
    variance: [f64; 2],
}

/// Finds it as rows arrive.
pub(super) struct StillnessDetector {
    /// Rows of a block.
    size: usize,
    /// Blocks that are looked back upon for a run.
    max_run: usize,
    /// Steps that the values come in.
    resolution: [f64; 6],
    /// Rows of the next block.
    samples: Vec<Sample>,
    /// Blocks since the last interruption.
    blocks: VecDeque<Block>,
    /// Variances of all blocks.
    variances: [SortedWindow; 2],
}

impl StillnessDetector {
    /// For runs of at least `run_s`.
    pub fn new(rate_hz: f64, resolution: [f64; 6], run_s: f64) -> Self {
        let size = block_len(rate_hz.recip(), BLOCK_S);
        StillnessDetector {
            size,
            max_run: (run_s * rate_hz / size as f64).ceil() as usize + 1,
            resolution,
            samples: Vec::new(),
            blocks: VecDeque::new(),
            variances: [(); 2].map(|()| SortedWindow::new(std::iter::empty())),
        }
    }

    /// The next row does not follow the last one: no run spans both.
    pub fn split(&mut self) {
        self.samples.clear();
        self.blocks.clear();
    }

    /// Takes a row; the state if it completes a block.
    pub fn push(&mut self, sample: Sample) -> Option<Stillness> {
        self.samples.push(sample);
        if self.samples.len() < self.size {
            return None;
        }
        let (first, last) = (self.samples[0].row, sample.row);
        let means = Means::of(&self.samples);
        self.samples.clear();
        let block = Block {
            rows: first..last + 1,
            mean: means.accel,
            variance: [means.sigma, means.gyro_sigma].map(|s| s * s),
        };
        for ((all, variance), step) in self
            .variances
            .iter_mut()
            .zip(block.variance)
            .zip(self.resolution.chunks(3))
        {
            // A sensor that is not read has no noise.
            if variance > 0.0 || variance == 0.0 && floors(step) > 0.0 {
                all.insert(variance);
            }
        }
        self.blocks.push_back(block);
        if self.blocks.len() > self.max_run {
            self.blocks.pop_front();
        }
        self.state()
    }

    fn state(&self) -> Option<Stillness> {
        let last = self.blocks.back()?;
        let [accel_step, gyro_step] = [&self.resolution[..3], &self.resolution[3..]];
        let level = quiet_level(&self.variances[0], accel_step)?;
        let gyro_level = quiet_level(&self.variances[1], gyro_step).unwrap_or(f64::INFINITY);
        let most = [
            max_variance(level, MAX_EXCESS[0], accel_step),
            max_variance(gyro_level, MAX_EXCESS[1], gyro_step),
        ];
        let is_quiet = |block: &Block| {
            let [accel, gyro] = block.variance;
            accel <= most[0] && (gyro.is_nan() || gyro <= most[1])
        };
        let white = MAX_MEAN * (level / self.size as f64).sqrt();
        let agree = white.max(TREMOR * norm(&last.mean)) + step_of_means(level, accel_step);
        let (mut low, mut high, mut run) = (last.mean, last.mean, None);
        for block in self.blocks.iter().rev() {
            for axis in 0..3 {
                low[axis] = low[axis].min(block.mean[axis]);
                high[axis] = high[axis].max(block.mean[axis]);
            }
            if !is_quiet(block) || norm(&sub(&high, &low)) > 2.0 * agree {
                break;
            }
            run = Some(block.rows.start..last.rows.end);
        }
        Some(Stillness {
            block: last.rows.clone(),
            run,
            scatter: last.variance.map(f64::sqrt),
            max_scatter: most.map(f64::sqrt),
            noise: level.sqrt(),
        })
    }
}

/// The variance that the quietest twentieth of the blocks stay below, at least that of rounding.
fn quiet_level(sorted: &SortedWindow, step: &[f64]) -> Option<f64> {
    let values = sorted.values();
    let at = (values.len() as f64 * QUIET_SHARE) as usize;
    values.get(at).map(|level| level.max(floors(step)))
}

/// The contribution of rounding is known: only the rest is multiplied.
fn max_variance(level: f64, factor: f64, step: &[f64]) -> f64 {
    let rounding = floors(step).min(level);
    (level - rounding) * factor.powi(2) + rounding * MAX_ROUNDING.min(factor).powi(2)
}

/// Largest difference of two means of one reading by rounding: noise below a step leaves means that
/// change by a whole step.
fn step_of_means(level: f64, step: &[f64]) -> f64 {
    let left = step
        .iter()
        .map(|q| rounding::mean_variance(level / 3.0 - rounding::floor(*q), *q));
    (12.0 * left.sum::<f64>()).sqrt()
}
