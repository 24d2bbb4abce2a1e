//! How far the velocity may be off, for telling a rest from constant speed.

use super::{MotionConfig, Removal};
use crate::Real;
use crate::still::RestNoise;
use crate::strapdown::times;

/// Standard deviations from zero that a velocity at rest may have.
pub(super) const FAR: f64 = 4.0;

/// No velocity is known better than this, m/s: feet and hands are not quite still
/// where they rest.
const FLOOR_MPS: f64 = 0.01;

/// What the uncertainty of a velocity follows from.
pub(super) struct Doubt<T> {
    /// Since the rest, s.
    pub since_s: T,
    /// Mean step, s.
    pub step_s: T,
    /// How long that rest was, s.
    pub rested_s: T,
    /// g, m/s².
    pub gravity: T,
    /// ∫ of the angle that the sensor is turned by, rad s.
    pub turned: T,
}

impl<T: Real> Doubt<T> {
    /// Standard uncertainty of a component of the velocity, m/s: noise since the rest
    /// T₀, N²(τ + τ²/T₀) + g²N_g²(τ³/3 + τ⁴/4T₀), and what the parameters make of
    /// the angle θ that the sensor is turned by, (g s + b) ∫θ dt: the scale s of the
    /// gyroscope leaves a tilt of s θ; a bias b that was levelled away comes back as
    /// b θ. A bound for each axis; the correlations between them are left out.
    pub fn velocity(&self, config: &MotionConfig<T>, noise: &RestNoise<T>) -> T {
        let c = T::from_f64;
        let largest = |from: usize| {
            noise.mean_variance[0][from..from + 3]
                .iter()
                .fold(T::zero(), |most, v| most.max(*v))
        };
        let t = self.since_s;
        let rest = self.rested_s.max(self.step_s);
        let accel = largest(0) * self.step_s;
        let mut variance = accel * (t + t * t / rest) + c(FLOOR_MPS * FLOOR_MPS);
        if config.removal == Removal::Strapdown {
            let gyro = largest(3) * self.step_s;
            let tilt = gyro * t * t * t * (c(1.0 / 3.0) + t / (c(4.0) * rest));
            variance = variance + self.gravity * self.gravity * tilt;
            let parameters = (self.gravity * config.gyro_scale + config.bias_mps2) * self.turned;
            variance = variance + parameters * parameters;
        } else {
            let tilt = self.gravity * config.wobble_rad * t;
            variance = variance + tilt * tilt;
        }
        variance.sqrt()
    }
}

/// The angle between two attitudes, rad, to within the third order of it.
#[inline]
pub(super) fn angle<T: Real>(from: &[T; 4], to: &[T; 4]) -> T {
    let back = [from[0], -from[1], -from[2], -from[3]];
    let [_, x, y, z] = times(to, &back);
    T::from_f64(2.0) * (x * x + y * y + z * z).sqrt()
}
