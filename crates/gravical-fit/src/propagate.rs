//! Covariance of a value by the errors of what it is computed from.

use nalgebra::{DMatrix, DVector};

/// Covariance of a value by `errors` independent errors: `value` takes the number of one of them and a
/// step in its standard deviations, `here` is the value without a step.
///
/// With slopes s_k and curves q_k from steps of ±1 it is Σ s_k s_kᵀ + 2 Σ q_k q_kᵀ + (Σ q_k)(Σ q_k)ᵀ: a
/// frame known to 2° lengthens a reading by 0.06 %, of which slopes know nothing. None where the value
/// does not exist after a step.
pub fn propagate(
    here: &DVector<f64>,
    errors: usize,
    value: impl Fn(usize, f64) -> Option<DVector<f64>>,
) -> Option<DMatrix<f64>> {
    let mut covariance = DMatrix::zeros(here.len(), here.len());
    let mut curved = DVector::zeros(here.len());
    for k in 0..errors {
        let (up, down) = (value(k, 1.0)?, value(k, -1.0)?);
        let slope = (&up - &down) / 2.0;
        let curve = (up + down) / 2.0 - here;
        covariance += &slope * slope.transpose() + &curve * curve.transpose() * 2.0;
        curved += curve;
    }
    covariance += &curved * curved.transpose();
    Some(covariance)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean square of x² − 0 for a standard normal x is 3, a variance of 2 and a mean of 1.
    #[test]
    fn a_square_has_the_moments_of_chi_square() {
        let square = |_, x: f64| Some(DVector::from_element(1, x * x));
        let moment = propagate(&DVector::zeros(1), 1, square).unwrap();
        assert_eq!(moment[(0, 0)], 3.0);
    }
}
