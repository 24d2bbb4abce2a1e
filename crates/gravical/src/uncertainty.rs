//! What a covariance says: the χ² of a difference whatever its rank, and the
//! variance of ‖a‖ at rest in one direction.

use gravical_core::matrix3;
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SymmetricEigen, Vector3};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::calibration_file::AccelerometerSection;

/// Accelerometer parameters: M row by row, then b.
pub type Covariance12 = [[f64; 12]; 12];

/// Eigenvalues of a covariance under this share of the largest are zero: the
/// data do not determine that direction. Rounding leaves 1e-16; a well-placed
/// session has 1e-7 between its best and worst direction.
const RANK_TOLERANCE: f64 = 1e-12;

/// A difference held against its covariance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChiSquare {
    /// dᵀ C⁺ d, C⁺ the pseudo-inverse.
    pub chi2: f64,
    /// Rank of C.
    pub degrees_of_freedom: u32,
    /// Degrees of freedom that C itself is estimated with; null where it counts as
    /// known.
    #[serde(default)]
    pub covariance_freedom: Option<f64>,
    /// Probability of a χ² at least as large when there is no difference; with an
    /// estimated C by the F distribution of χ² over its degrees of freedom.
    pub p_value: f64,
}

impl ChiSquare {
    /// "p = 0.31".
    #[doc(hidden)]
    #[must_use]
    pub fn probability(p_value: f64) -> String {
        if p_value < 1e-4 {
            return "p < 0.0001".to_owned();
        }
        format!("p = {p_value:.*}", if p_value < 0.095 { 4 } else { 2 })
    }

    /// The statistic as textbooks write it: "χ² = 10.5 with 9 degrees of freedom", and with an
    /// estimated C "F = 1.2 with 9 and 17 degrees of freedom".
    pub(crate) fn statistic(&self) -> String {
        let n = self.degrees_of_freedom;
        match self.covariance_freedom {
            Some(known_by) => format!(
                "F = {:.1} with {n} and {known_by:.0} degrees of freedom",
                self.chi2 / f64::from(n.max(1))
            ),
            None => {
                let s = if n == 1 { "" } else { "s" };
                format!("χ² = {:.1} with {n} degree{s} of freedom", self.chi2)
            }
        }
    }
}

/// χ² of `difference` by `covariance`, and the length of the part of the
/// difference in directions that the covariance calls certain (rank decision:
/// [`RANK_TOLERANCE`]); that part is not in χ². Both have to be scaled so that
/// their components compare. `covariance_freedom` as [`ChiSquare`] has it.
///
/// None when the covariance is zero or not finite.
pub(crate) fn chi_square(
    difference: &DVector<f64>,
    covariance: &DMatrix<f64>,
    covariance_freedom: Option<f64>,
) -> Option<(ChiSquare, f64)> {
    let finite = difference
        .iter()
        .chain(covariance.iter())
        .all(|v| v.is_finite());
    if !finite || difference.is_empty() {
        return None;
    }
    let symmetric = (covariance + covariance.transpose()) * 0.5;
    let eigen = SymmetricEigen::new(symmetric);
    let largest = eigen.eigenvalues.max();
    if largest <= 0.0 {
        return None;
    }
    let along = eigen.eigenvectors.transpose() * difference;
    let (mut chi2, mut rank, mut outside) = (0.0, 0_u32, 0.0);
    for (value, component) in eigen.eigenvalues.iter().zip(along.iter()) {
        if *value > RANK_TOLERANCE * largest {
            chi2 += component * component / value;
            rank += 1;
        } else {
            outside += component * component;
        }
    }
    let p_value = upper_tail(chi2, f64::from(rank), covariance_freedom)?;
    let test = ChiSquare {
        chi2,
        degrees_of_freedom: rank,
        covariance_freedom,
        p_value,
    };
    Some((test, outside.sqrt()))
}

/// P(χ² ≥ `chi2`), or with the scale of the covariance known by `covariance_freedom`
/// degrees of freedom P(F ≥ `chi2`/`degrees_of_freedom`).
pub(crate) fn upper_tail(
    chi2: f64,
    degrees_of_freedom: f64,
    covariance_freedom: Option<f64>,
) -> Option<f64> {
    let p = match covariance_freedom {
        Some(known_by) => FisherSnedecor::new(degrees_of_freedom, known_by)
            .ok()?
            .sf(chi2 / degrees_of_freedom),
        None => ChiSquared::new(degrees_of_freedom).ok()?.sf(chi2),
    };
    Some(p.clamp(0.0, 1.0))
}

