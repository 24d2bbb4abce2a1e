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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_leaves_differences_unchanged() {
        let c = [0.3, -0.02, 0.001];
        let shifted = shift(&c, 7.0);
        for x in [-20.0, 0.0, 3.5, 40.0] {
            let value = evaluate(&c, 7.0) + evaluate(&shifted, x - 7.0);
            assert!((value - evaluate(&c, x)).abs() < 1e-12, "{x}");
        }
        assert!(shift(&[], 3.0).is_empty());
    }
}
