//! What the values say of their unit: the magnitude of the quietest ones is gravity, in
//! whatever unit, and counts are whole numbers.

use crate::recording::unit_choice::whole;
use crate::stats::{Thinned, median};

/// Rows of one block over which stillness is judged here.
const BLOCK: usize = 20;

/// BlockWriter that are kept at most: for a median half of them are enough.
const MOST: usize = 1 << 12;

/// Median magnitude of the quietest third of the blocks of 20 rows, and
/// whether all values there are whole numbers. Still or not: gravity dominates
/// the mean of a quiet block. None without a complete row.
#[must_use]
pub fn quiet_norm(accel: &[Vec<f64>; 3]) -> Option<(f64, bool)> {
    quiet(accel).map(|q| (q.norm, q.integers))
}

/// The quietest third of the blocks of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quiet {
    /// Median magnitude of their means, in the unit of the values.
    pub norm: f64,
    /// Median standard deviation within them, all axes together.
    pub spread: f64,
    /// All values of the recording are whole numbers.
    pub integers: bool,
}

/// As [`quiet_norm`], with how quiet they are.
pub(crate) fn quiet(accel: &[Vec<f64>; 3]) -> Option<Quiet> {
    let mut blocks = QuietBlocks::default();
    let [x, y, z] = accel;
    for ((x, y), z) in x.iter().zip(y).zip(z) {
        blocks.push([*x, *y, *z]);
    }
    blocks.finish()
}

/// The same row by row. Of a long recording every so many blocks count.
#[derive(Debug, Clone)]
pub(super) struct QuietBlocks {
    rows: [[f64; 3]; BLOCK],
    filled: usize,
    blocks: Thinned<Block, MOST>,
}

#[derive(Debug, Clone, Copy)]
struct Block {
    variance: f64,
    norm: f64,
    integers: bool,
}

impl Default for QuietBlocks {
    fn default() -> Self {
        QuietBlocks {
            rows: [[0.0; 3]; BLOCK],
            filled: 0,
            blocks: Thinned::default(),
        }
    }
}

impl QuietBlocks {
    /// A row; one that is not complete counts nothing.
    #[inline]
    pub fn push(&mut self, accel: [f64; 3]) {
        if !(accel[0] + accel[1] + accel[2]).is_finite() {
            return;
        }
        if self.blocks.keeps_next()
            && let Some(place) = self.rows.get_mut(self.filled)
        {
            *place = accel;
        }
        self.filled += 1;
        if self.filled == BLOCK {
            self.filled = 0;
            self.blocks.push_with(|| block(&self.rows));
        }
    }

    /// What they say; none without a complete row.
    pub fn finish(&self) -> Option<Quiet> {
        let mut blocks = self.blocks.items().to_vec();
        if blocks.is_empty() && self.filled > 0 {
            blocks.extend(self.rows.get(..self.filled).map(block));
        }
        let integers = blocks.iter().all(|b| b.integers);
        blocks.sort_by(|a, b| a.variance.total_cmp(&b.variance));
        blocks.truncate(blocks.len().div_ceil(3));
        let (mut variances, mut norms): (Vec<f64>, Vec<f64>) =
            blocks.into_iter().map(|b| (b.variance, b.norm)).unzip();
        Some(Quiet {
            norm: median(&mut norms)?,
            spread: median(&mut variances)?.sqrt(),
            integers,
        })
    }
}

#[inline(never)]
fn block(rows: &[[f64; 3]]) -> Block {
    let n = rows.len() as f64;
    let mut variance = 0.0;
    for axis in 0..3 {
        let mean = rows.iter().map(|r| r[axis]).sum::<f64>() / n;
        variance += rows.iter().map(|r| (r[axis] - mean).powi(2)).sum::<f64>() / n;
    }
    // The mean of the lengths, not the length of the mean: in a short list
    // of means every row is another placement.
    let length = |r: &[f64; 3]| r.iter().map(|v| v * v).sum::<f64>().sqrt();
    Block {
        variance,
        norm: rows.iter().map(length).sum::<f64>() / n,
        integers: rows.iter().flatten().all(|v| whole(*v)),
    }
}

/// Unsigned counts of a sensor at rest: at ±2 g, 1 g is 16384 off the middle.
const AROUND: std::ops::RangeInclusive<f64> = 12_288.0..=53_248.0;

/// Unsigned 16-bit values: whole numbers, most of them around 32768 on every axis.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Unsigned {
    /// A value is no unsigned one of 16 bits.
    refuted: bool,
    /// Values of each axis, and those of them [`AROUND`] 32768.
    values: [u64; 3],
    around: [u64; 3],
}

impl Unsigned {
    #[inline]
    pub fn see(&mut self, accel: [f64; 3]) {
        if self.refuted {
            return;
        }
        for (axis, v) in accel.into_iter().enumerate().filter(|(_, v)| v.is_finite()) {
            self.refuted |= !(whole(v) && (0.0..65536.0).contains(&v));
            self.values[axis] += 1;
            self.around[axis] += u64::from(AROUND.contains(&v));
        }
    }

    /// Whether they are.
    pub fn is_so(&self) -> bool {
        let most = |i: usize| 2 * self.around[i] > self.values[i];
        !self.refuted && (0..3).all(most)
    }
}

/// Whether the values of a gyroscope look like counts: whole numbers that are not all zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LooksCounted {
    whole: bool,
    moves: bool,
}

impl Default for LooksCounted {
    fn default() -> Self {
        LooksCounted {
            whole: true,
            moves: false,
        }
    }
}

impl LooksCounted {
    #[inline]
    pub fn see(&mut self, rate: [f64; 3]) {
        if self.whole {
            self.whole = rate.iter().all(|v| v.is_nan() || v.fract() == 0.0);
            self.moves |= rate.iter().any(|v| v.abs() >= 1.0);
        }
    }

    pub fn is_so(self) -> bool {
        self.whole && self.moves
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quiet_part_decides_not_the_shaking() {
        let mut accel = [Vec::new(), Vec::new(), Vec::new()];
        for i in 0..400 {
            let shake = if i < 200 {
                0.0
            } else {
                30.0 * f64::from(i).sin()
            };
            accel[0].push(shake);
            accel[1].push(shake);
            accel[2].push(9.81 + shake);
        }
        let (norm, integers) = quiet_norm(&accel).unwrap();
        assert!((norm - 9.81).abs() < 1e-9 && !integers);
    }

    #[test]
    fn few_rows_are_one_block() {
        let mut few = QuietBlocks::default();
        assert_eq!(few.finish(), None);
        few.push([f64::NAN, 0.0, 1.0]);
        assert_eq!(few.finish(), None);
        few.push([3.0, 0.0, 4.0]);
        assert_eq!(few.finish().unwrap().norm, 5.0);
    }
}
