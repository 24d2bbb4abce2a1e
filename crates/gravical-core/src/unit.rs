//! Units, the nominal sensitivities of the MPU6050, and local gravity.
//!
//! Inside gravical everything is m/s², rad/s, s and °C; a recording is
//! converted once, when it is read. The constants are `f64`; [`crate::Real`]
//! rounds one to the type of a computation.

use crate::Real;

/// Standard gravity in m/s², exact by definition (CGPM 1901): what "1 g" means
/// as a unit. It is not the gravity at any given place, for which there is
/// [`local_gravity_mps2`].
pub const STANDARD_GRAVITY_MPS2: f64 = 9.80665;

/// One degree in radians.
pub const RADIANS_PER_DEGREE: f64 = core::f64::consts::PI / 180.0;

/// One radian in degrees.
pub const DEGREES_PER_RADIAN: f64 = 180.0 / core::f64::consts::PI;

/// The full-scale ranges of the MPU6050's accelerometer in g, each with its
/// nominal sensitivity in LSB per g (MPU-6000/6050 product specification,
/// section 6.2). A single device is within ±3 % of it.
pub const MPU6050_ACCELEROMETER_LSB_PER_G: [(u16, f64); 4] =
    [(2, 16384.0), (4, 8192.0), (8, 4096.0), (16, 2048.0)];

/// The full-scale ranges of the MPU6050's gyroscope in °/s, each with its
/// nominal sensitivity in LSB per °/s (MPU-6000/6050 product specification,
/// section 6.1). A single device is within ±3 % of it.
pub const MPU6050_GYROSCOPE_LSB_PER_DEG_S: [(u16, f64); 4] =
    [(250, 131.0), (500, 65.5), (1000, 32.8), (2000, 16.4)];

/// The gravity of the WGS 84 ellipsoid in m/s² at a geodetic latitude in
/// degrees and a height above the ellipsoid in metres.
///
/// Somigliana's closed form on the ellipsoid and the second-order expansion in
/// the height (NIMA TR8350.2, equations 4-1 and 4-3). Real gravity usually
/// differs from it by less than 0.001 m/s², by more in high mountains. A height
/// above sea level may stand for one above the ellipsoid: the two are within
/// about 100 m, which is 0.0003 m/s².
///
/// The latitude is not checked: beyond ±90° the result is that of the mirrored
/// latitude. It is not finite where an argument is not.
///
/// ```
/// use gravical_core::unit::local_gravity_mps2;
///
/// let cairo_mps2 = local_gravity_mps2(30.0444, 23.0);
/// assert!((cairo_mps2 - 9.793211_f64).abs() < 5e-7);
/// ```
pub fn local_gravity_mps2<T: Real>(latitude_deg: T, height_m: T) -> T {
    const SEMI_MAJOR_AXIS_M: f64 = 6_378_137.0;
    const FLATTENING: f64 = 1.0 / 298.257_223_563;
    // ω²a²b/GM, the ratio of centrifugal to gravitational acceleration.
    const CENTRIFUGAL_RATIO: f64 = 0.003_449_786_506_84;

    let constant = T::from_f64;
    let one = T::one();
    let sine = (latitude_deg * constant(RADIANS_PER_DEGREE)).sin();
    let s = sine * sine;
    let on_the_ellipsoid = constant(9.780_325_335_9) * (one + constant(0.001_931_852_652_41) * s)
        / (one - constant(0.006_694_379_990_13) * s).sqrt();

    let h = height_m / constant(SEMI_MAJOR_AXIS_M);
    let slope = constant(1.0 + FLATTENING + CENTRIFUGAL_RATIO) - constant(2.0 * FLATTENING) * s;
    on_the_ellipsoid * (one - constant(2.0) * h * slope + constant(3.0) * h * h)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Latitude, height, gravity and half a unit of its last digit: published
    /// values of the formula (the first three are the equator, 45° and the pole).
    const GRAVITY: [(f64, f64, f64, f64); 6] = [
        (0.0, 0.0, 9.780_325_335_9, 5e-11),
        (45.0, 0.0, 9.806_197_769_4, 5e-11),
        (90.0, 0.0, 9.832_184_937_9, 5e-11),
        (30.0444, 23.0, 9.793_211, 5e-7),
        (47.3769, 408.0, 9.807_088, 5e-7),
        (-16.5, 3640.0, 9.773_263, 5e-7),
    ];

    #[test]
    fn gravity_agrees_to_the_last_digit() {
        for (latitude, height, expected, half_digit) in GRAVITY {
            let got = local_gravity_mps2(latitude, height);
            assert!((got - expected).abs() <= half_digit, "{latitude}: {got}");
            let got = f64::from(local_gravity_mps2(latitude as f32, height as f32));
            // A few roundings of 9.8, whose neighbours in f32 are 9.5e-7 apart.
            assert!((got - expected).abs() < 3e-6, "{latitude}: {got}");
        }
        assert!(local_gravity_mps2(f64::NAN, 0.0).is_nan());
        assert!(!local_gravity_mps2(0.0, f64::INFINITY).is_finite());
    }
}
