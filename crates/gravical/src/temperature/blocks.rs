//! Means of short blocks in which nothing moves, and the stretches of one
//! placement that they make up.
//!
//! The stills of [`crate::segment`] are no help here: their means have to
//! agree, and a drift is what is looked for. A block is still by its variance;
//! a stretch ends where the recording breaks, or where the mean of the
//! accelerometer jumps.

use std::ops::Range;

use crate::recording::Recording;
use crate::segment::still::{quiet_level, step_of_means};
use crate::stats::{Thinned, median};

use super::TemperatureOptions;

/// Variances of still blocks stay under this many times the noise floor …
const QUIET_FACTOR: f64 = 9.0;
/// … and of the gyroscope, which feels every tremor.
const QUIET_FACTOR_GYRO: f64 = 81.0;
/// Means of neighbouring blocks differ by less than so many times what is
/// usual (1.4826 × the median step) …
const JUMP_FACTOR: f64 = 8.0;
/// … or by less than this share of gravity, 0.11°.
const JUMP_SHARE: f64 = 0.002;
/// Blocks that motion takes out allow for so much more drift at most.
const MOST_MISSING: usize = 4;
/// Fewer rows have no variance worth the name.
const LEAST_ROWS: usize = 6;

/// The mean of a block.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub t_c: f64,
    /// Accelerometer and gyroscope; NaN without one.
    pub values: [f64; 6],
}

/// One placement, held from the first block to the last.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    pub recording: usize,
    pub blocks: Vec<Block>,
}

impl Stretch {
    /// Lowest and highest temperature.
    pub fn range_c(&self) -> [f64; 2] {
        self.blocks
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], b| {
                [low.min(b.t_c), high.max(b.t_c)]
            })
    }
}

/// A block of a recording, still or not.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    /// Its number, counted over all blocks: neighbours follow each other.
    number: usize,
    segment: usize,
    block: Block,
    variance: [f64; 2],
}

impl Candidate {
    /// Of the values of its rows; none where the temperature or an axis of the
    /// accelerometer has no value.
    fn of(
        number: usize,
        segment: usize,
        temperature: &[f64],
        accel: [&[f64]; 3],
        gyro: Option<[&[f64]; 3]>,
    ) -> Option<Self> {
        let (t_c, _) = moments(temperature);
        let mut values = [f64::NAN; 6];
        let mut variance = [0.0, f64::NAN];
        for (axis, channel) in accel.into_iter().enumerate() {
            let (mean, own) = moments(channel);
            values[axis] = mean;
            variance[0] += own;
        }
        if let Some(gyro) = gyro {
            variance[1] = 0.0;
            for (axis, channel) in gyro.into_iter().enumerate() {
                let (mean, own) = moments(channel);
                values[3 + axis] = mean;
                variance[1] += own;
            }
        }
        let known = t_c.is_finite() && values[..3].iter().all(|v| v.is_finite());
        known.then_some(Candidate {
            number,
            segment,
            block: Block { t_c, values },
            variance,
        })
    }
}

/// Blocks of a recording that are kept at most: a day of them.
const MOST_BLOCKS: usize = 1 << 15;

/// Cuts rows into blocks as they come.
#[derive(Debug, Clone)]
pub(crate) struct Cutter {
    width: usize,
    temperature: Vec<f64>,
    accel: [Vec<f64>; 3],
    gyro: Option<[Vec<f64>; 3]>,
    number: usize,
    segment: usize,
    blocks: Thinned<Option<Candidate>, MOST_BLOCKS>,
}

impl Cutter {
    /// For rows at a rate, Hz, with a gyroscope or without.
    pub fn new(rate: f64, gyro: bool) -> Self {
        Cutter {
            width: block_rows(rate, &TemperatureOptions::default()),
            temperature: Vec::new(),
            accel: Default::default(),
            gyro: gyro.then(Default::default),
            number: 0,
            segment: 0,
            blocks: Thinned::default(),
        }
    }

    /// The next row, which `parts` from the one before.
    pub fn push(&mut self, t_c: f64, accel: [f64; 3], rate: [f64; 3], parts: bool) {
        if parts {
            self.segment += 1;
            self.clear();
        }
        self.temperature.push(t_c);
        let all = self.accel.iter_mut().zip(accel);
        let gyro = self.gyro.iter_mut().flatten().zip(rate);
        all.chain(gyro).for_each(|(channel, v)| channel.push(v));
        if self.temperature.len() == self.width {
            self.number += 1;
            let (temperature, accel, gyro) = (&self.temperature, &self.accel, &self.gyro);
            let (number, segment) = (self.number, self.segment);
            self.blocks.push_with(|| {
                let accel = accel.each_ref().map(|c| &c[..]);
                let gyro = gyro.as_ref().map(|g| g.each_ref().map(|c| &c[..]));
                Candidate::of(number, segment, temperature, accel, gyro)
            });
            self.clear();
        }
    }

