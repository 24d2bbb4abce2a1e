//! Attitude and position of the sensor as functions of time.
//!
//! Both sensors are computed from this path: angular rate is the derivative of the attitude,
//! specific force is f = Rᵀ(a + g ẑ) with the same attitude R (sensor → world, world z up). The
//! accelerometer is in the centre of every rotation.

use nalgebra::{UnitQuaternion, Vector3};

/// Attitude and position as functions of time; the sensor rests before the first and after the
/// last piece.
#[derive(Debug, Clone)]
pub(super) struct MotionPath {
    pub pieces: Vec<Piece>,
    pub gravity_mps2: f64,
}

/// One piece of the path: a rotation about a fixed axis and a straight displacement, or rest.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub start_s: f64,
    pub duration_s: f64,
    pub attitude: UnitQuaternion<f64>,
    /// Rotation vector in the sensor frame, rad.
    pub rotation: Vector3<f64>,
    pub displacement: Vector3<f64>,
}

/// From 0 to 1, starting and ending at rest: 10τ³ − 15τ⁴ + 6τ⁵ (Flash and Hogan 1985), with its first
/// and second derivative with respect to τ.
fn minimum_jerk(tau: f64) -> (f64, f64, f64) {
    let rest = 1.0 - tau;
    (
        tau * tau * tau * (10.0 + tau * (6.0 * tau - 15.0)),
        30.0 * tau * tau * rest * rest,
        60.0 * tau * rest * (1.0 - 2.0 * tau),
    )
}

impl MotionPath {
    /// Length of the path, s.
    pub fn duration_s(&self) -> f64 {
        let last = self.pieces.last();
        last.map_or(0.0, |p| p.start_s + p.duration_s)
    }

    /// Specific force, m/s², and angular rate, rad/s, in the sensor frame. The rate is exact, because the
    /// axis of a rotation is also fixed in the sensor.
    pub fn force_and_rate(&self, t_s: f64) -> [[f64; 3]; 2] {
        let up = Vector3::z() * self.gravity_mps2;
        let after = self.pieces.partition_point(|p| p.start_s <= t_s);
        // The first piece before the start.
        let Some(piece) = self.pieces.get(after.saturating_sub(1)) else {
            return [up.into(), [0.0; 3]];
        };
        let tau = ((t_s - piece.start_s) / piece.duration_s).clamp(0.0, 1.0);
        let (angle, rate, acceleration) = minimum_jerk(tau);
        let attitude = piece.attitude * UnitQuaternion::from_scaled_axis(piece.rotation * angle);
        let per_s = 1.0 / piece.duration_s;
        let acceleration = piece.displacement * (acceleration * per_s * per_s);
        let force = attitude.inverse_transform_vector(&(acceleration + up));
        let rate = piece.rotation * (rate / piece.duration_s);
        [force.into(), rate.into()]
    }
}
