//! Stills of rows that arrive one by one.

use std::ops::Range;

use gravical_core::matrix3::norm;

use super::block::Block;
use super::{Levels, block_rows, distance};
use crate::resolution::AxisValues;

/// Blocks that are kept at most: an hour and more at 100 Hz.
const MOST_BLOCKS: usize = 20_000;

/// Noise at rest over the magnitude at most, three axes together: twice that of a bad MPU6050
/// without low-pass. Where the quietest blocks scatter more, the sensor has not rested yet.
pub(crate) const MOST_NOISE_AT_REST: f64 = 0.035;

/// A still of [`LiveStills`].
#[derive(Debug, Clone, PartialEq)]
pub struct LiveStill {
    /// Rows since the first one.
    pub rows: Range<usize>,
    /// Mean reading, in the unit of the rows.
    pub mean: [f64; 3],
    /// Standard deviation of the quietest blocks, root of the sum over the axes, in the
    /// unit of the rows.
    pub noise: f64,
}

impl LiveStill {
    /// Whether it is a rest: without one in the recording yet, the level of noise is that of a
    /// motion, whose calmest parts would seem still.
    #[must_use]
    pub fn is_rest(&self) -> bool {
        self.noise <= MOST_NOISE_AT_REST * norm(&self.mean)
    }
}

/// Finds stills while rows arrive: blocks are kept, not rows, and each call of
/// [`stills`](Self::stills) judges all of them anew, since a quieter block later lowers the
/// level of noise.
///
/// An interval in which the sensor turns evenly about the vertical, at a rate that may as well be the
/// bias of the gyroscope, is a still here.
///
/// ```
/// use gravical::stills::LiveStills;
///
/// let mut live = LiveStills::new(100.0);
/// for i in 0..600 {
///     let noise = f64::from(i * 7919 % 61) * 1e-3;
///     let shaken = if i < 300 { 0.0 } else { f64::from(i % 7) };
///     live.push([noise, shaken - noise, 9.81 + noise]);
/// }
/// let stills = live.stills();
/// assert_eq!(stills.len(), 1);
/// assert!(stills[0].rows.start == 0 && (260..=300).contains(&stills[0].rows.end));
/// ```
#[derive(Debug, Clone)]
pub struct LiveStills {
    rate_hz: f64,
    /// Rows since the last block.
    accel: [Vec<f64>; 3],
    gyro: [Vec<f64>; 3],
    segments: Vec<Vec<Block>>,
    /// Steps that the values come in.
    values: AxisValues<3>,
    gyro_values: AxisValues<3>,
    rows: usize,
}

/// The state after the last whole block of [`LiveStills`]. Values are in the unit of the rows,
/// scatters are roots of the sum of the variances of three axes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LiveState {
    /// The last block.
    pub block: Range<usize>,
    /// Rows up to the end of the last block that were quiet without interruption and whose means
    /// agree; none if the last block is not quiet.
    pub run: Option<Range<usize>>,
    /// Scatter of the last block, and the largest of a quiet one.
    pub scatter: f64,
    pub most_scatter: f64,
    /// The same of the gyroscope; NaN without one.
    pub gyro_scatter: f64,
    pub most_gyro_scatter: f64,
    /// Scatter of the quietest blocks.
    pub noise: f64,
}

/// Blocks that are looked back upon for a run: 10 s of the shortest ones.
const MOST_RUN: usize = 200;

impl LiveStills {
    /// For a sampling rate in Hz.
    #[must_use]
    pub fn new(rate_hz: f64) -> Self {
        LiveStills {
            rate_hz,
            accel: Default::default(),
            gyro: Default::default(),
            segments: vec![Vec::new()],
            values: AxisValues::default(),
            gyro_values: AxisValues::default(),
            rows: 0,
        }
    }

    /// Takes a row: specific force in any unit.
    pub fn push(&mut self, accel: [f64; 3]) {
        self.push_with_gyro(accel, None);
    }

    /// The same with the angular rate, in any unit: a rate that changes is not still. True if
    /// the row completes a block.
    pub fn push_with_gyro(&mut self, accel: [f64; 3], gyro: Option<[f64; 3]>) -> bool {
        self.values.observe(accel);
        for (channel, value) in self.accel.iter_mut().zip(accel) {
            channel.push(value);
        }
        if let Some(gyro) = gyro {
            self.gyro_values.observe(gyro);
            for (channel, value) in self.gyro.iter_mut().zip(gyro) {
                channel.push(value);
            }
        }
        self.rows += 1;
        let held = self.accel[0].len();
        if held < block_rows(self.rate_hz) {
            return false;
        }
        let gyro = (self.gyro[0].len() == held).then_some(&self.gyro);
        let block = Block::of(&self.accel, gyro, 0..held, self.rows - held..self.rows);
        if let Some(segment) = self.segments.last_mut() {
            segment.push(block);
        }
        self.begin_block();
        true
    }

    fn begin_block(&mut self) {
        let channels = self.accel.iter_mut().chain(&mut self.gyro);
        channels.for_each(Vec::clear);
    }

