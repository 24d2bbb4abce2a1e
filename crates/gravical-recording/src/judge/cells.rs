//! Empty cells, and simple statistics of a column.

use crate::finding::{Finding, FindingKind};
use crate::readings::Readings;

/// Median of the finite values.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Shares of the steps that go up and down.
pub fn trend(values: &[f64]) -> (f64, f64) {
    let steps = values.len().max(2) as f64 - 1.0;
    let up = values.windows(2).filter(|w| w[1] > w[0]).count() as f64;
    let down = values.windows(2).filter(|w| w[1] < w[0]).count() as f64;
    (up / steps, down / steps)
}

/// Temperatures that a sensor can have, °C.
pub const POSSIBLE_C: std::ops::RangeInclusive<f64> = -60.0..=150.0;

/// Smallest number of rows for holding values.
const SPARSE_ROWS: usize = 20;

/// Longest holding of the gyroscope's values, in usual distances between them. As for gaps, an
/// integral over longer holding would be meaningless.
const GYRO_HELD: f64 = 4.5;

/// Rows for which the last values of accelerometer and gyroscope hold, where they do.
pub(crate) type HeldRows = [Option<[f64; 3]>; 2];

/// Counts empty cells and temperatures that no sensor can have, which become empty.
///
/// A recorder that writes each channel when it arrives leaves most cells empty: then the last
/// value of a channel holds until the next one, but not in cells of text: these are failed readings.
/// `lines`: that of each row; `texts`: of each channel, not zero where a cell holds text, empty without
/// any; `known`: what holds by rows before these. Returns what was found, and for how many rows the values
/// of accelerometer and gyroscope hold.
pub(crate) fn fill_cells(
    readings: &mut Readings,
    lines: &[u32],
    names: [&str; 7],
    texts: &[&[u8]],
    known: Option<HeldRows>,
) -> (Option<Finding>, HeldRows) {
    let rows = lines.len();
    let mut marked = vec![false; rows];
    let (mut counts, mut holds) = ([0; 7], [None; 2]);
    let sensors = [
        (Some(&mut readings.accel), f64::INFINITY),
        (readings.gyro.as_mut(), GYRO_HELD),
    ];
    for (k, (sensor, max_distances)) in sensors.into_iter().enumerate() {
        let Some(axes) = sensor else {
            continue;
        };
        let texts = &texts[3 * k..3 * k + 3];
        for (axis, channel) in axes.iter().enumerate() {
            for (marked, v) in marked.iter_mut().zip(channel) {
                *marked |= v.is_nan();
                counts[3 * k + axis] += usize::from(v.is_nan());
            }
        }
        holds[k] = match known {
            Some(known) => known[k],
            None => held_rows(axes, texts, max_distances),
        };
        for ((max_rows, channel), text) in holds[k].iter().flatten().zip(axes).zip(texts) {
            hold(channel, *max_rows, text);
        }
    }
    let mut impossible = 0;
    for (row, t) in readings.temperature_c.iter_mut().flatten().enumerate() {
        if t.is_finite() && !POSSIBLE_C.contains(t) {
            *t = f64::NAN;
            impossible += 1;
        }
        marked[row] |= t.is_nan();
        counts[6] += usize::from(t.is_nan());
    }
    let total: usize = counts.iter().sum();
    let some = names.iter().zip(&counts).filter(|(_, n)| **n > 0);
    let mut parts: Vec<String> = some.map(|(name, n)| format!("{name} {n}")).collect();
    if impossible > 0 {
        let (low, high) = (POSSIBLE_C.start(), POSSIBLE_C.end());
        parts.push(format!("{impossible} of them outside {low} to {high} °C"));
    }
    let is_held = holds.iter().any(Option::is_some);
    let done = if is_held {
        "each channel is written when it arrives: its last value is held, that of the gyroscope for a few rows"
    } else {
        "they stay empty"
    };
    let parts = parts.join(", ");
    let lacking = marked.iter().filter(|m| **m).count();
    let text = format!("{total} empty cells in {lacking} of {rows} rows ({parts}); {done}");
    // If cells are empty throughout the file, their lines are of no use.
    let lines = lines.iter().zip(marked).filter(|(_, m)| *m && !is_held);
    let lines = lines.map(|(line, _)| u64::from(*line)).collect();
    let found = (total > 0).then(|| Finding::new(FindingKind::EmptyCells, text).at_lines(&lines));
    (found, holds)
}

/// Rows for which the last value of each channel holds where cells are empty, as many usual distances
/// between values; `None` for a sensor whose cells are rarely empty.
fn held_rows(axes: &[Vec<f64>; 3], texts: &[&[u8]], distances: f64) -> Option<[f64; 3]> {
    let rows = axes[0].len();
    let is_empty = |row: usize| {
        let mut cells = axes.iter().zip(texts);
        cells.any(|(axis, text)| axis[row].is_nan() && !is_text(text, row))
    };
    let lacking = (0..rows).filter(|row| is_empty(*row)).count();
    let is_sparse = rows >= SPARSE_ROWS && 5 * lacking > rows;
    is_sparse.then(|| {
        axes.each_ref().map(|axis| {
            let known = axis.iter().filter(|v| !v.is_nan()).count();
            distances * rows as f64 / known.max(1) as f64
        })
    })
}

fn is_text(text: &[u8], row: usize) -> bool {
    text.get(row).is_some_and(|code| *code > 0)
}

/// Fills empty cells with the value before, for so many rows at most.
fn hold(channel: &mut [f64], max_rows: f64, text: &[u8]) {
    let (mut last, mut rows) = (f64::NAN, 0.0);
    for (row, v) in channel.iter_mut().enumerate() {
        if !v.is_nan() {
            (last, rows) = (*v, 0.0);
        } else if rows < max_rows && !is_text(text, row) {
            *v = last;
            rows += 1.0;
        }
    }
}