/// Degrees of freedom of a sum of variances, each with its own; none where all of it
/// is known (Welch and Satterthwaite, JCGM 100:2008, G.4).
pub(crate) fn freedom_of_sum(parts: &[(f64, Option<f64>)]) -> Option<f64> {
    let all: f64 = parts.iter().map(|(variance, _)| variance).sum();
    let weighed: f64 = parts
        .iter()
        .filter_map(|(variance, freedom)| Some((variance / all).powi(2) / (*freedom)?))
        .sum();
    Some(1.0 / weighed).filter(|nu| nu.is_finite() && *nu > 0.0)
}

/// What turning the board in its case leaves alone: the lengths of the rows of M
/// (scale), the cosines between them (xy, yz, zx), and b.
pub(crate) fn invariants(m: &[[f64; 3]; 3], b: &[f64; 3]) -> [f64; 9] {
    let k = matrix3::row_norms(m);
    let cosine = |p: usize, q: usize| matrix3::dot(&m[p], &m[q]) / (k[p] * k[q]);
    [
        k[0],
        k[1],
        k[2],
        cosine(0, 1),
        cosine(1, 2),
        cosine(2, 0),
        b[0],
        b[1],
        b[2],
    ]
}

/// Derivatives of [`invariants`] by row-major M and b. That of a cosine is also
/// the derivative of the angle, in rad, but for its sign.
pub(crate) fn invariant_derivatives(m: &[[f64; 3]; 3]) -> [[f64; 12]; 9] {
    let k = matrix3::row_norms(m);
    let r = matrix3::scale_rows(m, &k.map(|k| 1.0 / k));
    let mut out = [[0.0; 12]; 9];
    for i in 0..3 {
        out[i][3 * i..3 * i + 3].copy_from_slice(&r[i]);
        let (p, q) = (i, (i + 1) % 3);
        let cosine = matrix3::dot(&r[p], &r[q]);
        for a in 0..3 {
            out[3 + i][3 * p + a] = (r[q][a] - cosine * r[p][a]) / k[p];
            out[3 + i][3 * q + a] = (r[p][a] - cosine * r[q][a]) / k[q];
        }
        out[6 + i][9 + i] = 1.0;
    }
    out
}

/// The second-order part of how ‖a‖ at rest along `n` follows errors d of the
/// parameters, d ↦ dᵀ Q d; the first is [`crate::predicted::sensitivity`].
///
/// With x = A (dM a + db) and a = g n the calibrated vector moves by
/// −x + A dM x, and its length to second order by
/// nᵀ A dM x + (‖x‖² − (nᵀx)²)/2g. A tilt of 2.4° makes 10 mm/s² of it, more than
/// the noise of a mean, and first order knows nothing of it.
pub(crate) fn norm_curvature(
    matrix: &[[f64; 3]; 3],
    n: [f64; 3],
    gravity: f64,
) -> SMatrix<f64, 12, 12> {
    let a = Matrix3::from_fn(|r, c| matrix[r][c]);
    let n = Vector3::from(n);
    // The bilinear form behind it, on unit vectors of the parameters.
    let parts: [(Matrix3<f64>, Vector3<f64>); 12] = std::array::from_fn(|i| {
        let (mut dm, mut db) = (Matrix3::zeros(), Vector3::zeros());
        if i < 9 {
            dm[(i / 3, i % 3)] = 1.0;
        } else {
            db[i - 9] = 1.0;
        }
        (dm, a * (dm * n * gravity + db))
    });
    let product = |(dm, x): &(Matrix3<f64>, Vector3<f64>), other: &Vector3<f64>| {
        n.dot(&(a * dm * other)) + 0.5 / gravity * (x.dot(other) - n.dot(x) * n.dot(other))
    };
    SMatrix::from_fn(|i, j| {
        0.5 * (product(&parts[i], &parts[j].1) + product(&parts[j], &parts[i].1))
    })
}

/// What gravity that is known to `sd_mps2` only does to the parameters: M is
/// fitted in proportion to 1/g and b does not depend on it, so (σ/g)² times the
/// outer product of M's elements. No placement can lower it.
pub(crate) fn of_gravity(model: &[[f64; 3]; 3], sd_mps2: f64, gravity: f64) -> Covariance12 {
    let share = (sd_mps2 / gravity).powi(2);
    let element = |i: usize| if i < 9 { model[i / 3][i % 3] } else { 0.0 };
    std::array::from_fn(|i| std::array::from_fn(|j| share * element(i) * element(j)))
}

/// The sum of two covariances, element by element.
pub(crate) fn sum(a: &Covariance12, b: &Covariance12) -> Covariance12 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

