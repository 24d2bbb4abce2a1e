//! Rows that are no measurement.

use std::cmp::Reverse;
use std::ops::Range;

use gravical_signal::resolution;

use super::frozen::runs;
use super::unit::quiet_norm;

/// Rows for which all channels may repeat by chance.
pub(crate) const MAX_REPEATS: usize = 20;
/// Rows in a row in which the accelerometer alone reads zero that are no free fall.
const ZEROS_IN_A_ROW: usize = 5;
/// Rows from which the resolution is taken.
const RESOLUTION_ROWS: usize = 20_000;
/// Coarser than this, a MEMS accelerometer at rest may stay at one value: its noise is 1 to 5 mg.
const MAX_RESOLUTION_G: f64 = 0.002;
/// Rows of a block whose magnitude tells whether channels are shifted.
const SLIP_ROWS: usize = 10;

/// Rows in a row in which the accelerometer reads zero on all axes: it was not read. `before`: so
/// many such rows precede the first. Returns also how many there are at the end.
pub(crate) fn unread_runs(accel: [&[f64]; 3], before: usize) -> (Vec<Range<usize>>, usize) {
    let (mut found, mut from, mut zeros) = (Vec::new(), 0, before);
    let rows = accel[0].len();
    for row in 0..rows {
        if accel.iter().all(|axis| axis[row] == 0.0) {
            zeros += 1;
            continue;
        }
        if zeros >= ZEROS_IN_A_ROW && from < row {
            found.push(from..row);
        }
        (from, zeros) = (row + 1, 0);
    }
    if zeros >= ZEROS_IN_A_ROW && from < rows {
        found.push(from..rows);
    }
    (found, zeros)
}

/// False for the rows of runs in which all channels repeat exactly for longer than noise allows:
/// a sensor or bus that hung.
///
/// Repeats prove nothing, and no row is marked, where they are common between the runs, where
/// they are most rows (a logger faster than its sensor), and where the accelerometer resolves no
/// noise.
#[must_use]
pub fn mark_hung(accel: [&[f64]; 3], gyro: &[&[f64]]) -> Vec<bool> {
    let rows = accel[0].len();
    let repeats = |row: usize| accel.iter().chain(gyro).all(|c| c[row] == c[row - 1]);
    let (mut keep, mut short, mut long) = (vec![true; rows], 0, 0);
    for run in runs(rows, repeats) {
        if run.len() > MAX_REPEATS {
            keep[run.start + 1..run.end].fill(false);
            long += run.len();
        } else {
            short += run.len() - 1;
        }
    }
    let is_common = short * 20 > rows - long || long * 2 > rows;
    if long > 0 && (is_common || !resolves_noise(accel)) {
        vec![true; rows]
    } else {
        keep
    }
}

/// Whether the steps in which the accelerometer is written are finer than its noise may be.
pub(crate) fn resolves_noise(accel: [&[f64]; 3]) -> bool {
    let rows = accel[0].len().min(RESOLUTION_ROWS);
    let axes = accel.map(|axis| &axis[..rows]);
    let Some(gravity) = quiet_norm(axes) else {
        return false;
    };
    let steps = axes
        .iter()
        .map(|axis| resolution(axis.iter().copied().filter(|v| v.is_finite())));
    steps.fold(0.0, f64::max) < MAX_RESOLUTION_G * gravity
}

/// The row from which on the six channels are shifted (a lost byte on the bus): before it only
/// the named axes hold gravity, after it only those the same number of places further on.
#[must_use]
pub fn slip(channels: [&[f64]; 6], accel_at: usize) -> Option<usize> {
    let rows = channels[0].len();
    let named = [0, 1, 2].map(|i| &channels[accel_at + i][..rows / 4]);
    let gravity = quiet_norm(named)?;
    let blocks: Vec<[f64; 6]> = (0..rows / SLIP_ROWS)
        .map(|b| channels.map(|c| mean_square(&c[SLIP_ROWS * b..][..SLIP_ROWS])))
        .collect();
    let axes = |shift: usize| [0, 1, 2].map(|i| (accel_at + shift + i) % 6);
    // Relative error of the magnitude of gravity in three channels of each block.
    let errors = |shift: usize| -> Vec<f64> {
        let norm = |block: &[f64; 6]| axes(shift).iter().map(|c| block[*c]).sum::<f64>().sqrt();
        blocks
            .iter()
            .map(|b| (norm(b) / gravity - 1.0).abs())
            .collect()
    };
    let named = errors(0);
    let slips = (1..6).filter_map(|shift| slip_by(channels, &named, &errors(shift)));
    // Of several shifts that fit as often, the one that began first.
    slips
        .max_by_key(|(blocks, row)| (*blocks, Reverse(*row)))
        .map(|s| s.1)
}

fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64
}

/// Number of shifted blocks, and the row from which on the channels are shifted, by the errors of
/// gravity in the named and in the shifted channels.
fn slip_by(channels: [&[f64]; 6], named: &[f64], shifted: &[f64]) -> Option<(usize, usize)> {
    let is_named = |b: &usize| named[*b] < 0.1 && shifted[*b] > 0.2;
    let is_shifted = |b: &usize| named[*b] > 0.2 && shifted[*b] < 0.1;
    let blocks = named.len();
    let count = (0..blocks).filter(is_shifted).count();
    let first = (0..blocks).find(is_shifted)?;
    let last = (0..first).rev().find(is_named)?;
    let stays = (first..blocks).filter(is_named).count() * 20 <= count;
    let jump = |row: usize| -> f64 {
        let steps = channels.iter().map(|c| (c[row] - c[row - 1]).abs());
        steps.sum()
    };
    let rows = SLIP_ROWS * last + 1..SLIP_ROWS * (first + 1);
    let row = rows.max_by(|a, b| jump(*a).total_cmp(&jump(*b)))?;
    (stays && count >= 5).then_some((count, row))
}
