//! Constancy on every scale: what a block is too short or too long to show.

use std::ops::Range;

use crate::quiet::Noise;
use crate::samples::Samples;

/// Longest window, s, for the slow beginning of a move of a quarter of a minute; each of the others is half as
/// long, down to 31 ms, a knock.
const LONGEST_S: f64 = 4.0;
const WINDOWS: i32 = 8;
/// A window is compared with as much of what is before it as twice its length, at least so much, s: over longer
/// ones biases drift.
const REFERENCE_S: f64 = 3.0;
/// Samples are summed up for so long at a time, s: the sums of a day take as much memory as its samples.
const SUMMED_S: f64 = 60.0;
/// χ² of the three means of a window without a gyroscope, and of six with one, above which it is not at rest: chance
/// exceeds it once in 10⁶ windows; a minute at 100 Hz has some 10⁴ independent ones.
const MAX_CHI2: [f64; 2] = [32.0, 40.0];

/// The parts of a span in which force and rate are constant within their noise on every scale, in order: from
/// its middle, or that of what is left, outwards to the first window that leaves the mean of those inside it. The
/// deviation began with that window, or within half of its length before.
pub(crate) fn steady_parts(
    samples: &Samples,
    span: &Range<usize>,
    noise: &Noise,
    min_len: usize,
) -> Vec<Range<usize>> {
    let mut bank = Bank {
        sums: Sums {
            samples,
            span: span.clone(),
            origin: samples.mean(span),
            margin: samples.count_in(SUMMED_S),
            start: 0,
            sums: Vec::new(),
        },
        noise,
        channels: samples.count(),
        lengths: lengths(samples),
        reference: samples.count_in(REFERENCE_S),
    };
    let mut parts = Vec::new();
    bank.split(span, min_len, &mut parts);
    parts
}

/// Samples of the windows.
fn lengths(samples: &Samples) -> Vec<usize> {
    let seconds = (0..WINDOWS).rev().map(|k| LONGEST_S / f64::from(1 << k));
    let lengths = seconds.map(|s| samples.count_in(s + 0.5 * samples.period_s));
    lengths.filter(|length| *length > 1).collect()
}

/// Windows over a span, compared with what lies inside of them.
struct Bank<'a> {
    sums: Sums<'a>,
    noise: &'a Noise,
    channels: usize,
    lengths: Vec<usize>,
    reference: usize,
}

impl Bank<'_> {
    fn split(&mut self, span: &Range<usize>, min_len: usize, parts: &mut Vec<Range<usize>>) {
        if span.len() < min_len {
            return;
        }
        let middle = (span.start + span.end) / 2;
        let at = |u: isize| middle.saturating_add_signed(u);
        let (before, after) = (middle - span.start, span.end - middle);
        let after = self.first_change(after, before, &|u, v| at(u)..at(v));
        let before = self.first_change(before, span.end - middle, &|u, v| at(-v)..at(-u));
        // What deviates began within half of the window before it.
        let start = before.map_or(span.start, |(u, w)| middle - u + w / 2);
        let end = after.map_or(span.end, |(u, w)| middle + u - w / 2);
        if let Some((u, _)) = before {
            self.split(&(span.start..middle - u), min_len, parts);
        }
        if start + min_len <= end {
            parts.push(start..end);
        }
        if let Some((u, _)) = after {
            self.split(&(middle + u..span.end), min_len, parts);
        }
    }

    /// Samples from the middle outwards to the first window that leaves what is inside of it, and its length.
    /// `at` gives the samples from `u` to `v` outwards.
    fn first_change(
        &mut self,
        outwards: usize,
        inwards: usize,
        at: &dyn Fn(isize, isize) -> Range<usize>,
    ) -> Option<(usize, usize)> {
        let lengths = self.lengths.clone();
        for u in 1..=outwards {
            let longest = lengths.iter().rev().find(|&&w| {
                // What is near the other end may move, too.
                let inside = u + inwards / 2;
                let most = self.reference.max(2 * w).min(inside.saturating_sub(w));
                // Long windows move by an eighth of their length.
                w <= u.max(inwards / 2) && inside >= 2 * w && u % (w / 8).max(1) == 0 && {
                    let (v, w, most) = (u as isize, w as isize, most as isize);
                    self.differ(&at(v - w, v), &at(v - w - most, v - w))
                }
            });
            if let Some(&w) = longest {
                return Some((u.saturating_sub(w), w));
            }
        }
        None
    }

    fn differ(&mut self, window: &Range<usize>, reference: &Range<usize>) -> bool {
        self.sums
            .cover(&(window.start.min(reference.start)..window.end.max(reference.end)));
        let chi2: f64 = (0..self.channels)
            .map(|c| {
                let apart = 0.5 * (window.len() + reference.len()) as f64;
                let variance = self.noise.of_mean(c, window.len())
                    + self.noise.of_mean(c, reference.len())
                    + self.noise.of_drift(c, apart);
                let d = self.sums.mean(window, c) - self.sums.mean(reference, c);
                d * d / variance
            })
            .sum();
        chi2 > MAX_CHI2[usize::from(self.channels > 3)]
    }
}

/// Sums of the samples of a span, of a part of it at a time: those of a long recording need much memory.
struct Sums<'a> {
    samples: &'a Samples,
    span: Range<usize>,
    origin: [f64; 6],
    /// Samples that are summed beyond those asked for, on both sides.
    margin: usize,
    start: usize,
    sums: Vec<[f64; 6]>,
}

impl Sums<'_> {
    /// Sums up what is around some samples.
    fn cover(&mut self, part: &Range<usize>) {
        if self.start <= part.start && part.end < self.start + self.sums.len() {
            return;
        }
        self.start = part.start.saturating_sub(self.margin).max(self.span.start);
        let end = (part.end + self.margin).min(self.span.end);
        let mut sum = [0.0; 6];
        self.sums.clear();
        self.sums.push(sum);
        for i in self.start..end {
            let x = self.samples.sample(i);
            (0..6).for_each(|c| sum[c] += x[c] - self.origin[c]);
            self.sums.push(sum);
        }
    }

    fn mean(&self, span: &Range<usize>, c: usize) -> f64 {
        let at = |i: usize| self.sums[i - self.start][c];
        (at(span.end) - at(span.start)) / span.len() as f64
    }
}
