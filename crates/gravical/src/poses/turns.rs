//! Motions between rests, and full turns about one axis among them.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use gravical_core::matrix3::norm;
use nalgebra::{UnitQuaternion, Vector3};

use crate::recording::Recording;
use crate::recording::units::GyroScale;

use super::face::angle_deg;
use super::sum_of_rows;
use crate::stats::moments;

/// The move from one rest to the next.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Rows between the rests.
    pub rows: Range<usize>,
    /// The same with the slow beginning and end that the rests around it may hide.
    pub integrated: Range<usize>,
    /// Mean of the accelerometer in the rest before and in the one after.
    pub gravity: [[f64; 3]; 2],
    /// Angle that each row of `integrated` turns by, less the bias that both rests show, unit of the
    /// file · s.
    pub steps: Vec<[f64; 3]>,
}

/// A full turn about one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Turn {
    /// Its label, or `turn about x`.
    pub label: String,
    /// 0, 1, 2.
    pub axis: usize,
    /// Index of the recording.
    pub recording: usize,
    /// Its rows.
    pub rows: Range<usize>,
    /// Rows that the angular rate is integrated over: those, and what the rests around
    /// them may hide of it.
    pub integrated: Range<usize>,
}

/// Rows without a reading of the gyroscope that its neighbours stand in for, at most:
/// as many as may be lost.
const BRIDGED: usize = 3;

/// Time that a sample stands for, s: half the way to its neighbours by the
/// stamps, else by the rate; none when neither is known. Neighbours are rows in which
/// the gyroscope was read.
#[must_use]
pub fn sample_period_s(recording: &Recording, row: usize) -> Option<f64> {
    let is_read = |r: &usize| recording.gyro.iter().flatten().all(|c| c[*r].is_finite());
    let end = (row + 2 + BRIDGED).min(recording.rows());
    let before = (row.saturating_sub(1 + BRIDGED)..row).rfind(is_read);
    let after = (row + 1..end).find(is_read);
    let sides = f64::from(u8::from(before.is_some()) + u8::from(after.is_some()));
    let (before, after) = (before.unwrap_or(row), after.unwrap_or(row));
    let rate = recording.timing.rate_hz();
    if after == before {
        return rate.map(f64::recip);
    }
    let Some(t) = &recording.time_s else {
        return rate.map(|rate| (after - before) as f64 / sides / rate);
    };
    let period = (t[after] - t[before]) / sides;
    // Across a gap, a repeat or a step back the usual period stands.
    match rate {
        Some(rate) if !(period > 0.0 && period * rate < 4.0) => Some(1.0 / rate),
        _ => (period > 0.0).then_some(period),
    }
}

/// How far a motion may reach into the rests around it, s: it begins and ends so slowly
/// that this is taken for rest.
const SLOW_END_S: f64 = 0.5;

/// The rows from the end of one rest to the start of the next, and as much of both as
/// may hide the slow beginning and end of the motion between them: less the bias, what
/// is rest adds but noise.
pub(crate) fn with_slow_ends(
    recording: &Recording,
    before: &Range<usize>,
    after: &Range<usize>,
) -> Range<usize> {
    let most = (SLOW_END_S * recording.working_rate_hz().0) as usize;
    // The greater part of a static interval is rest.
    let hidden = |rest: &Range<usize>| most.min(rest.len() / 3);
    before.end - hidden(before)..after.start + hidden(after)
}

/// The moves between neighbouring rests of one stretch.
#[must_use]
pub fn motions(recording: &Recording, rests: &[Range<usize>]) -> Vec<Motion> {
    let Some(gyro) = &recording.gyro else {
        return Vec::new();
    };
    let mut out = Vec::new();
    for pair in rests.windows(2) {
        let rows = pair[0].end..pair[1].start;
        // Of the rests rows may be left out, of the move none.
        let broken = recording.is_broken(&(pair[0].start..pair[1].end));
        if broken || rows.is_empty() {
            continue;
        }
        let means = |sensor| [0, 1].map(|i: usize| moments(sensor, pair[i].clone()).0);
        let [before, after] = means(gyro);
        let bias = std::array::from_fn(|i| 0.5 * (before[i] + after[i]));
        let integrated = with_slow_ends(recording, &pair[0], &pair[1]);
        let Some(steps) = steps(recording, integrated.clone(), bias) else {
            return Vec::new();
        };
        out.push(Motion {
            rows,
            integrated,
            gravity: means(&recording.accel),
            steps,
        });
    }
    out
}

/// Angle that each of some rows turns by, less the bias, unit of the file · s;
/// none without a gyroscope or a rate.
fn steps(recording: &Recording, rows: Range<usize>, bias: [f64; 3]) -> Option<Vec<[f64; 3]>> {
    let gyro = recording.gyro.as_ref()?;
    let mut steps = Vec::with_capacity(rows.len());
    for row in rows {
        let period = sample_period_s(recording, row)?;
        steps.push(std::array::from_fn(|i| {
            let step = (gyro[i][row] - bias[i]) * period;
            if step.is_finite() { step } else { 0.0 }
        }));
    }
    Some(steps)
}

