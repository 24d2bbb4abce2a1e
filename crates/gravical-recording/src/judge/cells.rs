//! Empty cells, and simple statistics of a column.

use crate::finding::{Finding, FindingKind};

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

/// Cells of the channels.
pub(crate) struct Cells<'a> {
    pub accel: &'a mut [Vec<f64>; 3],
    pub gyro: Option<&'a mut [Vec<f64>; 3]>,
    pub temperature_c: Option<&'a mut Vec<f64>>,
    /// Of each channel of the two sensors, not zero where a cell holds text; empty without any.
    pub texts: &'a [Vec<u8>],
    /// Cells that are empty because they held what marks an invalid sample.
    pub invalid: usize,
}

/// Counts empty cells and temperatures that no sensor can have, which become empty.
///
/// A recorder that writes each channel when it arrives leaves most cells empty: then the last
/// value of a channel holds until the next one, but not in cells of text: these are failed readings.
/// `lines`: that of each row. Returns what was found, and whether values hold.
pub(crate) fn fill_cells(
    cells: Cells<'_>,
    lines: &[u32],
    names: [&str; 7],
) -> (Option<Finding>, bool) {
    let rows = lines.len();
    let mut marked = vec![false; rows];
    let (mut counts, mut is_sparse) = ([0; 7], false);
    let sensors = [(Some(cells.accel), f64::INFINITY), (cells.gyro, GYRO_HELD)];
    for (k, (sensor, max_distances)) in sensors.into_iter().enumerate() {
        let Some(axes) = sensor else {
            continue;
        };
        let texts = &cells.texts[3 * k..3 * k + 3];
        for (axis, channel) in axes.iter().enumerate() {
            for (marked, v) in marked.iter_mut().zip(channel) {
                *marked |= v.is_nan();
                counts[3 * k + axis] += usize::from(v.is_nan());
            }
        }
        let held = held_rows(axes, texts, max_distances);
        is_sparse |= held.is_some();
        for ((max_rows, channel), text) in held.iter().flatten().zip(axes).zip(texts) {
            forward_fill(channel, *max_rows, text);
        }
    }
    let mut impossible = 0;
    for (row, t) in cells.temperature_c.into_iter().flatten().enumerate() {
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
    if cells.invalid > 0 {
        let invalid = cells.invalid;
        parts.push(format!(
            "{invalid} of them held -32768 alone, which marks an invalid sample"
        ));
    }
    if impossible > 0 {
        let (low, high) = (POSSIBLE_C.start(), POSSIBLE_C.end());
        parts.push(format!("{impossible} of them outside {low} to {high} °C"));
    }
    let done = if is_sparse {
        "each channel is written when it arrives: its last value is held, that of the gyroscope for a few rows"
    } else {
        "they stay empty"
    };
    let parts = parts.join(", ");
    let lacking = marked.iter().filter(|m| **m).count();
    let text = format!("{total} empty cells in {lacking} of {rows} rows ({parts}); {done}");
    // If cells are empty throughout the file, their lines are of no use.
    let lines = lines.iter().zip(marked).filter(|(_, m)| *m && !is_sparse);
    let lines = lines.map(|(line, _)| u64::from(*line)).collect();
    let found = (total > 0).then(|| Finding::new(FindingKind::EmptyCells, text).at_lines(&lines));
    (found, is_sparse)
}

/// Rows for which the last value of each channel holds where cells are empty, as many usual distances
/// between values; `None` for a sensor whose cells are rarely empty.
fn held_rows(axes: &[Vec<f64>; 3], texts: &[Vec<u8>], distances: f64) -> Option<[f64; 3]> {
    let rows = axes[0].len();
    let is_empty = |row: usize| {
        let mut cells = axes.iter().zip(texts);
        cells.any(|(axis, text)| axis[row].is_nan() && !is_text(text, row))
    };
    let lacking = (0..rows).filter(|row| is_empty(*row)).count();
    are_many(lacking, rows).then(|| {
        axes.each_ref().map(|axis| {
            let known = axis.iter().filter(|v| !v.is_nan()).count();
            distances * rows as f64 / known.max(1) as f64
        })
    })
}

/// Whether so many rows lack a value that each channel may be written when it arrives.
pub(crate) fn is_sparse(channels: &[&[f64]]) -> bool {
    let rows = channels[0].len();
    let lacks = |row: &usize| channels.iter().any(|c| c[*row].is_nan());
    are_many((0..rows).filter(lacks).count(), rows)
}

fn are_many(lacking: usize, rows: usize) -> bool {
    rows >= SPARSE_ROWS && 5 * lacking > rows
}

fn is_text(text: &[u8], row: usize) -> bool {
    text.get(row).is_some_and(|code| *code > 0)
}

/// Fills empty cells with the value before, for so many rows at most.
fn forward_fill(channel: &mut [f64], max_rows: f64, text: &[u8]) {
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
