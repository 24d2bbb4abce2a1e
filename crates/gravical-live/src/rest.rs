//! The sensor at rest: since when, block by block, and what is wrong with it as a pose.
//!
//! A guided session decides while the sensor still lies there, by the blocks of the last seconds: a hold is a run
//! of quiet blocks whose means agree. The limits are those of the rest detector of a
//! recording ([`gravical_calibrate::poses::rests::find_rests`]), with the noise of the quietest blocks so far.

use std::collections::VecDeque;
use std::ops::Range;

use gravical_core::matrix3::{norm, sub};
use gravical_judge::full_scale::clipped_count;
use gravical_recording::Sample;
use gravical_signal::{
    BLOCK_S, Block, MAX_VARIANCE, RestTolerance, block_len, flips, is_quiet, quiet_level,
    quiet_limit,
};

use crate::event::Rejection;
use gravical_calibrate::poses::face::AXES;
use gravical_calibrate::recording::units::AccelScale;

/// Blocks that tell how much noise there is.
const MIN_LEVEL_BLOCKS: usize = 5;
/// Means of the blocks of a hold are no further from their mean than this multiple of noise/√rows …
const MAX_MEAN: f64 = 10.0;
/// … or this fraction of gravity, the vibration of a table.
const VIBRATION: f64 = 0.004;
/// A magnitude further from gravity than these factors is another unit, or another scale.
const OTHER_UNIT: f64 = 2.0;
const MAX_OFF: f64 = 0.35;
/// A mean angular rate that differs from that of the first rest by more is a steady turn, °/s.
const MAX_TURNING_DEG_S: f64 = 5.0;

/// The remedy for what moved.
pub(crate) const RELEASE_HINT: &str = "Lay it down, take the hand off, and wait.";

/// The state after a whole block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stillness {
    /// Rows up to the end of the block that were quiet without interruption and whose means agree; none
    /// if it is not quiet.
    pub run: Option<Range<usize>>,
    /// Variance of the block, three axes, and that below which it is quiet: (m/s²)² and (rad/s)².
    pub variance: [f64; 2],
    pub limit: [f64; 2],
}

/// Finds holds as rows arrive.
pub(crate) struct StillnessDetector {
    /// Rows of a block.
    size: usize,
    /// Blocks that are looked back upon.
    max_blocks: usize,
    /// Units of the rows per m/s² and per rad/s.
    scale: [f64; 2],
    /// Steps that the values come in, m/s² and rad/s.
    resolution: [f64; 6],
    /// Rows of the next block.
    samples: Vec<Sample>,
    /// The last blocks, m/s² and rad/s, and how many of them there are since the last interruption.
    blocks: VecDeque<Block>,
    since_split: usize,
    /// Variance of the quietest blocks so far, three axes.
    level: [f64; 2],
}

impl StillnessDetector {
    /// For runs of at least `run_s`. `scale` is in units of the rows per m/s² and per rad/s, `resolution` in units of
    /// the rows.
    pub fn new(rate_hz: f64, scale: [f64; 2], resolution: [[f64; 3]; 2], run_s: f64) -> Self {
        let size = block_len(rate_hz.recip(), BLOCK_S);
        StillnessDetector {
            size,
            max_blocks: (run_s * rate_hz / size as f64).ceil() as usize + 1,
            scale,
            resolution: std::array::from_fn(|c| resolution[c / 3][c % 3] / scale[c / 3]),
            samples: Vec::new(),
            blocks: VecDeque::new(),
            since_split: 0,
            level: MAX_VARIANCE,
        }
    }

    /// The next row does not follow the last one: no run spans both.
    pub fn split(&mut self) {
        self.samples.clear();
        self.since_split = 0;
    }

    /// Takes a row; the state if it completes a block.
    pub fn push(&mut self, sample: Sample) -> Option<Stillness> {
        self.samples.push(sample);
        if self.samples.len() < self.size {
            return None;
        }
        let last = block(&self.samples, self.scale);
        self.samples.clear();
        if self.blocks.len() == self.max_blocks {
            self.blocks.pop_front();
        }
        self.blocks.push_back(last.clone());
        self.since_split = (self.since_split + 1).min(self.blocks.len());
        let blocks = &*self.blocks.make_contiguous();
        if blocks.len() >= MIN_LEVEL_BLOCKS {
            for (sensor, level) in self.level.iter_mut().enumerate() {
                *level = level.min(quiet_level(blocks, sensor));
            }
        }
        let level = self.level;
        let mut limit = quiet_limit(level);
        // A gyroscope that has never rested may have another unit than it claims: the accelerometer decides.
        if level[1] == MAX_VARIANCE[1] {
            limit[1] = f64::INFINITY;
        }
        let since_split = &blocks[blocks.len() - self.since_split..];
        let moving = since_split.iter().rposition(|b| !is_quiet(b, limit));
        let quiet = &since_split[moving.map_or(0, |last| last + 1)..];
        let white_mps2 = MAX_MEAN * (level[0] / self.size as f64).sqrt();
        let flips = flips(std::slice::from_ref(&last), &self.resolution);
        let flip_mps2 = flips[..3].iter().sum::<f64>().sqrt();
        let force_mps2 = norm(&last.sensor_mean(0));
        let agree_mps2 = white_mps2.max(VIBRATION * force_mps2) + flip_mps2;
        let tolerance = RestTolerance {
            tilt_rad: agree_mps2 / force_mps2,
            rate_rad_s: f64::INFINITY,
            steps_are_turns: false,
        };
        let first = (0..quiet.len()).find(|first| tolerance.contains(&quiet[*first..]));
        Some(Stillness {
            run: first.map(|first| quiet[first].span.start..last.span.end),
            variance: [0, 1].map(|sensor| last.total_variance(sensor)),
            limit,
        })
    }
}

/// The scales of rows that are taken as they are.
pub(crate) const UNSCALED: [f64; 2] = [1.0; 2];

/// Statistics of rows, divided by these scales of accelerometer and gyroscope.
pub(crate) fn block(samples: &[Sample], scale: [f64; 2]) -> Block {
    let rows = samples.iter().map(|s| {
        let of_sensor = [s.accel, s.gyro];
        std::array::from_fn(|c| of_sensor[c / 3][c % 3] / scale[c / 3])
    });
    let [first, end] = [samples.first(), samples.last()].map(|s| s.map_or(0, |s| s.row));
    Block::new(first..end + 1, 6, rows)
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
    pub fn fault(&self, samples: &[Sample], capture: &Block, gravity_mps2: f64) -> Option<Fault> {
        self.clipped(samples)
            .or_else(|| self.magnitude_fault(capture.sensor_mean(0), gravity_mps2))
            .or_else(|| self.turning(capture.sensor_mean(1)))
    }

    fn clipped(&self, samples: &[Sample]) -> Option<Fault> {
        let is_clipped = |axis: &usize| {
            let values: Vec<f64> = samples.iter().map(|s| s.accel[*axis]).collect();
            clipped_count(&values, &self.scale) > 0
        };
        let axis = (0..3).find(is_clipped)?;
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
    fn turning(&self, gyro: [f64; 3]) -> Option<Fault> {
        let rate = norm(&sub(&gyro, &self.gyro_bias));
        let rate_deg_s = (rate / self.gyro_nominal?).to_degrees();
        (rate_deg_s > MAX_TURNING_DEG_S).then(|| {
            let text = format!(
                "It turns steadily: {rate_deg_s:.0} °/s more than in the first rest. {RELEASE_HINT}"
            );
            (Rejection::Moved, text)
        })
    }
}
