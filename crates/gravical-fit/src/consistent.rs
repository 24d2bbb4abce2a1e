//! The one test of a difference by its covariance.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Below this probability chance is no explanation.
pub const SIGNIFICANCE: f64 = 0.01;

/// Eigenvalues of a covariance below this fraction of the largest count as zero. Rounding leaves
/// 1e-16; a well-placed session has 1e-7 between its best and worst direction.
const RANK_TOLERANCE: f64 = 1e-12;

/// Steps of the decomposition; it takes some tens, and never ends on some broken matrices.
pub(crate) const MAX_STEPS: usize = 10_000;

/// A difference held against its covariance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Test {
    /// dᵀ C⁺ d.
    pub chi2: f64,
    /// Rank of C: its degrees of freedom; 0 where there was nothing to test.
    pub degrees_of_freedom: usize,
    /// Probability that chance makes as much; 1 where there was nothing to test.
    pub p_value: f64,
}

impl Test {
    pub(crate) fn new(chi2: f64, rank: usize) -> Test {
        let tail = ChiSquared::new(rank as f64).map(|d| d.sf(chi2.max(0.0)));
        Test {
            chi2,
            degrees_of_freedom: rank,
            p_value: tail.unwrap_or(1.0).clamp(0.0, 1.0),
        }
    }
}

/// χ² of `difference` (n) by its `covariance` (n × n) whatever its rank: C⁺ is the pseudo-inverse,
/// so that what no reading determines is not tested. Components have to be of similar size. Rank 0
/// where the covariance is zero, not finite, or of another size.
pub fn consistent(difference: &DVector<f64>, covariance: &DMatrix<f64>) -> Test {
    let n = difference.len();
    let mut values = difference.iter().chain(covariance.iter());
    if n == 0 || covariance.shape() != (n, n) || !values.all(|v| v.is_finite()) {
        return Test::new(0.0, 0);
    }
    let symmetric = covariance * 0.5 + covariance.transpose() * 0.5;
    let Some(eigen) = SymmetricEigen::try_new(symmetric, f64::EPSILON, MAX_STEPS) else {
        return Test::new(0.0, 0);
    };
    let along = eigen.eigenvectors.tr_mul(difference);
    let least = RANK_TOLERANCE * eigen.eigenvalues.max();
    let parts = eigen.eigenvalues.iter().zip(along.iter());
    let kept = parts.filter(|(value, _)| **value > least.max(0.0));
    let (chi2, rank) = kept.fold((0.0, 0), |(chi2, rank), (value, part)| {
        (chi2 + part * part / value, rank + 1)
    });
    Test::new(chi2, rank)
}
