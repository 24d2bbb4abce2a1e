//! Uneven samples on an even grid, and back.
//!
//! If every step is a whole multiple of the usual one, the lost samples are added by linear
//! interpolation. Otherwise the samples are interpolated linearly to an even grid and the result
//! back to the time stamps. This alone smooths: white noise to 0.61 of its standard deviation if
//! the grid is midway between the samples. Samples with equal time stamps are averaged.

/// Steps that are whole multiples of the usual one within this share are due to lost samples;
/// others are uneven sampling.
pub(super) const WHOLE_SHARE: f64 = 0.25;
/// The same where the stamps are coarse: 1.5 steps are a lost sample.
const MAX_WHOLE_SHARE: f64 = 0.45;
/// Number of time stamps from which their resolution is determined.
const FIRST_STAMPS: usize = 2000;

/// Time stamps that differ by less than this share of the usual step are equal.
const SAME_SHARE: f64 = 0.01;

/// Where samples lie on an even grid.
pub(super) struct EvenGrid {
    /// Position of each sample, in steps of the grid.
    at: Vec<f64>,
    /// All samples are interpolated; otherwise only the lost ones.
    pub is_resampled: bool,
}

impl EvenGrid {
    /// For samples at these times, which ascend; `whole_share`: see [`whole_share`].
    pub fn new(step_s: f64, whole_share: f64, time_s: &[f64]) -> Self {
        let steps = || time_s.windows(2).map(|t| (t[1] - t[0]) / step_s);
        let is_resampled = !steps().all(|steps| is_on_grid(steps, whole_share));
        let at = if is_resampled {
            time_s.iter().map(|t| (t - time_s[0]) / step_s).collect()
        } else {
            let places = steps().scan(0.0, |place, step| {
                *place += step.round();
                Some(*place)
            });
            std::iter::once(0.0).chain(places).collect()
        };
        EvenGrid { at, is_resampled }
    }

    /// The samples are the points of the grid.
    pub fn is_even(&self) -> bool {
        let mut places = self.at.iter().enumerate();
        places.all(|(point, at)| *at == point as f64)
    }

    /// Number of points of the grid.
    pub fn len(&self) -> usize {
        self.at.last().map_or(0, |at| at.ceil() as usize + 1)
    }

    /// Points without a sample.
    pub fn lost(&self) -> usize {
        let distinct = self.at.chunk_by(|a, b| a == b).count();
        self.len().saturating_sub(distinct)
    }

    /// Values at the points of the grid; beyond the last sample its value.
    pub fn interpolate(&self, samples: &[f64]) -> Vec<f64> {
        let mut rest = samples;
        let means = self.at.chunk_by(|a, b| a == b).map(|same| {
            let (own, others) = rest.split_at(same.len());
            rest = others;
            (same[0], own.iter().sum::<f64>() / own.len() as f64)
        });
        let means: Vec<(f64, f64)> = means.collect();
        let mut next = 0;
        let value = |point: usize| {
            let at = point as f64;
            while next < means.len() && means[next].0 < at {
                next += 1;
            }
            match (next.checked_sub(1).map(|i| means[i]), means.get(next)) {
                (_, Some(&(there, value))) if there == at => value,
                (Some((from, a)), Some(&(to, b))) => a + (b - a) * (at - from) / (to - from),
                (Some((_, value)), None) | (None, Some(&(_, value))) => value,
                (None, None) => f64::NAN,
            }
        };
        (0..self.len()).map(value).collect()
    }

    /// Values of the grid at the samples.
    pub fn back(&self, even: &[f64]) -> Vec<f64> {
        let value = |at: &f64| {
            let (point, share) = (at.floor() as usize, at.fract());
            match even.get(point + 1) {
                Some(next) if share > 0.0 => even[point] + share * (next - even[point]),
                _ => even[point],
            }
        };
        self.at.iter().map(value).collect()
    }
}

/// True if a number of steps fits on the grid.
fn is_on_grid(steps: f64, whole_share: f64) -> bool {
    let off = (steps - steps.round()).abs();
    // Two samples with one index must have equal time stamps.
    off <= whole_share * (1.0 + 1e-6) && (steps <= SAME_SHARE || steps.round() >= 1.0)
}

/// Share of a step within which steps are whole: wider where the resolution of the stamps is coarse (1e-3 s
/// if all are whole milliseconds).
pub(super) fn whole_share(time_s: &[f64], step_s: f64) -> f64 {
    let first = time_s.iter().filter(|t| t.is_finite()).take(FIRST_STAMPS);
    let is_digit = |digit: &f64| {
        let off = |t: &f64| (t - digit * (t / digit).round()).abs();
        first.clone().all(|t| off(t) < 1e-4 * digit.min(step_s))
    };
    let digits = (0..=9).map(|digits| 10_f64.powi(-digits));
    let digit_s = digits.into_iter().find(is_digit).unwrap_or(0.0);
    WHOLE_SHARE.max((digit_s / step_s).min(MAX_WHOLE_SHARE))
}
