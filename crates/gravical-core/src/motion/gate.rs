//! How far the velocity may be off, for telling a rest from constant speed.

use crate::Real;
use crate::strapdown::{conjugate, quat_mul};

/// Standard deviations from zero that a velocity at rest may have.
pub const FAR: f64 = 4.0;

/// No velocity is known better than this, m/s: feet and hands are not quite still
/// where they rest.
pub const FLOOR_MPS: f64 = 0.01;

/// Noise that is integrated from a rest on without another, τ s after it: by the
/// accelerometer, over N², and by the tilt.
///
/// ```text
/// v:  τ + τ²/T₀        g² (N_g² τ³/3 + σ_A² τ⁴/4 + σ_w² τ²)
/// p:  τ³/3 + τ⁴/4T₀    g² (N_g² τ⁵/20 + σ_A² τ⁶/36 + σ_w² τ⁴/4)
/// ```
#[derive(Debug, Clone, Copy)]
pub struct OpenNoise<T> {
    /// N_g², rad²/s.
    pub gyro: T,
    /// σ_A², variance of the gyroscope's bias, rad²/s².
    pub bias: T,
    /// σ_w², constant tilt that sets in with the motion, rad².
    pub tilt_change: T,
    /// g, m/s².
    pub gravity: T,
    /// T₀, length of the rest, s.
    pub rest_s: T,
}

impl<T: Real> OpenNoise<T> {
    /// Variance of the velocity by noise over N², s; by tilt, m²/s².
    #[must_use]
    pub fn velocity(&self, tau: T) -> [T; 2] {
        let c = T::from_f64;
        let t2 = tau * tau;
        let tilt =
            self.gyro * t2 * tau / c(3.0) + self.bias * t2 * t2 / c(4.0) + self.tilt_change * t2;
        [tau + t2 / self.rest_s, self.gravity * self.gravity * tilt]
    }

    /// Variance of the position by noise over N², s³; by tilt, m².
    #[must_use]
    pub fn position(&self, tau: T) -> [T; 2] {
        let c = T::from_f64;
        let (t2, t3) = (tau * tau, tau * tau * tau);
        let tilt = self.gyro * t2 * t3 / c(20.0)
            + self.bias * t3 * t3 / c(36.0)
            + self.tilt_change * t2 * t2 / c(4.0);
        let noise = t3 / c(3.0) + t2 * t2 / (c(4.0) * self.rest_s);
        [noise, self.gravity * self.gravity * tilt]
    }
}

/// The angle between two attitudes, rad, to within the third order of it.
#[inline]
pub(super) fn angle<T: Real>(from: &[T; 4], to: &[T; 4]) -> T {
    let [_, x, y, z] = quat_mul(to, &conjugate(from));
    T::from_f64(2.0) * (x * x + y * y + z * z).sqrt()
}
