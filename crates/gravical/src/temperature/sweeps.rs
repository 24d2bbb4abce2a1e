//! Cooling and warming sweeps: splits the temperature at its turning points and computes the
//! means of every sweep per degree.

use std::collections::BTreeMap;

use crate::calibration_file::{Sweep, SweepDirection};

use super::intervals::PoseInterval;

/// A turning point requires a change back by this share of the total temperature range …
const TURN_SHARE: f64 = 0.1;
/// … and by this many °C, since thermometers are noisy and chambers oscillate.
const LEAST_TURN_C: f64 = 1.0;

/// Number of bins over the total range, and their widths in °C.
const BINS: f64 = 60.0;
const BIN_C: std::ops::RangeInclusive<f64> = 0.2..=1.0;

/// Mean of one sweep in one pose over about a degree. Bins have equal weight: a chamber stays
/// long at its ends, and a model must also predict the temperatures in between.
#[derive(Debug, Clone)]
pub(super) struct Bin {
    pub pose: usize,
    pub direction: SweepDirection,
    /// Equal numbers are equal temperatures.
    pub degree: i64,
    /// Mean, lowest and highest temperature in it.
    pub t_c: f64,
    pub range_c: [f64; 2],
    pub values: [f64; 6],
    /// Number of blocks in the mean.
    pub blocks: f64,
    /// Sum of the squared deviations of the blocks.
    pub squares: [f64; 6],
}

/// Sweeps of all intervals in order, and their bins.
pub(super) fn bins(intervals: &[PoseInterval], span_c: f64) -> (Vec<Sweep>, Vec<Bin>) {
    let turn_c = (TURN_SHARE * span_c).max(LEAST_TURN_C);
    let width_c = (span_c / BINS).clamp(*BIN_C.start(), *BIN_C.end());
    let mut sweeps = Vec::new();
    let mut bins = Vec::new();
    let mut from = 0;
    while from < intervals.len() {
        // A sweep continues while the sensor is moved to another pose.
        let recording = intervals[from].recording;
        let to = intervals[from..]
            .iter()
            .position(|s| s.recording != recording)
            .map_or(intervals.len(), |n| from + n);
        let history: Vec<f64> = intervals[from..to]
            .iter()
            .flat_map(|s| s.blocks.iter().map(|b| b.t_c))
            .collect();
        let own = cut(&history, turn_c);
        let mut at = 0;
        let mut sorted: BTreeMap<(usize, usize, i64), Vec<[f64; 7]>> = BTreeMap::new();
        for (index, pose) in intervals.iter().enumerate().take(to).skip(from) {
            for block in &pose.blocks {
                if let Some(sweep) = own.iter().position(|(rows, _)| rows.contains(&at)) {
                    let degree = (block.t_c / width_c).floor() as i64;
                    let mut row = [block.t_c; 7];
                    row[..6].copy_from_slice(&block.values);
                    sorted.entry((index, sweep, degree)).or_default().push(row);
                }
                at += 1;
            }
        }
        bins.extend(sorted.into_iter().map(|((pose, sweep, degree), rows)| {
            let (means, squares) = moments(&rows);
            let mut values = [0.0; 6];
            values.copy_from_slice(&means[..6]);
            Bin {
                pose,
                direction: own[sweep].1.direction,
                degree,
                t_c: means[6],
                range_c: rows
                    .iter()
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], r| {
                        [low.min(r[6]), high.max(r[6])]
                    }),
                values,
                blocks: rows.len() as f64,
                squares,
            }
        }));
        sweeps.extend(own.iter().map(|(_, sweep)| *sweep));
        from = to;
    }
    (sweeps, bins)
}

fn moments(rows: &[[f64; 7]]) -> ([f64; 7], [f64; 6]) {
    let n = rows.len() as f64;
    let means: [f64; 7] = std::array::from_fn(|i| rows.iter().map(|r| r[i]).sum::<f64>() / n);
    let squares = std::array::from_fn(|i| rows.iter().map(|r| (r[i] - means[i]).powi(2)).sum());
    (means, squares)
}

/// Ranges of `history` between its turning points. A turning point requires a change back by
/// `turn_c`; a plateau is split at its extreme and belongs to both sweeps.
fn cut(history: &[f64], turn_c: f64) -> Vec<(std::ops::Range<usize>, Sweep)> {
    let (Some(&first), Some(&end)) = (history.first(), history.last()) else {
        return Vec::new();
    };
    let mut starts: Vec<(usize, SweepDirection)> = Vec::new();
    let (mut low, mut high) = ((0, first), (0, first));
    for (i, &t) in history.iter().enumerate() {
        if t < low.1 {
            low = (i, t);
        }
        if t > high.1 {
            high = (i, t);
        }
        let direction = starts.last().map(|s| s.1);
        let (pivot, turned) = if t - low.1 >= turn_c && direction != Some(SweepDirection::Warming) {
            (low.0, SweepDirection::Warming)
        } else if high.1 - t >= turn_c && direction != Some(SweepDirection::Cooling) {
            (high.0, SweepDirection::Cooling)
        } else {
            continue;
        };
        starts.push((if starts.is_empty() { 0 } else { pivot }, turned));
        (low, high) = ((i, t), (i, t));
    }
    let ends = starts.iter().skip(1).map(|(at, _)| (*at, history[*at]));
    let ends = ends.chain([(history.len(), end)]);
    starts
        .iter()
        .zip(ends)
        .map(|(&(at, direction), (until, to_c))| {
            let from_c = history[at];
            let sweep = Sweep {
                direction,
                from_c,
                to_c,
            };
            (at..until, sweep)
        })
        .collect()
}
