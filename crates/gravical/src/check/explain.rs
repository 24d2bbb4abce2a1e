//! What would explain the errors: one share for all, or one bias.
//!
//! Errors e of ‖a‖ with covariance V (that of the calibration included): a share
//! s gives e = s g, a change d of the bias (calibrated axes) gives e = n·d. Each
//! is estimated by generalised least squares; it explains the errors when what
//! is left is within the uncertainty.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::coverage::TESTED_COSINE;
use super::types::{Cause, Explanation};
use crate::compare::SIGNIFICANCE;
use crate::uncertainty::upper_tail;

/// Estimates all causes; `directions` are unit vectors in calibrated axes of the
/// board, `freedom_of_covariance` what V is known by (none: exactly). Empty when V is not positive definite.
pub(super) fn explanations(
    errors: &DVector<f64>,
    covariance: &DMatrix<f64>,
    freedom_of_covariance: Option<f64>,
    directions: &[[f64; 3]],
    gravity: f64,
) -> Vec<Explanation> {
    let Some(v) = Cholesky::new(covariance.clone()) else {
        return Vec::new();
    };
    let chi2 = errors.dot(&v.solve(errors));
    let n = errors.len();
    let columns: [DMatrix<f64>; 5] = [
        DMatrix::from_element(n, 1, gravity),
        DMatrix::from_fn(n, 1, |i, _| directions[i][0]),
        DMatrix::from_fn(n, 1, |i, _| directions[i][1]),
        DMatrix::from_fn(n, 1, |i, _| directions[i][2]),
        DMatrix::from_fn(n, 3, |i, k| directions[i][k]),
    ];
    let causes = [
        Cause::Share,
        Cause::BiasX,
        Cause::BiasY,
        Cause::BiasZ,
        Cause::Bias,
    ];
    let mut out: Vec<Explanation> = causes
        .into_iter()
        .zip(&columns)
        .filter_map(|(cause, design)| {
            // A bias across all stills would have to be enormous.
            let seen = |k: usize| directions.iter().any(|n| n[k].abs() >= TESTED_COSINE);
            let sees = match cause {
                Cause::Share => true,
                Cause::BiasX => seen(0),
                Cause::BiasY => seen(1),
                Cause::BiasZ => seen(2),
                Cause::Bias => (0..3).all(seen),
            };
            if !sees {
                return None;
            }
            let weighted = v.solve(design);
            let normal = design.transpose() * &weighted;
            // A direction that no still points along tells nothing about it.
            let inverse = Cholesky::new(normal)?.inverse();
            let estimate = &inverse * weighted.transpose() * errors;
            let explained = (weighted.transpose() * errors).dot(&estimate);
            let left = (chi2 - explained).max(0.0);
            let freedom = n.checked_sub(design.ncols())?;
            let p_value_left = (freedom > 0)
                .then(|| upper_tail(left, freedom as f64, freedom_of_covariance))
                .flatten();
            let sigma = inverse.diagonal().max().sqrt();
            let along = |k: usize| match (cause, k) {
                (Cause::BiasX, 0) | (Cause::BiasY, 1) | (Cause::BiasZ, 2) => estimate[0],
                (Cause::Bias, _) => estimate[k],
                _ => 0.0,
            };
            // What is nothing explains nothing.
            let significant = upper_tail(explained, design.ncols() as f64, freedom_of_covariance)
                .is_some_and(|p| p < SIGNIFICANCE);
            let share = cause == Cause::Share;
            Some(Explanation {
                cause,
                bias_mps2: (!share).then(|| std::array::from_fn(along)),
                share_percent: share.then(|| 100.0 * estimate[0]),
                sigma: if share { 100.0 * sigma } else { sigma },
                p_value_left,
                explains: significant && p_value_left.is_none_or(|p| p >= SIGNIFICANCE),
            })
        })
        .collect();
    // Three biases at once only where nothing simpler does.
    if out.iter().any(|e| e.cause != Cause::Bias && e.explains) {
        out.retain(|e| e.cause != Cause::Bias);
    }
    out
}

/// The likeliest faults (one share, one bias) are looked for by themselves, since
/// a test of all stills at once dilutes one of them: the smallest p of those that
/// the stills can show, times their number (Bonferroni). None where there is
/// none.
pub(super) fn focused(all: &[Explanation], freedom_of_covariance: Option<f64>) -> Option<f64> {
    let simple = || all.iter().filter(|e| e.cause != Cause::Bias);
    let smallest = simple()
        .filter_map(|e| {
            let estimate = match (e.share_percent, e.bias_mps2) {
                (Some(share), _) => share,
                (None, Some(bias)) => gravical_core::matrix3::norm(&bias),
                (None, None) => return None,
            };
            upper_tail((estimate / e.sigma).powi(2), 1.0, freedom_of_covariance)
        })
        .min_by(f64::total_cmp)?;
    Some((smallest * simple().count() as f64).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACES: [[f64; 3]; 6] = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];

    fn explained(errors: [f64; 6]) -> Vec<Explanation> {
        let v = DMatrix::identity(6, 6) * 0.01_f64.powi(2);
        explanations(&DVector::from_row_slice(&errors), &v, None, &FACES, 9.81)
            .into_iter()
            .filter(|e| e.explains)
            .collect()
    }

    #[test]
    fn one_bias_is_found_and_named() {
        let found = explained([0.0, 0.0, 0.3, -0.3, 0.0, 0.0]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].cause, Cause::BiasY);
        assert!((found[0].bias_mps2.unwrap()[1] - 0.3).abs() < 1e-12);
        assert!((found[0].sigma - 0.01 / 2_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn one_share_is_scale_or_gravity() {
        let found = explained([0.0981; 6]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].cause, Cause::Share);
        assert!((found[0].share_percent.unwrap() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn two_biases_need_all_three() {
        let found = explained([0.2, -0.2, 0.3, -0.3, 0.0, 0.0]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].cause, Cause::Bias);
        // A scale of one axis is none of these.
        assert!(explained([0.2, 0.2, 0.0, 0.0, 0.0, 0.0]).is_empty());
    }

    #[test]
    fn a_single_pose_is_explained_by_more_than_one() {
        let v = DMatrix::identity(1, 1) * 1e-4;
        let found = explanations(&DVector::from_element(1, 0.3), &v, None, &FACES[4..5], 9.81);
        let causes: Vec<Cause> = found.iter().map(|e| e.cause).collect();
        assert_eq!(causes, [Cause::Share, Cause::BiasZ]);
    }
}
