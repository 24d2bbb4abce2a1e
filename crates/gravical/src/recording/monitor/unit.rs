//! Unit of the values: the magnitude of the quietest values is gravity, and counts are whole
//! numbers.

use gravical_core::matrix3;

use crate::finding::{Finding, FindingKind, LineSpans};
use crate::stats::{Thinned, median};

/// Rows of a block.
const BLOCK: usize = 20;

/// Largest number of blocks stored; half of them are enough for a median.
const MOST: usize = 1 << 12;

/// The quietest third of the blocks of 20 rows of a recording. The sensor need not be at rest:
/// gravity dominates the mean of a quiet block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quiet {
    /// Median of the mean magnitudes of the blocks, in the unit of the values.
    pub norm: f64,
    /// Median standard deviation within the blocks, all axes together.
    pub spread: f64,
    /// All values of the recording are whole numbers.
    pub integers: bool,
}

/// Collects them row by row. Of a long recording only every nth block is stored.
#[derive(Debug, Clone)]
pub(crate) struct QuietBlocks {
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
    /// Adds a row; incomplete rows are skipped.
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

    /// The result; `None` without a complete row.
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
    // The mean of the magnitudes, not the magnitude of the mean: in a table of means every row is
    // another pose.
    Block {
        variance,
        norm: rows.iter().map(matrix3::norm).sum::<f64>() / n,
        integers: rows.iter().flatten().all(|v| is_whole_number(*v)),
    }
}

/// Number of consecutive blocks at rest that establish a magnitude.
const SETTLED: usize = 5;
/// Largest standard deviation of a block at rest, as a share of its magnitude.
const MOST_RESTLESS: f64 = 0.05;
/// Magnitudes at rest in one unit differ by no more than this share …
const ONE_UNIT: f64 = 0.25;
/// … and the ratio of two units, or ranges, is matched within this share.
const RATIO: f64 = 0.08;
/// One g in the units other than counts: g, m/s², mg.
const GRAVITIES: [f64; 3] = [1.0, 9.80665, 1000.0];
/// Counts per g of 16-bit converters at ±16 g to ±2 g.
const COUNTS: [f64; 4] = [2048.0, 4096.0, 8192.0, 16384.0];
/// Counts at or near the end of the range of a 16-bit converter.
const FULL: f64 = 32_700.0;

/// Detects a change of unit or range: the magnitude at rest jumps from gravity in one unit to
/// gravity in another and stays there. No motion can cause this, since a sensor at rest measures
/// 1 g.
#[derive(Debug, Clone)]
pub(super) struct UnitWatch {
    rows: [([f64; 3], u64); BLOCK],
    filled: usize,
    /// The block before the current one.
    last: [([f64; 3], u64); BLOCK],
    /// Magnitude at rest, once established.
    norm: Option<f64>,
    /// Consecutive blocks at rest that agree with each other and not with `norm`: their number,
    /// their magnitude, and the line of the first of these rows.
    run: (usize, f64, u64),
    /// The first change: its line, and the magnitudes before and after.
    pub changed: Option<(u64, f64, f64)>,
    lines: LineSpans,
}

impl Default for UnitWatch {
    fn default() -> Self {
        UnitWatch {
            rows: [([0.0; 3], 0); BLOCK],
            filled: 0,
            last: [([0.0; 3], 0); BLOCK],
            norm: None,
            run: (0, 0.0, 0),
            changed: None,
            lines: LineSpans::default(),
        }
    }
}

impl UnitWatch {
    /// Adds a row and its line; incomplete rows are skipped.
    #[inline]
    pub fn observe(&mut self, accel: [f64; 3], line: u64) {
        if !(accel[0] + accel[1] + accel[2]).is_finite() {
            return;
        }
        if let Some(place) = self.rows.get_mut(self.filled) {
            *place = (accel, line);
        }
        self.filled += 1;
        if self.filled == BLOCK {
            self.filled = 0;
            self.end_block();
        }
    }

