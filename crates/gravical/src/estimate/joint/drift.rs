//! Whether the drift of the bias with temperature is worth its three parameters.

use gravical_core::matrix3;

use super::fit::rough_fit;
use super::{JointError, JointOptions, JointPose, prepare};

/// Contiguous parts of the poses that are left out in turn.
pub const FOLDS: usize = 8;

/// Errors of ‖a‖ at poses that the fit did not use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftTest {
    /// Mean of |‖a‖ − g| by a bias that is constant, m/s².
    pub without_mps2: f64,
    /// The same by a bias with a drift.
    pub with_mps2: f64,
    /// The drift lowers the error by more than one standard error of the difference.
    pub helps: bool,
}

/// Leaves out every eighth of the `poses` in turn, which have to be in order of time, and compares
/// the errors there of a bias without and with a drift. Neighbours in time agree whatever the
/// cause of their error is: only contiguous parts test that temperature is the cause.
///
/// The drift is accepted by the rule of one standard error (Breiman et al., Classification and
/// Regression Trees, 1984, 3.4.3), the simpler model being that without it.
///
/// # Errors
///
/// Those of [`joint`](super::joint); `Undetermined` where seven eighths determine nothing.
pub fn test_drift(poses: &[JointPose], options: &JointOptions) -> Result<DriftTest, JointError> {
    let parts = |drift: bool| {
        let options = JointOptions { drift, ..*options };
        errors_of_parts(poses, &options)
    };
    let (without, with) = (parts(false)?, parts(true)?);
    let mean = |parts: &[f64]| parts.iter().sum::<f64>() / parts.len() as f64;
    let gains: Vec<f64> = without.iter().zip(&with).map(|(a, b)| a - b).collect();
    let gain = mean(&gains);
    let scatter = crate::stats::standard_deviation(&gains) / (gains.len() as f64).sqrt();
    Ok(DriftTest {
        without_mps2: mean(&without),
        with_mps2: mean(&with),
        helps: gain > scatter,
    })
}

/// Mean of |‖a‖ − g| over each part, by the fit to the others.
fn errors_of_parts(poses: &[JointPose], options: &JointOptions) -> Result<Vec<f64>, JointError> {
    let (mut work, mut search) = prepare(poses, options)?;
    let found = search.settle(&mut work)?;
    (0..FOLDS)
        .map(|part| {
            let out = part * work.len() / FOLDS..(part + 1) * work.len() / FOLDS;
            let mut rest = work.clone();
            rest[out.clone()].iter_mut().for_each(|p| p.left_out = true);
            let fit = rough_fit(&rest, &search.held, &found.start())
                .filter(|f| f.converged)
                .ok_or_else(|| search.open(&rest))?;
            let inverse = matrix3::inverse(&fit.state.m).ok_or(JointError::NotConverged)?;
            let error = |pose| (matrix3::norm(&fit.force(&inverse, pose)) - options.gravity).abs();
            Ok(work[out.clone()].iter().map(error).sum::<f64>() / out.len() as f64)
        })
        .collect()
}
