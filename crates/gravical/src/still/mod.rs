//! Stills: where a sensor lies or is held still, in channels of any unit.
//!
//! # Overview
//!
//! 1. `block`, `levels`: the channels are cut into short blocks. Their own noise is the
//!    variance of the quietest blocks; a block is quiet while its variance stays under
//!    [`StillOptions::noise_factor`]² times that, of the gyroscope likewise.
//! 2. `runs`: a still is a run of quiet blocks whose means agree: a slow turn is quiet
//!    and drifts.
//! 3. `turning`: an even turn about the vertical is quiet and does not drift; its
//!    angular rate is another one than that of the stills around it.
//!
//! Nothing here is a constant in m/s², so that it fits any sensor in any unit. Noise is
//! never taken for less than what rounding makes of it
//! ([`crate::recording::resolution`]): at rest two decimals may never change.
//!
//! These are stills to a block. Where a rest of a motion begins and ends to the sample,
//! [`gravical_core::still`] says, and [`crate::motion::still`] with it.
//!
//! It fails where a recording is never still: then its quietest motion is taken for
//! noise. The drift of the block means unmasks that in most cases; what is left are a
//! few short stills, which the caller judges. Without a gyroscope an even turn about
//! the vertical is a still.

mod block;
mod levels;
mod runs;
mod temperature;
mod turning;

use std::ops::Range;

use gravical_core::rounding;

pub(crate) use block::Block;
pub(crate) use levels::{Levels, quiet_level, step_of_means};
pub(crate) use temperature::{TemperatureBlock, TemperatureCutter};

use block::blocks;

/// How stills are found.
#[derive(Debug, Clone, PartialEq)]
pub struct StillOptions {
    /// Length of a block, s (5 to 25 rows, and at least 0.05 s). Default 0.2.
    pub block_s: f64,
    /// A block is quiet under this many times the standard deviation of the
    /// quietest ones. Default 3.
    pub noise_factor: f64,
    /// The same for the gyroscope, which a hand that holds still moves more than
    /// the accelerometer. Default 18.
    pub gyro_noise_factor: f64,
    /// Means of blocks agree within this many times noise/√width. Default 10.
    pub mean_factor: f64,
    /// … or within this share of gravity, what a resting table may tremble.
    /// Default 0.004.
    pub tremor: f64,
    /// Shortest still, s, where there are fewer rows than `enough_rows` in it.
    /// Default 1.
    pub shortest_s: f64,
    /// So many rows are always enough, however little time they take.
    /// Default 200.
    pub enough_rows: usize,
    /// But nothing shorter than this is a still, s. Default 0.2.
    pub least_s: f64,
    /// Let a still grow row by row into the blocks at its ends, while the rows
    /// are within noise of its mean: a short rest loses up to two blocks to
    /// where the blocks happen to begin. Default false.
    pub grow_edges: bool,
}

impl StillOptions {
    /// For a rest in the hand or on something that shakes: what is taken for a
    /// hold has to be said with a warning.
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

    /// For short rests, as after setting the sensor down, where the mean of any
    /// pose is of use: 0.15 s and 150 rows, counted after the edges have grown.
    /// A rest of that length holds two whole blocks wherever they begin; what its
    /// mean is worth, its standard error has to say.
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

/// Stills of a recording and the noise they were found with.
#[derive(Debug, Clone, Default)]
pub struct Stills {
    /// Rows of each still, in order.
    pub spans: Vec<Range<usize>>,
    /// Standard deviation of the quietest blocks, the three axes together
    /// (root of the sum of variances), in the unit of the file.
    pub noise: f64,
}

/// What stills are looked for in: channels of equal length, in any unit.
pub(crate) struct Channels<'a> {
    /// Specific force along x, y, z.
    pub accel: &'a [Vec<f64>; 3],
    /// Angular rate about x, y, z.
    pub gyro: Option<&'a [Vec<f64>; 3]>,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Rows that follow each other; no still spans two of these.
    pub segments: Vec<Range<usize>>,
    /// Steps that the values come in, accelerometer and gyroscope.
    pub resolution: [f64; 6],
}

/// Finds the stills.
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
    }
}

/// Rows of a block at a rate.
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
        // Empty cells count as nothing; without branches, since this is half of
        // the work of finding stills.
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

/// Variance that rounding to these steps makes at the least, all axes together.
pub(crate) fn floors(step: &[f64]) -> f64 {
    step.iter().map(|q| rounding::floor(*q)).sum()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(x, y)| (x - y).powi(2))
        .sum::<f64>()
        .sqrt()
}