/// The covariance of a file by its readings alone: without what the gravity of
/// the session adds. For what happens in the same place, with the same error of
/// gravity.
pub(crate) fn covariance_at_its_gravity(
    section: &AccelerometerSection,
    gravity: f64,
) -> Option<Covariance12> {
    let all = covariance_of(section)?;
    let model = matrix3::inverse(&section.matrix)?;
    let own = of_gravity(&model, section.gravity_sd_mps2, gravity);
    Some(std::array::from_fn(|i| {
        std::array::from_fn(|j| all[i][j] - own[i][j])
    }))
}

/// The covariance of M and b in a file as numbers; none where it is absent, of another
/// size, not finite or zero throughout.
pub fn covariance_of(section: &AccelerometerSection) -> Option<Covariance12> {
    let values = &section.covariance.as_ref()?.values;
    if values.len() < 12 || values.iter().any(|row| row.len() < 12) {
        return None;
    }
    let all = || values.iter().flatten();
    let usable = all().all(|v| v.is_finite()) && all().any(|v| *v != 0.0);
    usable.then(|| std::array::from_fn(|r| std::array::from_fn(|c| values[r][c])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chi_square_of_independent_components() {
        let d = DVector::from_vec(vec![2.0, 3.0]);
        let c = DMatrix::from_diagonal(&DVector::from_vec(vec![4.0, 9.0]));
        let (test, outside) = chi_square(&d, &c, None).unwrap();
        assert!((test.chi2 - 2.0).abs() < 1e-12);
        assert_eq!(test.degrees_of_freedom, 2);
        // Two degrees of freedom: e^(−χ²/2).
        assert!((test.p_value - (-1.0_f64).exp()).abs() < 1e-9);
        assert!(outside < 1e-12);
    }

    #[test]
    fn a_certain_direction_is_told_and_not_divided_by() {
        // Variance only along (1, 1)/√2.
        let c = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        let d = DVector::from_vec(vec![1.0, 0.0]);
        let (test, outside) = chi_square(&d, &c, None).unwrap();
        assert_eq!(test.degrees_of_freedom, 1);
        assert!((test.chi2 - 0.25).abs() < 1e-12, "{}", test.chi2);
        assert!((outside - 0.5_f64.sqrt()).abs() < 1e-12);
        assert!(chi_square(&d, &DMatrix::zeros(2, 2), None).is_none());
    }

    #[test]
    fn the_tail_of_chi_square_as_in_tables() {
        for (chi2, freedom, p) in [
            (6.635, 1.0, 0.01),
            (16.919, 9.0, 0.05),
            (26.217, 12.0, 0.01),
        ] {
            let got = upper_tail(chi2, freedom, None).unwrap();
            assert!((got - p).abs() < 1e-5, "{got}");
        }
        // F of 3 and 10 degrees of freedom: 6.552 at 1 %.
        let got = upper_tail(3.0 * 6.552, 3.0, Some(10.0)).unwrap();
        assert!((got - 0.01).abs() < 1e-5, "{got}");
    }

    #[test]
    fn the_sensitivity_is_the_derivative() {
        let m = [[1.02, 0.01, -0.02], [0.0, 0.97, 0.03], [-0.01, 0.02, 1.01]];
        let b = [0.3, -0.2, 0.1];
        let (n, g) = ([0.48, -0.6, 0.64], 9.81);
        let a = gravical_core::matrix3::inverse(&m).unwrap();
        // What is read along n, calibrated with parameters that are off by dθ.
        let length = |theta: usize, step: f64| {
            let (mut m2, mut b2) = (m, b);
            if theta < 9 {
                m2[theta / 3][theta % 3] += step;
            } else {
                b2[theta - 9] += step;
            }
            let a2 = gravical_core::matrix3::inverse(&m2).unwrap();
            let off: [f64; 3] = std::array::from_fn(|i| {
                (0..3).map(|j| m[i][j] * g * n[j]).sum::<f64>() + b[i] - b2[i]
            });
            let c = gravical_core::matrix3::mul_vec(&a2, &off);
            gravical_core::matrix3::norm(&c)
        };
        let h = crate::predicted::sensitivity(&a, n, g);
        let q = norm_curvature(&a, n, g);
        for theta in 0..12 {
            let slope = (length(theta, 1e-6) - length(theta, -1e-6)) / 2e-6;
            assert!(
                (slope + h[theta]).abs() < 1e-5,
                "{theta}: {slope} {}",
                h[theta]
            );
            // f(d) + f(−d) − 2 f(0) = 2 d² Q.
            let step = 1e-4;
            let curve =
                (length(theta, step) + length(theta, -step) - 2.0 * g) / (2.0 * step * step);
            assert!(
                (curve - q[(theta, theta)]).abs() < 1e-4,
                "{theta}: {curve} {}",
                q[(theta, theta)]
            );
        }
    }
}
