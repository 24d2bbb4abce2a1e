//! The fit, with the nonlinearity of the axes where it holds beside the poses that show it.

use crate::fit::{Fit, Options, Undetermined, converged, prepare};
use crate::pose::Pose;
use crate::trust::left_out_rms;

/// Fits M and b.
///
/// The model is u = M a + b. A free pose says that ‖a‖ = g; a face, besides, that a lies along its axis
/// but for a tilt whose two components have the standard deviation σ. Found out on the way, by restricted
/// maximum likelihood: the roles of the poses, σ, a model error that is added to every mean, and the
/// spread of six *nonlinearity coefficients*, what a nonlinear response does to ‖a‖ that M and b cannot; then the poses that
/// contradict the others, one by one. Data sheets count unless `prior` is off.
///
/// # Errors
///
/// [`Undetermined`]; also without poses, or if a mean, its standard deviation or a temperature is not finite.
pub fn fit(poses: &[Pose], options: &Options) -> Result<Fit, Undetermined> {
    let open = || Undetermined::of(poses);
    let search = prepare(poses, options).ok_or_else(open)?;
    let curved = converged(search.clone(), poses, options)?;
    if curved
        .nonlinearity()
        .iter()
        .all(|c| c.abs() < MIN_NONLINEARITY)
    {
        return Ok(curved);
    }
    // A nonlinearity that no pose beside it confirms is how the sensor was held, or moved.
    let linear = converged(search.without_nonlinearity(), poses, options)?;
    let left_out = |fit: &Fit| left_out_rms(&fit.left_out());
    match (left_out(&curved), left_out(&linear)) {
        (Some(with), Some(without)) if WORSE * without < with => Ok(linear),
        _ => Ok(curved),
    }
}

/// Coefficients that change ‖a‖ by less, as a share of g, are not worth a question.
const MIN_NONLINEARITY: f64 = 1e-3;
/// A nonlinearity that poses on edges alone show raises the error of poses left out, too, but by little, and is real.
const WORSE: f64 = 2.0;
