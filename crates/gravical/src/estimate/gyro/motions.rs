//! The motions between stills, gathered for the inner loop.

use std::ops::Range;

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use nalgebra::Vector3;

use super::integrate::Sample;
use super::rest::{Rest, Rested};
use crate::recording::units::{GyroScale, GyroUnit};
use crate::recording::{Finding, FindingKind, LineSpans, Recording};
use crate::segment::turns::with_slow_ends;

/// One motion: directions of gravity before and after, and where its samples
/// are.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    /// Index of its recording.
    pub recording: usize,
    /// Index of the still before it, of all stills; the next one is after it.
    pub still: usize,
    /// Rows of the recording, both ends included in the integration.
    pub rows: Range<usize>,
    /// Its range of [`Motions::samples`].
    pub samples: Range<usize>,
    /// Unit vectors of gravity in both stills.
    pub gravity: [[f64; 3]; 2],
    pub seconds: f64,
}

/// All motions that can be used.
#[derive(Debug, Clone, Default)]
pub(super) struct Motions {
    pub list: Vec<Motion>,
    /// Rates less bias and reaction to gravity, units of the file, and steps.
    pub samples: Vec<Sample>,
    /// The row of each sample.
    pub rows: Vec<usize>,
    /// Motions left out: gaps, clipped samples.
    pub left_out: usize,
    pub findings: Vec<Finding>,
}

/// A step longer than this many periods is a gap: what happened in it is not
/// known. Over a shorter one the rate is a straight line, whether rows are lost or
/// their cells empty.
const GAP_PERIODS: f64 = 4.5;

/// What motions are gathered from: the stills of one recording, in order.
pub(super) struct Source<'a> {
    pub recording: &'a Recording,
    /// Its gyroscope.
    pub gyro: &'a [Vec<f64>; 3],
    pub scale: Option<GyroScale>,
    pub stills: &'a [Rested<'a>],
    /// Index of the recording, and of the first of its stills among all.
    pub index: usize,
    pub first: usize,
    pub accelerometer: &'a Calibration<f64>,
    /// What all stills say.
    pub rest: &'a Rest,
    pub period_s: f64,
}

/// Gathers those of one recording.
pub(super) fn gather(source: &Source<'_>, motions: &mut Motions) {
    let Source {
        recording,
        gyro,
        scale,
        stills,
        ..
    } = *source;
    let ends: [Option<[f64; 2]>; 3] = std::array::from_fn(|i| range_end(&gyro[i], scale));
    let is_read = |row: &usize| {
        let time = recording.time_s.iter();
        time.chain(gyro).all(|c| c[*row].is_finite())
    };
    let (mut gaps, mut clips) = (LineSpans::default(), LineSpans::default());
    let (mut with_gap, mut with_clip) = (0, 0);
    for (pair, still) in stills.windows(2).zip(source.first..) {
        // From a reading at rest to one at rest.
        let [before, after] = [&pair[0], &pair[1]].map(|r| &r.still.rows);
        let Range { start, end } = with_slow_ends(recording, before, after);
        let (mut early, mut late) = (before.start..start, end..after.end);
        let (Some(from), Some(to)) = (early.rfind(is_read), late.find(is_read)) else {
            continue;
        };
        let rows = from..to + 1;
        if rows.len() < 3 {
            continue;
        }
        if recording.is_cut(&rows) && !recording.is_broken(&rows) {
            // Said when it was read.
            motions.left_out += 1;
            continue;
        }
        let lines = (recording.line(rows.start), recording.line(rows.end - 1));
        let mut clipped = 0_u64;
        let from = motions.samples.len();
        let whole = push(source, rows.clone(), still, motions);
        for row in rows.clone() {
            clipped += u64::from((0..3).any(|i| {
                ends[i].is_some_and(|[low, high]| gyro[i][row] <= low || gyro[i][row] >= high)
            }));
        }
        if !whole || clipped > 0 {
            motions.samples.truncate(from);
            motions.rows.truncate(from);
            if whole {
                with_clip += 1;
                clips.push_range(lines.0, lines.1, clipped);
            } else {
                with_gap += 1;
                gaps.push_range(lines.0, lines.1, lines.1 - lines.0 + 1);
            }
            continue;
        }
        let samples = from..motions.samples.len();
        let seconds = motions.samples[samples.clone()].iter().map(|s| s[3]).sum();
        motions.list.push(Motion {
            recording: source.index,
            still,
            rows,
            samples,
            gravity: [&pair[0], &pair[1]].map(|r| Vector3::from(r.accel).normalize().into()),
            seconds,
        });
    }
    motions.left_out += with_gap + with_clip;
    if with_gap > 0 {
        motions.findings.push(
            Finding::new(
                FindingKind::GyroMotionGap,
                format!("{with_gap} of the motions between stills have a break, or miss readings of the gyroscope for more than {GAP_PERIODS} periods; left out of its fit"),
            )
            .at_lines(&gaps)
            .in_file(&recording.name),
        );
    }
    if with_clip > 0 {
        motions.findings.push(
            Finding::new(
                FindingKind::GyroMotionClipped,
                format!(
                    "in {with_clip} of the motions between stills the gyroscope reaches the end of its range ({} rows): turned too fast; left out of its fit",
                    clips.count()
                ),
            )
            .at_lines(&clips)
            .in_file(&recording.name),
        );
    }
}

