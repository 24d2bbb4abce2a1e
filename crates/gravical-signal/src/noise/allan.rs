//! Overlapping Allan variance.

use serde::{Deserialize, Serialize};

use super::model::{NoiseModel, chi_square_factors, correlations, degrees_of_freedom};

/// An Allan variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AllanVariance {
    /// Averaging time, s
    pub tau_s: f64,
    /// Allan variance, in the unit of the samples squared
    pub variance: f64,
    /// Equivalent degrees of freedom if the noise were that of one term: N, B, K
    pub freedom: [f64; 3],
}

impl AllanVariance {
    /// Over `m` samples in segments of these lengths.
    pub(super) fn new(m: usize, period_s: f64, variance: f64, lengths: &[usize]) -> Self {
        let fitting = lengths.iter().filter(|n| **n >= 2 * m);
        let each = fitting.map(|n| degrees_of_freedom(m as f64, *n as f64));
        AllanVariance {
            tau_s: m as f64 * period_s,
            variance,
            freedom: std::array::from_fn(|term| each.clone().map(|n| n[term]).sum()),
        }
    }

    /// The Allan deviation, distributed as under a model; `None` without any degrees of freedom.
    pub fn point(&self, model: &NoiseModel) -> Option<AllanPoint> {
        let [n, b, k, _] = model.parts(self.tau_s);
        let edf = 2.0 * ((n + b + k) / self.deviation(model, 0.0)).powi(2);
        let sigma = self.variance.sqrt();
        let [low, high] = chi_square_factors(edf)?.map(|factor| sigma * factor);
        sigma.is_finite().then_some(AllanPoint {
            tau_s: self.tau_s,
            sigma,
            low,
            high,
            edf,
        })
    }

    /// Standard deviation under a model, as far as it is common to a point so many octaves away. Each
    /// term adds to the second differences by itself, so that deviations add.
    pub(super) fn deviation(&self, model: &NoiseModel, octaves: f64) -> f64 {
        let (parts, common) = (model.parts(self.tau_s), correlations(octaves));
        let each = (0..3).map(|i| parts[i] * (2.0 / self.freedom[i] * common[i]).sqrt());
        each.sum()
    }
}

/// A point of the Allan deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AllanPoint {
    /// Averaging time, s.
    pub tau_s: f64,
    /// Allan deviation.
    pub sigma: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// Equivalent degrees of freedom of its square.
    pub edf: f64,
}

/// Overlapping Allan variances of evenly spaced samples, `period_s` apart, for averaging times in octaves,
/// as long as two of them fit into a segment.
///
/// With phases θ_k, the sums of the samples before the k-th,
///
/// ```text
/// σ²(m) = 1/(2 m² n) Σ (θ_{k+2m} − 2 θ_{k+m} + θ_k)²
/// ```
///
/// over all n places k (W. J. Riley, NIST Special Publication 1065, 2008, equation 11). Segments are
/// separated by gaps; no difference is taken across one, and their terms are pooled.
///
/// ```
/// use gravical_signal::allan_variances;
///
/// let variances = allan_variances(&[[1.0, 2.0, 1.0, 2.0, 1.0]], 1.0);
/// let variances: Vec<f64> = variances.iter().map(|v| v.variance).collect();
/// assert_eq!(variances, [0.5, 0.0]);
/// ```
pub fn allan_variances(segments: &[impl AsRef<[f64]>], period_s: f64) -> Vec<AllanVariance> {
    let phases: Vec<Vec<f64>> = segments.iter().map(|s| phases(s.as_ref())).collect();
    let lengths: Vec<usize> = segments.iter().map(|s| s.as_ref().len()).collect();
    let variance = |m: usize| {
        let (mut terms, mut squares) = (0, 0.0);
        for phases in phases.iter().filter(|phases| phases.len() > 2 * m) {
            let triples = phases.iter().zip(&phases[m..]).zip(&phases[2 * m..]);
            terms += triples.len();
            squares += triples
                .map(|((a, b), c)| (c - 2.0 * b + a).powi(2))
                .sum::<f64>();
        }
        let variance = squares / (2.0 * (m as f64).powi(2) * terms as f64);
        (terms > 0).then(|| AllanVariance::new(m, period_s, variance, &lengths))
    };
    (0..).map_while(|octave| variance(1 << octave)).collect()
}

/// Sums of the samples before each one, less the first sample so that they stay small.
fn phases(samples: &[f64]) -> Vec<f64> {
    let reference = samples.first().copied().unwrap_or(0.0);
    let sums = samples.iter().scan(0.0, |sum, value| {
        *sum += value - reference;
        Some(*sum)
    });
    std::iter::once(0.0).chain(sums).collect()
}
