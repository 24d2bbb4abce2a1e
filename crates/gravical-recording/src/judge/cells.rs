//! Empty cells, and simple statistics of a column.

use crate::finding::{Finding, FindingKind};

/// Median of the finite values.
#[must_use]
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Shares of the steps that go up and down.
#[must_use]
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
pub(crate) const GYRO_HELD: f64 = 4.5;

/// The channels of a recording.
#[derive(Debug)]
pub struct Channels<'a> {
    /// Specific force
    pub accel: &'a mut [Vec<f64>; 3],
    /// Angular rate
    pub gyro: Option<&'a mut [Vec<f64>; 3]>,
    /// Temperature, °C
    pub temperature_c: Option<&'a mut Vec<f64>>,
}

/// Counts empty cells and temperatures that no sensor can have, which become empty.
///
/// A recorder that writes each channel when it arrives leaves most cells empty: then the last
/// value of a channel holds until the next one. `lines`: that of each row. Returns what was found, and
/// whether values of the accelerometer are held.
pub fn fill_cells(
    channels: Channels<'_>,
    lines: &[u32],
    names: [&str; 7],
) -> (Option<Finding>, bool) {
    let Channels {
        accel,
        mut gyro,
        temperature_c,
    } = channels;
    let rows = lines.len();
    let is_empty = |channel: &Vec<f64>, row: usize| channel[row].is_nan();
    let empty = |channel: &Vec<f64>| channel.iter().filter(|v| v.is_nan()).count();
    let lacks = |sensor: &[Vec<f64>; 3]| -> Vec<bool> {
        (0..rows)
            .map(|row| sensor.iter().any(|c| is_empty(c, row)))
            .collect()
    };
    let mut marked = lacks(accel);
    let incomplete = marked.iter().filter(|m| **m).count();
    let mut counts = accel.iter().map(empty).collect::<Vec<_>>();
    let mut holds = [is_sparse(incomplete, rows), false];
    match &gyro {
        Some(gyro) => {
            let lacking = lacks(gyro);
            holds[1] = is_sparse(lacking.iter().filter(|l| **l).count(), rows);
            marked.iter_mut().zip(lacking).for_each(|(m, l)| *m |= l);
            counts.extend(gyro.iter().map(empty));
        }
        None => counts.extend([0; 3]),
    }
    let (mut impossible, mut missing) = (0, 0);
    if let Some(temperature_c) = temperature_c {
        for (row, t) in temperature_c.iter_mut().enumerate() {
            if t.is_finite() && !POSSIBLE_C.contains(t) {
                *t = f64::NAN;
                impossible += 1;
                marked[row] = true;
            }
            missing += usize::from(t.is_nan());
        }
    }
    counts.push(missing);
    if holds[0] {
        accel.iter_mut().for_each(|c| hold(c, f64::INFINITY));
    }
    for channel in gyro
        .iter_mut()
        .filter(|_| holds[1])
        .flat_map(|g| g.iter_mut())
    {
        let distance = rows as f64 / (rows - empty(channel)).max(1) as f64;
        hold(channel, GYRO_HELD * distance);
    }
    let total: usize = counts.iter().sum();
    let some = names.iter().zip(&counts).filter(|(_, n)| **n > 0);
    let mut parts: Vec<String> = some.map(|(name, n)| format!("{name} {n}")).collect();
    if impossible > 0 {
        let (low, high) = (POSSIBLE_C.start(), POSSIBLE_C.end());
        parts.push(format!("{impossible} of them outside {low} to {high} °C"));
    }
    let done = match holds {
        [true, _] => {
            ": each channel is written when it arrives; the last value of the others is held"
        }
        [_, true] => {
            "; each channel of the gyroscope is written when it arrives: its last value is held for a few rows"
        }
        _ => "; they stay empty",
    };
    // If cells are empty throughout the file, their lines are of no use.
    let marked = lines
        .iter()
        .zip(marked)
        .filter(|(_, m)| *m && holds == [false; 2]);
    let sensor = if names[0] == "gx" {
        "gyroscope"
    } else {
        "accelerometer"
    };
    let found = (total > 0).then(|| {
        let text = format!(
            "{total} empty cells ({}); {incomplete} of {rows} rows lack a value of the {sensor}{done}",
            parts.join(", ")
        );
        Finding::new(FindingKind::EmptyCells, text).at_lines(&marked.map(|(line, _)| u64::from(*line)).collect())
    });
    (found, holds[0])
}

/// Whether so many rows lack a value that each channel is written when it arrives.
pub(crate) fn is_sparse(incomplete: usize, rows: usize) -> bool {
    rows >= SPARSE_ROWS && 5 * incomplete > rows
}

/// Fills empty cells with the last value, for so many rows at most.
fn hold(channel: &mut [f64], longest: f64) {
    let (mut last, mut held) = (f64::NAN, 0.0);
    for v in channel {
        if !v.is_nan() {
            (last, held) = (*v, 0.0);
        } else if held < longest {
            *v = last;
            held += 1.0;
        }
    }
}
