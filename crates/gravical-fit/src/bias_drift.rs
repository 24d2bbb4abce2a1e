//! Drift of the bias with temperature, from many poses: is it predictable?

use nalgebra::SVector;

use crate::fit::{Options, Undetermined, prepare};
use crate::pose::Pose;
use crate::rows::force;
use crate::search::{Found, Search};

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
    let gains = without - with;
    // The variance of a mean of so many.
    let variance = gains.add_scalar(-gains.mean()).norm_squared() / (PARTS * (PARTS - 1)) as f64;
    Ok(DriftTest {
        without_mps2: without.mean(),
        with_mps2: with.mean(),
        helps: gains.mean() > variance.sqrt(),
    })
}

/// Mean of |‖a‖ − g| over each part, by the fit to the others.
fn errors_of_parts(poses: &[Pose], options: &Options) -> Result<SVector<f64, PARTS>, Undetermined> {
    let one_part = |search: &Search, found: &Found, part: usize| {
        let count = search.poses.len();
        let out = part * count / PARTS..(part + 1) * count / PARTS;
        let linear = &found.linear;
        let rest = linear.solve_poses(&search.estimating(), |k| !out.contains(&k))?;
        let x = linear.x + rest.step;
        let error = |pose| Some((force(&x, pose)?.norm() - options.gravity).abs());
        let sum: Option<f64> = search.poses[out.clone()].iter().map(error).sum();
        Some(sum? / out.len() as f64)
    };
    let each = || {
        let search = prepare(poses, options).filter(|search| search.poses.len() >= PARTS);
        let mut search = search?;
        let found = search.converge()?;
        let each: Option<Vec<f64>> = (0..PARTS).map(|p| one_part(&search, &found, p)).collect();
        each.map(SVector::from_vec)
    };
    each().ok_or_else(|| Undetermined::of(poses))
}
