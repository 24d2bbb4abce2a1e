//! Columns through the filters: not across breaks and gaps, around empty cells, and on an even grid.

use std::borrow::Cow;
use std::ops::Range;

use super::Channels;
use super::even::{EvenGrid, WHOLE_SHARE, whole_share};
use super::filter::Filter;
use crate::recording::Recording;

/// Steps longer than this many usual steps are gaps: twice the window of the weakest smoothing.
const GAP_STEPS: f64 = 10.0;

/// Where filters restart.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Parts {
    /// Parts between breaks, gaps and steps back.
    pub count: usize,
    /// Gaps and steps back between breaks.
    pub gaps: usize,
    pub backward: usize,
    /// A longer step is a gap, s.
    pub gap_s: f64,
}

/// What a filter did, over all channels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Treatment {
    /// All samples.
    pub samples: usize,
    /// Lost samples that were interpolated.
    pub filled: usize,
    /// Samples that were interpolated to an even grid and back.
    pub resampled: usize,
    /// Outliers that were replaced.
    pub replaced: usize,
    /// Samples that were left unchanged because there are too few, and their stretches.
    pub too_short: usize,
    pub short_stretches: usize,
}

/// Standard deviation of each channel at rest.
pub(super) type ChannelSigmas = [Option<f64>; 6];

/// Results.
pub(super) struct Done {
    pub parts: Parts,
    /// Of each filter.
    pub treatments: Vec<Treatment>,
    /// Before the filters and after each, if requested.
    pub noise: Vec<ChannelSigmas>,
}

/// Filters the channels of a recording in place. `at_rest`: rows in which noise is measured, before the
/// filters and after each.
pub(super) fn run(
    recording: &mut Recording,
    filters: &[Filter],
    channels: Channels,
    at_rest: &[Vec<Range<usize>>],
) -> Done {
    let step_s = recording.timing.rate_hz().map_or(1.0, f64::recip);
    let Recording {
        accel,
        gyro,
        time_s,
        breaks,
        ..
    } = recording;
    let rows = Rows {
        time_s: times(time_s.as_deref(), accel[0].len(), step_s),
        breaks,
        step_s,
        whole_share: time_s
            .as_deref()
            .map_or(WHOLE_SHARE, |t| whole_share(t, step_s)),
    };
    let mut done = Done {
        parts: rows.parts(),
        treatments: vec![Treatment::default(); filters.len()],
        noise: vec![ChannelSigmas::default(); at_rest.len()],
    };
    let columns = accel.iter_mut().chain(gyro.iter_mut().flatten());
    for (c, column) in columns.enumerate().filter(|(c, _)| channels.contain(*c)) {
        let stretches = rows.stretches(column);
        let mut noise = done.noise.iter_mut().zip(at_rest);
        let mut measure = |column: &[f64]| {
            if let Some((sigmas, at_rest)) = noise.next() {
                sigmas[c] = sigma_at_rest(column, at_rest);
            }
        };
        measure(column);
        for (filter, treatment) in filters.iter().zip(&mut done.treatments) {
            for stretch in &stretches {
                rows.filter(filter, stretch, column, treatment);
            }
            measure(column);
        }
    }
    done
}

/// The rows of a recording.
struct Rows<'a> {
    /// Times, s (or rows, without time stamps and rate).
    time_s: Cow<'a, [f64]>,
    /// Rows that do not continue the one before.
    breaks: &'a [usize],
    /// The usual step, s.
    step_s: f64,
    /// Steps that are whole multiples of it within this share are on the grid.
    whole_share: f64,
}

