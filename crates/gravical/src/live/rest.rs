//! Rows at rest: their means, and what is wrong with them as a pose.

use gravical_core::matrix3::{norm, sub};
use gravical_recording::Sample;
use gravical_recording::full_scale::clipped_count;

use super::event::Rejection;
use crate::poses::face::AXES;
use crate::recording::units::AccelScale;
use crate::stats::{mean_of_finite, moments};

/// A magnitude further from gravity than these factors is another unit, or another scale.
const OTHER_UNIT: f64 = 2.0;
const MAX_OFF: f64 = 0.35;
/// A mean angular rate that differs from that of the first rest by more is a steady turn, °/s.
const MAX_TURNING_DEG_S: f64 = 5.0;

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
    /// What the gyroscope read in the first rest.
    pub gyro_bias: [f64; 3],
}

impl Units {
    /// What is wrong with a capture, the gravest fault first.
    pub fn fault(&self, samples: &[Sample], means: &Means, gravity_mps2: f64) -> Option<Fault> {
        self.clipped(samples)
            .or_else(|| self.magnitude_fault(means.accel, gravity_mps2))
            .or_else(|| self.turning(means))
    }

    fn clipped(&self, samples: &[Sample]) -> Option<Fault> {
        let axes = columns(samples, |s| s.accel);
        let axis = (0..3).find(|&axis| clipped_count(&axes[axis], &self.scale) > 0)?;
        let text = format!(
            "a{} is at the end of its range. Set the sensor to a wider range (±4 g), and begin anew.",
            AXES[axis]
        );
        Some((Rejection::Clipped, text))
    }

    /// What is wrong with the magnitude of a rest in local gravity.
    pub fn magnitude_fault(&self, accel: [f64; 3], gravity_mps2: f64) -> Option<Fault> {
        let norm = norm(&accel) / self.nominal;
        let ratio = norm / gravity_mps2;
        let off = 100.0 * (ratio - 1.0).abs();
        if !(1.0 / OTHER_UNIT..=OTHER_UNIT).contains(&ratio) {
            let text = format!(
                "‖a‖ is {norm:.2} m/s² at rest: the unit or the range has changed. Set the range of the sensor as it was, or begin anew."
            );
            Some((Rejection::Units, text))
        } else if off > 100.0 * MAX_OFF {
            let text = format!(
                "‖a‖ is {norm:.2} m/s² at rest, {off:.0} % from gravity. Check that the sensor is raw and at the range that the sketch converts with."
            );
            Some((Rejection::Scale, text))
        } else {
            None
        }
    }

    /// A turn about the vertical leaves gravity where it is.
    fn turning(&self, means: &Means) -> Option<Fault> {
        let rate = norm(&sub(&means.gyro, &self.gyro_bias));
        let rate_deg_s = (rate / self.gyro_nominal?).to_degrees();
        (rate_deg_s > MAX_TURNING_DEG_S).then(|| {
            let text = format!(
                "It turns steadily: {rate_deg_s:.0} °/s more than in the first rest. {LET_GO}"
            );
            (Rejection::Moved, text)
        })
    }
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

fn columns(samples: &[Sample], of: impl Fn(&Sample) -> [f64; 3]) -> [Vec<f64>; 3] {
    std::array::from_fn(|i| samples.iter().map(|s| of(s)[i]).collect())
}
