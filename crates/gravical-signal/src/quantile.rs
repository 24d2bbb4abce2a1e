//! Quantiles.

/// The value that a fraction `q`, 0 to 1, of all is at most, the lower one of two; 0 without values. What is no number
/// is last.
pub fn quantile(mut values: Vec<f64>, q: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let k = ((values.len() - 1) as f64 * q) as usize;
    *values.select_nth_unstable_by(k, f64::total_cmp).1
}