    /// The next row does not follow the last one: no still spans both.
    pub fn split(&mut self) {
        self.begin_block();
        if self
            .segments
            .last()
            .is_some_and(|blocks| !blocks.is_empty())
        {
            self.segments.push(Vec::new());
        }
    }

    /// Rows so far.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// So many blocks are kept that the stills should be noted elsewhere, and
    /// [forgotten](Self::forget) here.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.segments.iter().map(Vec::len).sum::<usize>() >= MOST_BLOCKS
    }

    /// Forgets all blocks; rows are counted on.
    pub fn forget(&mut self) {
        self.segments = vec![Vec::new()];
    }

    /// Forgets the older half of the blocks of a stream that is [full](Self::is_full).
    pub(crate) fn forget_older(&mut self) {
        let mut left = self.segments.iter().map(Vec::len).sum::<usize>() / 2;
        for segment in &mut self.segments {
            let gone = left.min(segment.len());
            segment.drain(..gone);
            left -= gone;
        }
        let last = self.segments.len().saturating_sub(1);
        let mut at = 0..;
        self.segments
            .retain(|blocks| at.next() == Some(last) || !blocks.is_empty());
    }

    fn levels(&self) -> Option<Levels> {
        let [x, y, z] = self.values.resolution(0);
        let [u, v, w] = match self.segments.iter().flatten().next() {
            Some(block) if block.gyro_variance.is_finite() => self.gyro_values.resolution(0),
            _ => [0.0; 3],
        };
        let steps = [x, y, z, u, v, w];
        Levels::of(&self.segments, self.rate_hz, &steps)
    }

    /// The state after the last whole block; none before the first.
    pub(crate) fn state(&self) -> Option<LiveState> {
        let blocks = self.segments.last()?;
        let last = blocks.last()?;
        let levels = self.levels()?;
        let mut run = None;
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for block in blocks.iter().rev().take(MOST_RUN) {
            for axis in 0..3 {
                low[axis] = low[axis].min(block.mean[axis]);
                high[axis] = high[axis].max(block.mean[axis]);
            }
            let width = distance(low, high);
            if !levels.is_quiet(block) || width > 2.0 * levels.agree() {
                break;
            }
            run = Some(block.rows.start..last.rows.end);
        }
        let [most_scatter, most_gyro_scatter] = levels.most();
        Some(LiveState {
            block: last.rows.clone(),
            run,
            scatter: last.variance.sqrt(),
            most_scatter,
            gyro_scatter: last.gyro_variance.sqrt(),
            most_gyro_scatter,
            noise: levels.noise(),
        })
    }

    /// The stills so far. One that ends with the last whole block still lasts.
    #[must_use]
    pub fn stills(&self) -> Vec<LiveStill> {
        let Some(levels) = self.levels() else {
            return Vec::new();
        };
        let of_segment = |blocks: &Vec<Block>| -> Vec<LiveStill> {
            let long = levels.quiet_rows(blocks).into_iter();
            long.filter(|rows| rows.len() >= levels.shortest)
                .map(|rows| LiveStill {
                    mean: mean(blocks, &rows),
                    rows,
                    noise: levels.noise(),
                })
                .collect()
        };
        self.segments.iter().flat_map(of_segment).collect()
    }

    /// Rows up to the end of the last whole block.
    #[must_use]
    pub fn judged_rows(&self) -> usize {
        self.rows - self.accel[0].len()
    }
}

/// Mean of the blocks of `rows`.
fn mean(blocks: &[Block], rows: &Range<usize>) -> [f64; 3] {
    let within = |b: &&Block| rows.start <= b.rows.start && b.rows.end <= rows.end;
    let mut sum = [0.0; 3];
    let mut n = 0.0;
    for block in blocks.iter().filter(within) {
        n += 1.0;
        for (sum, mean) in sum.iter_mut().zip(block.mean) {
            *sum += mean;
        }
    }
    sum.map(|s| s / n)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(i: usize, at: [f64; 3]) -> [f64; 3] {
        let noise = |k: usize| ((i * 7919 + k * 131) % 61) as f64 * 1e-3;
        [at[0] + noise(1), at[1] + noise(2), at[2] + noise(3)]
    }

    #[test]
    fn a_split_ends_a_still_and_forgetting_counts_on() {
        let mut live = LiveStills::new(100.0);
        for i in 0..600 {
            if i == 300 {
                live.split();
            }
            live.push(row(i, [0.0, 0.0, 9.81]));
        }
        let rows = |live: &LiveStills| -> Vec<Range<usize>> {
            live.stills().into_iter().map(|s| s.rows).collect()
        };
        assert_eq!(rows(&live), [0..300, 300..600]);
        live.forget();
        assert!(rows(&live).is_empty() && live.rows() == 600);
        for i in 0..200 {
            live.push(row(i, [0.0, 0.0, 9.81]));
        }
        assert_eq!(rows(&live).first(), Some(&(600..800)));
    }
}
