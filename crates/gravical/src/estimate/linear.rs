//! `linear12`: straight least squares with the directions taken as exact.
//!
//! # The model
//!
//! u_k = M g n_k + b with n_k known: twelve parameters, four for each channel,
//! and each channel on its own. The classical fit of a precise fixture. On a
//! table it is the worst of all: a placement that is tilted by 1° moves the bias
//! by 6 mg, since nothing says that it may be tilted (see
//! [`joint`](super::joint)).
//!
//! Weights are one over the variance of the means; all alike when a reading has
//! none. Solved by the singular values of the columns, never by normal
//! equations.
//!
//! Source: Grip and Sabourova, Mech. Syst. Signal Process. 25 (2011) 493, with
//! directions instead of tilting angles.

use gravical_core::matrix3;
use nalgebra::{DMatrix, DVector};

use crate::estimate::{Reading, reading, undetermined, wanted};
use crate::{Error, Result};

/// The fitted accelerometer.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearFit {
    /// M of u = M a + b, input unit per m/s².
    pub model: [[f64; 3]; 3],
    /// M⁻¹ of a = M⁻¹(u − b).
    pub matrix: [[f64; 3]; 3],
    /// b, input unit.
    pub bias: [f64; 3],
    /// u − g M n − b of every reading, input unit.
    pub residuals: Vec<[f64; 3]>,
    /// Σ of the squared residuals over the variances of the means; none where a
    /// reading has none.
    pub chi2: Option<f64>,
    /// Readings of one channel less its four parameters, times three.
    pub freedom: usize,
    /// Covariance of row-major M and b. By the standard errors, times
    /// χ²/freedom where that exceeds 1; by the scatter of the residuals where a
    /// reading has no standard error. None when there is neither. The tilt of
    /// the placements, which is larger, is not in it.
    pub covariance: Option<[[f64; 12]; 12]>,
    /// Largest over smallest singular value of the four columns, each of length
    /// one (the worst of the three channels).
    pub condition: f64,
}

/// Smallest singular value, over the root of the number of readings, that counts
/// as determined.
const LEAST: f64 = 1e-3;

/// Fits M and b. `directions` are unit vectors of specific force, one for each
/// reading: `face.direction()` of the face that is up.
///
/// # Errors
///
/// `underdetermined` when the directions do not determine the parameters, naming
/// sides that would; `reading-values` for numbers that are none; `singular` when
/// the fitted M has no inverse.
pub fn linear12(readings: &[Reading], directions: &[[f64; 3]], gravity: f64) -> Result<LinearFit> {
    reading::check(readings)?;
    let n = readings.len().min(directions.len());
    let (readings, directions) = (&readings[..n], &directions[..n]);
    determined(directions)?;
    let errors = reading::standard_errors(readings);
    let mut model = [[0.0; 3]; 3];
    let mut bias = [0.0; 3];
    let mut residuals = vec![[0.0; 3]; n];
    let mut covariance = [[0.0; 12]; 12];
    let (mut squares, mut condition) = (0.0, 0.0_f64);
    for channel in 0..3 {
        let weight = |k: usize| errors.as_ref().map_or(1.0, |e| 1.0 / e[k][channel]);
        let mut rows = DMatrix::from_fn(n, 4, |k, j| {
            weight(k) * if j < 3 { directions[k][j] } else { 1.0 }
        });
        let right = DVector::from_fn(n, |k, _| weight(k) * readings[k].mean[channel]);
        let lengths: Vec<f64> = rows.column_iter().map(|c| c.norm()).collect();
        for (mut column, length) in rows.column_iter_mut().zip(&lengths) {
            column.unscale_mut(*length);
        }
        // The decomposition may never end on what is not finite.
        if rows.iter().chain(&right).any(|v| !v.is_finite()) {
            return Err(Error::input("underdetermined", "the readings have no fit"));
        }
        let svd = rows.svd(true, true);
        let (largest, smallest) = (svd.singular_values.max(), svd.singular_values.min());
        condition = condition.max(largest / smallest);
        let (Ok(x), Some(v_t)) = (svd.solve(&right, 0.0), svd.v_t.as_ref()) else {
            return Err(Error::input("underdetermined", "the readings have no fit"));
        };
        // Parameters from scaled columns, M from g M.
        let unit: Vec<f64> = (0..4)
            .map(|j| 1.0 / lengths[j] / if j < 3 { gravity } else { 1.0 })
            .collect();
        let place = |j: usize| if j < 3 { 3 * channel + j } else { 9 + channel };
        model[channel] = [0, 1, 2].map(|j| x[j] * unit[j]);
        bias[channel] = x[3] * unit[3];
        for i in 0..4 {
            for j in 0..4 {
                let sum: f64 = (0..4)
                    .map(|k| v_t[(k, i)] * v_t[(k, j)] / svd.singular_values[k].powi(2))
                    .sum();
                covariance[place(i)][place(j)] = sum * unit[i] * unit[j];
            }
        }
        for k in 0..n {
            let fitted = gravity * matrix3::dot(&model[channel], &directions[k]) + bias[channel];
            residuals[k][channel] = readings[k].mean[channel] - fitted;
            squares += (weight(k) * residuals[k][channel]).powi(2);
        }
    }
    let freedom = 3 * (n - 4);
    let per_freedom = squares / freedom.max(1) as f64;
    let factor = match (&errors, freedom) {
        (Some(_), _) => Some(per_freedom.max(1.0)),
        (None, 0) => None,
        (None, _) => Some(per_freedom),
    };
    let matrix = matrix3::inverse(&model).ok_or_else(|| {
        Error::input(
            "singular",
            "the fitted matrix has no inverse: an axis does not answer",
        )
        .with_hint("is an axis dead, or are placements the same?")
    })?;
    Ok(LinearFit {
        model,
        matrix,
        bias,
        residuals,
        chi2: errors.is_some().then_some(squares),
        freedom,
        covariance: factor.map(|f| covariance.map(|row| row.map(|c| c * f))),
        condition,
    })
}

