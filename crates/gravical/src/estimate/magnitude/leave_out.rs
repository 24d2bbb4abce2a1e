//! Error of ‖a‖ on poses that were left out of the fit.

use gravical_core::matrix3;

use super::{MagnitudeOptions, fit};
use crate::Result;
use crate::estimate::Reading;
use crate::segment::face::angle_deg;

/// Neighbours within this angle know a pose's answer, degrees.
pub const NEIGHBOUR_DEG: f64 = 25.0;

/// Errors of ‖a‖ on poses that the fit did not know.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// ‖A(u − b)‖ − g of every pose under the fit to the others, m/s²; none
    /// where these do not determine the parameters.
    pub errors_mps2: Vec<Option<f64>>,
}

impl LeftOut {
    /// Root of the mean square over the poses that have an error, and how many
    /// these are.
    #[must_use]
    pub fn rms_mps2(&self) -> Option<(f64, usize)> {
        let some: Vec<f64> = self.errors_mps2.iter().flatten().copied().collect();
        let mean = some.iter().map(|e| e * e).sum::<f64>() / some.len() as f64;
        (!some.is_empty()).then(|| (mean.sqrt(), some.len()))
    }
}

pub(super) fn direction(force: &[f64; 3]) -> [f64; 3] {
    let length = matrix3::norm(force);
    force.map(|v| v / length)
}

/// For every pose: refits without it and every pose within `neighbour_deg` of it,
/// usually [`NEIGHBOUR_DEG`]; with 0 the pose alone is left out.
///
/// # Errors
///
/// As [`magnitude`](super::magnitude()), of all poses together; but ‖a‖ need
/// not be known well in every direction: how well it is shows in the errors.
pub fn leave_out(
    readings: &[Reading],
    options: &MagnitudeOptions,
    neighbour_deg: f64,
) -> Result<LeftOut> {
    let whole = fit(readings, options)?;
    let directions: Vec<[f64; 3]> = readings
        .iter()
        .map(|r| direction(&whole.calibrated(r.mean)))
        .collect();
    let errors_mps2 = (0..readings.len())
        .map(|k| {
            let rest: Vec<Reading> = readings
                .iter()
                .zip(&directions)
                .enumerate()
                .filter(|(i, (_, d))| *i != k && angle_deg(**d, directions[k]) > neighbour_deg)
                .map(|(_, (r, _))| *r)
                .collect();
            let fit = fit(&rest, options).ok()?;
            Some(fit.length_mps2(readings[k].mean) - options.gravity)
        })
        .collect();
    Ok(LeftOut { errors_mps2 })
}
