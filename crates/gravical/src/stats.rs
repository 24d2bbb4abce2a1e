//! Statistics used by several modules.

/// Median; the slice is reordered. `None` if empty.
pub(crate) fn median(values: &mut [f64]) -> Option<f64> {
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
pub(crate) fn weighted_median(pairs: &mut [(f64, f64)]) -> Option<f64> {
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

/// Sample standard deviation; NaN for fewer than two values.
pub(crate) fn standard_deviation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
}

/// Items evenly distributed over a stream of unknown length: every nth item is stored, n a power
/// of two, so that between half of `MOST` and `MOST` items of a long stream are stored.
#[derive(Debug, Clone)]
pub(crate) struct Thinned<T, const MOST: usize> {
    items: Vec<T>,
    stride: u64,
    number: u64,
}

impl<T, const MOST: usize> Default for Thinned<T, MOST> {
    fn default() -> Self {
        Thinned {
            items: Vec::new(),
            stride: 1,
            number: 0,
        }
    }
}

impl<T, const MOST: usize> Thinned<T, MOST> {
    /// Adds the next item, which is only computed if it is stored.
    #[inline]
    pub fn push_with(&mut self, item: impl FnOnce() -> T) {
        if self.keeps_next() {
            self.items.push(item());
            if self.items.len() >= MOST {
                self.thin();
            }
        }
        self.number += 1;
    }

    /// True if the next item will be stored.
    #[inline]
    pub fn keeps_next(&self) -> bool {
        // The stride is a power of two.
        self.number & (self.stride - 1) == 0
    }

    #[cold]
    fn thin(&mut self) {
        self.stride *= 2;
        let mut place = 0;
        self.items.retain(|_| {
            place += 1;
            place % 2 == 1
        });
    }

    /// Distance between stored items in the stream.
    pub fn stride(&self) -> u64 {
        self.stride
    }

    /// The stored items, in order.
    pub fn items(&self) -> &[T] {
        &self.items
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_of_few_values() {
        assert_eq!(median(&mut []), None);
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }

    #[test]
    fn long_streams_are_thinned_evenly() {
        for length in [3_u64, 15, 16, 1000, 4097] {
            let mut kept = Thinned::<u64, 16>::default();
            (0..length).for_each(|i| kept.push_with(|| i));
            let items = kept.items();
            assert!(
                items.len() < 16 && (length < 8 || items.len() >= 7),
                "{length}"
            );
            let stride = items[1] - items[0];
            assert!(items.windows(2).all(|w| w[1] - w[0] == stride), "{items:?}");
            assert!(length - 1 - items[items.len() - 1] < stride);
        }
    }
}
