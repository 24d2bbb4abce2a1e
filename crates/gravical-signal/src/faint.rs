//! Moves within a rest that no single block shows.

use std::ops::Range;

use crate::blocks::rounded;
use crate::samples::Samples;

/// Durations of the moves that are looked for, s: one between two of them loses a tenth of its σ.
const DURATIONS_S: [f64; 8] = [0.35, 0.5, 0.7, 1.0, 1.5, 2.5, 4.0, 8.0];
/// χ² of three axes, of the best of all places and durations, above which there is a move: 7 σ. Chance
/// exceeds it once in 10¹⁰; of a move of 10 σ, some 8.5 are left where place and duration do not fit.
const MIN_CHI2: f64 = 49.0;
/// Places that are tried within a duration.
const PLACES: usize = 8;

/// The parts of a rest before, between and after moves that a matched filter sees: smooth displacements
/// from rest to rest (minimum jerk, Flash and Hogan 1985), whose acceleration is known but for its size
/// and direction. `density` is that of the force, (m/s²)² s.
pub(crate) fn without_faint_moves(
    samples: &Samples,
    rest: Range<usize>,
    density: &[f64; 3],
    min_len: usize,
) -> Vec<Range<usize>> {
    let size = rounded(DURATIONS_S[0] / samples.period_s / 8.0 - 0.5).max(1);
    let force = means(samples, &rest, size);
    let block_s = size as f64 * samples.period_s;
    let white: Vec<[f64; 3]> = force
        .iter()
        .map(|f| std::array::from_fn(|c| f[c] * (block_s / density[c]).sqrt()))
        .collect();
    let mut parts = Vec::new();
    split(&white, 0..white.len(), block_s, &mut parts);
    let samples = |part: Range<usize>| {
        let end = if part.end == white.len() {
            rest.end
        } else {
            rest.start + part.end * size
        };
        rest.start + part.start * size..end
    };
    parts
        .into_iter()
        .map(samples)
        .filter(|part| part.len() >= min_len)
        .collect()
}

/// Adds the parts of a span, in order.
fn split(white: &[[f64; 3]], span: Range<usize>, block_s: f64, parts: &mut Vec<Range<usize>>) {
    let found = DURATIONS_S
        .iter()
        .map(|seconds| rounded(seconds / block_s))
        // Fewer blocks have no curve.
        .filter(|len| *len > 2)
        .filter_map(|len| strongest(&white[span.clone()], len))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match found {
        Some((chi2, at)) if chi2 > MIN_CHI2 => {
            split(white, span.start..span.start + at.start, block_s, parts);
            split(white, span.start + at.end..span.end, block_s, parts);
        }
        _ => parts.push(span),
    }
}

/// χ² and place of the strongest move of `len` blocks.
fn strongest(white: &[[f64; 3]], len: usize) -> Option<(f64, Range<usize>)> {
    let shape: Vec<f64> = (0..len)
        .map(|j| (j as f64 + 0.5) / len as f64)
        .map(|u| u * (1.0 - u) * (1.0 - 2.0 * u))
        .collect();
    let norm = shape.iter().map(|w| w * w).sum::<f64>().sqrt();
    let chi2 = |at: usize| {
        let mut sum = [0.0; 3];
        for (x, w) in white[at..at + len].iter().zip(&shape) {
            (0..3).for_each(|c| sum[c] += x[c] * w / norm);
        }
        sum.iter().map(|s| s * s).sum::<f64>()
    };
    let places = (0..(white.len() + 1).saturating_sub(len)).step_by((len / PLACES).max(1));
    places
        .map(|at| (chi2(at), at..at + len))
        .max_by(|a, b| a.0.total_cmp(&b.0))
}

/// Means of the force over runs of `size` samples.
fn means(samples: &Samples, span: &Range<usize>, size: usize) -> Vec<[f64; 3]> {
    let runs = span.clone().step_by(size);
    runs.filter(|from| from + size <= span.end)
        .map(|from| {
            let mean = samples.mean(&(from..from + size));
            [mean[0], mean[1], mean[2]]
        })
        .collect()
}
