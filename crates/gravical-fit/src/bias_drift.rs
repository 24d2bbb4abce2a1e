//! Drift of the bias with temperature, from many poses: is it predictable?

use crate::fit::{Options, Undetermined, prepare};
use crate::pose::Pose;
use crate::rows::force;

/// Contiguous parts of the poses that are left out in turn.
const PARTS: usize = 8;

/// Errors of ‖a‖ at poses that the fit did not use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftTest {
    /// Mean of |‖a‖ − g| by a constant bias, m/s².
    pub without_mps2: f64,
    /// The same by a bias with a drift.
    pub with_mps2: f64,
    /// The drift lowers the error by more than one standard error of the difference.
    pub helps: bool,
}

/// Leaves out every eighth of the `poses` in turn, which have to be in order of time, and compares the
/// errors there of a bias without and with a drift. Neighbours in time agree whatever the cause of their
/// error is: only contiguous parts test that temperature is the cause.
///
/// The drift is accepted by the rule of one standard error (Breiman et al., Classification and Regression
/// Trees, 1984, 3.4.3), the simpler model being that without it.
///
/// # Errors
///
/// [`Undetermined`], for all poses or seven eighths of them; with fewer than eight poses, too.
pub fn test_drift(poses: &[Pose], options: &Options) -> Result<DriftTest, Undetermined> {
    let parts = |drift: bool| errors_of_parts(poses, &Options { drift, ..*options });
    let (without, with) = (parts(false)?, parts(true)?);
    let mean = |parts: &[f64]| parts.iter().sum::<f64>() / parts.len() as f64;
    let gains: Vec<f64> = without.iter().zip(&with).map(|(a, b)| a - b).collect();
    let gain = mean(&gains);
    let squares: f64 = gains.iter().map(|g| (g - gain).powi(2)).sum();
    let count = gains.len() as f64;
    Ok(DriftTest {
        without_mps2: mean(&without),
        with_mps2: mean(&with),
        helps: gain > (squares / (count - 1.0) / count).sqrt(),
    })
}

/// Mean of |‖a‖ − g| over each part, by the fit to the others.
fn errors_of_parts(poses: &[Pose], options: &Options) -> Result<Vec<f64>, Undetermined> {
    let open = Undetermined::of(poses);
    let mut search = prepare(poses, options).ok_or(open)?;
    if search.poses.len() < PARTS {
        return Err(open);
    }
    let found = search.settle().ok_or(open)?;
    let count = search.poses.len();
    let one_part = |part: usize| {
        let out = part * count / PARTS..(part + 1) * count / PARTS;
        let rest = found
            .linear
            .solve_poses(&search.estimating(), |k| !out.contains(&k))?;
        let x = found.linear.x + rest.step;
        let error = |pose| Some((force(&x, pose)?.norm() - options.gravity).abs());
        let sum: Option<f64> = search.poses[out.clone()].iter().map(error).sum();
        Some(sum? / out.len() as f64)
    };
    (0..PARTS).map(|part| one_part(part).ok_or(open)).collect()
}
