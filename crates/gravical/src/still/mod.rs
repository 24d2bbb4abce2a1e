//! Detection of static intervals, in channels of any unit.
//!
//! # Overview
//!
//! 1. `block`, `levels`: the channels are divided into short blocks. The noise is the variance of
//!    the quietest blocks; a block is quiet if its variance is below
//!    [`StillOptions::noise_factor`]² times that, and likewise for the gyroscope.
//! 2. `runs`: a static interval is a run of quiet blocks whose means agree: a slow turn is quiet,
//!    but its means drift.
//! 3. `turning`: an even turn about the vertical is quiet and does not drift; its angular rate
//!    differs from that of the neighbouring static intervals.
//!
//! There are no constants in m/s², so that the method works for any sensor in any unit; but a
//! sensor that is worn for half a day or longer is at rest within 13 mg on each axis, whatever its
//! noise ([`Stills::worn`]). Noise is
//! never assumed to be less than that of rounding ([`crate::resolution`]): values of
//! two decimals may be constant at rest.
//!
//! The ends of these intervals are accurate to a block. The beginning and end of a rest in a
//! motion, to the sample, are determined by [`gravical_signal::detect_rests`].
//!
//! The method fails if a recording has no static interval: its quietest motion is then assumed to
//! be noise. In most cases the drift of the block means reveals that; otherwise a few short
//! intervals are found, which the caller must judge. Without a gyroscope an even turn about the
//! vertical is reported as static.

mod block;
mod levels;
mod live;
mod runs;
mod temperature;
mod turning;

use std::ops::Range;

use gravical_core::matrix3::{norm, sub};
use gravical_core::rounding;

pub(crate) use block::Block;
pub(crate) use levels::{Levels, quiet_level, step_of_means};
pub(crate) use live::{LiveState, MOST_NOISE_AT_REST};
pub use live::{LiveStill, LiveStills};
pub(crate) use temperature::{TemperatureBlock, TemperatureCutter};

use block::blocks;

/// Options of the detection of static intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct StillOptions {
    /// Length of a block, s (5 to 25 rows, and at least 0.05 s). Default 0.2.
    pub block_s: f64,
    /// A block is quiet below this multiple of the standard deviation of the quietest blocks.
    /// Default 3.
    pub noise_factor: f64,
    /// The same for the gyroscope, which measures more of the unsteadiness of a hand than the
    /// accelerometer. Default 18.
    pub gyro_noise_factor: f64,
    /// Means of blocks agree within this multiple of noise/√width. Default 10.
    pub mean_factor: f64,
    /// … or within this share of gravity, the vibration of a table. Default 0.004.
    pub tremor: f64,
    /// Shortest static interval, s, if it has fewer rows than `enough_rows`. Default 1.
    pub shortest_s: f64,
    /// Number of rows that is sufficient for any duration. Default 200.
    pub enough_rows: usize,
    /// Shortest static interval in any case, s. Default 0.2.
    pub least_s: f64,
    /// Extend an interval row by row into the blocks at its ends while the rows are within noise
    /// of its mean: otherwise a short rest loses up to two blocks, depending on the position of
    /// the blocks. Default false.
    pub grow_edges: bool,
}

impl StillOptions {
    /// The shortest static interval in words: "1 s, or 200 rows in at least 0.2 s".
    #[must_use]
    pub fn shortest(&self) -> String {
        format!(
            "{} s, or {} rows in at least {} s",
            self.shortest_s, self.enough_rows, self.least_s
        )
    }

    /// For a sensor held in the hand or on a vibrating base: intervals found with these options
    /// must be reported with a warning.
    #[must_use]
    pub fn unsteady() -> Self {
        StillOptions {
            noise_factor: 6.0,
            gyro_noise_factor: 50.0,
            mean_factor: 30.0,
            tremor: 0.03,
            ..Self::default()
        }
    }

    /// For short rests, as after setting the sensor down, if the mean of any pose is useful: 0.15
    /// s and 150 rows, counted after the ends are extended. A rest of that length contains two
    /// complete blocks in any case; the accuracy of its mean must be judged by its standard
    /// error.
    #[must_use]
    pub fn short_rests() -> Self {
        StillOptions {
            enough_rows: 150,
            least_s: 0.15,
            grow_edges: true,
            ..Self::default()
        }
    }
}

