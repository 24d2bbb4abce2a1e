//! The sensor at rest: since when, block by block, and what is wrong with it as a pose.
//!
//! A guided session decides while the sensor still lies there, so it knows its noise from what came
//! before: a block of 0.2 s is quiet up to three times the scatter of the quietest blocks (gyroscope:
//! 18 times, which shows more of the unsteadiness of a hand), and a hold is a run of quiet blocks whose
//! means agree. A recording is judged by [`gravical_calibrate::poses::rests::find_rests`], which knows what follows.

use std::collections::VecDeque;
use std::ops::Range;

use gravical_core::matrix3::{norm, sub};
use gravical_recording::Sample;
use gravical_recording::full_scale::clipped_count;
use gravical_signal::{BLOCK_S, block_len};

use crate::event::Rejection;
use gravical_calibrate::poses::face::AXES;
use gravical_calibrate::recording::units::AccelScale;
use gravical_calibrate::rounding;
use gravical_calibrate::stats::{floors, mean_of_finite, moments};

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
/// A magnitude further from gravity than these factors is another unit, or another scale.
const OTHER_UNIT: f64 = 2.0;
const MAX_OFF: f64 = 0.35;
/// A mean angular rate that differs from that of the first rest by more is a steady turn, °/s.
const MAX_TURNING_DEG_S: f64 = 5.0;

/// The remedy for what moved.
pub(crate) const LET_GO: &str = "Lay it down, take the hand off, and wait.";

/// The state after a whole block, in the unit of the rows; scatters as in [`Means`].
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stillness {
    /// Rows up to the end of the block that were quiet without interruption and whose means agree; none
    /// if it is not quiet.
    pub run: Option<Range<usize>>,
    /// Scatter of the block, and the largest of a quiet one: of accelerometer and gyroscope.
    pub scatter: [f64; 2],
    pub max_scatter: [f64; 2],
    /// Scatter of the quietest blocks.
    pub noise: f64,
}

/// Finds holds as rows arrive.
pub(crate) struct StillnessDetector {
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

/// Why a hold is no pose, and in whole sentences what to do.
pub(crate) type Fault = (Rejection, String);

/// What is known of the units once the noise is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Units {
    /// Subtracted from the counts of the accelerometer.
    pub zero_offset: f64,
    /// Units of the recording per m/s².
    pub nominal: f64,
    pub scale: AccelScale,
    /// Units of the gyroscope per rad/s.
    pub gyro_nominal: Option<f64>,
    /// What the gyroscope read in the first rest.
    pub gyro_bias: [f64; 3],
}

impl Units {
    /// What is wrong with a capture, the gravest fault first.
    pub fn fault(&self, samples: &[Sample], means: &Means, gravity_mps2: f64) -> Option<Fault> {
        self.clipped(samples)
            .or_else(|| self.magnitude_fault(means.accel, gravity_mps2))
            .or_else(|| self.turning(means))
    }

    fn clipped(&self, samples: &[Sample]) -> Option<Fault> {
        let axes = columns(samples, |s| s.accel);
        let axis = (0..3).find(|&axis| clipped_count(&axes[axis], &self.scale) > 0)?;
        let text = format!(
            "a{} is at the end of its range. Set the sensor to a wider range (±4 g), and begin anew.",
            AXES[axis]
        );
        Some((Rejection::Clipped, text))
    }

    /// What is wrong with the magnitude of a rest in local gravity.
    pub fn magnitude_fault(&self, accel: [f64; 3], gravity_mps2: f64) -> Option<Fault> {
        let norm = norm(&accel) / self.nominal;
        let ratio = norm / gravity_mps2;
        let off = 100.0 * (ratio - 1.0).abs();
        if !(1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&ratio) {
            let text = format!(
                "‖a‖ is {norm:.2} m/s² at rest: the unit or the range has changed. Set the range of the sensor as it was, or begin anew."
            );
            Some((Rejection::Units, text))
        } else if off > 100.0 * MAX_OFF {
            let text = format!(
                "‖a‖ is {norm:.2} m/s² at rest, {off:.0} % from gravity. Check that the sensor is raw and at the range that the sketch converts with."
            );
            Some((Rejection::Scale, text))
        } else {
            None
        }
    }

    /// A turn about the vertical leaves gravity where it is.
    fn turning(&self, means: &Means) -> Option<Fault> {
        let rate = norm(&sub(&means.gyro, &self.gyro_bias));
        let rate_deg_s = (rate / self.gyro_nominal?).to_degrees();
        (rate_deg_s > MAX_TURNING_DEG_S).then(|| {
            let text = format!(
                "It turns steadily: {rate_deg_s:.0} °/s more than in the first rest. {LET_GO}"
            );
            (Rejection::Moved, text)
        })
    }
}

/// Means of rows, and their scatter; empty cells are left out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Means {
    pub accel: [f64; 3],
    pub gyro: [f64; 3],
    /// Roots of the sum of the variances of three axes, of accelerometer and gyroscope; NaN without one.
    pub scatter: [f64; 2],
    pub temperature_c: Option<f64>,
}

impl Means {
    pub fn of(samples: &[Sample]) -> Self {
        let (accel, variance) = moments(&columns(samples, |s| s.accel), 0..samples.len());
        let (gyro, gyro_variance) = moments(&columns(samples, |s| s.gyro), 0..samples.len());
        let temperatures: Vec<f64> = samples.iter().map(|s| s.temperature_c).collect();
        Means {
            accel,
            gyro,
            scatter: [variance.sqrt(), gyro_variance.sqrt()],
            temperature_c: Some(mean_of_finite(&temperatures)).filter(|t| t.is_finite()),
        }
    }
}

fn columns(samples: &[Sample], of: impl Fn(&Sample) -> [f64; 3]) -> [Vec<f64>; 3] {
    std::array::from_fn(|i| samples.iter().map(|s| of(s)[i]).collect())
}