/// Says which sides are missing when the directions leave parameters open.
fn determined(directions: &[[f64; 3]]) -> Result<()> {
    let n = directions.len();
    let row = |d: [f64; 3]| DVector::from_vec(vec![d[0], d[1], d[2], 1.0]);
    let mut rows = DMatrix::zeros(n.max(4), 4);
    for (k, d) in directions.iter().enumerate() {
        rows.set_row(k, &row(*d).transpose());
    }
    let svd = rows.svd(false, true);
    let limit = LEAST * (n.max(1) as f64).sqrt();
    let open: Vec<Vec<f64>> = svd.v_t.as_ref().map_or_else(Vec::new, |v_t| {
        (0..4)
            .filter(|&i| svd.singular_values[i] < limit)
            .map(|i| v_t.row(i).iter().copied().collect())
            .collect()
    });
    if open.is_empty() {
        return Ok(());
    }
    let wanted = wanted::wanted(&open, true, row);
    Err(Error::input(
        "underdetermined",
        format!(
            "{n} placements span {} of 3 directions and determine {} of the 12 parameters",
            undetermined::span(directions).0,
            12 - 3 * open.len()
        ),
    )
    .with_hint(format!(
        "twelve parameters need 4 sides that do not lie in one plane, better all six; record it with {}",
        wanted.join("; with ")
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segment::face::Face;

    const M: [[f64; 3]; 3] = [[1.01, 0.02, -0.01], [0.015, 0.98, 0.03], [0.0, -0.02, 1.02]];
    const B: [f64; 3] = [0.2, -0.3, 0.1];
    const G: f64 = 9.81;

    fn reading(n: [f64; 3], off: [f64; 3], s: Option<[f64; 3]>) -> Reading {
        let force = matrix3::mul_vec(&M, &n.map(|v| v * G));
        Reading {
            mean: [0, 1, 2].map(|i| force[i] + B[i] + off[i]),
            standard_error: s,
        }
    }

    #[test]
    fn an_exact_fixture_gives_the_parameters_back() {
        // Four directions are enough, six leave two readings of each channel.
        let corners = [
            [1.0, 1.0, 1.0],
            [1.0, -1.0, -1.0],
            [-1.0, 1.0, -1.0],
            [-1.0, -1.0, 1.0],
        ]
        .map(|n| n.map(|v: f64| v / 3_f64.sqrt()));
        let faces = Face::all().map(Face::direction);
        for (directions, freedom) in [(&corners[..], 0), (&faces[..], 6)] {
            let readings: Vec<Reading> = directions
                .iter()
                .map(|n| reading(*n, [0.0; 3], None))
                .collect();
            let fit = linear12(&readings, directions, G).unwrap();
            assert_eq!(fit.freedom, freedom);
            assert_eq!(fit.covariance.is_some(), freedom > 0);
            for i in 0..3 {
                assert!((fit.bias[i] - B[i]).abs() < 1e-13);
                for j in 0..3 {
                    assert!((fit.model[i][j] - M[i][j]).abs() < 1e-14);
                }
            }
            let product = matrix3::mul(&fit.matrix, &fit.model);
            assert!((product[0][0] - 1.0).abs() < 1e-14 && product[0][1].abs() < 1e-14);
        }
    }

    #[test]
    fn six_faces_have_the_covariance_that_stands_on_paper() {
        // Var b = s²/6 and Var M_ij = s²/(2g²): pairs of faces.
        let s = [1e-3, 2e-3, 3e-3];
        let directions = Face::all().map(Face::direction);
        let readings: Vec<Reading> = directions
            .iter()
            .map(|n| reading(*n, [0.0; 3], Some(s)))
            .collect();
        let fit = linear12(&readings, &directions, G).unwrap();
        let c = fit.covariance.unwrap();
        for i in 0..3 {
            let (b, m) = (s[i] * s[i] / 6.0, s[i] * s[i] / 2.0 / G / G);
            assert!((c[9 + i][9 + i] / b - 1.0).abs() < 1e-12);
            for j in 0..3 {
                assert!((c[3 * i + j][3 * i + j] / m - 1.0).abs() < 1e-12);
                assert!(c[3 * i + j][9 + i].abs() < 1e-12 * b);
            }
        }
        assert!((fit.condition - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_reading_that_is_known_less_counts_less() {
        // +z twice, once off by 1 and a hundred times less sure.
        let mut directions: Vec<[f64; 3]> = Face::all().map(Face::direction).to_vec();
        directions.push([0.0, 0.0, 1.0]);
        let mut readings: Vec<Reading> = directions[..6]
            .iter()
            .map(|n| reading(*n, [0.0; 3], Some([1e-3; 3])))
            .collect();
        readings.push(reading([0.0, 0.0, 1.0], [0.0, 0.0, 1.0], Some([0.1; 3])));
        let weighed = linear12(&readings, &directions, G).unwrap();
        assert!((weighed.bias[2] - B[2]).abs() < 1e-4);
        // χ² = (1/0.1)² over 9 degrees of freedom widens the covariance.
        assert!((weighed.chi2.unwrap() - 100.0).abs() < 0.1);
        readings.iter_mut().for_each(|r| r.standard_error = None);
        let alike = linear12(&readings, &directions, G).unwrap();
        assert!((alike.bias[2] - B[2]).abs() > 0.05);
        assert_eq!(alike.chi2, None);
        assert!(alike.covariance.is_some());
    }

    #[test]
    fn sides_that_are_missing_are_named() {
        let named = |faces: &[usize]| {
            let directions: Vec<_> = faces.iter().map(|&i| Face::all()[i].direction()).collect();
            let readings: Vec<_> = directions
                .iter()
                .map(|n| reading(*n, [0.0; 3], None))
                .collect();
            let error = linear12(&readings, &directions, G).unwrap_err();
            assert_eq!(error.code(), "underdetermined");
            (error.message().to_owned(), error.hint().unwrap().to_owned())
        };
        // +x, −x, +y, −y: nothing along z.
        let (what, hint) = named(&[0, 1, 2, 3]);
        assert_eq!(
            what,
            "4 placements span 2 of 3 directions and determine 9 of the 12 parameters"
        );
        assert!(hint.ends_with("record it with z up"), "{hint}");
        // +x, +y, +z lie in a plane.
        let (what, hint) = named(&[0, 2, 4]);
        assert!(what.contains("9 of the 12"), "{what}");
        assert!(hint.ends_with(" down"), "{hint}");
        assert!(named(&[]).0.contains("0 of the 12"));
    }

    #[test]
    fn no_number_is_no_reading() {
        let mut readings = [reading([0.0, 0.0, 1.0], [0.0; 3], None)];
        readings[0].mean[1] = f64::NAN;
        let error = linear12(&readings, &[[0.0, 0.0, 1.0]], G).unwrap_err();
        assert_eq!(error.code(), "reading-values");
    }
}