    fn clear(&mut self) {
        self.temperature.clear();
        let all = self.accel.iter_mut().chain(self.gyro.iter_mut().flatten());
        all.for_each(Vec::clear);
    }

    /// The blocks; of very many every so many, as neighbours.
    pub fn blocks(&self) -> Vec<Candidate> {
        let stride = self.blocks.stride() as usize;
        let some = self.blocks.items().iter().flatten().cloned();
        some.map(|block| Candidate {
            number: block.number / stride,
            ..block
        })
        .collect()
    }
}

/// Rows of a block at a rate, Hz.
fn block_rows(rate: f64, options: &TemperatureOptions) -> usize {
    ((options.block_s * rate).round() as usize).max(LEAST_ROWS)
}

/// Stretches of `recording`, which has temperatures; `index` is its number.
pub(super) fn stretches(
    recording: &Recording,
    index: usize,
    options: &TemperatureOptions,
) -> Vec<Stretch> {
    let candidates = cut(recording, options);
    let steps: [&[f64]; 2] = recording.resolution.split_at(3).into();
    let floor = |i: usize| quiet_level(candidates.iter().map(|c| c.variance[i]), steps[i]);
    let Some(accel_floor) = floor(0) else {
        return Vec::new();
    };
    let gyro_floor = floor(1).unwrap_or(f64::INFINITY);
    let still: Vec<&Candidate> = candidates
        .iter()
        .filter(|c| {
            c.variance[0] <= QUIET_FACTOR * accel_floor
                && (c.variance[1].is_nan() || c.variance[1] <= QUIET_FACTOR_GYRO * gyro_floor)
        })
        .collect();
    let mut jumps: Vec<f64> = still.windows(2).map(|w| step(w[0], w[1])).collect();
    let mut norms: Vec<f64> = still.iter().map(|c| norm(&c.block)).collect();
    let usual = 1.4826 * median(&mut jumps).unwrap_or(0.0);
    let gravity = median(&mut norms).unwrap_or(0.0);
    let most =
        (JUMP_FACTOR * usual).max(JUMP_SHARE * gravity) + step_of_means(accel_floor, steps[0]);

    let mut out: Vec<Stretch> = Vec::new();
    let mut last: Option<&Candidate> = None;
    for candidate in still {
        let follows = last.is_some_and(|before| {
            let missing = (candidate.number - before.number - 1).min(MOST_MISSING);
            candidate.segment == before.segment
                && step(before, candidate) <= most * (1 + missing) as f64
        });
        match out.last_mut() {
            Some(stretch) if follows => stretch.blocks.push(candidate.block.clone()),
            _ => out.push(Stretch {
                recording: index,
                blocks: vec![candidate.block.clone()],
            }),
        }
        last = Some(candidate);
    }
    out
}

fn cut(recording: &Recording, options: &TemperatureOptions) -> Vec<Candidate> {
    if let Some(excerpt) = &recording.excerpt {
        return excerpt.thermal.clone();
    }
    let Some(temperature) = &recording.temperature_c else {
        return Vec::new();
    };
    let (rate, _) = recording.working_rate_hz();
    let width = block_rows(rate, options);
    let mut out = Vec::new();
    let mut number = 0;
    for (segment, rows) in recording.segments().into_iter().enumerate() {
        let mut from = rows.start;
        while from + width <= rows.end {
            let span = from..from + width;
            from += width;
            number += 1;
            out.extend(Candidate::of(
                number,
                segment,
                &temperature[span.clone()],
                part(&recording.accel, &span),
                recording.gyro.as_ref().map(|gyro| part(gyro, &span)),
            ));
        }
    }
    out
}

fn part<'a>(channels: &'a [Vec<f64>; 3], rows: &Range<usize>) -> [&'a [f64]; 3] {
    channels.each_ref().map(|c| &c[rows.clone()])
}

/// Mean and variance of the values that are there.
fn moments(values: &[f64]) -> (f64, f64) {
    let (mut n, mut sum) = (0.0, 0.0);
    for v in values.iter().filter(|v| v.is_finite()) {
        n += 1.0;
        sum += v;
    }
    let mean = sum / n;
    let squares: f64 = values
        .iter()
        .filter(|v| v.is_finite())
        .map(|v| (v - mean).powi(2))
        .sum();
    (mean, squares / (n - 1.0))
}

fn step(a: &Candidate, b: &Candidate) -> f64 {
    (0..3)
        .map(|i| (a.block.values[i] - b.block.values[i]).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn norm(block: &Block) -> f64 {
    block.values[..3].iter().map(|v| v * v).sum::<f64>().sqrt()
}
