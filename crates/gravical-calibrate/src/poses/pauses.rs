//! Pauses of a continuous recording that are not rests, but were probably meant as poses.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_signal::{
    BLOCK_S, Block, MAX_EXCESS, MAX_VARIANCE, Samples, TREMOR, blocks, quantile,
};

use super::face::angle_deg;
use super::nominal::NominalSamples;
use super::rests::{APART_DEG, MANY_POSES, MIN_REST_S, directions, min_samples_without_rate};
use super::stills::{HELD_DEG, MIN_WINDOW_LEN, READINGS_S, middle, still_spans};
use crate::finding::finding;
use crate::numfmt::count;
use crate::recording::{Finding, Recording};
use crate::stats::moments;

/// A shorter pause is one of a hand on its way, s; without a rate ten readings …
const MIN_PAUSE_S: f64 = 0.3;
/// … in which windows of this duration lie wherever it begins, s.
const SHORT_S: f64 = 0.25;
/// On a table the variance is less than that of a calm hand by this factor.
const CALM: f64 = 4.0;
/// Poses and pauses are at least one part in so many of a session: of a motion recording they are less.
const MAX_MOTION: usize = 3;
/// Scale and bias change the magnitude by less than this share; more is acceleration.
const MAX_MAGNITUDE_ERROR: f64 = 0.1;

/// Pauses that point elsewhere than the `poses` of a continuous recording: too short for a pose, or held by a hand
/// that trembles.
pub(super) fn unused_pauses(
    recording: &Recording,
    nominal: &NominalSamples,
    poses: &[Range<usize>],
) -> Option<Finding> {
    // Nobody places a sensor that is worn.
    if poses.is_empty() || poses.len() >= MANY_POSES {
        return None;
    }
    let samples = &nominal.samples;
    let at = |rows: &Range<usize>| moments(&recording.accel, rows.clone());
    let means: Vec<[f64; 3]> = poses.iter().map(|rows| at(rows).0).collect();
    let usual = quantile(means.iter().map(norm).collect(), 0.5);
    let poses: Vec<Range<usize>> = poses.iter().map(|rows| nominal.in_samples(rows)).collect();
    let min_rest = min_rest_len(recording, samples, &poses);
    let min_unsteady = min_rest + min_rest / 2;
    let is_meant = |span: &Range<usize>| {
        let (mean, variance) = at(&nominal.in_rows(&middle(span)));
        means.iter().all(|pose| angle_deg(*pose, mean) > APART_DEG)
            && (norm(&mean) / usual - 1.0).abs() < MAX_MAGNITUDE_ERROR
            // A motion that passes for spikes is held in the samples.
            && variance < MAX_VARIANCE[0] * (usual / STANDARD_GRAVITY_MPS2).powi(2)
    };
    let find = |window, max_variance| {
        let mut spans = still_spans(samples, &poses, window, max_variance, HELD_DEG);
        // A recording begins and ends in a hand.
        spans.retain(|span| span.start >= window && span.end + window <= samples.len());
        spans.retain(is_meant);
        let mut slow = nominal.without_turns([&poses[..], &spans].concat());
        slow.retain(|span| spans.contains(span));
        slow
    };
    let rate_hz = recording.clock.rate_hz();
    let window = samples.count_in(rate_hz.map_or(READINGS_S, |_| SHORT_S));
    let window = window.max(MIN_WINDOW_LEN);
    let mut short = find(window, quiet_variance(samples, &poses, window));
    let min_short = samples.count_in(rate_hz.map_or(BLOCK_S, |_| MIN_PAUSE_S));
    short.retain(|span| (min_short..min_unsteady).contains(&span.len()));
    let mut unsteady = find(samples.count_in(MIN_REST_S).max(window), MAX_VARIANCE);
    // Where a hand trembles little, it is quiet now and then.
    let overlap = |a: &Range<usize>, b: &Range<usize>| a.start < b.end && b.start < a.end;
    let is_short = |u: &Range<usize>| short.iter().any(|s| overlap(s, u) && 2 * s.len() > u.len());
    unsteady.retain(|u| u.len() >= min_unsteady && !is_short(u));
    short.retain(|s| !unsteady.iter().any(|u| overlap(s, u)));
    let still = poses.iter().chain(&short).chain(&unsteady);
    if still.map(ExactSizeIterator::len).sum::<usize>() * MAX_MOTION < samples.len() {
        return None;
    }
    let pauses = short.iter().chain(&unsteady);
    let pauses: Vec<Range<usize>> = pauses.map(|span| nominal.in_rows(span)).collect();
    let pauses = directions(recording, &pauses, None);
    let is_short = short.len() >= unsteady.len();
    let first = if is_short { short } else { unsteady }.into_iter().next()?;
    let why = if is_short {
        let length = |samples: usize| match rate_hz {
            Some(rate_hz) => format!("{:.1} s", samples as f64 / rate_hz),
            None => count(samples, "row"),
        };
        let (lasts, takes) = (length(first.len()), length(min_rest));
        format!(
            "lasts {lasts} with the ends of motions, a pose at least {takes} without: hold each for longer"
        )
    } else {
        let (mean, variance) = at(&nominal.in_rows(&middle(&first)));
        let rms_mg = 1000.0 * (variance / 3.0).sqrt() / norm(&mean);
        format!("moves by {rms_mg:.0} mg rms, as in a hand: lean the sensor against something")
    };
    let rows = nominal.in_rows(&first);
    let [from, to] = [rows.start, rows.end - 1].map(|row| recording.line(row));
    let number = count(pauses.len(), "direction");
    let finding = finding!(
        UnusedPauses,
        "pauses in {number} other than those of the poses are not used; that in lines {from} to {to} {why}"
    );
    Some(finding.in_file(&recording.name))
}

/// Samples of the shortest rest that is used.
fn min_rest_len(recording: &Recording, samples: &Samples, poses: &[Range<usize>]) -> usize {
    if recording.clock.rate_hz().is_some() {
        return samples.count_in(MIN_REST_S);
    }
    let lengths = poses.iter().map(ExactSizeIterator::len);
    let usual = min_samples_without_rate(lengths.clone(), samples) as usize;
    lengths.fold(usual, usize::min)
}

/// Variance up to which a window is as quiet as the poses, or nearly: a hand that hesitates trembles more.
fn quiet_variance(samples: &Samples, poses: &[Range<usize>], window: usize) -> [f64; 2] {
    let windows = poses.iter().flat_map(|pose| blocks(samples, pose, window));
    let windows: Vec<Block> = windows.collect();
    [0, 1].map(|sensor| {
        let variances = windows.iter().map(|w| w.total_variance(sensor)).collect();
        let level = quantile(variances, 0.5);
        (MAX_EXCESS * level).clamp(TREMOR[sensor] / CALM, MAX_VARIANCE[sensor])
    })
}
