//! Values that are no measurement: clipped, spiked.

use std::borrow::Cow;
use std::ops::Range;

use crate::quantile::quantile;
use crate::samples::Interpolated;

/// Longest spike, rows: a longer pulse may be a knock.
const MAX_SPIKE_ROWS: usize = 4;
/// A spike stands out of its neighbours by this factor, and out of the scatter near it by the other.
const SPIKE_OVER_NEIGHBOURS: f64 = 5.0;
const SPIKE_OVER_SCATTER: f64 = 12.0;
/// Rows on both sides that the scatter near a spike is taken from.
const SCATTER_ROWS: usize = 25;
/// The largest value is a range that was reached if it is one to this fraction.
const RANGE_TOLERANCE: f64 = 1e-3;
/// A channel stands at its extreme for longer than its noise allows: neighbours are equal that often in a run of
/// chance, once in so many.
const MAX_CHANCE: f64 = 1e-9;
/// What an interpolation over clipped samples may be off, as a fraction of what it adds: it meets a parabola's cap,
/// falls short of a cosine's by a twentieth and of a sharp top's by half.
const INTERPOLATED_SD: f64 = 0.25;
/// … and of the largest step at its ends: when it left the range is known to a tenth of a row.
const ONSET_SD: f64 = 0.1;

/// Replaces values that are no measurement, in the sensor's own axes before a calibration, and says
/// what the interpolation may be off.
///
/// Values at the end of one of the full-scale `ranges` (unit of the channels; the one that the largest
/// value reaches), or at an extreme of their channel where it stands for longer than its noise allows, follow the
/// slopes on both sides and stay at or beyond it. Spikes of up to four
/// rows higher than `min_spike` follow a line. Times are s, in order, one for each row; at the first and last two rows
/// nothing is replaced. `read` has three columns of one length. Returns them, and what was replaced; its channels are those of an accelerometer: add 3 for a gyroscope.
pub fn interpolate_outliers<'a>(
    time_s: &[f64],
    read: [&'a [f64]; 3],
    ranges: &[f64],
    min_spike: f64,
) -> ([Cow<'a, [f64]>; 3], Vec<Interpolated>) {
    let count = time_s.len().min(read[0].len());
    let sizes = read.iter().flat_map(|c| c.iter()).map(|v| v.abs());
    let largest = sizes.filter(|v| v.is_finite()).fold(0.0, f64::max);
    let is_reached = |range: &&f64| (largest / **range - 1.0).abs() < RANGE_TOLERANCE;
    let range = ranges.iter().find(is_reached).copied();
    let mut out = Vec::new();
    let mut columns = read.map(Cow::Borrowed);
    for (axis, column) in columns.iter_mut().enumerate() {
        let limits = limits(column);
        let mut i = 2;
        while i + 2 < count {
            let at_range = clipped_rows(column, i, range);
            let clipped = at_range.max(flat_rows(column, i, &limits));
            let is_clipped = clipped > 0;
            let rows = if is_clipped {
                i..i + clipped
            } else {
                i..i + spiked_rows(column, i, min_spike)
            };
            i += 1;
            let mut others = (0..3).filter(|other| *other != axis);
            let mut is_knock = || others.any(|k| jumps(read[k], &rows));
            if rows.is_empty() || rows.end + 1 >= count || (!is_clipped && is_knock()) {
                continue;
            }
            i = rows.end + 1;
            let sd = if is_clipped {
                interpolate_clipped(time_s, column.to_mut(), &rows)
            } else {
                interpolate_spike(time_s, column.to_mut(), &rows)
            };
            if sd.is_finite() {
                out.push(Interpolated {
                    rows,
                    channel: axis,
                    is_clipped,
                    sd,
                });
            }
        }
    }
    (columns, out)
}

/// Rows from `i` on at the end of the range.
fn clipped_rows(column: &[f64], i: usize, range: Option<f64>) -> usize {
    let Some(range) = range else { return 0 };
    let end = column[i].signum() * range;
    let at_end = |v: &&f64| (**v / end - 1.0).abs() < RANGE_TOLERANCE;
    column[i..column.len() - 2]
        .iter()
        .take_while(at_end)
        .count()
}

/// The extremes of a column, highest and lowest, and how many equal values in a row there are no chance; none where it
/// hardly changes.
fn limits(column: &[f64]) -> [(f64, usize); 2] {
    let finite = || column.iter().copied().filter(|v| v.is_finite());
    let ends = [
        finite().fold(f64::MIN, f64::max),
        finite().fold(f64::MAX, f64::min),
    ];
    let inside = column.windows(2).filter(|w| !ends.contains(&w[0]));
    let (mut pairs, mut equal) = (1.0, 1.0);
    for pair in inside {
        pairs += 1.0;
        equal += f64::from(u8::from(pair[0] == pair[1]));
    }
    let rows = 2.0 + (MAX_CHANCE.ln() / (equal / pairs).ln()).ceil();
    ends.map(|end| {
        (
            end,
            if rows.is_finite() {
                rows as usize
            } else {
                usize::MAX
            },
        )
    })
}

/// Rows from `i` on at one of the limits; 0 if there are too few.
fn flat_rows(column: &[f64], i: usize, limits: &[(f64, usize); 2]) -> usize {
    let reached = limits.iter().find(|(end, _)| column[i] == *end);
    let rows = |end: f64| {
        column[i..column.len() - 2]
            .iter()
            .take_while(|v| **v == end)
            .count()
    };
    reached.map_or(0, |(end, least)| {
        Some(rows(*end)).filter(|n| n >= least).unwrap_or(0)
    })
}

/// Rows from `i` on that stand out of their neighbours: 0 if it is no spike.
fn spiked_rows(column: &[f64], i: usize, min_spike: f64) -> usize {
    let is_spike = |run: &usize| {
        let (before, after) = (i - 1, i + run);
        let middle = 0.5 * (column[before] + column[after]);
        let off = |k: usize| column[k] - middle;
        let height = (i..after).map(|k| off(k).abs()).fold(f64::MAX, f64::min);
        let neighbours = [before - 1, before, after, after + 1];
        height > min_spike
            && (i..after).all(|k| off(k) * off(i) > 0.0)
            && neighbours
                .iter()
                .all(|k| off(*k).abs() * SPIKE_OVER_NEIGHBOURS < height)
            && scatter(column, &(i..after)) * SPIKE_OVER_SCATTER < height
    };
    let mut runs = (1..=MAX_SPIKE_ROWS).take_while(|run| i + run + 1 < column.len());
    runs.find(is_spike).unwrap_or(0)
}

/// True if a channel steps out of the scatter near `rows` there, too: a knock, or a foot that strikes, is felt
/// along all axes.
fn jumps(column: &[f64], rows: &Range<usize>) -> bool {
    largest_step(&column[rows.start - 1..=rows.end]) > SPIKE_OVER_SCATTER * scatter(column, rows)
}

fn largest_step(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|w| (w[1] - w[0]).abs());
    steps.fold(0.0, f64::max)
}