impl Rows<'_> {
    fn parts(&self) -> Parts {
        let mut parts = Parts {
            count: usize::from(!self.time_s.is_empty()),
            gap_s: GAP_STEPS * self.step_s,
            ..Parts::default()
        };
        for (before, times) in self.time_s.windows(2).enumerate() {
            let step_s = times[1] - times[0];
            let is_break = self.breaks.binary_search(&(before + 1)).is_ok();
            let is_gap = !is_break && step_s > parts.gap_s;
            let is_backward = !is_break && step_s < 0.0;
            parts.gaps += usize::from(is_gap);
            parts.backward += usize::from(is_backward);
            parts.count += usize::from(is_break || is_gap || is_backward);
        }
        parts
    }

    /// Rows of a channel between breaks, gaps and steps back of its samples; both ends are samples.
    fn stretches(&self, column: &[f64]) -> Vec<Range<usize>> {
        let within = 0.0..=GAP_STEPS * self.step_s;
        let mut stretches: Vec<Range<usize>> = Vec::new();
        let mut breaks = self.breaks.iter().peekable();
        let mut is_broken = true;
        for row in (0..column.len()).filter(|row| column[*row].is_finite()) {
            while breaks.next_if(|b| **b <= row).is_some() {
                is_broken = true;
            }
            match stretches.last_mut().filter(|_| !is_broken) {
                Some(last) if within.contains(&(self.time_s[row] - self.time_s[last.end - 1])) => {
                    last.end = row + 1;
                }
                _ => stretches.push(row..row + 1),
            }
            is_broken = false;
        }
        stretches
    }

    /// Filters the samples of a channel in a stretch.
    fn filter(
        &self,
        filter: &Filter,
        stretch: &Range<usize>,
        column: &mut [f64],
        treatment: &mut Treatment,
    ) {
        let rows = stretch.clone().filter(|row| column[*row].is_finite());
        let rows: Vec<usize> = rows.collect();
        let mut samples: Vec<f64> = rows.iter().map(|row| column[*row]).collect();
        treatment.samples += samples.len();
        let grid = filter.needs_even_steps().then(|| {
            let times: Vec<f64> = rows.iter().map(|row| self.time_s[*row]).collect();
            EvenGrid::new(self.step_s, self.whole_share, &times)
        });
        let grid = grid.filter(|grid| !grid.is_even());
        let points = grid.as_ref().map_or(samples.len(), EvenGrid::len);
        if samples.len().min(points) < filter.shortest() {
            treatment.too_short += samples.len();
            treatment.short_stretches += 1;
            return;
        }
        if let Some(grid) = grid {
            if grid.is_resampled {
                treatment.resampled += samples.len();
            } else {
                treatment.filled += grid.lost();
            }
            let mut even = grid.interpolate(&samples);
            filter.apply(&mut even);
            samples = grid.back(&even);
        } else {
            treatment.replaced += filter.apply(&mut samples);
        }
        for (row, value) in rows.into_iter().zip(samples) {
            column[row] = value;
        }
    }
}

/// Times of all rows, s: rows without a stamp lie evenly between their neighbours, at the ends at the usual step.
fn times(stamps: Option<&[f64]>, rows: usize, step_s: f64) -> Cow<'_, [f64]> {
    if let Some(stamps) = stamps.filter(|t| t.iter().all(|t| t.is_finite())) {
        return Cow::Borrowed(stamps);
    }
    let stamp = |row: usize| stamps.map(|t| t[row]).filter(|t| t.is_finite());
    let stamped_from = |from: usize| (from..rows).find_map(|row| Some((row, stamp(row)?)));
    let (mut before, mut next) = (None, stamped_from(0));
    let time = |row: usize| match (before, next) {
        (_, Some((at, time))) if at == row => {
            (before, next) = (next, stamped_from(row + 1));
            time
        }
        (Some((a, from)), Some((b, to))) => from + (to - from) * (row - a) as f64 / (b - a) as f64,
        (Some((at, time)), None) => time + (row - at) as f64 * step_s,
        (None, Some((at, time))) => time - (at - row) as f64 * step_s,
        (None, None) => row as f64 * step_s,
    };
    Cow::Owned((0..rows).map(time).collect())
}

/// √(Σ(x − mean of its interval)²/Σ(n − 1)) over intervals; `None` if none has two values.
fn sigma_at_rest(column: &[f64], intervals: &[Range<usize>]) -> Option<f64> {
    let (mut squares, mut freedom) = (0.0, 0.0);
    for rows in intervals {
        let values = column.get(rows.clone()).unwrap_or_default();
        let values: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        if values.len() >= 2 {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            squares += values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>();
            freedom += values.len() as f64 - 1.0;
        }
    }
    (freedom > 0.0).then(|| (squares / freedom).sqrt())
}
