//! Attitude from angular rate, and from gravity at rest.
//!
//! An attitude is a unit quaternion w, x, y, z (Hamilton) that turns vectors of
//! the sensor into the frame of reference, whose z points up.
//!
//! ```
//! use gravical_core::strapdown::{level, rotate, from_rotation_vector, quat_mul};
//!
//! // A sensor that lies with x up, turned a quarter about its y: z is up then.
//! let q = level([9.81_f64, 0.0, 0.0], 0.0);
//! let up = rotate(&q, &[1.0, 0.0, 0.0]);
//! assert!((up[2] - 1.0).abs() < 1e-12);
//! let half = core::f64::consts::FRAC_PI_2;
//! let q = quat_mul(&q, &from_rotation_vector(&[0.0, half, 0.0]));
//! assert!((rotate(&q, &[0.0, 0.0, 1.0])[2] - 1.0).abs() < 1e-12);
//! ```

use crate::{Real, matrix3};

/// Squared half angle, rad², above which the series gives way to the exact sine:
/// 0.5 rad a step. Below it the series' error is under 3e-13.
const SERIES: f64 = 0.0625;

/// The quaternion of a rotation vector, rad.
#[inline]
#[must_use]
pub fn from_rotation_vector<T: Real>(vector: &[T; 3]) -> [T; 4] {
    let c = T::from_f64;
    let squared = c(0.25) * matrix3::dot(vector, vector);
    let (cosine, factor) = if squared < c(SERIES) {
        let cosine = T::one()
            - squared
                * (c(1.0 / 2.0)
                    - squared
                        * (c(1.0 / 24.0)
                            - squared * (c(1.0 / 720.0) - squared * c(1.0 / 40320.0))));
        let factor = c(0.5)
            - squared
                * (c(1.0 / 12.0)
                    - squared
                        * (c(1.0 / 240.0)
                            - squared * (c(1.0 / 10080.0) - squared * c(1.0 / 725_760.0))));
        (cosine, factor)
    } else {
        let half = squared.sqrt();
        (half.cos(), c(0.5) * half.sin() / half)
    };
    [
        cosine,
        factor * vector[0],
        factor * vector[1],
        factor * vector[2],
    ]
}

/// The rotation over one step of `h_s` seconds whose rate goes in a straight line
/// from `from` to `to`, rad/s: h (ω₀ + ω₁)/2 + h²/12 ω₀ × ω₁ (Magnus' series).
///
/// The straight line is what is left of the error: it falls with h².
#[inline]
#[must_use]
pub fn step<T: Real>(from: &[T; 3], to: &[T; 3], h_s: T) -> [T; 4] {
    let (a, b) = (T::from_f64(0.5) * h_s, h_s * h_s * T::from_f64(1.0 / 12.0));
    from_rotation_vector(&[
        a * (from[0] + to[0]) + b * (from[1] * to[2] - from[2] * to[1]),
        a * (from[1] + to[1]) + b * (from[2] * to[0] - from[0] * to[2]),
        a * (from[2] + to[2]) + b * (from[0] * to[1] - from[1] * to[0]),
    ])
}

/// The product of two quaternions: first `b`, then `a`.
#[inline]
#[must_use]
pub fn quat_mul<T: Real>(a: &[T; 4], b: &[T; 4]) -> [T; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
        a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
    ]
}

/// The rotation matrix of a unit quaternion, row-major.
#[inline]
#[must_use]
pub fn matrix<T: Real>(q: &[T; 4]) -> [[T; 3]; 3] {
    let [w, x, y, z] = *q;
    let one = T::one();
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    [
        [one - yy - zz, xy - wz, xz + wy],
        [xy + wz, one - xx - zz, yz - wx],
        [xz - wy, yz + wx, one - xx - yy],
    ]
}

/// A vector of the sensor, in the frame of reference.
#[inline]
#[must_use]
pub fn rotate<T: Real>(q: &[T; 4], v: &[T; 3]) -> [T; 3] {
    matrix3::mul_vec(&matrix(q), v)
}

/// A quaternion of length one again: rounding leaves a product of many off.
#[inline]
#[must_use]
pub fn normalize<T: Real>(q: &[T; 4]) -> [T; 4] {
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    q.map(|v| v / length)
}

