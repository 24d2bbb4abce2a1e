//! Hampel's outlier filter: a sample that deviates from the median of its window by more than a
//! number of robust standard deviations is replaced by that median.
//!
//! F. R. Hampel, "The influence curve and its role in robust estimation", JASA 69, 1974; as a
//! filter R. K. Pearson, IEEE Transactions on Control Systems Technology 10, 2002. The standard
//! deviation is 1.4826 times the median deviation from the median. If that is zero (more than
//! half of the window has one value, as with a coarse resolution), it is 1.2533 times the mean
//! deviation (Iglewicz and Hoaglin 1993): otherwise every other value would be an outlier.
//!
//! At the ends the window is truncated. Time stamps are not used.

use crate::stats::median;

/// 1/Φ⁻¹(3/4).
const FROM_MEDIAN: f64 = 1.482_602_218_505_602;
/// √(π/2).
const FROM_MEAN: f64 = 1.253_314_137_315_500_1;

/// `x` with its outliers replaced, and their number. A window that reaches beyond `x` is truncated.
pub(super) fn hampel(x: &[f64], window: usize, sigmas: f64) -> (Vec<f64>, usize) {
    let half = window / 2;
    let mut near = Vec::new();
    let mut replaced = 0;
    let filtered = x.iter().enumerate().map(|(i, &value)| {
        near.clear();
        near.extend_from_slice(&x[i.saturating_sub(half)..(i + half + 1).min(x.len())]);
        let middle = median(&mut near).unwrap_or(f64::NAN);
        let off = (value - middle).abs();
        // For most samples the first condition fails, so the spread is not computed.
        let is_outlier = off > 0.0 && off > sigmas * spread(&mut near, middle);
        replaced += usize::from(is_outlier);
        if is_outlier { middle } else { value }
    });
    (filtered.collect(), replaced)
}

/// Robust standard deviation of values, which become their distances from the median.
fn spread(values: &mut [f64], middle: f64) -> f64 {
    values.iter_mut().for_each(|v| *v = (*v - middle).abs());
    match median(values) {
        Some(typical) if typical > 0.0 => FROM_MEDIAN * typical,
        _ => FROM_MEAN * (values.iter().sum::<f64>() / values.len() as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::hampel;

    #[test]
    fn what_stands_out_becomes_the_median_of_its_window() {
        let mut x: Vec<f64> = (0..50).map(f64::from).collect();
        x[0] = 90.0;
        x[20] = -90.0;
        let (filtered, replaced) = hampel(&x, 7, 3.0);
        // The window of the first is truncated: 90, 1, 2, 3.
        assert_eq!((replaced, filtered[0], filtered[20]), (2, 2.5, 19.0));
        // More than half have one value: the mean deviation scales.
        let step = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!([6.0, 4.0].map(|sigmas| hampel(&step, 7, sigmas).1), [0, 1]);
        // Zero deviations are a median filter.
        assert_eq!(hampel(&[1.0, 5.0, 2.0], 3, 0.0).0, [3.0, 2.0, 3.5]);
    }
}
