//! The gyroscope's half of the six-position calibration: a turn by a known
//! angle about each axis, and the six holds for bias and g-sensitivity.

use core::array::from_fn;

use super::{SixPositionError, SixPositionMeans, check_gravity, check_means, split};
use crate::Real;
use crate::calibration::{GyroscopeCalibration, rate_left};
use crate::matrix3;

/// The gyroscope model u = K R ω + b + S a, ω in rad/s, a in m/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroscopeParameters<T> {
    /// The diagonal of K, raw unit per rad/s, always positive.
    pub scale: [T; 3],
    /// R, row-major, rows of unit length: the sensor's axes in the frame of the turns.
    pub orientation: [[T; 3]; 3],
    /// b, in the raw unit.
    pub bias: [T; 3],
    /// S, row-major, raw unit per m/s².
    pub g_sensitivity: [[T; 3]; 3],
}

impl<T: Real> GyroscopeParameters<T> {
    /// M = K R, row-major, raw unit per rad/s.
    #[must_use]
    pub fn model(&self) -> [[T; 3]; 3] {
        matrix3::scale_rows(&self.orientation, &self.scale)
    }

    /// The way back, ω = R⁻¹K⁻¹ (u − b − S a), raw unit → rad/s.
    ///
    /// `None` where K R has no inverse, which [`ferraris_gyroscope`] has
    /// excluded already.
    #[must_use]
    pub fn calibration(&self) -> Option<GyroscopeCalibration<T>> {
        Some(GyroscopeCalibration {
            matrix: matrix3::inverse(&self.model())?,
            bias: self.bias,
            g_sensitivity: self.g_sensitivity,
        })
    }
}

/// The gyroscope's reaction to acceleration, S = (U_g₊ − U_g₋)/2g.
///
/// `means_gyro` are the gyroscope's means in the six holds, in the raw unit;
/// `gravity_mps2` in m/s². The result is row-major, raw unit per m/s². A drift
/// of the bias from one hold to its opposite is not distinguished from it.
///
/// # Errors
///
/// [`SixPositionError`] when a value is not finite or gravity is not positive.
pub fn g_sensitivity<T: Real>(
    means_gyro: &SixPositionMeans<T>,
    gravity_mps2: T,
) -> Result<[[T; 3]; 3], SixPositionError> {
    check_means(means_gyro, "mean readings of the gyroscope")?;
    check_gravity(gravity_mps2)?;
    Ok(means_gyro.half_difference(gravity_mps2))
}

/// Scale and orientation from three turns, beside bias and g-sensitivity from
/// the six holds (Ferraris et al. 1995).
///
/// - `bias`: the mean over all samples of the six holds together, raw unit.
/// - `means_gyro`, `gravity_mps2`: as for [`g_sensitivity`].
/// - `turns`: `turns[i]` is the [`TurnIntegral`] of the turn about axis i, in
///   raw unit · s.
/// - `angle_rad`: how far each turn went about the positive axis, in rad, the
///   same for the three; −2π for the usual full turn clockwise.
///
/// With W the matrix whose *columns* are the turns, M = W (angle · I)⁻¹, K =
/// the norms of its rows, R = K⁻¹M.
///
/// An error of the angle is an error of the scale in the same proportion. A turn the
/// other way round gives R the wrong sign: det R is near −1 after an odd number of them;
/// two show only as negative elements on the diagonal of R.
///
/// # Errors
///
/// [`SixPositionError`] when a value is not finite, gravity is not positive,
/// the angle is zero, a channel did not turn, or two react alike.
///
/// ```
/// use core::f64::consts::TAU;
/// use gravical_core::six_position::{SixPositionMeans, TurnIntegral, ferraris_gyroscope};
///
/// // A gyroscope in °/s without any error but a bias of 1 °/s on x.
/// let bias = [1.0, 0.0, 0.0];
/// let at_rest = SixPositionMeans { plus: [bias; 3], minus: [bias; 3] };
/// let turns = core::array::from_fn(|axis| {
///     let mut turn = TurnIntegral::new(bias, [[0.0; 3]; 3]);
///     for _ in 0..400 {
///         let mut raw_deg_s = bias;
///         raw_deg_s[axis] -= 90.0;
///         turn.add(raw_deg_s, [0.0, 0.0, 9.81], 0.01);
///     }
///     turn.finish()
/// });
/// let parameters = ferraris_gyroscope(bias, &at_rest, 9.81, &turns, -TAU)?;
/// let calibration = parameters.calibration().expect("Ferraris has checked it");
/// let rate_rad_s = calibration.apply([1.0, 180.0, 0.0], [0.0, 0.0, 9.81]);
/// assert!((rate_rad_s[1] - TAU / 2.0).abs() < 1e-12);
/// # Ok::<(), gravical_core::six_position::SixPositionError>(())
/// ```
pub fn ferraris_gyroscope<T: Real>(
    bias: [T; 3],
    means_gyro: &SixPositionMeans<T>,
    gravity_mps2: T,
    turns: &[[T; 3]; 3],
    angle_rad: T,
) -> Result<GyroscopeParameters<T>, SixPositionError> {
    let g_sensitivity = g_sensitivity(means_gyro, gravity_mps2)?;
    let not_finite = |input| Err(SixPositionError::NotFinite { input });
    if !bias.iter().all(|b| b.is_finite()) {
        return not_finite("bias of the gyroscope");
    }
    if !matrix3::is_finite(turns) {
        return not_finite("integrals of the turns");
    }
    if !angle_rad.is_finite() {
        return not_finite("angle of the turns");
    }
    if angle_rad == T::zero() {
        return Err(SixPositionError::AngleZero);
    }
    let model = from_fn(|r| from_fn(|i| turns[i][r] / angle_rad));
    // An integral has no offset to lose digits against: only zero has vanished.
    let (scale, orientation) = split(&model, &[T::zero(); 3])?;
    Ok(GyroscopeParameters {
        scale,
        orientation,
        bias,
        g_sensitivity,
    })
}

