//! The model of the Allan variance of a sensor at rest.
//!
//! ```text
//! σ²(τ) = N²/τ + (2 ln 2/π) B² + K²τ/3
//! ```
//!
//! (IEEE Std 952, annex C). It fails where noise is not stationary: vibration and drift with temperature
//! look like noise of the sensor.

use std::f64::consts::{LN_2, PI};

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// A term of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseTerm {
    /// White noise: noise density N
    N,
    /// Flicker noise: bias instability B
    B,
    /// Random walk K
    K,
}

impl NoiseTerm {
    /// All terms, in the order of arrays.
    pub const ALL: [NoiseTerm; 3] = [NoiseTerm::N, NoiseTerm::B, NoiseTerm::K];

    /// Its letter.
    pub fn symbol(self) -> &'static str {
        ["N", "B", "K"][self as usize]
    }

    /// Its Allan variance at τ for a coefficient of 1.
    pub fn shape(self, tau_s: f64) -> f64 {
        shapes(tau_s)[self as usize]
    }
}

/// Allan variances of N, B and K of 1 at τ, and what a low-pass adds to them.
pub(super) fn shapes(tau_s: f64) -> [f64; 4] {
    [1.0 / tau_s, 2.0 * LN_2 / PI, tau_s / 3.0, tau_s.powi(-2)]
}

/// Coefficients of the Allan variance: N², B², K², and e over τ², with e < 0: what a low-pass takes from the
/// ends of a mean.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NoiseModel(pub [f64; 4]);

impl NoiseModel {
    /// White noise of N = 1.
    pub const WHITE: NoiseModel = NoiseModel([1.0, 0.0, 0.0, 0.0]);

    /// Parts of the Allan variance at τ.
    pub(super) fn parts(&self, tau_s: f64) -> [f64; 4] {
        let shapes = shapes(tau_s);
        std::array::from_fn(|i| self.0[i] * shapes[i])
    }

    /// Allan variance at τ.
    pub fn variance(&self, tau_s: f64) -> f64 {
        self.parts(tau_s).iter().sum()
    }
}

/// Equivalent degrees of freedom of the overlapping Allan variance over `m` of `samples` if the noise is that
/// of N, B or K (NIST SP 1065, table 5; copies of it lack the square of flicker noise at m = 1).
pub(super) fn degrees_of_freedom(m: f64, samples: f64) -> [f64; 3] {
    let n = samples + 1.0;
    let overlap = 4.0 * m * m / (4.0 * m * m + 5.0);
    let white = (1.5 * (n - 1.0) / m - 2.0 * (n - 2.0) / n) * overlap;
    let flicker = match m {
        1.0 => 2.0 * (n - 2.0).powi(2) / (2.3 * n - 4.9),
        _ => 1.25 * n * n / (m * (n + 3.0 * m)),
    };
    let squares = (n - 1.0).powi(2) - 3.0 * m * (n - 1.0) + 4.0 * m * m;
    let walk = match n {
        3.0 => 1.0,
        _ => (n - 2.0) / m * squares / (n - 3.0).powi(2),
    };
    [white, flicker, walk].map(|freedom| freedom.max(1.0))
}

/// Correlations of Allan variances at averaging times so many octaves apart, of noise of N, B and K. In a
/// long recording each is the integral of the squared covariance of the second differences, which depends
/// on the ratio of the times alone; these closed forms are right to 0.01.
pub(super) fn correlations(octaves: f64) -> [f64; 3] {
    if octaves == 0.0 {
        return [1.0; 3];
    }
    let power = |exponent: f64| 2_f64.powf(-exponent * octaves);
    let flicker = 2.9 * power(1.5) - 2.1 * power(2.65);
    [
        1.5 * power(1.5),
        flicker,
        1.39 * power(0.5) - 0.38 * power(2.0),
    ]
}

/// Ends of the 95 % interval of a standard deviation with these degrees of freedom, over its
/// estimate; `None` without any freedom.
pub(super) fn chi_square_factors(freedom: f64) -> Option<[f64; 2]> {
    // Beyond that the quantile is the normal one to six digits, and its iteration slow.
    if freedom > 1e5 {
        let half = 1.959_964 / (2.0 * freedom).sqrt();
        return Some([1.0 - half, 1.0 + half]);
    }
    let chi2 = ChiSquared::new(freedom).ok()?;
    let factor = |p: f64| (freedom / chi2.inverse_cdf(p)).sqrt();
    Some([factor(0.975), factor(0.025)])
}
