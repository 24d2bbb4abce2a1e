//! The motions between stills, gathered for the inner loop.

use std::ops::Range;

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use nalgebra::Vector3;

use super::integrate::Sample;
use super::rest::{Rest, Rested};
use crate::recording::range_end::range_end;
use crate::recording::units::GyroScale;
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
                format!("{with_gap} of the motions between static intervals have a break, or miss readings of the gyroscope for more than {GAP_PERIODS} periods; left out of its fit"),
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
                    "in {with_clip} of the motions between static intervals the gyroscope reaches the end of its range ({} rows): turned too fast; left out of its fit",
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
        before = row;
    }
    seconds(before, last).abs() < GAP_PERIODS * period_s
}
