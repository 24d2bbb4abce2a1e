//! What the covariance says about ‖a‖ in any direction.

/// Directions over which the error is averaged.
const DIRECTIONS: usize = 400;

/// `n` directions spread evenly over the sphere (Fibonacci lattice).
pub fn sphere(n: usize) -> impl Iterator<Item = [f64; 3]> {
    let golden = std::f64::consts::PI * (3.0 - 5_f64.sqrt());
    (0..n).map(move |i| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / n as f64;
        let radius = (1.0 - z * z).sqrt();
        let (sine, cosine) = (golden * i as f64).sin_cos();
        [radius * cosine, radius * sine, z]
    })
}

/// How a small error of (M, b) moves the length along `n`: with u = M a + b and
/// A = M⁻¹ (`matrix`), an error (dM, db) moves the measured length along n by
/// −wᵀ(dM n g + db), w = Aᵀ n; so h = \[g w⊗n ; w\].
#[must_use]
pub fn sensitivity(matrix: &[[f64; 3]; 3], n: [f64; 3], gravity: f64) -> [f64; 12] {
    let w: [f64; 3] = std::array::from_fn(|i| (0..3).map(|k| matrix[k][i] * n[k]).sum());
    let mut h = [0.0; 12];
    for i in 0..3 {
        for j in 0..3 {
            h[3 * i + j] = gravity * w[i] * n[j];
        }
        h[9 + i] = w[i];
    }
    h
}

/// C h.
#[must_use]
pub fn times(covariance: &[[f64; 12]; 12], h: &[f64; 12]) -> [f64; 12] {
    covariance.map(|row| row.iter().zip(h).map(|(c, x)| c * x).sum())
}

/// hᵀ C h.
#[must_use]
pub fn variance(covariance: &[[f64; 12]; 12], h: &[f64; 12]) -> f64 {
    times(covariance, h).iter().zip(h).map(|(c, x)| c * x).sum()
}

/// Standard uncertainty of ‖a‖ at rest, root mean square over the sphere, m/s².
/// None when that is not a number.
#[must_use]
pub fn norm_error(
    matrix: &[[f64; 3]; 3],
    covariance: &[[f64; 12]; 12],
    gravity: f64,
) -> Option<f64> {
    let sum: f64 = sphere(DIRECTIONS)
        .map(|n| variance(covariance, &sensitivity(matrix, n, gravity)))
        .sum();
    let mean = sum / DIRECTIONS as f64;
    (mean.is_finite() && mean >= 0.0).then(|| mean.sqrt())
}

/// The direction in which ‖a‖ is known least, and its standard uncertainty
/// there, m/s².
#[must_use]
pub fn weakest(
    matrix: &[[f64; 3]; 3],
    covariance: &[[f64; 12]; 12],
    gravity: f64,
) -> ([f64; 3], f64) {
    let mut worst = ([0.0, 0.0, 1.0], f64::NEG_INFINITY);
    for n in sphere(DIRECTIONS) {
        let v = variance(covariance, &sensitivity(matrix, n, gravity));
        if v > worst.1 || v.is_nan() {
            worst = (n, v);
        }
    }
    (worst.0, worst.1.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_directions_are_spread_evenly() {
        let mut second = [[0.0; 3]; 3];
        for n in sphere(DIRECTIONS) {
            assert!((n.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
            for i in 0..3 {
                for j in 0..3 {
                    second[i][j] += n[i] * n[j] / DIRECTIONS as f64;
                }
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                let even = if i == j { 1.0 / 3.0 } else { 0.0 };
                assert!((second[i][j] - even).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn a_bias_alone_shows_whole_along_its_axis() {
        // sd 0.3 on one bias: ‖a‖ along n errs by 0.3 n_x, whose rms is 0.3/√3.
        let mut covariance = [[0.0; 12]; 12];
        covariance[9][9] = 0.09;
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let error = norm_error(&identity, &covariance, 9.81).unwrap();
        assert!((error - 0.3 / 3_f64.sqrt()).abs() < 1e-4);
    }
}
