//! Overlapping Allan variance.

/// An Allan variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AllanVariance {
    /// Averaging time, samples
    pub m: usize,
    /// Allan variance, in the unit of the samples squared
    pub variance: f64,
}

/// Overlapping Allan variances of evenly spaced samples for averaging times of `m` samples; times that
/// fit into no segment are left out.
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
/// let variances = allan_variances(&[&[1.0, 2.0, 1.0, 2.0, 1.0]], &[1, 2, 3]);
/// let variances: Vec<f64> = variances.iter().map(|v| v.variance).collect();
/// assert_eq!(variances, [0.5, 0.0]);
/// ```
pub fn allan_variances(segments: &[impl AsRef<[f64]>], m: &[usize]) -> Vec<AllanVariance> {
    let mut sums = vec![(0, 0.0); m.len()];
    for segment in segments {
        let phases = phases(segment.as_ref());
        for (m, (terms, squares)) in m.iter().zip(&mut sums) {
            if *m > 0 && phases.len() > 2 * m {
                *terms += phases.len() - 2 * m;
                *squares += sum_of_squares(&phases, *m);
            }
        }
    }
    let fitting = m.iter().zip(sums).filter(|(_, (terms, _))| *terms > 0);
    let variances = fitting.map(|(m, (terms, squares))| AllanVariance {
        m: *m,
        variance: squares / (2.0 * (*m as f64).powi(2) * terms as f64),
    });
    variances.collect()
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

fn sum_of_squares(phases: &[f64], m: usize) -> f64 {
    let pairs = phases.iter().zip(&phases[m..]);
    let triples = pairs.zip(&phases[2 * m..]);
    triples.map(|((a, b), c)| (c - 2.0 * b + a).powi(2)).sum()
}
