//! Means of rows at rest, and what is wrong with their magnitude.

use gravical_core::matrix3::norm;
use gravical_recording::Sample;

use super::event::Rejection;
use crate::recording::units::AccelScale;
use crate::stats::{mean_of_finite, moments};

/// A magnitude further from gravity than these factors is another unit, or another scale.
const OTHER_UNIT: f64 = 2.0;
const MAX_OFF: f64 = 0.35;

/// The remedy for what moved.
pub(super) const LET_GO: &str = "Lay it down, take the hand off, and wait.";

/// Why a hold is no pose, and in whole sentences what to do.
pub(super) type Fault = (Rejection, String);

/// What is known of the units once the noise is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Units {
    /// Subtracted from the counts of the accelerometer.
    pub zero_offset: f64,
    /// Units of the recording per m/s².
    pub nominal: f64,
    pub scale: AccelScale,
    /// Units of the gyroscope per rad/s.
    pub gyro_nominal: Option<f64>,
}

impl Units {
    /// What is wrong with the magnitude of a rest in local `gravity`, m/s².
    pub fn fault(&self, accel: [f64; 3], gravity: f64) -> Option<Fault> {
        let norm = norm(&accel) / self.nominal;
        let ratio = norm / gravity;
        let off = 100.0 * (ratio - 1.0).abs();
        if !(1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&ratio) {
            let text = format!(
                "‖a‖ is {norm:.2} m/s² at rest: the unit or the range has changed. Set the range of the sensor as it was, or begin anew."
            );
            Some((Rejection::Units, text))
        } else if off > 100.0 * MAX_OFF {
            let what = format!("‖a‖ is {norm:.2} m/s² at rest, {off:.0} % from gravity");
            Some(other_scale(&what))
        } else {
            None
        }
    }
}

pub(super) fn other_scale(what: &str) -> Fault {
    let remedy = "Check that the sensor is raw and at the range that the sketch converts with.";
    (Rejection::Scale, format!("{what}. {remedy}"))
}

/// Means of rows, and their scatter; empty cells are left out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Means {
    pub accel: [f64; 3],
    pub gyro: [f64; 3],
    /// Roots of the sum of the variances of three axes, of accelerometer and gyroscope; NaN without one.
    pub scatter: [f64; 2],
    pub temperature_c: Option<f64>,
}

impl Means {
    pub fn of(samples: &[Sample]) -> Self {
        let (accel, variance) = moments(&columns(samples, |s| s.accel), 0..samples.len());
        let (gyro, gyro_variance) = moments(&columns(samples, |s| s.gyro), 0..samples.len());
        let temperatures: Vec<f64> = samples.iter().map(|s| s.temperature_c).collect();
        Means {
            accel,
            gyro,
            scatter: [variance.sqrt(), gyro_variance.sqrt()],
            temperature_c: Some(mean_of_finite(&temperatures)).filter(|t| t.is_finite()),
        }
    }
}

pub(super) fn columns(samples: &[Sample], of: impl Fn(&Sample) -> [f64; 3]) -> [Vec<f64>; 3] {
    std::array::from_fn(|i| samples.iter().map(|s| of(s)[i]).collect())
}

/// A temperature beside that of the first pose: `1.4 °C warmer than in the first pose`.
pub(super) fn warming(change_c: f64) -> String {
    let how = if change_c > 0.0 { "warmer" } else { "colder" };
    format!(
        "The sensor is {:.1} °C {how} than in the first pose",
        change_c.abs()
    )
}