fn sum(steps: &[[f64; 3]]) -> [f64; 3] {
    std::array::from_fn(|i| steps.iter().map(|step| step[i]).sum())
}

/// Angle between gravity turned by the steps of a motion and gravity as it was
/// found in the rest after, for files of `nominal` units per rad/s. 180 where a
/// row turns by more than half a turn, as no recording can tell.
pub(super) fn residual_deg(motion: &Motion, nominal: f64) -> f64 {
    let is_too_fast = |step: &[f64; 3]| norm(step) > PI * nominal;
    if motion.steps.iter().any(is_too_fast) {
        return 180.0;
    }
    let turned = motion.steps.iter().fold(motion.gravity[0], |v, step| {
        rotate_back(v, step.map(|s| s / nominal))
    });
    angle_deg(turned, motion.gravity[1])
}

/// A direction fixed in space, seen from a sensor that turns by `step` (rad): it turns the
/// other way.
fn rotate_back(v: [f64; 3], step: [f64; 3]) -> [f64; 3] {
    let turn = UnitQuaternion::from_scaled_axis(-Vector3::from(step));
    (turn * Vector3::from(v)).into()
}

/// Integral of the angular rate over `rows`, less the bias that the rests show,
/// unit of the file · s; none without a gyroscope or a rate.
pub(super) fn plain_integral(
    recording: &Recording,
    rows: &Range<usize>,
    rests: &[Range<usize>],
) -> Option<[f64; 3]> {
    let at_rest = rests.iter().flat_map(Clone::clone);
    let rest = sum_of_rows(recording.gyro.as_ref()?, at_rest);
    let bias = rest.map_or([0.0; 3], |(sum, count)| sum.map(|s| s / count as f64));
    Some(sum(&steps(recording, rows.clone(), bias)?))
}

/// Turns by `angle_rad` between the rests of a recording, which has this number in the session: one axis
/// carries the turn, its angle in the unit of the gyroscope is within a sixth of the one wanted, and after a
/// full turn gravity is back within 10°.
#[must_use]
pub fn full_turns(
    (index, recording): (usize, &Recording),
    rests: &[Range<usize>],
    scale: Option<GyroScale>,
    angle_rad: f64,
) -> Vec<Turn> {
    let Some(nominal) = scale.and_then(|s| s.nominal()) else {
        return Vec::new();
    };
    let whole_turns = (angle_rad / TAU).fract().abs() < 1e-9;
    let turn = |motion: Motion| {
        let back = !whole_turns || angle_deg(motion.gravity[0], motion.gravity[1]) < 10.0;
        let angles = sum(&motion.steps).map(|v| v / nominal);
        let axis = (0..3).max_by(|&i, &j| angles[i].abs().total_cmp(&angles[j].abs()))?;
        let carries = angles[axis].abs() > 0.9 * norm(&angles);
        let full = (angles[axis].abs() / angle_rad.abs() - 1.0).abs() < 1.0 / 6.0;
        (back && carries && full).then(|| Turn {
            label: format!("turn about {}", super::face::AXES[axis]),
            axis,
            recording: index,
            rows: motion.rows,
            integrated: motion.integrated,
        })
    };
    motions(recording, rests)
        .into_iter()
        .filter_map(turn)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{ReadOptions, read_bytes};

    #[test]
    fn rows_without_a_reading_take_nothing_off_a_turn() {
        let turn = |stamps: bool, empty: &[usize]| {
            let rows: String = (0..300)
                .map(|i| {
                    let rate = match (empty.contains(&i), i) {
                        (true, _) => "",
                        (_, 100..200) => "30",
                        _ => "0",
                    };
                    let stamp = if stamps {
                        (10 * i).to_string()
                    } else {
                        String::new()
                    };
                    format!("{stamp},0,0,9.81,{rate},0,0\n")
                })
                .collect();
            let text = format!("t_ms,ax,ay,az,gx,gy,gz\n{rows}");
            let options = ReadOptions {
                rate_hz: (!stamps).then_some(100.0),
                ..ReadOptions::default()
            };
            let recording = read_bytes(text.as_bytes(), "turn.csv", &options).unwrap();
            plain_integral(&recording, &(90..210), &[0..80, 220..300]).unwrap()[0]
        };
        for stamps in [true, false] {
            let whole = turn(stamps, &[]);
            let holed = turn(stamps, &[110, 140, 141, 142, 170]);
            assert!((whole - 30.0).abs() < 1e-9, "{whole}");
            assert!((holed - whole).abs() < 1e-9, "{stamps}: {holed}");
        }
    }
}
