//! Rows that are no measurement, axes that keep one value, and rows that repeat.

use std::ops::Range;

use crate::accel_unit::quiet_norm;
use crate::cells::median;
use crate::finding::{Case, Finding};
use crate::spans::LineSpans;

/// Rows for which all channels may repeat by chance.
const MAX_REPEATS: usize = 20;
/// Rows in a row in which the accelerometer alone reads zero that are no free fall.
const ZEROS_IN_A_ROW: usize = 5;
/// Rows from which the resolution is taken.
const RESOLUTION_ROWS: usize = 20_000;
/// Coarser than this, a MEMS accelerometer at rest may stay at one value: its noise is 1 to 5 mg.
const MAX_RESOLUTION_G: f64 = 0.002;
/// Rows in which an axis must keep exactly one value, while the others change, to count as frozen.
const FROZEN_ROWS: usize = 100;
/// The same for a channel that never changes in the whole recording.
const WHOLE_ROWS: usize = 20;
/// Steps of the resolution by which a channel must change to show that the row before was no new
/// reading.
const JUMP: f64 = 2.5;
/// Largest number of rows per run of repeats that ends with a jump; a rest every four seconds at
/// 25 Hz is as rare.
const ROWS_OF_RUN: usize = 100;
/// Repeated rows from which on they are reported.
const MIN_REPEATS: u64 = 10;

/// Runs of rows, two or more, in each of which all channels repeat the row before.
fn repeats(channels: &[&[f64]]) -> Vec<Range<usize>> {
    let rows = channels[0].len();
    let (mut found, mut from) = (Vec::new(), 0);
    for row in 1..=rows {
        if row == rows || channels.iter().any(|c| c[row] != c[row - 1]) {
            found.extend((row - from > 1).then_some(from..row));
            from = row;
        }
    }
    found
}

/// Rows in a row in which the accelerometer reads zero on all axes: it was not read.
pub fn unread_runs(accel: [&[f64]; 3]) -> Vec<Range<usize>> {
    let is_zero = |run: &Range<usize>| accel.iter().all(|axis| axis[run.start] == 0.0);
    let mut runs = repeats(&accel);
    runs.retain(|run| run.len() >= ZEROS_IN_A_ROW && is_zero(run));
    runs
}

/// False for the rows of runs in which all channels, those of the accelerometer first, repeat exactly
/// for longer than noise allows: a sensor or bus that hung.
///
/// Repeats prove nothing, and no row is marked, where they are common between the runs, where
/// they are most rows (a logger faster than its sensor), and where the accelerometer resolves no
/// noise.
pub fn detect_stuck(channels: &[&[f64]]) -> Vec<bool> {
    let rows = channels[0].len();
    let mut short = repeats(channels);
    let long: Vec<_> = short
        .extract_if(.., |run| run.len() > MAX_REPEATS)
        .collect();
    let short: usize = short.iter().map(|run| run.len() - 1).sum();
    let stuck: usize = long.iter().map(Range::len).sum();
    let are_common = short * 20 > rows - stuck || stuck * 2 > rows;
    let mut keep = vec![true; rows];
    if !long.is_empty() && !are_common && resolves_noise(&channels[..3]) {
        for run in long {
            keep[run.start + 1..run.end].fill(false);
        }
    }
    keep
}

/// Whether the steps in which the accelerometer is written are finer than its noise may be.
fn resolves_noise(accel: &[&[f64]]) -> bool {
    let rows = accel[0].len().min(RESOLUTION_ROWS);
    let axes = [0, 1, 2].map(|i| &accel[i][..rows]);
    let step = axes.map(usual_step).into_iter().fold(0.0, f64::max);
    quiet_norm(axes).is_some_and(|gravity| step < MAX_RESOLUTION_G * gravity)
}

/// By how much neighbouring ones of the values that occur differ, in the median; 0 if there is one only. Not their
/// resolution: a filter that was written with many digits has no noise either.
fn usual_step(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let steps = sorted.windows(2).map(|w| w[1] - w[0]);
    median(steps.filter(|step| *step > 0.0)).unwrap_or(0.0)
}

