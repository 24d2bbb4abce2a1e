//! Rows that are no measurement.

use std::cmp::Reverse;
use std::ops::Range;

use gravical_signal::resolution;

use super::frozen::runs;
use super::unit::quiet_norm;

/// Rows for which all channels may repeat by chance.
const MAX_REPEATS: usize = 20;
/// Rows in a row in which the accelerometer alone reads zero that are no free fall.
const ZEROS_IN_A_ROW: usize = 5;
/// Rows from which the resolution is taken.
const RESOLUTION_ROWS: usize = 20_000;
/// Coarser than this, a MEMS accelerometer at rest may stay at one value: its noise is 1 to 5 mg.
const MAX_RESOLUTION_G: f64 = 0.002;
/// Rows of a block whose magnitude tells whether channels are shifted.
const SLIP_ROWS: usize = 10;

/// Rows in a row in which the accelerometer reads zero on all axes: it was not read.
pub(crate) fn unread_runs(accel: [&[f64]; 3]) -> Vec<Range<usize>> {
    let is_zero = |row: usize| accel.iter().all(|axis| axis[row] == 0.0);
    let zeros = runs(accel[0].len(), |row| is_zero(row) && is_zero(row - 1));
    zeros
        .into_iter()
        .filter(|run| run.len() >= ZEROS_IN_A_ROW)
        .collect()
}

/// False for the rows of runs in which all channels, those of the accelerometer first, repeat exactly
/// for longer than noise allows: a sensor or bus that hung.
///
/// Repeats prove nothing, and no row is marked, where they are common between the runs, where
/// they are most rows (a logger faster than its sensor), and where the accelerometer resolves no
/// noise. `is_proof`: what other rows showed of that.
pub fn mark_hung(channels: &[&[f64]], is_proof: Option<bool>) -> Vec<bool> {
    let (long, short) = find_repeats(channels);
    let mut keep = vec![true; channels[0].len()];
    if !long.is_empty() && is_proof.unwrap_or_else(|| are_proof(channels, &long, short)) {
        for run in long {
            keep[run.start + 1..run.end].fill(false);
        }
    }
    keep
}

/// Whether repeats in rows that follow these are proof of a sensor that hung.
pub(crate) fn repeats_are_proof(channels: &[&[f64]]) -> bool {
    let (long, short) = find_repeats(channels);
    are_proof(channels, &long, short)
}

fn are_proof(channels: &[&[f64]], long: &[Range<usize>], short: usize) -> bool {
    let rows = channels[0].len();
    let hung: usize = long.iter().map(Range::len).sum();
    let are_common = short * 20 > rows - hung || hung * 2 > rows;
    !are_common && resolves_noise(&channels[..3])
}

/// Runs in which all channels repeat for longer than by chance, and repeats in shorter ones.
fn find_repeats(channels: &[&[f64]]) -> (Vec<Range<usize>>, usize) {
    let repeats = |row: usize| channels.iter().all(|c| c[row] == c[row - 1]);
    let all = runs(channels[0].len(), repeats).into_iter();
    let (long, short): (Vec<_>, Vec<_>) = all.partition(|run| run.len() > MAX_REPEATS);
    (long, short.iter().map(|run| run.len() - 1).sum())
}

/// Whether the steps in which the accelerometer is written are finer than its noise may be.
fn resolves_noise(accel: &[&[f64]]) -> bool {
    let rows = accel[0].len().min(RESOLUTION_ROWS);
    let axes = [0, 1, 2].map(|i| &accel[i][..rows]);
    let Some(gravity) = quiet_norm(axes) else {
        return false;
    };
    let steps = axes
        .iter()
        .map(|axis| resolution(axis.iter().copied().filter(|v| v.is_finite())));
    steps.fold(0.0, f64::max) < MAX_RESOLUTION_G * gravity
}

/// The row from which on the six channels are shifted (a lost byte on the bus): before it only
/// the named axes hold gravity, after it only those the same number of places further on. `gravity`:
/// in the unit of the values; by default that of the first quarter.
pub fn slip(channels: [&[f64]; 6], accel_at: usize, gravity: Option<f64>) -> Option<usize> {
    let rows = channels[0].len();
    let named = [0, 1, 2].map(|i| &channels[accel_at + i][..rows / 4]);
    let gravity = gravity.or_else(|| quiet_norm(named))?;
    let blocks: Vec<[f64; 6]> = (0..rows / SLIP_ROWS)
        .map(|b| channels.map(|c| mean_square(&c[SLIP_ROWS * b..][..SLIP_ROWS])))
        .collect();
    // Relative error of the magnitude of gravity in three channels of a block.
    let error = |block: usize, shift: usize| -> f64 {
        let squares = [0, 1, 2].map(|i| blocks[block][(accel_at + shift + i) % 6]);
        (squares.iter().sum::<f64>().sqrt() / gravity - 1.0).abs()
    };
    let jump = |row: usize| -> f64 {
        let steps = channels.iter().map(|c| (c[row] - c[row - 1]).abs());
        steps.sum()
    };
    // Number of shifted blocks, and the row from which on the channels are shifted.
    let slip_by = |shift: usize| -> Option<(usize, usize)> {
        let is_named = |b: &usize| error(*b, 0) < 0.1 && error(*b, shift) > 0.2;
        let is_shifted = |b: &usize| error(*b, 0) > 0.2 && error(*b, shift) < 0.1;
        let count = (0..blocks.len()).filter(is_shifted).count();
        let first = (0..blocks.len()).find(is_shifted)?;
        let last = (0..first).rev().find(is_named)?;
        let stays = (first..blocks.len()).filter(is_named).count() * 20 <= count;
        let rows = SLIP_ROWS * last + 1..SLIP_ROWS * (first + 1);
        let row = rows.max_by(|a, b| jump(*a).total_cmp(&jump(*b)))?;
        (stays && count >= 5).then_some((count, row))
    };
    // Of several shifts that fit as often, the one that began first.
    let slips = (1..6).filter_map(slip_by);
    let slip = slips.max_by_key(|(blocks, row)| (*blocks, Reverse(*row)));
    slip.map(|s| s.1)
}

fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64
}