/// Follows the slopes on both sides (cubic Hermite), at least the range; what its mean may be off.
fn interpolate_clipped(time_s: &[f64], column: &mut [f64], rows: &Range<usize>) -> f64 {
    let (a, b) = (rows.start - 1, rows.end);
    let slope = |p: usize, q: usize| (column[q] - column[p]) / (time_s[q] - time_s[p]);
    let (before, after) = (slope(a - 1, a), slope(b, b + 1));
    let (seconds, end) = (time_s[b] - time_s[a], column[rows.start]);
    // Of the rows on both sides, those to the end of the range included.
    let step = largest_step(&[column[a - 1], column[a], end, column[b], column[b + 1]]);
    let over = |k: usize| {
        let u = (time_s[k] - time_s[a]) / seconds;
        let line = column[a] + (column[b] - column[a]) * u;
        let bow = seconds * u * (1.0 - u) * (before * (1.0 - u) - after * u);
        ((line + bow - end) * end.signum()).max(0.0)
    };
    let over: Vec<f64> = rows.clone().map(over).collect();
    if over.iter().all(|v| v.is_finite()) {
        for (value, over) in column[rows.clone()].iter_mut().zip(&over) {
            *value = end + over * end.signum();
        }
    }
    let beyond: f64 = over.iter().map(|over| over / rows.len() as f64).sum();
    INTERPOLATED_SD * beyond + ONSET_SD * step
}

/// Follows a line; what its mean may be off.
fn interpolate_spike(time_s: &[f64], column: &mut [f64], rows: &Range<usize>) -> f64 {
    let (a, b) = (rows.start - 1, rows.end);
    let sd = (column[b] - column[a]).abs() / 2.0 + scatter(column, rows);
    for k in rows.clone() {
        let u = (time_s[k] - time_s[a]) / (time_s[b] - time_s[a]);
        column[k] = column[a] + (column[b] - column[a]) * if u.is_finite() { u } else { 0.5 };
    }
    sd
}

/// Median step from row to row near `rows`, without them.
fn scatter(column: &[f64], rows: &Range<usize>) -> f64 {
    let before = rows.start.saturating_sub(SCATTER_ROWS)..rows.start - 1;
    let after = rows.end + 1..(rows.end + SCATTER_ROWS).min(column.len() - 1);
    let steps = before
        .chain(after)
        .map(|k| (column[k + 1] - column[k]).abs());
    quantile(steps.collect(), 0.5)
}