/// The integral of one turn, ∫(u − b − S a) dt, sample by sample.
///
/// Rectangles: each sample stands for the time that it is given. The sum is
/// compensated (Kahan 1965), so that `f32` does not lose the small steps of a
/// long turn; what a clock error of x % costs is x % of scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnIntegral<T> {
    bias: [T; 3],
    g_sensitivity: [[T; 3]; 3],
    sum: [T; 3],
    lost: [T; 3],
}

impl<T: Real> TurnIntegral<T> {
    /// An integral of zero; `bias` in the raw unit, `g_sensitivity` row-major in
    /// raw unit per m/s² (zeros where it is not known).
    #[must_use]
    pub fn new(bias: [T; 3], g_sensitivity: [[T; 3]; 3]) -> Self {
        Self {
            bias,
            g_sensitivity,
            sum: [T::zero(); 3],
            lost: [T::zero(); 3],
        }
    }

    /// Adds one sample: the gyroscope in the raw unit, the calibrated
    /// accelerometer in m/s², and the time in s that the sample stands for.
    ///
    /// Nothing is checked: a value that is not finite makes the integral so, and
    /// [`ferraris_gyroscope`] says it.
    pub fn add(&mut self, gyro_raw: [T; 3], accel_mps2: [T; 3], period_s: T) {
        let rate = rate_left(&self.bias, &self.g_sensitivity, &gyro_raw, &accel_mps2);
        for ((sum, lost), rate) in self.sum.iter_mut().zip(&mut self.lost).zip(rate) {
            let step = rate * period_s - *lost;
            let next = *sum + step;
            *lost = (next - *sum) - step;
            *sum = next;
        }
    }

