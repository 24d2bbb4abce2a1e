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
/// use gravical_core::calibration::Calibration;
///
/// let calibration = Calibration {
///     matrix: [[0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     bias: [1.0, 0.0, -1.0],
/// };
/// assert_eq!(calibration.apply([21.0, 0.0, -1.0]), [10.0, 0.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration<T> {
    /// Row-major 3 × 3, calibrated unit per raw unit.
    pub matrix: [[T; 3]; 3],
    /// The reading at zero input, in the raw unit.
    pub bias: [T; 3],
}

impl<T: Real> Calibration<T> {
    /// The calibration that changes nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self {
            matrix: matrix3::identity(),
            bias: [T::zero(); 3],
        }
    }

    /// One sample of three channels, raw unit → calibrated unit.
    ///
    /// Nothing is checked: where `raw` is not finite, neither is the result.
    #[must_use]
    pub fn apply(&self, raw: [T; 3]) -> [T; 3] {
        matrix3::mul_vec(&self.matrix, &matrix3::sub(&raw, &self.bias))
    }

    /// The calibration that does this one first and `outer` on its result, for
    /// instance a unit first and the sensor's own calibration after.
    ///
    /// The bias of `outer`, taken back to this one's input, needs this matrix
    /// to have an inverse: `None` where it has none (see [`matrix3::inverse`]).
    ///
    /// ```
    /// use gravical_core::calibration::Calibration;
    ///
    /// let counts_to_g = Calibration {
    ///     matrix: [[1.0 / 16384.0, 0.0, 0.0], [0.0, 1.0 / 16384.0, 0.0], [0.0, 0.0, 1.0 / 16384.0]],
    ///     bias: [0.0; 3],
    /// };
    /// let sensor = Calibration { bias: [0.25, 0.0, 0.0], ..Calibration::identity() };
    /// let both = counts_to_g.then(&sensor).expect("a diagonal without zeros has an inverse");
    /// assert_eq!(both.bias, [4096.0, 0.0, 0.0]);
    /// assert_eq!(both.apply([4096.0, 0.0, 16384.0]), [0.0, 0.0, 1.0]);
    /// ```
    #[must_use]
    pub fn then(&self, outer: &Self) -> Option<Self> {
        let back = matrix3::inverse(&self.matrix)?;
        let shift = matrix3::mul_vec(&back, &outer.bias);
        Some(Self {
            matrix: matrix3::mul(&outer.matrix, &self.matrix),
            bias: [
                self.bias[0] + shift[0],
                self.bias[1] + shift[1],
                self.bias[2] + shift[2],
            ],
        })
    }

    /// The way back, calibrated → raw, again as `matrix · (x − bias)`.
    ///
    /// raw = S⁻¹ · calibrated + o is S⁻¹ · (calibrated − (−S · o)). `None` where
    /// the matrix has no inverse (see [`matrix3::inverse`]).
    ///
    /// ```
    /// use gravical_core::calibration::Calibration;
    ///
    /// let calibration = Calibration { bias: [0.5, 0.0, 0.0], ..Calibration::identity() };
    /// let sensor = calibration.invert().expect("the identity has an inverse");
    /// assert_eq!(sensor.apply([1.0, 2.0, 3.0]), [1.5, 2.0, 3.0]);
    /// ```
    #[must_use]
    pub fn invert(&self) -> Option<Self> {
        Some(Self {
            matrix: matrix3::inverse(&self.matrix)?,
            bias: matrix3::mul_vec(&self.matrix, &self.bias).map(|x| -x),
        })
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
///     bias: [0.5, 0.0, 0.0],
///     g_sensitivity: [[0.0, 0.0, 0.125], [0.0; 3], [0.0; 3]],
///     ..GyroscopeCalibration::identity()
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
    /// The calibration that changes nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self {
            matrix: matrix3::identity(),
            bias: [T::zero(); 3],
            g_sensitivity: [[T::zero(); 3]; 3],
        }
    }

    /// One sample of three channels, raw unit → rad/s; `accel_mps2` is the
    /// calibrated specific force of the same moment in m/s².
    ///
    /// Nothing is checked: where an argument is not finite, neither is the result.
    #[must_use]
    pub fn apply(&self, raw: [T; 3], accel_mps2: [T; 3]) -> [T; 3] {
        let rate = rate_left(&self.bias, &self.g_sensitivity, &raw, &accel_mps2);
        matrix3::mul_vec(&self.matrix, &rate)
    }
}

/// What is left of a gyroscope's reading, in its own unit, without its bias and
/// its reaction to acceleration.
pub(crate) fn rate_left<T: Real>(
    bias: &[T; 3],
    g_sensitivity: &[[T; 3]; 3],
    raw: &[T; 3],
    accel_mps2: &[T; 3],
) -> [T; 3] {
    let reaction = matrix3::mul_vec(g_sensitivity, accel_mps2);
    matrix3::sub(&matrix3::sub(raw, bias), &reaction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(limit: f64) -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3(-limit..limit)
    }

    /// At most 0.2 from the identity per element, so that it has an inverse.
    fn calibration() -> impl Strategy<Value = Calibration<f64>> {
        (prop::array::uniform3(vector(0.2)), vector(1.0)).prop_map(|(mut matrix, bias)| {
            for (i, row) in matrix.iter_mut().enumerate() {
                row[i] += 1.0;
            }
            Calibration { matrix, bias }
        })
    }

    fn close(a: [f64; 3], b: [f64; 3], tolerance: f64) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance)
    }

    proptest! {
        #[test]
        fn the_inverse_takes_back(c in calibration(), raw in vector(20.0)) {
            // 20 times a condition number of a few times the epsilon of f64.
            let back = c.invert().unwrap();
            prop_assert!(close(back.apply(c.apply(raw)), raw, 1e-13));
            prop_assert!(close(c.apply(back.apply(raw)), raw, 1e-13));
        }

        #[test]
        fn single_precision_takes_back_too(c in calibration(), raw in vector(20.0)) {
            let single = Calibration {
                matrix: c.matrix.map(|row| row.map(|x| x as f32)),
                bias: c.bias.map(|x| x as f32),
            };
            let there = single.apply(raw.map(|x| x as f32));
            let back = single.invert().unwrap().apply(there);
            prop_assert!(close(back.map(f64::from), raw, 1e-4));
            prop_assert!(close(there.map(f64::from), c.apply(raw), 1e-5));
        }

        #[test]
        fn then_is_one_after_the_other(
            inner in calibration(), outer in calibration(), raw in vector(20.0)
        ) {
            let both = inner.then(&outer).unwrap();
            prop_assert!(close(both.apply(raw), outer.apply(inner.apply(raw)), 1e-13));
        }
    }

    #[test]
    fn a_flat_matrix_has_no_way_back() {
        let flat = Calibration {
            matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
            bias: [0.0; 3],
        };
        assert_eq!(flat.invert(), None);
        assert_eq!(flat.then(&Calibration::identity()), None);
        // As the outer one it needs no inverse.
        assert!(Calibration::identity().then(&flat).is_some());
    }
}
