//! Simple statistics of columns.

/// Median of the finite values.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    middle(&mut values)
}

/// The upper one of two.
fn middle(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Shares of the steps that go up and down.
pub fn trend(values: &[f64]) -> (f64, f64) {
    let steps = values.len().max(2) as f64 - 1.0;
    let up = values.windows(2).filter(|w| w[1] > w[0]).count() as f64;
    let down = values.windows(2).filter(|w| w[1] < w[0]).count() as f64;
    (up / steps, down / steps)
}
