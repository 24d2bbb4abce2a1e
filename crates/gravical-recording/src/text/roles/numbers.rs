//! Columns without names: told by their numbers.

use gravical_core::matrix3::norm;
use gravical_judge::units::POSSIBLE_C;
use gravical_judge::{Role, median, shows_gravity, trend};

use super::behaviour::{Axes, may_be_rate};
use super::clocks::{is_counter, rises};
use crate::text::format::Format;
use crate::text::rows::Rows;

/// The magnitude of an accelerometer in a column of its own differs from the root by its rounding.
const NORM_TOLERANCE: f64 = 0.02;
/// A temperature changes from row to row by less than this share of its range, and a step does not.
const MAX_ROUGHNESS: f64 = 0.2;

/// Accelerometer and gyroscope, behind, between or before clocks, counters, words and constants.
pub(super) fn guess(
    format: &mut Format,
    sample: &Rows,
) -> Option<([usize; 3], Option<[usize; 3]>)> {
    let is_gyroscope = format.options.is_gyroscope;
    let columns = format.columns.len();
    let values = |c: usize| sample.columns[c].as_slice();
    let is_open = |c: usize| values(c).iter().all(|v| v.is_nan());
    let is_text = |c: usize| sample.is_text(c) || format.columns[c].is_dated;
    // The rate of a turn may rise as time does: the last three columns are axes.
    let last = (0..columns).rev().find(|c| !is_open(*c))?;
    let is_axis_of_turn = |c: usize| is_gyroscope && c + 3 > last;
    let is_clock = |c: usize| {
        let is_strict = || values(c).len() > 1 && values(c).windows(2).all(|w| w[1] > w[0]);
        let is_first = || (0..c).all(|before| rises(values(before)) || is_text(before));
        !is_axis_of_turn(c) && (is_strict() || is_first() && rises(values(c)))
    };
    let clocks: Vec<usize> = (0..columns)
        .filter(|c| !is_text(*c) && is_clock(*c))
        .collect();
    let may_be_axis = |c: &usize| !is_text(*c) && !is_open(*c) && !clocks.contains(c);
    let columns: Vec<usize> = (0..columns).filter(may_be_axis).collect();
    // What stands alone is a number of the user, the session, the sensor.
    let runs = columns.chunk_by(|a, b| a + 1 == *b);
    let axes: Vec<usize> = runs
        .filter(|run| run.len() >= 3)
        .flatten()
        .copied()
        .collect();
    for c in &clocks {
        let is_number = is_counter(values(*c));
        format.columns[*c].role = if is_number { Role::Other } else { Role::Time };
    }
    let triple = |k: usize| Some([*axes.get(k)?, *axes.get(k + 1)?, *axes.get(k + 2)?]);
    let sample_of = |axes: [usize; 3]| axes.map(values);
    match axes.len() {
        3 => return Some((triple(0)?, None)),
        // Which of four numbers would be the stamp?
        4 if is_gyroscope => return None,
        4 => {
            let accel = triple(0)?;
            format.columns[axes[3]].role = role_beside(values(axes[3]), sample_of(accel));
            return Some((accel, None));
        }
        6 | 9 => {}
        // In the order of the sensor's registers the temperature is in the middle; otherwise it is
        // last.
        7 => {
            let [middle, last] = [3, 6].map(|k| spread(values(axes[k])));
            let (temperature, gyro) = if middle <= last { (3, 4) } else { (6, 3) };
            format.columns[axes[temperature]].role = Role::Temperature;
            return Some((triple(0)?, triple(gyro)));
        }
        _ => return None,
    }
    let (mut accel, mut other) = (triple(0)?, triple(3)?);
    let shows = |axes| shows_gravity(sample_of(axes));
    let spread = |axes| norm_spread(sample_of(axes)).unwrap_or(f64::MAX);
    let is_second = match (shows(accel), shows(other)) {
        (first, second) if first != second => second,
        _ => spread(other) < spread(accel),
    };
    if is_second {
        std::mem::swap(&mut accel, &mut other);
    }
    let is_rate = |axes: &[usize; 3]| may_be_rate(sample_of(*axes), sample_of(accel));
    let gyro = [Some(other), triple(6)].into_iter().flatten().find(is_rate);
    Some((accel, gyro))
}

/// What a number beside an accelerometer is: its magnitude, the time since the row before, or its
/// temperature.
fn role_beside(values: &[f64], accel: Axes<'_>) -> Role {
    let off = |(row, v): (usize, &f64)| (v / norm(&accel.map(|c| c[row])) - 1.0).abs();
    let off = median(values.iter().enumerate().map(off));
    if off.is_some_and(|off| off < NORM_TOLERANCE) {
        return Role::Other;
    }
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let [low, high] = [
        finite().fold(f64::MAX, f64::min),
        finite().fold(f64::MIN, f64::max),
    ];
    let steps = values.windows(2).map(|w| (w[1] - w[0]).abs());
    let is_smooth = median(steps).is_none_or(|step| step <= MAX_ROUGHNESS * (high - low));
    let (up, down) = trend(values);
    if is_smooth && POSSIBLE_C.contains(&low) && POSSIBLE_C.contains(&high) {
        Role::Temperature
    } else if low > 0.0 && high < 2.0 * low && (up - down).abs() < 0.5 {
        Role::Step
    } else {
        Role::Other
    }
}

/// Largest deviation of a column from its mean, as a share of it.
fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let most = values.iter().fold(0.0_f64, |m, v| m.max((v - mean).abs()));
    if mean.abs() > 1.0 {
        most / mean.abs()
    } else {
        f64::INFINITY
    }
}

/// Median deviation of the magnitude from its median, as a share of it.
fn norm_spread(axes: [&[f64]; 3]) -> Option<f64> {
    let norms = (0..axes[0].len()).map(|row| norm(&axes.map(|c| c[row])));
    let norms: Vec<f64> = norms.collect();
    let middle = median(norms.iter().copied())?;
    Some(median(norms.iter().map(|x| (x - middle).abs()))? / middle)
}
