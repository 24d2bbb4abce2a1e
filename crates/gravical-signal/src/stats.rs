//! Statistics used by several modules.

use std::ops::Range;

/// Median; the slice is reordered. `None` if empty.
pub fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let even = values.len().is_multiple_of(2);
    let middle = values.len() / 2;
    let (low, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let upper = *upper;
    Some(if even {
        0.5 * (low.iter().copied().fold(f64::NEG_INFINITY, f64::max) + upper)
    } else {
        upper
    })
}

/// Weighted median of pairs of value and weight, which are reordered; values that are not finite
/// are skipped. `None` without any.
pub fn weighted_median(pairs: &mut [(f64, f64)]) -> Option<f64> {
    pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let known = || pairs.iter().filter(|(value, _)| value.is_finite());
    let half = 0.5 * known().map(|(_, weight)| weight).sum::<f64>();
    let mut sum = 0.0;
    let middle = known().find(|(_, weight)| {
        sum += weight;
        sum >= half
    });
    middle.map(|(value, _)| *value)
}

/// Variance of rounding to these steps, all axes together.
pub fn floors(step: &[f64]) -> f64 {
    step.iter().map(|q| crate::rounding::floor(*q)).sum()
}

/// Mean of the values that are finite; NaN without any.
pub fn mean_of_finite<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    let finite = values.into_iter().filter(|v| v.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    sum / count
}

/// Root of the mean square; NaN without any value.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (squares, count) = values.fold((0.0, 0.0), |(sum, n), v| (sum + v * v, n + 1.0));
    (squares / count).sqrt()
}

/// Mean of each axis and the sum of the variances; empty cells are left out.
pub fn moments(channels: &[Vec<f64>; 3], rows: Range<usize>) -> ([f64; 3], f64) {
    let mut means = [f64::NAN; 3];
    let mut total = 0.0;
    for (axis, channel) in channels.iter().enumerate() {
        let values = || channel[rows.clone()].iter().filter(|v| v.is_finite());
        let mean = mean_of_finite(values());
        means[axis] = mean;
        let squares: f64 = values().map(|v| (v - mean).powi(2)).sum();
        let n = values().count() as f64;
        total += if n > 1.0 {
            squares / (n - 1.0)
        } else {
            f64::NAN
        };
    }
    (means, total)
}

/// √(Σ(x − mean of its interval)²/Σ(n − 1)) over the finite values of intervals; NaN unless one of
/// them has two.
pub fn pooled_deviation<'a>(intervals: impl Iterator<Item = &'a [f64]>) -> f64 {
    let (mut squares, mut freedom) = (0.0, 0.0);
    for interval in intervals {
        let values = || interval.iter().filter(|v| v.is_finite());
        let mean = mean_of_finite(values());
        squares += values().map(|v| (v - mean) * (v - mean)).sum::<f64>();
        freedom += (values().count() as f64 - 1.0).max(0.0);
    }
    (squares / freedom).sqrt()
}
