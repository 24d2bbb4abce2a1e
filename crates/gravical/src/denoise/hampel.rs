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

use crate::stats::SortedWindow;

/// 1/Φ⁻¹(3/4).
const FROM_MEDIAN: f64 = 1.482_602_218_505_602;
/// √(π/2).
const FROM_MEAN: f64 = 1.253_314_137_315_500_1;

/// `x` with its outliers replaced. A window that reaches beyond `x` is truncated.
pub(super) fn hampel(x: &[f64], window: usize, sigmas: f64) -> Vec<f64> {
    let half = window / 2;
    // The samples of the window, except the newest one.
    let mut sorted = SortedWindow::new(x.iter().copied().take(half));
    let filtered = x.iter().enumerate().map(|(i, &value)| {
        if let Some(sample) = x.get(i + half) {
            sorted.insert(*sample);
        }
        if let Some(old) = i.checked_sub(half + 1) {
            sorted.remove(x[old]);
        }
        let median = sorted.median().unwrap_or(f64::NAN);
        let off = (value - median).abs();
        // For most samples the first condition fails, so the spread is not computed.
        let is_outlier = off > 0.0 && off > sigmas * spread(&sorted, median);
        if is_outlier { median } else { value }
    });
    filtered.collect()
}

/// Robust standard deviation of a window.
fn spread(window: &SortedWindow, median: f64) -> f64 {
    let typical = window.median_deviation(median);
    if typical > 0.0 {
        return FROM_MEDIAN * typical;
    }
    let values = window.values();
    let sum = values.iter().map(|v| (v - median).abs()).sum::<f64>();
    FROM_MEAN * (sum / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::median;

    /// Computes the filter directly from its definition.
    fn by_definition(x: &[f64], window: usize, sigmas: f64) -> Vec<f64> {
        (0..x.len())
            .map(|i| {
                let part = &x[i.saturating_sub(window / 2)..(i + window / 2 + 1).min(x.len())];
                let middle = median(&mut part.to_vec()).unwrap();
                let mut off: Vec<f64> = part.iter().map(|v| (v - middle).abs()).collect();
                let mean = off.iter().sum::<f64>() / off.len() as f64;
                let typical = median(&mut off).unwrap();
                let s = if typical > 0.0 {
                    FROM_MEDIAN * typical
                } else {
                    FROM_MEAN * mean
                };
                if (x[i] - middle).abs() > sigmas * s {
                    middle
                } else {
                    x[i]
                }
            })
            .collect()
    }

    #[test]
    fn filter_equals_its_definition() {
        let mut state = 1_u32;
        let mut noise = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 16) / 65536.0 - 0.5
        };
        for coarse in [false, true] {
            let mut x: Vec<f64> = (0..300)
                .map(|i| 9.8 + 0.01 * f64::from(i) + noise())
                .collect();
            if coarse {
                x.iter_mut().for_each(|v| *v = (4.0 * *v).round() / 4.0);
            }
            for i in [0, 1, 40, 41, 150, 299] {
                x[i] += if i % 2 == 0 { 50.0 } else { -3.0 };
            }
            for (window, sigmas) in [(3, 3.0), (7, 3.0), (11, 2.0), (21, 0.0), (601, 3.0)] {
                let fast = hampel(&x, window, sigmas);
                assert_eq!(fast, by_definition(&x, window, sigmas), "{window} {sigmas}");
            }
        }
    }
}
