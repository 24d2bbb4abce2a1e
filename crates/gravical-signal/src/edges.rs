//! Where a rest begins and ends, to the sample.

use std::ops::Range;

use crate::quiet::BLOCK_S;
use crate::samples::Samples;

/// Blocks next to an edge that say what the rest is: 3 s.
const NEAR_BLOCKS: usize = 15;
/// A motion begins more gently than its fitted onset: a rest ends this long before it.
const MARGIN_S: f64 = 0.03;

/// The span with ends to the sample, by the seconds of rest next to each.
pub(crate) fn with_edges(
    samples: &Samples,
    span: &Range<usize>,
    size: usize,
    variance: &[f64; 6],
) -> Range<usize> {
    let piece = samples.piece(span.start);
    let start = start_edge(samples, span, size, variance);
    let end = if span.end + size < piece.end {
        end_edge(samples, span, span.end + size, size, variance)
    } else {
        span.end
    };
    if start < end {
        start..end
    } else {
        span.clone()
    }
}

/// Samples that a rest near `near` samples long is looked for its edge in: far enough that the ramp finds
/// its foot, from a block beyond it.
fn reach(near: usize, size: usize) -> usize {
    near / 3 + 2 * size
}

fn margin(size: usize) -> usize {
    (MARGIN_S / BLOCK_S * size as f64).ceil() as usize
}

/// Where a rest begins, to the sample.
fn start_edge(samples: &Samples, span: &Range<usize>, size: usize, variance: &[f64; 6]) -> usize {
    let piece = samples.piece(span.start);
    if span.start <= piece.start + size {
        return span.start;
    }
    let near = span.len().min(NEAR_BLOCKS * size);
    let rest = span.start..span.start + near;
    let first = span.start.saturating_sub(size).max(piece.start);
    let most = samples.time_s.len() - 1 - first;
    let reach = reach(near, size).min(most);
    let onset = onset(samples, &rest, variance, reach, |u| first + u);
    first + onset + margin(size)
}

/// Where a rest ends, to the sample, looked for from sample `last` back.
fn end_edge(
    samples: &Samples,
    span: &Range<usize>,
    last: usize,
    size: usize,
    variance: &[f64; 6],
) -> usize {
    let near = span.len().min(NEAR_BLOCKS * size);
    let (rest, reach) = (span.end - near..span.end, reach(near, size).min(last));
    let onset = onset(samples, &rest, variance, reach, |u| last - u);
    (last + 1).saturating_sub(onset + margin(size))
}

/// Samples from the first of `at` to the onset of a ramp: the one that explains most of what leaves the mean
/// of `rest`.
fn onset(
    samples: &Samples,
    rest: &Range<usize>,
    variance: &[f64; 6],
    reach: usize,
    at: impl Fn(usize) -> usize,
) -> usize {
    let mean = samples.mean(rest);
    let (mut total, mut moment, mut squares) = ([0.0; 6], [0.0; 6], 0.0);
    let (mut best, mut onset) = (f64::MIN, 0);
    for u in 1..reach {
        let x = samples.sample(at(u - 1));
        squares += (u * u) as f64;
        let mut gain = 0.0;
        for c in 0..6 {
            total[c] += x[c] - mean[c];
            moment[c] += total[c];
            gain += moment[c] * moment[c] / variance[c];
        }
        if gain / squares > best {
            (best, onset) = (gain / squares, u);
        }
    }
    onset
}
