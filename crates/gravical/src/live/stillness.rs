//! Whether the sensor lies still, block by block.
//!
//! A guided session decides while the sensor still lies there, so it knows its noise from what came
//! before: a block of 0.2 s is quiet up to three times the scatter of the quietest blocks (gyroscope:
//! 18 times, which shows more of the unsteadiness of a hand), and a hold is a run of quiet blocks whose
//! means agree. A recording is judged by [`crate::poses::rests::find_rests`], which knows what follows.

use std::collections::VecDeque;
use std::ops::Range;

use gravical_core::matrix3::{norm, sub};
use gravical_recording::Sample;
use gravical_signal::{BLOCK_S, block_len};

use super::rest::Means;
use crate::rounding;
use crate::stats::floors;

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

/// The state after a whole block, in the unit of the rows; scatters as in [`Means`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stillness {
    /// Rows up to the end of the block that were quiet without interruption and whose means agree; none
    /// if it is not quiet.
    pub run: Option<Range<usize>>,
    /// Scatter of the block, and the largest of a quiet one: of accelerometer and gyroscope.
    pub scatter: [f64; 2],
    pub max_scatter: [f64; 2],
    /// Scatter of the quietest blocks.
    pub noise: f64,
}

/// Finds it as rows arrive.
pub(super) struct StillnessDetector {
    /// Rows of a block.
    size: usize,
    /// Blocks that are looked back upon for a run.
    max_run: usize,
    /// Steps that the values come in.
    resolution: [[f64; 3]; 2],
    /// Rows of the next block.
    samples: Vec<Sample>,
    /// First rows and means of the blocks since the last interruption.
    blocks: VecDeque<(usize, Means)>,
    /// Variances of all blocks, in order.
    variances: [Vec<f64>; 2],
}

impl StillnessDetector {
    /// For runs of at least `run_s`.
    pub fn new(rate_hz: f64, resolution: [[f64; 3]; 2], run_s: f64) -> Self {
        let size = block_len(rate_hz.recip(), BLOCK_S);
        StillnessDetector {
            size,
            max_run: (run_s * rate_hz / size as f64).ceil() as usize + 1,
            resolution,
            samples: Vec::new(),
            blocks: VecDeque::new(),
            variances: [Vec::new(), Vec::new()],
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
        let means = Means::of(&self.samples);
        self.blocks.push_back((self.samples[0].row, means));
        if self.blocks.len() > self.max_run {
            self.blocks.pop_front();
        }
        self.samples.clear();
        let mut level = [f64::INFINITY; 2];
        let mut max_scatter = level;
        for (sensor, step) in self.resolution.iter().enumerate() {
            let sorted = &mut self.variances[sensor];
            let variance = means.scatter[sensor].powi(2);
            // A sensor that is not read has no noise.
            if variance > 0.0 || variance == 0.0 && floors(step) > 0.0 {
                let place = sorted.partition_point(|v| *v < variance);
                sorted.insert(place, variance);
            }
            let quiet = (sorted.len() as f64 * QUIET_SHARE) as usize;
            if let Some(quiet) = sorted.get(quiet) {
                // The contribution of rounding is known: only the rest is multiplied.
                let rounding = floors(step);
                let excess = MAX_EXCESS[sensor];
                level[sensor] = quiet.max(rounding);
                let max = (level[sensor] - rounding) * excess.powi(2)
                    + rounding * MAX_ROUNDING.min(excess).powi(2);
                max_scatter[sensor] = max.sqrt();
            }
        }
        level[0].is_finite().then(|| Stillness {
            run: self.run(&means, level[0], max_scatter, sample.row + 1),
            scatter: means.scatter,
            max_scatter,
            noise: level[0].sqrt(),
        })
    }

    /// The rows of the quiet blocks up to row `end` whose means agree with the last one.
    fn run(
        &self,
        last: &Means,
        level: f64,
        max_scatter: [f64; 2],
        end: usize,
    ) -> Option<Range<usize>> {
        let white = MAX_MEAN * (level / self.size as f64).sqrt();
        let agree =
            white.max(TREMOR * norm(&last.accel)) + step_of_means(level, &self.resolution[0]);
        let (mut low, mut high) = (last.accel, last.accel);
        let agrees = |block: &&(usize, Means)| {
            for axis in 0..3 {
                low[axis] = low[axis].min(block.1.accel[axis]);
                high[axis] = high[axis].max(block.1.accel[axis]);
            }
            let [accel, gyro] = block.1.scatter;
            accel <= max_scatter[0]
                && (gyro.is_nan() || gyro <= max_scatter[1])
                && norm(&sub(&high, &low)) <= 2.0 * agree
        };
        let first = self.blocks.iter().rev().take_while(agrees).last()?;
        Some(first.0..end)
    }
}

/// Largest difference of two means of one reading by rounding: noise below a step leaves means that
/// change by a whole step.
fn step_of_means(level: f64, step: &[f64]) -> f64 {
    let left = step
        .iter()
        .map(|q| rounding::mean_variance(level / 3.0 - rounding::floor(*q), *q));
    (12.0 * left.sum::<f64>()).sqrt()
}