    /// The integral so far, in raw unit · s.
    #[must_use]
    pub fn finish(self) -> [T; 3] {
        self.sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::six_position::tests::{assert_close, placements};
    use core::f64::consts::TAU;

    const BIAS: [f64; 3] = [1.5, -0.75, 0.3];
    /// °/s per rad/s with 2 % of scale and a few degrees of misalignment.
    const MODEL: [[f64; 3]; 3] = [[58.2, 1.1, -0.9], [0.4, 56.6, 1.3], [-2.2, 0.7, 57.5]];
    const REACTION: [[f64; 3]; 3] = [
        [0.01, -0.002, 0.004],
        [0.0, 0.02, -0.01],
        [0.003, 0.005, -0.008],
    ];
    const GRAVITY: f64 = 9.81;

    /// A turn by `angle` in 8 s, tilting through gravity, at 50 Hz.
    fn turn<T: Real>(axis: usize, angle: f64) -> [T; 3] {
        let mut integral = TurnIntegral::new(cast(BIAS), REACTION.map(cast));
        for i in 0..400 {
            let phase = f64::from(i) / 400.0 * TAU;
            let accel = [GRAVITY * phase.sin(), 0.5, GRAVITY * phase.cos()];
            // Rises and falls, and its mean over the turn is exactly angle/8 s.
            let rate = angle / 8.0 * (1.0 - phase.cos());
            let raw: [f64; 3] =
                from_fn(|r| BIAS[r] + MODEL[r][axis] * rate + matrix3::dot(&REACTION[r], &accel));
            integral.add(cast(raw), cast(accel), T::from_f64(0.02));
        }
        integral.finish()
    }

    fn cast<T: Real, const N: usize>(values: [f64; N]) -> [T; N] {
        values.map(T::from_f64)
    }

    fn estimate<T: Real>() -> GyroscopeParameters<T> {
        let means = placements(REACTION, BIAS, GRAVITY);
        let means = SixPositionMeans {
            plus: means.plus.map(cast),
            minus: means.minus.map(cast),
        };
        let turns = from_fn(|axis| turn(axis, -TAU));
        let (g, angle) = (T::from_f64(GRAVITY), T::from_f64(-TAU));
        ferraris_gyroscope(cast(BIAS), &means, g, &turns, angle).unwrap()
    }

    #[test]
    fn simulated_parameters_come_back() {
        let double = estimate::<f64>();
        assert_close(&double.model(), &MODEL, 1e-12 * 58.0);
        assert_close(&double.g_sensitivity, &REACTION, 1e-14);
        let (rate, accel) = ([0.3, -1.2, 2.0], [4.0, -3.0, 8.0]);
        let raw = from_fn(|r| {
            BIAS[r] + matrix3::dot(&MODEL[r], &rate) + matrix3::dot(&REACTION[r], &accel)
        });
        let got = double.calibration().unwrap().apply(raw, accel);
        assert!(
            got.iter().zip(rate).all(|(g, r)| (g - r).abs() < 1e-12),
            "{got:?}"
        );
        let single = estimate::<f32>();
        assert_close(
            &single.model().map(|row| row.map(f64::from)),
            &MODEL,
            1e-5 * 58.0,
        );
    }

    #[test]
    fn what_is_wrong_is_named() {
        use SixPositionError::*;
        let means = placements(REACTION, BIAS, GRAVITY);
        let turns: [[f64; 3]; 3] = from_fn(|axis| turn(axis, -TAU));
        let refused = |bias, gravity, turns, angle| {
            ferraris_gyroscope(bias, &means, gravity, &turns, angle).unwrap_err()
        };
        for (refused, input) in [
            (
                refused([f64::NAN; 3], GRAVITY, turns, -TAU),
                "bias of the gyroscope",
            ),
            (
                refused(BIAS, GRAVITY, [[f64::INFINITY; 3]; 3], -TAU),
                "integrals of the turns",
            ),
            (
                refused(BIAS, GRAVITY, turns, f64::NAN),
                "angle of the turns",
            ),
        ] {
            assert_eq!(refused, NotFinite { input });
        }
        assert_eq!(refused(BIAS, GRAVITY, turns, 0.0), AngleZero);
        assert_eq!(refused(BIAS, 0.0, turns, -TAU), GravityNotPositive);
        let still = turns.map(|[_, y, z]| [0.0, y, z]);
        let error = VanishedRow { channel: 0 };
        assert_eq!(refused(BIAS, GRAVITY, still, -TAU), error);
        let same = [turns[0], turns[1], turns[1]];
        assert_eq!(refused(BIAS, GRAVITY, same, -TAU), Singular);
    }

    #[test]
    fn a_long_turn_keeps_its_small_steps_in_single_precision() {
        // A million samples of 0.1 · 0.001: a plain f32 sum is 1 % off.
        let mut integral = TurnIntegral::new([0.0_f32; 3], [[0.0; 3]; 3]);
        let mut plain = 0.0_f32;
        for _ in 0..1_000_000 {
            integral.add([0.1; 3], [0.0; 3], 0.001);
            plain += 0.1 * 0.001;
        }
        let compensated = integral.finish();
        assert!((compensated[0] - 100.0).abs() < 1e-4, "{compensated:?}");
        assert!((plain - 100.0).abs() > 0.01, "{plain}");
    }
}
