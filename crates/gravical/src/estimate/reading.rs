//! What the estimators take.

use crate::segment::Placement;
use crate::{Error, Result};

/// Mean reading of a sensor at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Mean of each axis, input unit.
    pub mean: [f64; 3],
    /// Standard error of each component of the mean, input unit; none where a
    /// row is a mean itself.
    pub standard_error: Option<[f64; 3]>,
}

impl From<&Placement> for Reading {
    fn from(placement: &Placement) -> Self {
        Reading {
            mean: placement.mean,
            standard_error: placement.standard_error,
        }
    }
}

/// Refuses means and standard errors that are no numbers.
pub(super) fn check(readings: &[Reading]) -> Result<()> {
    for (k, reading) in readings.iter().enumerate() {
        let finite = |v: &[f64; 3]| v.iter().all(|x| x.is_finite());
        if !finite(&reading.mean) || !reading.standard_error.as_ref().is_none_or(finite) {
            return Err(Error::input(
                "reading-values",
                format!(
                    "pose {} has a mean or a standard error that is no number: {:?}, {:?}",
                    k + 1,
                    reading.mean,
                    reading.standard_error
                ),
            )
            .with_hint("leave the pose out"));
        }
    }
    Ok(())
}

/// The standard errors of all readings; none when one has none, or one of zero:
/// as a weight it would outvote all others.
pub(super) fn standard_errors(readings: &[Reading]) -> Option<Vec<[f64; 3]>> {
    readings
        .iter()
        .map(|r| r.standard_error.filter(|s| s.iter().all(|s| *s > 0.0)))
        .collect()
}
