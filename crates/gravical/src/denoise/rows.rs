//! Columns through the filters: not across breaks and gaps, around empty cells and lost samples.

use std::ops::Range;
use std::path::Path;

use super::filter::Filter;
use crate::problem::Problem;
use crate::recording::Recording;
use crate::{Error, Result};

/// Steps longer than this many usual steps are gaps: twice the window of the weakest smoothing.
const GAP_STEPS: usize = 10;
/// Steps that are whole multiples of the usual one within this share are due to lost samples.
const WHOLE_SHARE: f64 = 0.25;
/// The same where the stamps are coarse: 1.5 steps are a lost sample.
const MAX_WHOLE_SHARE: f64 = 0.45;
/// Stamps that differ by less than this share of the usual step are equal.
const SAME_SHARE: f64 = 0.01;
/// Number of time stamps from which their resolution is determined.
const FIRST_STAMPS: usize = 2000;
/// Fraction of the steps that may be uneven: a clock that hesitates now and then. With more the
/// recording is not evenly sampled.
const MAX_UNEVEN: f64 = 0.01;

/// What a filter did, over all channels.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Treatment {
    /// Outliers that were replaced.
    pub replaced: usize,
    /// Samples that were left unchanged because there are too few.
    pub too_short: usize,
}

fn uneven(recording: &Recording, share: f64) -> Error {
    let rate_hz = recording.clock.rate_hz().unwrap_or(f64::NAN);
    let error = Problem::UnevenStamps { share, rate_hz }.error();
    let error = error.at(Path::new(&recording.name), None);
    error.advise("columns", "t=-").advise("rate", "")
}

/// The rows of a recording on an even grid.
pub(super) struct Grid {
    /// Rows at which filters start.
    pub starts: Vec<usize>,
    /// Point of each row, ascending within a part; rows with equal time stamps share one.
    points: Vec<usize>,
}

impl Grid {
    /// A row without a time stamp follows the one before it by a step. Unless one of the filters needs
    /// even steps, any step up to a gap will do.
    ///
    /// # Errors
    ///
    /// `uneven-stamps` (input) if a filter needs even steps.
    pub fn new(recording: &Recording, filters: &[Filter]) -> Result<Self> {
        let needs_even = filters.iter().any(|f| f.spec.needs_even_steps());
        let step_s = recording.clock.rate_hz().map_or(1.0, f64::recip);
        let stamps = recording.time_s.as_deref().unwrap_or_default();
        let whole_share = whole_share(stamps, step_s);
        let mut grid = Grid {
            starts: Vec::new(),
            points: Vec::with_capacity(recording.rows()),
        };
        // Steps between time stamps, and those that should be a whole number of usual ones and are not.
        let (mut count, mut uneven_count) = (0.0, 0.0);
        // The last stamp and its point.
        let mut last: Option<(f64, usize)> = None;
        for row in 0..recording.rows() {
            let before = grid.points.last().copied().unwrap_or(0);
            let stamp = stamps.get(row).copied().filter(|t| t.is_finite());
            let mut is_start = row == 0 || recording.breaks.binary_search(&row).is_ok();
            let mut point = before + 1;
            if let (false, Some(stamp), Some((last_s, at))) = (is_start, stamp, last) {
                let steps = (stamp - last_s) / step_s;
                let most = (GAP_STEPS + before - at) as f64;
                let is_even = is_whole(steps, whole_share) || (!needs_even && steps >= 0.0);
                count += 1.0;
                uneven_count += f64::from(!is_even && (0.0..=most).contains(&steps));
                is_start = !is_even || steps.round() > most;
                point = at.saturating_add(steps.round() as usize).max(before);
            }
            if is_start {
                grid.starts.push(row);
                (point, last) = (0, None);
            }
            grid.points.push(point);
            last = stamp.map(|stamp| (stamp, point)).or(last);
        }
        if uneven_count > MAX_UNEVEN * count {
            return Err(uneven(recording, uneven_count / count));
        }
        Ok(grid)
    }

