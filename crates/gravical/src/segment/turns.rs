//! Motions between stills: full turns about one axis, and what the change of
//! gravity's direction says about the unit of the gyroscope.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::recording::units::{GyroScale, GyroUnit, LSB_PER_DEG_S, Origin};
use crate::recording::{Finding, Recording};

use super::face::angle_deg;
use super::still::moments;

/// The move from one still to the next.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Rows between the stills.
    pub rows: Range<usize>,
    /// Mean of the accelerometer in the still before and in the one after.
    pub gravity: [[f64; 3]; 2],
    /// Mean of the gyroscope in both stills: its bias.
    pub bias: [f64; 3],
    /// Integral of the angular rate less the bias, unit of the file · s.
    pub integral: [f64; 3],
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
}

/// Time that a sample stands for, s: half the way to its neighbours by the
/// stamps, else one over the rate; none when neither is known.
#[must_use]
pub fn sample_period_s(recording: &Recording, row: usize) -> Option<f64> {
    if let Some(t) = &recording.time_s {
        let last = t.len() - 1;
        let (before, after) = (row.saturating_sub(1), (row + 1).min(last));
        if after > before {
            let period = (t[after] - t[before]) / (after - before) as f64;
            // Across a gap, a repeat or a step back the usual period stands.
            if let Some(rate) = recording.timing.rate_hz()
                && !(period > 0.0 && period * rate < 4.0)
            {
                return Some(1.0 / rate);
            }
            return (period > 0.0).then_some(period);
        }
    }
    recording.timing.rate_hz().map(|rate| 1.0 / rate)
}

/// The moves between neighbouring stills of one stretch.
#[must_use]
pub fn motions(recording: &Recording, stills: &[Range<usize>]) -> Vec<Motion> {
    let Some(gyro) = &recording.gyro else {
        return Vec::new();
    };
    let mut out = Vec::new();
    for pair in stills.windows(2) {
        let rows = pair[0].end..pair[1].start;
        let broken = recording
            .breaks
            .iter()
            .any(|b| *b > pair[0].start && *b < pair[1].end);
        if broken || rows.is_empty() {
            continue;
        }
        let (before, after) = (
            moments(gyro, pair[0].clone()).0,
            moments(gyro, pair[1].clone()).0,
        );
        let bias: [f64; 3] = std::array::from_fn(|i| 0.5 * (before[i] + after[i]));
        let mut integral = [0.0; 3];
        for row in rows.clone() {
            let Some(period) = sample_period_s(recording, row) else {
                return Vec::new();
            };
            for axis in 0..3 {
                let rate = gyro[axis][row] - bias[axis];
                if rate.is_finite() {
                    integral[axis] += rate * period;
                }
            }
        }
        out.push(Motion {
            rows,
            gravity: [
                moments(&recording.accel, pair[0].clone()).0,
                moments(&recording.accel, pair[1].clone()).0,
            ],
            bias,
            integral,
        });
    }
    out
}

/// Units that a gyroscope can be in: name, counts per °/s, and file units per
/// rad/s.
fn hypotheses() -> Vec<GyroScale> {
    let scale = |unit, lsb_per_deg_s| GyroScale {
        unit,
        lsb_per_deg_s,
        origin: Origin::Data,
    };
    let mut all = vec![
        scale(GyroUnit::RadianPerSecond, None),
        scale(GyroUnit::DegreePerSecond, None),
    ];
    all.extend(LSB_PER_DEG_S.map(|lsb| scale(GyroUnit::Counts, Some(lsb))));
    all
}

/// Angle between gravity turned by the integrated rate and gravity as it was
/// found in the still after, for files units per rad/s of `nominal`.
fn residual_deg(recording: &Recording, motion: &Motion, nominal: f64) -> f64 {
    let Some(gyro) = &recording.gyro else {
        return f64::NAN;
    };
    let mut v = motion.gravity[0];
    for row in motion.rows.clone() {
        let Some(period) = sample_period_s(recording, row) else {
            return f64::NAN;
        };
        let step: [f64; 3] = std::array::from_fn(|i| {
            let rate = (gyro[i][row] - motion.bias[i]) / nominal * period;
            if rate.is_finite() { rate } else { 0.0 }
        });
        v = rotate_back(v, step);
    }
    angle_deg(v, motion.gravity[1])
}

