//! Columns through the filters: not across breaks and gaps, and around empty cells.

use std::borrow::Cow;
use std::ops::Range;

use super::even::EvenGrid;
use super::filter::Filter;

/// Steps longer than this many usual steps are gaps: twice the window of the weakest smoothing.
pub(super) const GAP_STEPS: f64 = 10.0;

/// What does not depend on the values.
pub(super) struct Setup {
    pub filters: Vec<Filter>,
    /// The usual step, s (or rows, without time stamps and rate).
    pub step_s: f64,
    /// Steps that are whole multiples of it within this share are on the grid.
    pub whole_share: f64,
    /// Numbers of the filtered channels: 0 to 2 the accelerometer, 3 to 5 the gyroscope.
    pub channels: Vec<usize>,
    /// Rows at rest in which noise is measured: before the filters and after each.
    pub at_rest: Vec<Vec<Range<usize>>>,
}

/// What was counted in all rows.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Counts {
    /// Parts between breaks, gaps and steps back.
    pub stretches: usize,
    /// Gaps and steps back between breaks.
    pub gaps: usize,
    pub backward: usize,
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
    pub counts: Counts,
    /// Of each filter.
    pub treatments: Vec<Treatment>,
    /// Before the filters and after each, if requested.
    pub noise: Vec<ChannelSigmas>,
}

/// Filters the columns of `channels` in place. `time_s`: the time stamps, NaN where unknown; `None`
/// for rows at an even step. `breaks`: rows that do not continue the one before.
pub(super) fn run(
    setup: &Setup,
    time_s: Option<&[f64]>,
    breaks: &[usize],
    channels: &mut [Option<&mut [f64]>; 6],
) -> Done {
    let rows = channels
        .iter()
        .flatten()
        .map(|c| c.len())
        .max()
        .unwrap_or(0);
    let time_s = times(time_s, rows, setup.step_s);
    let mut done = Done {
        counts: count_stretches(setup, &time_s, breaks),
        treatments: vec![Treatment::default(); setup.filters.len()],
        noise: vec![ChannelSigmas::default(); setup.at_rest.len()],
    };
    for (c, column) in channels.iter_mut().enumerate() {
        let Some(column) = column
            .as_deref_mut()
            .filter(|_| setup.channels.contains(&c))
        else {
            continue;
        };
        let stretches = stretches(setup, &time_s, breaks, column);
        let mut noise = done.noise.iter_mut().zip(&setup.at_rest);
        let mut measure = |column: &[f64]| {
            if let Some((sigmas, at_rest)) = noise.next() {
                sigmas[c] = sigma_at_rest(column, at_rest);
            }
        };
        measure(column);
        for (filter, treatment) in setup.filters.iter().zip(&mut done.treatments) {
            for rows in &stretches {
                filter_stretch(filter, setup, &time_s, rows, column, treatment);
            }
            measure(column);
        }
    }
    done
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

fn count_stretches(setup: &Setup, time_s: &[f64], breaks: &[usize]) -> Counts {
    let mut counts = Counts::default();
    for row in 0..time_s.len() {
        let step_s = time_s[row] - time_s[row.saturating_sub(1)];
        let parts = if row == 0 || breaks.binary_search(&row).is_ok() {
            true
        } else if step_s > GAP_STEPS * setup.step_s {
            counts.gaps += 1;
            true
        } else if step_s < 0.0 {
            counts.backward += 1;
            true
        } else {
            false
        };
        counts.stretches += usize::from(parts);
    }
    counts
}

/// Rows of a channel between breaks, gaps and steps back of its samples; both ends are samples.
fn stretches(setup: &Setup, time_s: &[f64], breaks: &[usize], column: &[f64]) -> Vec<Range<usize>> {
    let within = 0.0..=GAP_STEPS * setup.step_s;
    let mut stretches: Vec<Range<usize>> = Vec::new();
    let mut breaks = breaks.iter().peekable();
    let mut is_broken = true;
    for row in (0..column.len()).filter(|row| column[*row].is_finite()) {
        while breaks.next_if(|b| **b <= row).is_some() {
            is_broken = true;
        }
        match stretches.last_mut().filter(|_| !is_broken) {
            Some(last) if within.contains(&(time_s[row] - time_s[last.end - 1])) => {
                last.end = row + 1;
            }
            _ => stretches.push(row..row + 1),
        }
        is_broken = false;
    }
    stretches
}

/// Filters the samples of a channel in these rows.
fn filter_stretch(
    filter: &Filter,
    setup: &Setup,
    time_s: &[f64],
    rows: &Range<usize>,
    column: &mut [f64],
    treatment: &mut Treatment,
) {
    let sampled: Vec<usize> = rows
        .clone()
        .filter(|row| column[*row].is_finite())
        .collect();
    let mut samples: Vec<f64> = sampled.iter().map(|row| column[*row]).collect();
    treatment.samples += samples.len();
    let stamps = sampled.iter().map(|row| time_s[*row]);
    let grid = EvenGrid::new(setup.step_s, setup.whole_share, stamps);
    let grid = Some(grid).filter(|grid| filter.needs_even_steps() && !grid.is_even());
    let points = grid.as_ref().map_or(samples.len(), EvenGrid::len);
    if samples.len().min(points) < filter.shortest() {
        treatment.too_short += samples.len();
        treatment.short_stretches += 1;
        return;
    }
    match grid {
        None => treatment.replaced += filter.apply(&mut samples),
        Some(grid) => {
            match grid.is_resampled() {
                true => treatment.resampled += samples.len(),
                false => treatment.filled += grid.lost(),
            }
            let mut even = grid.interpolate(&samples);
            filter.apply(&mut even);
            samples = grid.back(&even);
        }
    }
    for (row, value) in sampled.iter().zip(samples) {
        column[*row] = value;
    }
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
