//! Polynomials without a constant, Σ c\[k\] x^(k+1), since a drift is zero at its reference.

/// Value at `x`.
///
/// ```
/// // 2 x + 3 x²
/// assert_eq!(gravical_fit::polynomial::evaluate(&[2.0, 3.0], 10.0), 320.0);
/// ```
#[inline]
pub fn evaluate(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| (sum + c) * x)
}

/// The same polynomial of x − `by`, less its value at x = `by`.
pub fn shift(coefficients: &[f64], by: f64) -> Vec<f64> {
    // Taylor's shift by repeated synthetic division.
    let mut c = vec![0.0];
    c.extend_from_slice(coefficients);
    for from in 0..c.len() {
        for k in (from..c.len() - 1).rev() {
            c[k] += by * c[k + 1];
        }
    }
    c.split_off(1)
}
