//! Still spans of any length, by sliding windows: shorter than the blocks of the rest detector find.

use std::ops::Range;

use gravical_core::matrix3::norm;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_signal::{BLOCK_S, Block, Samples, TREMOR, blocks, is_quiet};

/// Readings stay this near their mean in a pose, as an angle in degrees, by noise, a table that gives way, a
/// hand that wanders or a bias that drifts …
pub(super) const SAME_DEG: f64 = 1.0;
/// … and this near where no pose is asked for, or none is found.
pub(super) const HELD_DEG: f64 = 3.0;
/// Windows of 8 readings lie within a pause of 10 wherever it begins: blocks have 10 where no rate is known.
pub(super) const READINGS_S: f64 = 0.8 * BLOCK_S;
/// A variance of fewer samples says little.
pub(super) const MIN_WINDOW_LEN: usize = 8;
/// Parts of a window: each begins one after the one before.
const PARTS: usize = 8;

/// Rests of ten readings or more where no rate is known, without the reading at each end: it may be of a motion.
pub(super) fn brief_rests(samples: &Samples) -> Vec<Range<usize>> {
    let window = samples.count_in(READINGS_S).max(MIN_WINDOW_LEN);
    let spans = still_spans(samples, &[], window, TREMOR, SAME_DEG);
    let end = window.div_ceil(PARTS);
    let inner = spans.iter().map(|span| span.start + end..span.end - end);
    inner.filter(|span| span.len() >= window).collect()
}

/// Spans between the poses in which all windows vary by less, and that stay within a few degrees.
pub(super) fn still_spans(
    samples: &Samples,
    poses: &[Range<usize>],
    window: usize,
    max_variance: [f64; 2],
    max_tilt_deg: f64,
) -> Vec<Range<usize>> {
    let step = window.div_ceil(PARTS);
    let distance = |a: &[f64; 6], b: &[f64; 6]| norm(&[0, 1, 2].map(|c| a[c] - b[c]));
    let max_distance = max_tilt_deg.to_radians() * STANDARD_GRAVITY_MPS2;
    // From window to window: a hand that goes on in one direction is no pause.
    let max_step = HELD_DEG.to_radians() * STANDARD_GRAVITY_MPS2 / PARTS as f64;
    let goes_on = |a: &Block, b: &Block| {
        b.span.start - a.span.start == step && distance(&a.mean, &b.mean) < max_step
    };
    let is_one_piece = |a: &Block, b: &Block| samples.piece(a.span.start).contains(&b.span.start);
    let mut spans = Vec::new();
    let mut from = 0;
    let ends = poses.iter().map(|pose| pose.start).chain([samples.len()]);
    for (k, end) in ends.enumerate() {
        let parts = blocks(samples, &(from..end.max(from)), step);
        let adjacent = parts.chunk_by(|a, b| a.span.end == b.span.start && is_one_piece(a, b));
        let windows = adjacent
            .flat_map(|parts| parts.windows(PARTS))
            .map(Block::joined);
        let quiet: Vec<Block> = windows.filter(|w| is_quiet(w, max_variance)).collect();
        for run in quiet.chunk_by(goes_on) {
            let span = run[0].span.start..run[run.len() - 1].span.end;
            let mean = samples.mean(&middle(&span));
            if run.iter().all(|w| distance(&w.mean, &mean) < max_distance) {
                spans.push(span);
            }
        }
        from = poses.get(k).map_or(from, |pose| pose.end);
    }
    spans
}

/// The half of a span that is furthest from the motions around it.
pub(super) fn middle(span: &Range<usize>) -> Range<usize> {
    let quarter = span.len() / 4;
    span.start + quarter..span.end - quarter
}
