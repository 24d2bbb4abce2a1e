//! Noise of a sensor at rest: the model of its Allan variance.
//!
//! ```text
//! σ²(τ) = N²/τ + (2 ln 2/π) B² + K²τ/3
//! ```
//!
//! (IEEE Std 952, annex C). It fails where noise is not stationary: vibration and drift with temperature
//! look like noise of the sensor.

mod fit;

use std::f64::consts::{LN_2, PI};

pub use fit::{NoiseFit, NoisePoints, TermEstimate, chi_square_factors, fit_noise};

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
    #[must_use]
    pub fn symbol(self) -> &'static str {
        ["N", "B", "K"][self as usize]
    }

    /// Its Allan variance at τ for a coefficient of 1.
    #[must_use]
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
}

impl NoiseModel {
    /// Parts of the Allan variance at τ.
    fn parts(&self, tau_s: f64) -> [f64; 3] {
        NoiseTerm::ALL.map(|term| self.squares[term as usize] * term.shape(tau_s))
    }

    /// Allan variance at τ.
    #[must_use]
    pub fn variance(&self, tau_s: f64) -> f64 {
        self.parts(tau_s).iter().sum()
    }

    /// Variance of the slope of the line fitted to a recording of noise of this model, 1/s².
    #[must_use]
    pub fn slope_variance(&self, duration_s: f64) -> f64 {
        let [n, b, k] = self.squares;
        let t = duration_s;
        12.0 * n / t.powi(3) + 9.0 / PI * b / t.powi(2) + 1.2 * k / t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power spectral density of a model, one-sided.
    fn density(model: &NoiseModel, hz: f64) -> f64 {
        let [n, b, k] = model.squares;
        2.0 * n + b / (PI * hz) + k / (2.0 * (PI * hz).powi(2))
    }

    /// ∫ f(x) dx from `low` to 10⁸ times it, in logarithmic steps.
    fn integral(low: f64, f: impl Fn(f64) -> f64) -> f64 {
        let steps = 400_000;
        let at = |k: i32| low * 1e8_f64.powf((f64::from(k) + 0.5) / f64::from(steps));
        let dx = 1e8_f64.ln() / f64::from(steps);
        (0..steps).map(|k| f(at(k)) * at(k) * dx).sum()
    }

    #[test]
    fn longer_averaging_times_have_fewer_degrees_of_freedom() {
        for term in NoiseTerm::ALL {
            let freedom = |m: u32| term.degrees_of_freedom(f64::from(m), 300.0);
            assert!((1..150).all(|m| freedom(m) >= freedom(m + 1)), "{term:?}");
        }
        // Of 20,000 simulated series of flicker noise: 258.
        assert!((NoiseTerm::B.degrees_of_freedom(1.0, 300.0) / 258.0 - 1.0).abs() < 0.03);
    }

    #[test]
    fn the_slope_of_noise_has_the_variance_of_its_density() {
        // ∫ S(f) |W(f)|² df with the weights 12 (t − T/2)/T³.
        let duration_s = 3.0;
        for squares in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let model = NoiseModel { squares };
            let found = integral(1e-4 / (PI * duration_s), |hz| {
                // |W| = 6 (sin x/x − cos x)/(x T), x = πfT; its cancellation ends at x²/3.
                let x = PI * hz * duration_s;
                let bracket = if x < 1e-2 {
                    x * x / 3.0
                } else {
                    x.sin() / x - x.cos()
                };
                let weight = 6.0 * bracket / (x * duration_s);
                density(&model, hz) * weight * weight
            });
            let variance = model.slope_variance(duration_s);
            assert!((found / variance - 1.0).abs() < 2e-3, "{found} {variance}");
        }
    }
}