/// A direction fixed in space, seen from a sensor that turns by `step` (rad):
/// it turns the other way (Rodrigues' formula).
fn rotate_back(v: [f64; 3], step: [f64; 3]) -> [f64; 3] {
    let angle = step.iter().map(|s| s * s).sum::<f64>().sqrt();
    if angle < 1e-15 {
        return v;
    }
    let k: [f64; 3] = step.map(|s| -s / angle);
    let cross = [
        k[1] * v[2] - k[2] * v[1],
        k[2] * v[0] - k[0] * v[2],
        k[0] * v[1] - k[1] * v[0],
    ];
    let along: f64 = k.iter().zip(v).map(|(a, b)| a * b).sum();
    let (sine, cosine) = angle.sin_cos();
    std::array::from_fn(|i| v[i] * cosine + cross[i] * sine + k[i] * along * (1.0 - cosine))
}

/// Scales within this factor of each other (InvenSense's and ST's) are told apart by all
/// turns together: a single one of less than half a turn does not part them by 5°.
const ALIKE: f64 = 1.3;

/// Turns of gravity under this angle decide nothing.
const LEAST_TURN_DEG: f64 = 10.0;

/// Decides the unit of the gyroscope by letting every turn of gravity vote:
/// the best hypothesis counts when its residual is under max(3°, 0.15·Δ) and
/// the next one is over three times that and over 5°. Three votes decide
/// against a header, one where there is none; and the hypothesis has to fit
/// more than half of all turns. What was decided, or that nothing
/// could be, goes to `findings`.
#[must_use]
pub fn decide_gyro_unit(
    recording: &Recording,
    motions: &[Motion],
    findings: &mut Vec<Finding>,
) -> Option<GyroScale> {
    let claimed = recording.gyro_scale?;
    if claimed.origin == Origin::Given && claimed.nominal().is_some() {
        return Some(claimed);
    }
    let all = hypotheses();
    let mut votes = vec![0_usize; all.len()];
    // Sum of the squared residuals of the turns that voted.
    let mut misfit = vec![0.0; all.len()];
    let alike = |i: usize, o: usize| {
        let ratio = all[i].nominal().zip(all[o].nominal()).map(|(a, b)| a / b);
        ratio.is_some_and(|r| (1.0 / ALIKE..=ALIKE).contains(&r))
    };
    let mut fits = vec![0_usize; all.len()];
    let mut turns = 0;
    for motion in motions {
        let delta = angle_deg(motion.gravity[0], motion.gravity[1]);
        if delta < LEAST_TURN_DEG {
            continue;
        }
        turns += 1;
        let mut residuals: Vec<(usize, f64)> = all
            .iter()
            .enumerate()
            .filter(|(_, h)| claimed.origin != Origin::Given || h.unit == claimed.unit)
            .filter_map(|(i, h)| Some((i, residual_deg(recording, motion, h.nominal()?))))
            .filter(|(_, r)| r.is_finite())
            .collect();
        for &(i, residual) in &residuals {
            fits[i] += usize::from(residual < (0.15 * delta).max(3.0));
        }
        residuals.sort_by(|a, b| a.1.total_cmp(&b.1));
        let next = |best: usize| residuals.iter().find(|(i, _)| !alike(*i, best));
        if let Some(&best) = residuals.first()
            && best.1 < (0.15 * delta).max(3.0)
            && next(best.0).is_some_and(|next| next.1 > 3.0 * best.1 && next.1 > 5.0)
        {
            votes[best.0] += 1;
            for &(i, residual) in &residuals {
                misfit[i] += residual * residual;
            }
        }
    }
    let cast: usize = votes.iter().sum();
    // Of scales that are alike the one that fits all turns best.
    let votes: Vec<usize> = (0..all.len())
        .map(|i| {
            (0..all.len())
                .filter(|o| alike(i, *o))
                .map(|o| votes[o])
                .sum()
        })
        .collect();
    let most = votes.iter().copied().max()?;
    let best = (0..all.len())
        .filter(|&i| votes[i] == most)
        .min_by(|&i, &o| misfit[i].total_cmp(&misfit[o]))?;
    let same = |h: &GyroScale| {
        h.unit == claimed.unit
            && (claimed.lsb_per_deg_s.is_none() || h.lsb_per_deg_s == claimed.lsb_per_deg_s)
    };
    // A scale that is none of these fits a motion now and then, five times
    // round being as good as once; the right one fits most of them.
    let clear = votes[best] * 4 > cast * 3 && fits[best] * 2 > turns;
    let file = &recording.name;
    let needed = if claimed.origin == Origin::Header {
        3
    } else {
        1
    };
    if clear && (votes[best] >= needed || (cast > 0 && same(&all[best]))) {
        let found = all[best];
        if claimed.unit != found.unit && claimed.origin == Origin::Header {
            findings.push(
                Finding::warning(
                    "unit-mismatch",
                    format!(
                        "the header says {} for the gyroscope, but {} turns of gravity agree with {}; taken so",
                        claimed.unit.name(),
                        votes[best],
                        found.unit.name()
                    ),
                )
                .in_file(file),
            );
        }
        return Some(found);
    }
    findings.push(
        Finding::note(
            "gyro-unit-unverified",
            match claimed.unit {
                GyroUnit::Unknown => {
                    "nothing tells the unit of the gyroscope: no header, and no turn between stills; --gyro-unit says it".to_owned()
                }
                GyroUnit::Counts if claimed.nominal().is_none() => {
                    let sheet = if turns > 0 {
                        " (131, 65.5, 32.8 and 16.4 per °/s, as an MPU6050 has, and those of ST's sensors do not fit the turns)"
                    } else {
                        ""
                    };
                    format!("the gyroscope is in counts of a scale that nothing tells{sheet}; --gyro-range says it, and turns between stills show it")
                }
                unit => format!(
                    "the gyroscope is taken as {}{}; no turn between stills verifies it{}",
                    unit.name(),
                    if claimed.origin == Origin::Header { " as the header says" } else { "" },
                    // One wrong unit in a header makes the other doubtful.
                    if claimed.origin == Origin::Header
                        && recording.findings.iter().any(|f| f.kind == "unit-mismatch")
                    {
                        ", and the same header is wrong about the accelerometer"
                    } else {
                        ""
                    }
                ),
            },
        )
        .in_file(file),
    );
    Some(claimed)
}