    #[inline(never)]
    fn end_block(&mut self) {
        let Block {
            variance,
            norm,
            integers,
        } = block(&self.rows.map(|r| r.0));
        let near = |a: f64, b: f64| (a / b - 1.0).abs() <= ONE_UNIT;
        let rests = variance.sqrt() <= MOST_RESTLESS * norm && norm > 0.0;
        let full = self
            .rows
            .iter()
            .any(|r| r.0.iter().any(|v| v.abs() >= FULL));
        if !rests || full || self.norm.is_some_and(|n| near(norm, n)) {
            self.run.0 = 0;
        } else if self.run.0 > 0 && near(norm, self.run.1) {
            self.run.0 += 1;
        } else {
            self.run = (1, norm, self.begin(norm));
        }
        if self.run.0 == SETTLED {
            let (_, norm, line) = self.run;
            match self.norm {
                // The first magnitude that is established.
                None => self.norm = Some(norm),
                Some(before) if is_other_unit(before, norm, integers) => {
                    self.changed.get_or_insert((line, before, norm));
                    self.lines.push(line);
                    self.norm = Some(norm);
                }
                Some(_) => {}
            }
        }
        self.last = self.rows;
    }

    /// Line of the first row whose magnitude is nearer to `norm` than to the magnitude before.
    fn begin(&self, norm: f64) -> u64 {
        let between = self.norm.map_or(0.0, |before| (before * norm).sqrt());
        let is_new = |(a, _): &([f64; 3], u64)| (matrix3::norm(a) > between) == (norm > between);
        let rows = self.last.iter().chain(&self.rows).filter(|r| r.1 > 0);
        let new = rows.rev().take_while(|r| is_new(r)).last();
        new.map_or(self.rows[0].1, |r| r.1)
    }

    /// The finding; `None` without a change.
    pub fn finding(&self) -> Option<Finding> {
        let (line, before, after) = self.changed?;
        let message = format!(
            "the magnitude at rest is {before:.4} before line {line} and {after:.4} from there on: the unit or range changed without a new header"
        );
        Some(Finding::new(FindingKind::UnitChanged, message).at_lines(&self.lines))
    }
}

/// True if both magnitudes can be 1 g, in two units or at two ranges. A change of range is only
/// possible between counts (whole numbers): for other values a factor of two may be a force.
fn is_other_unit(before: f64, after: f64, integers: bool) -> bool {
    let ratio = after / before;
    let is = |expected: f64| (ratio / expected - 1.0).abs() <= RATIO;
    let ranges = [2.0, 4.0, 8.0];
    let to_counts = COUNTS.iter().flat_map(|c| GRAVITIES.map(|g| c / g));
    let mut units = [9.80665, 1000.0, 1000.0 / 9.80665]
        .into_iter()
        .chain(to_counts.filter(|r| *r > 8.5));
    units.any(|r| is(r) || is(1.0 / r)) || integers && ranges.iter().any(|r| is(*r) || is(1.0 / r))
}

/// True for a whole number in the range of a converter. (`fract` is a library call on most
/// processors and too slow for every value.)
fn is_whole_number(v: f64) -> bool {
    v == f64::from(v as i32)
}

/// Unsigned counts of a sensor at rest: at ±2 g, 1 g is 16384 from the middle.
const AROUND: std::ops::RangeInclusive<f64> = 12_288.0..=53_248.0;

/// Detects unsigned 16-bit values: whole numbers, most of them around 32768 on every axis.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Unsigned {
    /// A value cannot be an unsigned 16-bit number.
    refuted: bool,
    /// Number of values of each axis, and of those [`AROUND`] 32768.
    values: [u64; 3],
    around: [u64; 3],
}

impl Unsigned {
    #[inline]
    pub fn observe(&mut self, accel: [f64; 3]) {
        if self.refuted {
            return;
        }
        for (axis, v) in accel.into_iter().enumerate().filter(|(_, v)| v.is_finite()) {
            self.refuted |= !(is_whole_number(v) && (0.0..65536.0).contains(&v));
            self.values[axis] += 1;
            self.around[axis] += u64::from(AROUND.contains(&v));
        }
    }

    /// True if the values are unsigned counts.
    pub fn is_unsigned(&self) -> bool {
        let most = |i: usize| 2 * self.around[i] > self.values[i];
        !self.refuted && (0..3).all(most)
    }
}

/// Detects counts of a gyroscope: whole numbers that are not all zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GyroCounts {
    whole: bool,
    moves: bool,
}

impl Default for GyroCounts {
    fn default() -> Self {
        GyroCounts {
            whole: true,
            moves: false,
        }
    }
}

impl GyroCounts {
    #[inline]
    pub fn observe(&mut self, rate: [f64; 3]) {
        if self.whole {
            self.whole = rate.iter().all(|v| v.is_nan() || v.fract() == 0.0);
            self.moves |= rate.iter().any(|v| v.abs() >= 1.0);
        }
    }

    pub fn look_like_counts(self) -> bool {
        self.whole && self.moves
    }
}
