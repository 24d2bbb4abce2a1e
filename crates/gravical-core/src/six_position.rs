//! The six-position calibration in closed form.
//!
//! The sensor rests with each axis up and down. The reading is u = K R a + b:
//! K diagonal (scale), R with unit rows (orientation and misalignment), b the
//! bias. Opposite placements give all three at once: insensitive to how the
//! sensor sat before, and without iteration.
//!
//! Source: F. Ferraris, U. Grimaldi, M. Parvis, "Procedure for effortless
//! in-field calibration of three-axis rate gyros and accelerometers", Sensors
//! and Materials 7(5), 1995. The true inverse R⁻¹ is taken throughout; the rows
//! of R are unit vectors but not orthogonal, so Rᵀ is not it.

use core::array::from_fn;
use core::fmt;

use crate::Real;
use crate::calibration::LinearCalibration;
use crate::matrix3;

/// The mean readings of the six placements, three channels each, in the raw unit.
///
/// An accelerometer at rest reads +g on the axis that points up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SixPositionMeans<T> {
    /// `plus[i]`: channels x, y, z while axis i points up.
    pub plus: [[T; 3]; 3],
    /// `minus[i]`: channels x, y, z while axis i points down.
    pub minus: [[T; 3]; 3],
}

impl<T: Real> SixPositionMeans<T> {
    /// The largest absolute reading of one channel.
    fn largest(&self, channel: usize) -> T {
        self.plus
            .iter()
            .chain(&self.minus)
            .fold(T::zero(), |largest, u| largest.max(u[channel].abs()))
    }
}

/// Why six placements gave no parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SixPositionError {
    /// A mean reading is NaN or infinite, or so large that its square is.
    NotFinite,
    /// Gravity is no positive number.
    GravityNotPositive,
    /// A channel reacts to nothing: it is frozen, or all files are the same.
    VanishedRow {
        /// The channel: 0, 1 or 2 for x, y or z.
        channel: usize,
    },
    /// Two channels react alike, so that the model cannot be inverted.
    Singular,
}

impl fmt::Display for SixPositionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "a mean reading is not finite"),
            Self::GravityNotPositive => write!(f, "gravity has to be a number above zero"),
            Self::VanishedRow { channel } => {
                let name = ["x", "y", "z"].get(*channel).unwrap_or(&"?");
                write!(f, "channel {name} reads the same in opposite positions")
            }
            Self::Singular => f.write_str(
                "the readings span fewer than three directions: the model has no inverse",
            ),
        }
    }
}

impl core::error::Error for SixPositionError {}

/// The accelerometer model u = K R a + b, a in m/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerometerParameters<T> {
    /// The diagonal of K, raw unit per m/s², always positive.
    pub scale: [T; 3],
    /// R, row-major, rows of unit length: the sensor's axes in the frame of the placements.
    pub orientation: [[T; 3]; 3],
    /// b, in the raw unit.
    pub bias: [T; 3],
}

impl<T: Real> AccelerometerParameters<T> {
    /// M = K R of u = M a + b, row-major, raw unit per m/s².
    pub fn model(&self) -> [[T; 3]; 3] {
        matrix3::scale_rows(&self.orientation, &self.scale)
    }

    /// The way back, a = R⁻¹K⁻¹ (u − b), raw unit → m/s².
    ///
    /// `None` where K R has no inverse, which [`ferraris_accelerometer`] has
    /// excluded already.
    pub fn calibration(&self) -> Option<LinearCalibration<T>> {
        Some(LinearCalibration {
            matrix: matrix3::inverse(&self.model())?,
            bias: self.bias,
        })
    }
}

/// Scale, orientation and bias from six placements (Ferraris et al. 1995).
///
/// `means` in any unit (the raw unit), `gravity_mps2` in m/s². With D = U₊ − U₋:
/// K_ii = ‖row i of D‖/2g, R = K⁻¹D/2g, b = the diagonal of (U₊ + U₋)/2: each
/// channel from the pair of placements along which it points, where a tilt
/// enters squared. That is its own axis, unless the sensor sits turned in the
/// frame of the placements.
///
/// The result depends on nothing but the six means, and has as many parameters
/// as they have directions to give: its errors on these same placements say
/// little about its accuracy.
///
/// # Errors
///
/// [`SixPositionError`] when a value is not finite, gravity is not positive, a
/// channel does not react, or two react alike. Swapped files are *not* an
/// error here: a left-handed R fits its own placements perfectly, and nothing but its
/// negative determinant ([`matrix3::det`]) gives them away.
///
/// ```
/// use gravical_core::six_position::{SixPositionMeans, ferraris_accelerometer};
///
/// // m/s², from a real MPU6050.
/// let means = SixPositionMeans {
///     plus: [[10.20, -0.04, -0.10], [0.29, 9.73, 0.49], [0.83, -0.18, 10.42]],
///     minus: [[-9.43, -0.27, 0.92], [0.46, -9.99, 0.39], [-0.05, -0.08, -9.54]],
/// };
/// let parameters = ferraris_accelerometer(&means, 9.81)?;
/// assert!((parameters.bias[2] - 0.44_f64).abs() < 1e-12);
/// assert!((parameters.scale[0] - 1.001552).abs() < 1e-6);
///
/// let calibration = parameters.calibration().expect("Ferraris has checked it");
/// let up = calibration.apply(means.plus[2]);
/// assert!((up[2] - 9.81).abs() < 0.03);
/// # Ok::<(), gravical_core::six_position::SixPositionError>(())
/// ```
pub fn ferraris_accelerometer<T: Real>(
    means: &SixPositionMeans<T>,
    gravity_mps2: T,
) -> Result<AccelerometerParameters<T>, SixPositionError> {
    if !(gravity_mps2.is_finite() && gravity_mps2 > T::zero()) {
        return Err(SixPositionError::GravityNotPositive);
    }
    // (U₊ − U₋)/2g, where the columns of U₊ and U₋ are the placements.
    let two_g = gravity_mps2 + gravity_mps2;
    let model: [[T; 3]; 3] =
        from_fn(|r| from_fn(|i| (means.plus[i][r] - means.minus[i][r]) / two_g));
    // K, the norms of its rows, and R with rows of unit length. No reading that is not finite leaves
    // them finite.
    let scale = matrix3::row_norms(&model);
    if !scale.iter().all(|k| k.is_finite()) {
        return Err(SixPositionError::NotFinite);
    }
    // What rounding leaves of the difference of two readings that are equal on
    // paper: their means are sums, so a few times the epsilon of their size.
    let rounding = T::from_f64(64.0) * T::epsilon() / gravity_mps2;
    if let Some(channel) = (0..3).find(|&r| scale[r] <= means.largest(r) * rounding) {
        return Err(SixPositionError::VanishedRow { channel });
    }
    let orientation = from_fn(|r| model[r].map(|x| x / scale[r]));
    if matrix3::inverse(&orientation).is_none() {
        return Err(SixPositionError::Singular);
    }
    let half = T::from_f64(0.5);
    Ok(AccelerometerParameters {
        scale,
        orientation,
        bias: from_fn(|i| {
            let pair = own_pair(&model, i);
            half * (means.plus[pair][i] + means.minus[pair][i])
        }),
    })
}

/// The axis of the placements along which a channel points most: its own one
/// where two are alike.
fn own_pair<T: Real>(model: &[[T; 3]; 3], channel: usize) -> usize {
    (0..3).fold(channel, |best, axis| {
        if model[channel][axis].abs() > model[channel][best].abs() {
            axis
        } else {
            best
        }
    })
}

#[cfg(test)]
mod tests;