/// The unit in which a turn by a known angle comes out right within 25 %.
#[must_use]
pub fn unit_by_known_turn(integral: [f64; 3], angle_rad: f64) -> Option<GyroScale> {
    let size = integral.iter().map(|v| v * v).sum::<f64>().sqrt() / angle_rad.abs();
    let off = |h: &GyroScale| {
        h.nominal()
            .map_or(f64::INFINITY, |n| (size / n - 1.0).abs())
    };
    hypotheses()
        .into_iter()
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .filter(|h| off(h) < 0.25)
}

/// Turns by `angle_rad` among the moves: one axis carries the turn, its angle in
/// the unit of the gyroscope is within a sixth of the one wanted, and after a
/// full turn gravity is back within 10°.
#[must_use]
pub fn full_turns(
    recording_index: usize,
    motions: &[Motion],
    scale: Option<GyroScale>,
    angle_rad: f64,
) -> Vec<Turn> {
    let Some(nominal) = scale.and_then(|s| s.nominal()) else {
        return Vec::new();
    };
    motions
        .iter()
        .filter_map(|motion| {
            let whole_turns = (angle_rad / TAU).fract().abs() < 1e-9;
            let back = !whole_turns || angle_deg(motion.gravity[0], motion.gravity[1]) < 10.0;
            let angles = motion.integral.map(|v| v / nominal);
            let axis = (0..3).max_by(|&i, &j| angles[i].abs().total_cmp(&angles[j].abs()))?;
            let whole = angles.iter().map(|a| a * a).sum::<f64>().sqrt();
            let carries = angles[axis].abs() > 0.9 * whole;
            let full = (angles[axis].abs() / angle_rad.abs() - 1.0).abs() < 1.0 / 6.0;
            (back && carries && full).then(|| Turn {
                label: format!("turn about {}", super::face::AXES[axis]),
                axis,
                recording: recording_index,
                rows: motion.rows.clone(),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_turns_against_the_sensor() {
        // Turning by +90° about x lifts the y axis: what pointed along z now
        // points along y.
        let mut v = [0.0, 0.0, 1.0];
        for _ in 0..90 {
            v = rotate_back(v, [1_f64.to_radians(), 0.0, 0.0]);
        }
        assert!(angle_deg(v, [0.0, 1.0, 0.0]) < 1e-6, "{v:?}");
    }

    #[test]
    fn a_known_turn_tells_the_unit() {
        let unit = |size: f64| {
            unit_by_known_turn([0.1, size, 0.0], TAU).map(|s| (s.unit, s.lsb_per_deg_s))
        };
        assert_eq!(unit(-6.1), Some((GyroUnit::RadianPerSecond, None)));
        assert_eq!(unit(371.0), Some((GyroUnit::DegreePerSecond, None)));
        assert_eq!(unit(360.0 * 16.7), Some((GyroUnit::Counts, Some(16.4))));
        assert_eq!(unit(40.0), None);
    }
}