impl Default for StillOptions {
    fn default() -> Self {
        StillOptions {
            block_s: 0.2,
            noise_factor: 3.0,
            gyro_noise_factor: 18.0,
            mean_factor: 10.0,
            tremor: 0.004,
            shortest_s: 1.0,
            enough_rows: 200,
            least_s: 0.2,
            grow_edges: false,
        }
    }
}

/// Static intervals of a recording, and the noise level.
#[derive(Debug, Clone, Default)]
pub struct Stills {
    /// Rows of each interval, in order.
    pub spans: Vec<Range<usize>>,
    /// Standard deviation of the quietest blocks, the three axes together
    /// (root of the sum of variances), in the unit of the file.
    pub noise: f64,
    /// The sensor is worn, for half a day or longer: static is what stays within 13 mg on each axis
    /// for 10 s, not within its noise.
    pub worn: bool,
}

/// Channels in which static intervals are searched: of equal length, in any unit.
pub(crate) struct Channels<'a> {
    /// Specific force along x, y, z.
    pub accel: &'a [Vec<f64>; 3],
    /// Angular rate about x, y, z.
    pub gyro: Option<&'a [Vec<f64>; 3]>,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Ranges of consecutive rows; intervals do not extend across them.
    pub segments: Vec<Range<usize>>,
    /// Resolution of accelerometer and gyroscope.
    pub resolution: [f64; 6],
}

/// Finds the static intervals.
pub(crate) fn find_stills(recording: &Channels<'_>, options: &StillOptions) -> Stills {
    let rate = recording.rate_hz;
    let width = block_rows(rate, options);
    let segments: Vec<Vec<Block>> = recording
        .segments
        .iter()
        .cloned()
        .map(|rows| blocks(recording, rows, width))
        .collect();
    let Some(levels) = Levels::of(&segments, rate, &recording.resolution, options) else {
        return Stills::default();
    };
    let mut spans: Vec<Range<usize>> = Vec::new();
    for segment in &segments {
        let (Some(first), Some(last)) = (segment.first(), segment.last()) else {
            continue;
        };
        let edges = first.rows.start..last.rows.end;
        for mut rows in levels.quiet_rows(segment) {
            let from = spans.last().map_or(0, |s| s.end).max(edges.start);
            rows = levels.grow(recording.accel, rows, from..edges.end);
            if rows.len() >= levels.shortest {
                spans.push(rows);
            }
        }
    }
    Stills {
        spans: levels.without_turning(recording.gyro, spans),
        noise: levels.noise(),
        worn: levels.worn,
    }
}

/// Number of rows of a block.
#[must_use]
pub fn block_rows(rate_hz: f64, options: &StillOptions) -> usize {
    let wanted = (options.block_s * rate_hz).round();
    let least = (0.05 * rate_hz).round().max(5.0);
    wanted.clamp(5.0, 25.0).max(least) as usize
}

/// Mean of each axis and the sum of the variances; empty cells are left out.
pub(crate) fn moments(channels: &[Vec<f64>; 3], rows: Range<usize>) -> ([f64; 3], f64) {
    let mut means = [f64::NAN; 3];
    let mut total = 0.0;
    for (axis, channel) in channels.iter().enumerate() {
        // Without branches, since this takes half of the time of the detection.
        let part = &channel[rows.clone()];
        let (mut n, mut sum) = (0.0, 0.0);
        for &v in part {
            let there = v.is_finite();
            n += f64::from(u8::from(there));
            sum += if there { v } else { 0.0 };
        }
        let mean = sum / n;
        means[axis] = mean;
        let mut squares = 0.0;
        for &v in part {
            let off = v - mean;
            squares += if v.is_finite() { off * off } else { 0.0 };
        }
        total += if n > 1.0 {
            squares / (n - 1.0)
        } else {
            f64::NAN
        };
    }
    (means, total)
}

/// Variance of rounding to these steps, all axes together.
pub(crate) fn floors(step: &[f64]) -> f64 {
    step.iter().map(|q| rounding::floor(*q)).sum()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm(&sub(&a, &b))
}