/// Adds the samples of one motion, `still` the one before it; false when too much is
/// missing in it.
fn push(source: &Source<'_>, rows: Range<usize>, still: usize, motions: &mut Motions) -> bool {
    let Source {
        recording,
        gyro,
        accelerometer,
        rest,
        period_s,
        ..
    } = *source;
    if recording.is_broken(&rows) {
        return false;
    }
    // The drift of the bias is what both stills show of it.
    let bias: [f64; 3] = std::array::from_fn(|i| {
        rest.bias[i] + 0.5 * (rest.local[still][i] + rest.local[still + 1][i])
    });
    let reacts = rest.g_sensitivity != [[0.0; 3]; 3];
    let seconds = |from: usize, to: usize| match &recording.time_s {
        Some(t) => t[to] - t[from],
        None => (to - from) as f64 * period_s,
    };
    let (first, last) = (motions.samples.len(), rows.end - 1);
    let mut before = rows.start;
    for row in rows {
        let mut rate: [f64; 3] = std::array::from_fn(|i| gyro[i][row] - bias[i]);
        if reacts {
            let felt = matrix3::mul_vec(
                &rest.g_sensitivity,
                &accelerometer.apply(recording.accel_at(row)),
            );
            rate = matrix3::sub(&rate, &felt);
        }
        let step = seconds(before, row);
        if !(step.is_finite() && rate.iter().all(|v| v.is_finite())) {
            continue;
        }
        if step.abs() >= GAP_PERIODS * period_s {
            return false;
        }
        if let Some(sample) = motions.samples[first..].last_mut() {
            sample[3] = step;
        }
        motions.samples.push([rate[0], rate[1], rate[2], 0.0]);
        motions.rows.push(row);
        before = row;
    }
    seconds(before, last).abs() < GAP_PERIODS * period_s
}

/// Full scales in use, °/s.
const FULL_SCALES_DEG_S: [f64; 7] = [125.0, 245.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0];

/// Values of a channel at and beyond which it is clipped; none when it never
/// is. The end of the range is known where the unit is; everywhere it shows as
/// three or more readings in a row at the channel's own extreme that the signal comes
/// to, or leaves, in a step far above its last digit: the top of a smooth
/// motion is reached in small ones.
fn range_end(channel: &[f64], scale: Option<GyroScale>) -> Option<[f64; 2]> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut digit = f64::INFINITY;
    let mut before = f64::NAN;
    for &v in channel {
        low = low.min(v);
        high = high.max(v);
        let change = (v - before).abs();
        if change > 0.0 {
            digit = digit.min(change);
        }
        before = v;
    }
    if !digit.is_finite() {
        return None;
    }
    let signed = low < 16384.0;
    let repeats = |extreme: f64| channel.iter().filter(|v| **v == extreme).take(3).count() == 3;
    let at_end = |extreme: f64| {
        known_end(extreme, signed, scale) && (is_counts(scale) || repeats(extreme))
            || flat_top(channel, extreme, digit)
    };
    let (bottom, top) = (at_end(low), at_end(high));
    (bottom || top).then_some([
        if bottom { low } else { f64::NEG_INFINITY },
        if top { high } else { f64::INFINITY },
    ])
}

