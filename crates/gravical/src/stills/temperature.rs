//! Blocks with their temperature, computed from rows as they are read.
//!
//! Static intervals cannot be used to find temperature drift, since their means must agree.

use super::Block;
use crate::stats::{Thinned, mean_of_finite};

/// Length of a block, s.
const BLOCK_S: f64 = 3.0;
/// Smallest number of rows of a block.
const LEAST_ROWS: usize = 6;
/// Largest number of blocks stored: a day.
const MOST_BLOCKS: usize = 1 << 15;

/// A block of a recording, static or not.
#[derive(Debug, Clone)]
pub(crate) struct TemperatureBlock {
    /// Its number among all blocks: consecutive blocks have consecutive numbers.
    pub number: usize,
    /// Number of the segment (rows without a break) that contains it.
    pub segment: usize,
    /// Mean temperature, °C.
    pub t_c: f64,
    /// Means and variances of both sensors.
    pub block: Block,
}

/// Divides rows into blocks. Blocks without temperature or without an axis of the accelerometer
/// are dropped.
#[derive(Debug, Clone)]
pub(crate) struct TemperatureCutter {
    width: usize,
    temperature: Vec<f64>,
    accel: [Vec<f64>; 3],
    gyro: Option<[Vec<f64>; 3]>,
    number: usize,
    segment: usize,
    blocks: Thinned<Option<TemperatureBlock>, MOST_BLOCKS>,
}

impl TemperatureCutter {
    /// For rows at a rate in Hz, with or without a gyroscope.
    pub fn new(rate: f64, gyro: bool) -> Self {
        TemperatureCutter {
            width: ((BLOCK_S * rate).round() as usize).max(LEAST_ROWS),
            temperature: Vec::new(),
            accel: Default::default(),
            gyro: gyro.then(Default::default),
            number: 0,
            segment: 0,
            blocks: Thinned::default(),
        }
    }

    /// Adds a row; `is_break`: it does not continue the row before.
    pub fn push(&mut self, t_c: f64, accel: [f64; 3], rate: [f64; 3], parts: bool) {
        if parts {
            self.segment += 1;
            self.clear();
        }
        self.temperature.push(t_c);
        let all = self.accel.iter_mut().zip(accel);
        let gyro = self.gyro.iter_mut().flatten().zip(rate);
        all.chain(gyro).for_each(|(channel, v)| channel.push(v));
        if self.temperature.len() < self.width {
            return;
        }
        self.number += 1;
        let (temperature, accel, gyro) = (&self.temperature, &self.accel, self.gyro.as_ref());
        let (number, segment) = (self.number, self.segment);
        self.blocks.push_with(|| {
            let t_c = mean_of_finite(temperature);
            let rows = 0..temperature.len();
            let block = Block::of(accel, gyro, rows.clone(), rows);
            let whole = t_c.is_finite() && block.mean.iter().all(|v| v.is_finite());
            whole.then_some(TemperatureBlock {
                number,
                segment,
                t_c,
                block,
            })
        });
        self.clear();
    }

    fn clear(&mut self) {
        self.temperature.clear();
        let all = self.accel.iter_mut().chain(self.gyro.iter_mut().flatten());
        all.for_each(Vec::clear);
    }

    /// The blocks; of very many only every nth, renumbered consecutively.
    pub fn blocks(&self) -> Vec<TemperatureBlock> {
        let stride = self.blocks.stride() as usize;
        let some = self.blocks.items().iter().flatten().cloned();
        some.map(|block| TemperatureBlock {
            number: block.number / stride,
            ..block
        })
        .collect()
    }
}
