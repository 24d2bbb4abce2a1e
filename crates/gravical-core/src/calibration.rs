//! What a calibration is, and how it is applied to one sample.
//!
//! One direction everywhere: `calibrated = matrix · (raw − bias)`. The bias is
//! in the unit of the raw reading, the matrix turns that unit into the
//! calibrated one (m/s² or rad/s) and undoes scale and misalignment.

use crate::Real;
use crate::matrix3;

/// The calibration of an accelerometer: `calibrated = matrix · (raw − bias)`.
///
/// `matrix` is R⁻¹K⁻¹ of the sensor model u = K R a + b (Ferraris, Grimaldi and
/// Parvis 1995).
///
/// ```
/// use gravical_core::calibration::LinearCalibration;
///
/// let calibration = LinearCalibration {
///     matrix: [[0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     bias: [1.0, 0.0, -1.0],
/// };
/// assert_eq!(calibration.apply([21.0, 0.0, -1.0]), [10.0, 0.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearCalibration<T> {
    /// Row-major 3 × 3, calibrated unit per raw unit.
    pub matrix: [[T; 3]; 3],
    /// The reading at zero input, in the raw unit.
    pub bias: [T; 3],
}

impl<T: Real> LinearCalibration<T> {
    /// One sample of three channels, raw unit → calibrated unit.
    ///
    /// Nothing is checked: where `raw` is not finite, neither is the result.
    pub fn apply(&self, raw: [T; 3]) -> [T; 3] {
        matrix3::mul_vec(&self.matrix, &matrix3::sub(&raw, &self.bias))
    }
}

/// The calibration of a gyroscope:
/// `calibrated = matrix · (raw − bias − g_sensitivity · acceleration)`.
///
/// `matrix` is R_g⁻¹K_g⁻¹ of Ferraris, Grimaldi and Parvis 1995, with the
/// g-sensitivity that their six placements show as well.
///
/// ```
/// use gravical_core::calibration::GyroscopeCalibration;
///
/// let calibration = GyroscopeCalibration {
///     matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     bias: [0.5, 0.0, 0.0],
///     g_sensitivity: [[0.0, 0.0, 0.125], [0.0; 3], [0.0; 3]],
/// };
/// let rate_rad_s = calibration.apply([1.5, 0.0, 2.0], [0.0, 0.0, 8.0]);
/// assert_eq!(rate_rad_s, [0.0, 0.0, 2.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroscopeCalibration<T> {
    /// Row-major 3 × 3, rad/s per raw unit.
    pub matrix: [[T; 3]; 3],
    /// The reading at rest and without acceleration, in the raw unit.
    pub bias: [T; 3],
    /// Row-major 3 × 3, raw unit per m/s²: row = gyroscope, column = accelerometer axis.
    pub g_sensitivity: [[T; 3]; 3],
}

impl<T: Real> GyroscopeCalibration<T> {
    /// One sample of three channels, raw unit → rad/s; `accel_mps2` is the
    /// calibrated specific force of the same moment in m/s².
    ///
    /// Nothing is checked: where an argument is not finite, neither is the result.
    pub fn apply(&self, raw: [T; 3], accel_mps2: [T; 3]) -> [T; 3] {
        let reaction = matrix3::mul_vec(&self.g_sensitivity, &accel_mps2);
        let rate = matrix3::sub(&matrix3::sub(&raw, &self.bias), &reaction);
        matrix3::mul_vec(&self.matrix, &rate)
    }
}