fn is_counts(scale: Option<GyroScale>) -> bool {
    scale.is_some_and(|s| s.unit == GyroUnit::Counts)
}

fn known_end(extreme: f64, signed: bool, scale: Option<GyroScale>) -> bool {
    let Some(scale) = scale else { return false };
    if scale.unit == GyroUnit::Counts {
        // 16-bit values, signed, or unsigned around 32768.
        return if signed {
            (32767.0..=32768.0).contains(&extreme.abs())
        } else {
            extreme == 65535.0
        };
    }
    scale.nominal().is_some_and(|nominal| {
        let rate_deg_s = (extreme / nominal).to_degrees().abs();
        FULL_SCALES_DEG_S
            .iter()
            .any(|full| rate_deg_s <= full * 1.0005 && rate_deg_s >= full * (1.0 - 2.5 / 32768.0))
    })
}

fn flat_top(channel: &[f64], extreme: f64, digit: f64) -> bool {
    if !channel.windows(3).any(|w| w == [extreme; 3]) {
        return false;
    }
    // Lengths of the runs that begin or end with such a step.
    let mut lengths = Vec::new();
    let (mut from, mut longest) = (0, 0);
    for run in channel.chunk_by(|a, b| a == b) {
        let to = from + run.len();
        let beside = [from.checked_sub(1), Some(to)].map(|i| channel.get(i?));
        let mut steps = beside.into_iter().flatten().map(|v| (v - run[0]).abs());
        if steps.any(|step| step > 5.0 * digit) {
            lengths.push(run.len());
            if run[0] == extreme {
                longest = longest.max(run.len());
            }
        }
        from = to;
    }
    // Where values are held, or read faster than they are measured, each of them
    // stands in several rows.
    let quarter = lengths.len() / 4;
    longest > 0 && longest >= 3 * *lengths.select_nth_unstable(quarter).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::units::Origin;

    #[test]
    fn a_flat_top_is_clipped_and_a_round_one_is_not() {
        let wave = |limit: f64, digit: f64| -> Vec<f64> {
            (0..400)
                .map(|i| {
                    let v = 300.0 * (f64::from(i) * 0.05).sin();
                    (v / digit).round() * digit
                })
                .map(|v| v.clamp(-limit, limit))
                .collect()
        };
        assert_eq!(range_end(&wave(1e9, 0.01), None), None);
        assert_eq!(range_end(&wave(1e9, 5.0), None), None);
        let clipped = range_end(&wave(250.0, 0.01), None).unwrap();
        assert_eq!(clipped, [-250.0, 250.0]);
        assert_eq!(range_end(&[1.0; 50], None), None);
        // Every value is held over four rows.
        let held = |wave: Vec<f64>| wave.into_iter().flat_map(|v| [v; 4]).collect::<Vec<_>>();
        assert_eq!(range_end(&held(wave(1e9, 0.01)), None), None);
        assert_eq!(range_end(&held(wave(250.0, 0.01)), None), Some(clipped));
    }

    #[test]
    fn the_end_of_the_range_is_known_with_the_unit() {
        let scale = |unit, lsb| {
            Some(GyroScale {
                unit,
                lsb_per_deg_s: lsb,
                origin: Origin::Data,
            })
        };
        let counts = scale(GyroUnit::Counts, Some(131.0));
        assert!(known_end(32767.0, true, counts) && known_end(-32768.0, true, counts));
        // The rest of an unsigned channel is there, not its end.
        assert!(!known_end(32767.0, false, counts) && !known_end(40000.0, false, counts));
        let rad = scale(GyroUnit::RadianPerSecond, None);
        assert!(known_end(250_f64.to_radians(), true, rad) && !known_end(4.2, true, rad));
    }
}