/// Axes of a sensor that keep exactly one value while the others change. `resolution`: of each
/// axis; `lines`: that of each row.
pub fn frozen_axes(
    sensor: &[Vec<f64>; 3],
    names: &[&str],
    resolution: &[f64],
    lines: &[u32],
) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (axis, channel) in sensor.iter().enumerate() {
        let (mut spans, mut longest) = (LineSpans::default(), 0);
        for run in repeats(&[channel.as_slice()]) {
            let is_whole = run.start == 0 && run.end == channel.len();
            let least = if is_whole { WHOLE_ROWS } else { FROZEN_ROWS };
            if run.len() < least {
                continue;
            }
            let others = [1, 2].map(|k| &sensor[(axis + k) % 3][run.clone()]);
            if is_frozen(others, resolution[axis]) {
                longest = longest.max(run.len());
                let line = |row: usize| u64::from(lines[row]);
                spans.push_range(line(run.start), line(run.end - 1), run.len() as u64);
            }
        }
        if longest > 0 {
            let frozen = Case::FrozenAxis {
                channel: names[axis].to_owned(),
                rows: longest,
            };
            findings.push(frozen.finding().at_lines(&spans));
        }
    }
    findings
}

/// Rows that repeat the row before in every channel throughout the recording: the sensor was read
/// faster than it measures. With a coarse resolution rows also repeat at rest, until the last
/// digit flips or a motion begins; after repeated readings the value often differs by much.
pub fn repeated_rows(channels: &[&[f64]], resolution: &[f64], lines: &[u32]) -> Option<Finding> {
    let rows = lines.len();
    let (mut spans, mut jumped, mut flipped) = (LineSpans::default(), 0, 0);
    for run in repeats(channels) {
        let ends_with_jump = match channels.first().and_then(|c| c.get(run.end)) {
            // The last run has no end: it is assumed to be like most of the others.
            None => jumped > flipped,
            Some(_) => channels
                .iter()
                .zip(resolution)
                .any(|(c, step)| (c[run.end] - c[run.end - 1]).abs() > JUMP * step),
        };
        if ends_with_jump {
            let line = |row: usize| u64::from(lines[row]);
            spans.push_range(line(run.start + 1), line(run.end - 1), run.len() as u64 - 1);
            jumped += 1;
        } else {
            flipped += 1;
        }
    }
    let repeated = spans.count();
    (jumped > flipped && jumped * ROWS_OF_RUN > rows && repeated >= MIN_REPEATS).then(|| {
        let case = Case::RepeatedRows {
            rows: repeated,
            percent: 100.0 * repeated as f64 / rows.max(1) as f64,
        };
        case.finding().at_lines(&spans)
    })
}

/// Rows that differ from the row before, the first included.
pub fn count_changes(channels: &[&[f64]]) -> usize {
    let repeated = repeats(channels).into_iter().map(|run| run.len() - 1);
    channels[0].len() - repeated.sum::<usize>()
}

/// Rms step from row to row, in resolutions, at which a working axis next to it would change too:
/// twice that of noise.
const LIVE_STEP: f64 = 2.0 * std::f64::consts::SQRT_2;
/// Range, in resolutions, that both other axes must cover: a turn or a push about one axis may
/// leave another one unchanged, but not a motion that changes both so much.
const FAR_RANGE: f64 = 20.0;

/// True if an axis is faulty that keeps one value while the two others have these: one of them
/// scatters by more than the resolution `step` can hide, or both change by much. At rest with a
/// coarse resolution an axis may keep its value without a fault.
fn is_frozen(others: [&[f64]; 2], step: f64) -> bool {
    let rows = others[0].len() as f64;
    let is_lively = |axis: &[f64]| {
        let steps = axis.windows(2).map(|w| w[1] - w[0]).filter(|s| !s.is_nan());
        let squares: f64 = steps.map(|s| s * s).sum();
        squares > 0.0 && squares >= (LIVE_STEP * step).powi(2) * rows
    };
    let is_far = |axis: &[f64]| {
        let low = axis.iter().copied().fold(f64::INFINITY, f64::min);
        let high = axis.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        high - low > FAR_RANGE * step
    };
    others.iter().any(|axis| is_lively(axis)) || others.iter().all(|axis| is_far(axis))
}
