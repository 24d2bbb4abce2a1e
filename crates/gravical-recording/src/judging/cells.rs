//! Empty cells.

use gravical_judge::finding::{Case, EmptyCells};
use gravical_judge::units::POSSIBLE_C;
use gravical_judge::{Finding, GAP_PERIODS};

use super::clean::names;
use crate::recording::Recording;

impl Recording {
    /// Counts empty cells and temperatures that no sensor can have, which become empty.
    ///
    /// A recorder that writes each channel when it arrives leaves most cells empty: then the last
    /// value of a channel holds until the next one, but not in cells of text: these are failed readings.
    /// `texts`: of each channel, not zero where a cell holds text; empty without any. `invalid`: cells
    /// that are empty because they held what marks an invalid sample.
    pub(super) fn fill_cells(&mut self, texts: &[&[u8]], invalid: usize) -> Option<Finding> {
        let temperatures = self.temperature_c.iter_mut().flatten();
        let impossible = temperatures.filter(|t| t.is_finite() && !POSSIBLE_C.contains(t));
        let impossible = impossible.map(|t| *t = f64::NAN).count();
        let rows = self.rows();
        let mut is_marked = vec![false; rows];
        let mut cells = EmptyCells {
            rows,
            invalid,
            impossible,
            ..EmptyCells::default()
        };
        let channels = self.accel.iter().chain(self.gyro.iter().flatten());
        let named = names(&self.format).iter().copied().zip(channels);
        let temperature = self.temperature_c.iter().map(|t| ("temperature", t));
        for (name, channel) in named.chain(temperature) {
            let empty = (0..rows).filter(|row| channel[*row].is_nan());
            let count = empty.map(|row| is_marked[row] = true).count();
            cells.count += count;
            cells.channels.extend((count > 0).then_some((name, count)));
        }
        let sensors = [Some(&mut self.accel), self.gyro.as_mut()];
        let sensors = sensors.into_iter().flatten().zip(texts.chunks(3));
        // As for gaps, an integral over longer holding would be meaningless.
        let first = if self.format.options.is_gyroscope {
            GAP_PERIODS
        } else {
            f64::INFINITY
        };
        for ((axes, texts), distances) in sensors.zip([first, GAP_PERIODS]) {
            if is_sparse(axes, texts) {
                self.read_as.is_sparse = true;
                let channels = axes.iter_mut().zip(texts);
                channels.for_each(|(channel, text)| forward_fill(channel, distances, text));
            }
        }
        let is_sparse = self.read_as.is_sparse;
        cells.lacking = is_marked.iter().filter(|m| **m).count();
        // If cells are empty throughout the file, their lines are of no use.
        let lines = self.lines.iter().zip(is_marked);
        let lines = lines.filter(|(_, is_marked)| *is_marked && !is_sparse);
        let lines = lines.map(|(line, _)| u64::from(*line)).collect();
        (cells.count > 0).then(|| {
            let case = if is_sparse {
                Case::HeldCells { cells }
            } else {
                Case::EmptyCells { cells }
            };
            case.finding().at_lines(&lines)
        })
    }
}

/// Whether cells of a sensor are often empty, other than by text.
fn is_sparse(axes: &[Vec<f64>; 3], texts: &[&[u8]]) -> bool {
    let rows = axes[0].len();
    let is_empty = |row: &usize| {
        let mut cells = axes.iter().zip(texts);
        cells.any(|(axis, text)| axis[*row].is_nan() && !is_text(text, *row))
    };
    are_many((0..rows).filter(is_empty).count(), rows)
}

fn is_text(text: &[u8], row: usize) -> bool {
    text.get(row).is_some_and(|code| *code > 0)
}

/// Fills empty cells with the value before, over so many usual distances between values at most.
fn forward_fill(channel: &mut [f64], distances: f64, text: &[u8]) {
    let known = channel.iter().filter(|v| !v.is_nan()).count();
    let max_rows = distances * channel.len() as f64 / known.max(1) as f64;
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

/// Smallest number of rows for holding values.
const SPARSE_ROWS: usize = 20;

/// Whether so many rows lack a value that each channel may be written when it arrives.
pub(crate) fn has_sparse_rows(channels: &[&[f64]]) -> bool {
    let rows = channels[0].len();
    let lacks = |row: &usize| channels.iter().any(|c| c[*row].is_nan());
    are_many((0..rows).filter(lacks).count(), rows)
}

/// Whether so many of the rows are enough for it.
fn are_many(lacking: usize, rows: usize) -> bool {
    rows >= SPARSE_ROWS && 5 * lacking > rows
}
