//! Single cells and simple statistics of a column.

/// Median of the finite values.
#[must_use]
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Shares of the steps that go up and down.
#[must_use]
pub fn trend(values: &[f64]) -> (f64, f64) {
    let steps = values.len().max(2) as f64 - 1.0;
    let up = values.windows(2).filter(|w| w[1] > w[0]).count() as f64;
    let down = values.windows(2).filter(|w| w[1] < w[0]).count() as f64;
    (up / steps, down / steps)
}

/// In a column of which more than a fifth is empty, a slower sensor, the last value holds.
/// True if it does.
pub fn hold_slow(column: &mut [f64]) -> bool {
    let is_slow = column.iter().filter(|v| v.is_nan()).count() * 5 > column.len();
    if is_slow {
        let mut last = f64::NAN;
        for v in column {
            if v.is_nan() {
                *v = last;
            } else {
                last = *v;
            }
        }
    }
    is_slow
}
