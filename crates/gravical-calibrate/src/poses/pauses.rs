//! Pauses of a continuous recording that are not rests, but were probably meant as poses.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_signal::stats::moments;
use gravical_signal::{BLOCK_S, MAX_EXCESS, MAX_VARIANCE, Samples, TREMOR, quantile};

use super::face::angle_deg;
use super::nominal::NominalSamples;
use super::rests::{APART_DEG, MANY_POSES, MIN_REST_S, directions, min_samples_without_rate};
use super::stills::{HELD_DEG, MIN_WINDOW_LEN, READINGS_S, middle, still_spans};
use crate::finding::{Case, Finding};
use crate::recording::Recording;

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
    let (means, variances): (Vec<[f64; 3]>, Vec<f64>) = poses.iter().map(at).unzip();
    let usual = quantile(means.iter().map(norm).collect(), 0.5);
    let unit2 = (usual / STANDARD_GRAVITY_MPS2).powi(2);
    let max_calm = (MAX_EXCESS * quantile(variances, 0.5)).max(unit2 * TREMOR[0] / CALM);
    let poses: Vec<Range<usize>> = poses.iter().map(|rows| nominal.in_samples(rows)).collect();
    let rate_hz = recording.clock.rate_hz();
    let min_rest = min_rest_len(recording, samples, &poses);
    let min_unsteady = min_rest + min_rest / 2;
    let min_short = samples.count_in(rate_hz.map_or(BLOCK_S, |_| MIN_PAUSE_S));
    let window = samples.count_in(rate_hz.map_or(READINGS_S, |_| SHORT_S));
    let window = window.max(MIN_WINDOW_LEN);
    let is_calm = |span: &Range<usize>| at(&nominal.in_rows(&middle(span))).1 < max_calm;
    let is_meant = |span: &Range<usize>| {
        let (mean, variance) = at(&nominal.in_rows(&middle(span)));
        // A recording begins and ends in a hand.
        span.start >= window
            && span.end + window <= samples.len()
            && means.iter().all(|pose| angle_deg(*pose, mean) > APART_DEG)
            && (norm(&mean) / usual - 1.0).abs() < MAX_MAGNITUDE_ERROR
            // Spikes are taken out of the samples, and motion that passes for them.
            && variance < MAX_VARIANCE[0] * unit2
    };
    let find = |window: usize| {
        let spans = still_spans(samples, &poses, window, MAX_VARIANCE, HELD_DEG).into_iter();
        spans.filter(is_meant)
    };
    let is_short = |s: &Range<usize>| is_calm(s) && (min_short..min_unsteady).contains(&s.len());
    // A tremor is no motion over a second.
    let second = samples.count_in(MIN_REST_S).max(window);
    let is_unsteady = |span: &Range<usize>| !is_calm(span) && span.len() >= min_unsteady;
    let mut pauses: Vec<Range<usize>> = find(window).filter(is_short).collect();
    pauses.extend(find(second).filter(is_unsteady));
    let slow = nominal.without_turns([&poses[..], &pauses].concat());
    pauses.retain(|span| slow.contains(span));
    let still = poses.iter().chain(&pauses).map(ExactSizeIterator::len);
    if still.sum::<usize>() * MAX_MOTION < samples.len() {
        return None;
    }
    let rows: Vec<Range<usize>> = pauses.iter().map(|span| nominal.in_rows(span)).collect();
    let directions = directions(recording, &rows, None).len();
    let short = pauses.iter().filter(|span| is_calm(span));
    let is_short = 2 * short.count() >= pauses.len();
    let first = pauses.into_iter().find(|span| is_calm(span) == is_short)?;
    let lines = recording.lines_of(&nominal.in_rows(&first));
    let case = if is_short {
        Case::ShortPauses {
            directions,
            lines,
            lasts: first.len(),
            least: min_rest,
            rate_hz,
        }
    } else {
        let (mean, variance) = at(&nominal.in_rows(&middle(&first)));
        Case::UnsteadyPauses {
            directions,
            lines,
            rms_mg: 1000.0 * (variance / 3.0).sqrt() / norm(&mean),
        }
    };
    Some(case.finding().in_file(&recording.name))
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