    /// Rows of a channel between the starts and gaps of its samples; both ends are samples.
    pub fn stretches(&self, column: &[f64]) -> Vec<Range<usize>> {
        let mut stretches: Vec<Range<usize>> = Vec::new();
        let ends = self.starts.iter().skip(1).copied().chain([column.len()]);
        for (start, end) in self.starts.iter().copied().zip(ends) {
            let mut last: Option<usize> = None;
            for row in (start..end).filter(|row| column[*row].is_finite()) {
                let is_near = |point: usize| self.points[row] - point <= GAP_STEPS;
                match stretches.last_mut() {
                    Some(stretch) if last.is_some_and(is_near) => stretch.end = row + 1,
                    _ => stretches.push(row..row + 1),
                }
                last = Some(self.points[row]);
            }
        }
        stretches
    }

    /// Filters the samples of a channel in a stretch.
    pub fn filter(
        &self,
        filter: &Filter,
        stretch: &Range<usize>,
        column: &mut [f64],
        treatment: &mut Treatment,
    ) {
        // The ordinary case: a sample at each point.
        let follow = |two: &[usize]| two[1] == two[0] + 1;
        let is_whole = column[stretch.clone()].iter().all(|v| v.is_finite());
        if is_whole && self.points[stretch.clone()].windows(2).all(follow) {
            let samples = &mut column[stretch.clone()];
            if samples.len() < filter.shortest {
                treatment.too_short += samples.len();
            } else {
                treatment.replaced += filter.apply(samples);
            }
            return;
        }
        let rows = stretch.clone().filter(|row| column[*row].is_finite());
        let rows: Vec<usize> = rows.collect();
        let is_even = filter.spec.needs_even_steps();
        let mut samples: Vec<f64> = if is_even {
            self.interpolate(&rows, column)
        } else {
            rows.iter().map(|row| column[*row]).collect()
        };
        if rows.len().min(samples.len()) < filter.shortest {
            treatment.too_short += rows.len();
            return;
        }
        treatment.replaced += filter.apply(&mut samples);
        for (i, row) in rows.iter().enumerate() {
            let point = self.points[*row] - self.points[rows[0]];
            column[*row] = samples[if is_even { point } else { i }];
        }
    }

    /// Values at all points from the first row to the last: the mean of rows at one point, and
    /// between rows, where samples are lost, linear interpolation.
    fn interpolate(&self, rows: &[usize], column: &[f64]) -> Vec<f64> {
        let mut even: Vec<f64> = Vec::with_capacity(rows.len());
        for same in rows.chunk_by(|a, b| self.points[*a] == self.points[*b]) {
            let sum: f64 = same.iter().map(|row| column[*row]).sum();
            let value = sum / same.len() as f64;
            if let Some(&before) = even.last() {
                let steps = self.points[same[0]] - self.points[rows[0]] + 1 - even.len();
                let between =
                    (1..steps).map(|k| before + (value - before) * k as f64 / steps as f64);
                even.extend(between);
            }
            even.push(value);
        }
        even
    }
}

/// True if a number of steps is whole. Samples at one point must have equal time stamps.
fn is_whole(steps: f64, whole_share: f64) -> bool {
    let off = (steps - steps.round()).abs();
    steps >= 0.0
        && off <= whole_share * (1.0 + 1e-6)
        && (steps <= SAME_SHARE || steps.round() >= 1.0)
}

/// Share of a step within which steps are whole: wider where the resolution of the stamps is coarse (1e-3 s
/// if all are whole milliseconds).
fn whole_share(stamps: &[f64], step_s: f64) -> f64 {
    let first = stamps.iter().filter(|t| t.is_finite()).take(FIRST_STAMPS);
    let is_digit = |digit: &f64| {
        let off = |t: &f64| (t - digit * (t / digit).round()).abs();
        first.clone().all(|t| off(t) < 1e-4 * digit.min(step_s))
    };
    let digits = (0..=9).map(|digits| 10_f64.powi(-digits));
    let digit_s = digits.into_iter().find(is_digit).unwrap_or(0.0);
    WHOLE_SHARE.max((digit_s / step_s).min(MAX_WHOLE_SHARE))
}
