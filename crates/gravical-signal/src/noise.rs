//! Noise of a sensor at rest: the model of its Allan variance.
//!
//! ```text
//! σ²(τ) = N²/τ + (2 ln 2/π) B² + K²τ/3
//! ```
//!
//! (IEEE Std 952, annex C). It fails where noise is not stationary: vibration and drift with temperature
//! look like noise of the sensor.

mod fit;
mod trend;

use std::f64::consts::{LN_2, PI};

pub use fit::{NoiseFit, NoisePoints, TermEstimate, chi_square_factors, fit_noise};
pub use trend::{Slow, Trend, find_slow};

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
        match self {
            NoiseTerm::N => 1.0 / tau_s,
            NoiseTerm::B => 2.0 * LN_2 / PI,
            NoiseTerm::K => tau_s / 3.0,
        }
    }

    /// Equivalent degrees of freedom of its overlapping Allan variance over `m` of `samples` (NIST
    /// SP 1065, table 5; copies of it lack the square of flicker noise at m = 1).
    fn degrees_of_freedom(self, m: f64, samples: f64) -> f64 {
        let n = samples + 1.0;
        let freedom = match self {
            NoiseTerm::N => {
                let overlap = 4.0 * m * m / (4.0 * m * m + 5.0);
                (1.5 * (n - 1.0) / m - 2.0 * (n - 2.0) / n) * overlap
            }
            NoiseTerm::B if m == 1.0 => 2.0 * (n - 2.0).powi(2) / (2.3 * n - 4.9),
            NoiseTerm::B => 1.25 * n * n / (m * (n + 3.0 * m)),
            NoiseTerm::K if n > 3.0 => {
                let squares = (n - 1.0).powi(2) - 3.0 * m * (n - 1.0) + 4.0 * m * m;
                (n - 2.0) / m * squares / (n - 3.0).powi(2)
            }
            NoiseTerm::K => 1.0,
        };
        freedom.max(1.0)
    }

    /// Correlation of its Allan variances at averaging times so many octaves apart. In a long
    /// recording it is the integral of the squared covariance of the second differences, which
    /// depends on the ratio of the times alone; these closed forms are right to 0.01.
    fn correlation(self, octaves: f64) -> f64 {
        if octaves == 0.0 {
            return 1.0;
        }
        let power = |exponent: f64| 2_f64.powf(-exponent * octaves);
        match self {
            NoiseTerm::N => 1.5 * power(1.5),
            NoiseTerm::B => 2.9 * power(1.5) - 2.1 * power(2.65),
            NoiseTerm::K => 1.39 * power(0.5) - 0.38 * power(2.0),
        }
    }
}

/// Squares of N, B and K.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NoiseModel {
    /// N², B², K²
    pub squares: [f64; 3],
    /// What a low-pass takes from the ends of a mean: σ² gains this over τ²
    pub edge: f64,
}

impl NoiseModel {
    /// White noise of N = 1.
    pub const WHITE: NoiseModel = NoiseModel {
        squares: [1.0, 0.0, 0.0],
        edge: 0.0,
    };

    /// Parts of the Allan variance at τ.
    fn parts(&self, tau_s: f64) -> [f64; 3] {
        NoiseTerm::ALL.map(|term| self.squares[term as usize] * term.shape(tau_s))
    }

    /// Allan variance at τ.
    pub fn variance(&self, tau_s: f64) -> f64 {
        self.parts(tau_s).iter().sum::<f64>() + self.edge / tau_s.powi(2)
    }
}
