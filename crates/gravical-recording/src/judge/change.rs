//! Changes of unit or range among the rows.

use super::unit::rest_norm;
use crate::finding::{Finding, FindingKind};

/// Rows of a block.
const BLOCK_ROWS: usize = 20;
/// Blocks at rest in a row that establish a magnitude.
const SETTLED: usize = 5;
/// Magnitudes at rest in one unit differ by no more than this share …
const ONE_UNIT: f64 = 0.25;
/// … and the ratio of two units, or ranges, is matched within this share.
const RATIO: f64 = 0.08;
/// Ratios of 1 g in g, m/s² and mg, and of 1 g in counts at ±16 g to ±2 g to these, from 8.5 on.
const UNIT_RATIOS: [f64; 12] = [
    9.80665, 16.384, 101.972, 208.838, 417.676, 835.351, 1000.0, 1670.70, 2048.0, 4096.0, 8192.0,
    16384.0,
];
/// Ratios of two ranges.
const RANGE_RATIOS: [f64; 3] = [2.0, 4.0, 8.0];
/// Counts at or near the end of the range of a 16-bit converter.
const FULL: f64 = 32_700.0;

/// The first row under another unit or range: the magnitude at rest jumps from gravity in one unit
/// to gravity in another and stays there. No motion can cause this, since a sensor at rest measures
/// 1 g. `before`: the magnitude at rest before these rows, if it is known.
pub fn unit_change(accel: &[Vec<f64>; 3], lines: &[u32], before: Option<f64>) -> Option<Finding> {
    let norm = |row: usize| accel.iter().map(|c| c[row] * c[row]).sum::<f64>().sqrt();
    let is_near = |a: f64, b: f64| (a / b - 1.0).abs() <= ONE_UNIT;
    let is_full = |block: &[&[f64]; 3]| block.iter().any(|c| c.iter().any(|v| v.abs() >= FULL));
    let mut established = before;
    // Blocks that agree with each other and not with that: their number, magnitude, first row.
    let (mut count, mut other, mut from) = (0, 0.0, 0);
    for start in (0..accel[0].len().saturating_sub(BLOCK_ROWS - 1)).step_by(BLOCK_ROWS) {
        let block = accel.each_ref().map(|c| &c[start..start + BLOCK_ROWS]);
        let is_known = |magnitude: f64| established.is_some_and(|n| is_near(magnitude, n));
        let magnitude = rest_norm(block).filter(|m| !is_full(&block) && !is_known(*m));
        let Some(magnitude) = magnitude else {
            count = 0;
            continue;
        };
        if count > 0 && is_near(magnitude, other) {
            count += 1;
        } else {
            (count, other, from) = (1, magnitude, start);
        }
        if count < SETTLED {
            continue;
        }
        let Some(before) = established else {
            established = Some(other);
            continue;
        };
        if !is_other_unit(before, other, block) {
            continue;
        }
        let between = (before * other).sqrt();
        let is_new = |row: &usize| (norm(*row) > between) == (other > between);
        let rows = from.saturating_sub(BLOCK_ROWS)..from + BLOCK_ROWS;
        let row = rows.rev().take_while(is_new).last().unwrap_or(from);
        let line = lines[row];
        let text = format!(
            "the magnitude at rest is {before:.4} before line {line} and {other:.4} from there on: the unit or range changed without a new header"
        );
        let lines = [u64::from(line)].into_iter().collect();
        return Some(Finding::new(FindingKind::UnitChanged, text).at_lines(&lines));
    }
    None
}

/// True if both magnitudes can be 1 g, in two units or at two ranges. A change of range is only
/// possible between counts (whole numbers): for other values a factor of two may be a force.
fn is_other_unit(before: f64, after: f64, block: [&[f64]; 3]) -> bool {
    let ratio = after / before;
    let is = |expected: f64| (ratio / expected - 1.0).abs() <= RATIO;
    let is_one_of = |ratios: &[f64]| ratios.iter().any(|r| is(*r) || is(1.0 / r));
    let integers = block.iter().all(|c| c.iter().all(|v| v.fract() == 0.0));
    is_one_of(&UNIT_RATIOS) || integers && is_one_of(&RANGE_RATIOS)
}