/// The attitude of a sensor at rest that feels `force` (any unit): z up along
/// it, the sensor's x, made horizontal, `yaw_rad` from the frame's x. Where the
/// sensor's x is within 1e-6 of vertical its y takes its place, a quarter turn on.
///
/// A rest shows no yaw, and of tilt what bias leaves of it: bias/g rad. Not
/// finite where `force` is zero or not finite.
#[must_use]
pub fn level<T: Real>(force: [T; 3], yaw_rad: T) -> [T; 4] {
    let up = matrix3::scaled(&force, T::one() / matrix3::norm(&force));
    // Rows of the matrix: the frame's axes, seen from the sensor.
    let flat = T::one() - up[0] * up[0];
    let x = if flat > T::from_f64(1e-12) {
        let s = T::one() / flat.sqrt();
        [flat * s, -up[0] * up[1] * s, -up[0] * up[2] * s]
    } else {
        // y horizontal, then x = y × up is a quarter turn before it.
        let flat = T::one() - up[1] * up[1];
        let s = T::one() / flat.sqrt();
        let y = [-up[1] * up[0] * s, flat * s, -up[1] * up[2] * s];
        matrix3::cross(&y, &up)
    };
    let y = matrix3::cross(&up, &x);
    let half = yaw_rad * T::from_f64(0.5);
    let yaw = [half.cos(), T::zero(), T::zero(), half.sin()];
    quat_mul(&yaw, &from_matrix(&[x, y, up]))
}

/// The unit quaternion of a rotation matrix (Shepperd 1978), w not negative.
#[must_use]
pub fn from_matrix<T: Real>(m: &[[T; 3]; 3]) -> [T; 4] {
    let one = T::one();
    let quarter = T::from_f64(0.25);
    let trace = m[0][0] + m[1][1] + m[2][2];
    let q = if trace > m[0][0].max(m[1][1]).max(m[2][2]) {
        let w = (one + trace).sqrt() * T::from_f64(0.5);
        let s = quarter / w;
        [
            w,
            (m[2][1] - m[1][2]) * s,
            (m[0][2] - m[2][0]) * s,
            (m[1][0] - m[0][1]) * s,
        ]
    } else {
        // The largest of x, y, z first: nothing is divided by a small number.
        let i = if m[0][0] >= m[1][1] && m[0][0] >= m[2][2] {
            0
        } else if m[1][1] >= m[2][2] {
            1
        } else {
            2
        };
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let largest = (one + m[i][i] - m[j][j] - m[k][k]).max(T::zero()).sqrt() * T::from_f64(0.5);
        let s = quarter / largest;
        let mut q = [(m[k][j] - m[j][k]) * s, T::zero(), T::zero(), T::zero()];
        q[1 + i] = largest;
        q[1 + j] = (m[j][i] + m[i][j]) * s;
        q[1 + k] = (m[k][i] + m[i][k]) * s;
        q
    };
    let q = normalize(&q);
    if q[0] < T::zero() { q.map(|v| -v) } else { q }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: &[f64], b: &[f64], by: f64) {
        assert!(
            a.iter().zip(b).all(|(x, y)| (x - y).abs() < by),
            "{a:?} {b:?}"
        );
    }

    #[test]
    fn a_level_sensor_is_the_identity() {
        close(&level([0.0, 0.0, 9.81], 0.0), &[1.0, 0.0, 0.0, 0.0], 1e-15);
    }

    #[test]
    fn level_puts_the_force_up_and_keeps_the_yaw() {
        for force in [
            [1.0, 2.0, 3.0],
            [-9.8, 0.1, 0.0],
            [0.0, -9.8, 0.0],
            [0.0, 0.0, -9.8],
            [9.8, 1e-9, 0.0],
        ] {
            for yaw in [0.0, 0.7, -2.0] {
                let q = level(force, yaw);
                let seen = rotate(&q, &force);
                let norm = matrix3::norm(&force);
                close(&seen, &[0.0, 0.0, norm], 1e-9);
                let x = rotate(&q, &[1.0, 0.0, 0.0]);
                if x[0].hypot(x[1]) > 1e-3 {
                    close(&[x[1].atan2(x[0])], &[yaw], 1e-9);
                }
            }
        }
    }

    #[test]
    fn matrices_there_and_back() {
        for vector in [
            [0.1, 0.2, -0.3],
            [3.0, 0.0, 0.4],
            [0.0, 3.1, 0.1],
            [0.3, 0.2, -3.0],
        ] {
            let q = from_rotation_vector(&vector);
            let q = if q[0] < 0.0 { q.map(|v| -v) } else { q };
            close(&from_matrix(&matrix(&q)), &q, 1e-12);
        }
    }

    #[test]
    fn steps_of_any_size_are_exact_for_a_constant_rate() {
        for size in [1e-3, 0.4999, 0.5001, 1.0, 3.0_f64] {
            let q = step(
                &[0.6 * size, 0.0, 0.8 * size],
                &[0.6 * size, 0.0, 0.8 * size],
                1.0,
            );
            let (sine, cosine) = (0.5 * size).sin_cos();
            close(&q, &[cosine, 0.6 * sine, 0.0, 0.8 * sine], 1e-11);
        }
    }
}
