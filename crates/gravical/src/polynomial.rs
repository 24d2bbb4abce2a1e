//! Polynomials without a constant, Σ c\[k\] x^(k+1), since a drift is zero at its reference.

/// Value at `x`.
///
/// ```
/// // 2 x + 3 x²
/// assert_eq!(gravical::temperature::evaluate(&[2.0, 3.0], 10.0), 320.0);
/// ```
#[must_use]
#[inline]
pub fn evaluate(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| (sum + c) * x)
}

/// The same polynomial in x' = x − `by`: its value at x = `by`, and the coefficients of the rest.
fn shifted(coefficients: &[f64], by: f64) -> (f64, Vec<f64>) {
    // Taylor's shift by repeated synthetic division.
    let mut c = vec![0.0];
    c.extend_from_slice(coefficients);
    let n = c.len();
    for from in 0..n {
        for k in (from..n - 1).rev() {
            c[k] += by * c[k + 1];
        }
    }
    let rest = c.split_off(1);
    (c[0], rest)
}

/// Drift and gain relative to a reference that is `by` °C warmer.
///
/// raw = drift + (1 + gain) · u, with u the reading at the reference. With u' the reading at the
/// new one, u = (u' − drift₁)/(1 + gain₁), so that gain' = (gain − gain₁)/(1 + gain₁) and drift'
/// = drift − drift₁ (1 + gain'): polynomials of the same order.
pub(crate) fn about(drift: &[f64], gain: &[f64], by: f64) -> (Vec<f64>, Vec<f64>) {
    let (drift_1, mut drift) = shifted(drift, by);
    let (gain_1, mut gain) = shifted(gain, by);
    for c in &mut gain {
        *c /= 1.0 + gain_1;
    }
    for (c, g) in drift.iter_mut().zip(&gain) {
        *c -= drift_1 * g;
    }
    (drift, gain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_leaves_values_unchanged() {
        let c = [0.3, -0.02, 0.001];
        let (at, rest) = shifted(&c, 7.0);
        assert!((at - evaluate(&c, 7.0)).abs() < 1e-12);
        for x in [-20.0, 0.0, 3.5, 40.0] {
            let there = at + evaluate(&rest, x - 7.0);
            assert!((there - evaluate(&c, x)).abs() < 1e-12, "{x}");
        }
        assert_eq!(shifted(&[], 3.0), (0.0, vec![]));
    }

    #[test]
    fn a_change_of_reference_leaves_readings_unchanged() {
        let (drift, gain) = ([0.02, -1e-4, 2e-6], [3e-4, 1e-6, 0.0]);
        let raw = |u: f64, x: f64| evaluate(&drift, x) + (1.0 + evaluate(&gain, x)) * u;
        let (drift_2, gain_2) = about(&drift, &gain, 12.0);
        for u in [-9.8, 0.0, 9.8] {
            let u_2 = raw(u, 12.0);
            for x in [-30.0, 0.0, 12.0, 50.0] {
                let again =
                    evaluate(&drift_2, x - 12.0) + (1.0 + evaluate(&gain_2, x - 12.0)) * u_2;
                assert!((again - raw(u, x)).abs() < 1e-12, "{u} {x}");
            }
        }
    }
}
