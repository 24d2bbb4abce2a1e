//! Attitude and position of the sensor as functions of time.
//!
//! Both sensors are computed from this path: angular rate is the derivative of the attitude,
//! specific force is f = Rᵀ(a + g ẑ) with the same attitude R (sensor → world, world z up). The
//! accelerometer is in the centre of every rotation.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};

/// Attitude and position as functions of time; the sensor rests before the first and after the
/// last piece.
#[derive(Debug, Clone)]
pub(super) struct MotionPath {
    pub(super) pieces: Vec<Piece>,
    pub(super) gravity_mps2: f64,
}

/// How an angle varies over the unit interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Law {
    /// To 1, starting and ending at rest: 10τ³ − 15τ⁴ + 6τ⁵ (Flash and Hogan 1985).
    MinimumJerk,
    /// One full sine, back to 0.
    Sine,
}

/// One piece of the path: a rotation about a fixed axis and a straight minimum-jerk displacement,
/// or rest.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub start_s: f64,
    pub duration_s: f64,
    pub attitude: UnitQuaternion<f64>,
    /// Rotation vector in the sensor frame, rad.
    pub rotation: Vector3<f64>,
    pub law: Law,
    pub position: Vector3<f64>,
    pub displacement: Vector3<f64>,
}

impl Law {
    /// Value and first derivative with respect to τ.
    fn at(self, tau: f64) -> (f64, f64) {
        match self {
            Law::MinimumJerk => {
                let (s, ds, _) = minimum_jerk(tau);
                (s, ds)
            }
            Law::Sine => ((TAU * tau).sin(), TAU * (TAU * tau).cos()),
        }
    }
}

/// Value, first and second derivative with respect to τ.
fn minimum_jerk(tau: f64) -> (f64, f64, f64) {
    let rest = 1.0 - tau;
    (
        tau * tau * tau * (10.0 + tau * (6.0 * tau - 15.0)),
        30.0 * tau * tau * rest * rest,
        60.0 * tau * rest * (1.0 - 2.0 * tau),
    )
}

impl Piece {
    pub(super) fn end_s(&self) -> f64 {
        self.start_s + self.duration_s
    }

    fn is_still(&self) -> bool {
        self.rotation == Vector3::zeros() && self.displacement == Vector3::zeros()
    }

    /// Angular rate, rad/s; exact, because the axis is also fixed in the sensor.
    fn rate(&self, tau: f64) -> Vector3<f64> {
        self.rotation * (self.law.at(tau).1 / self.duration_s)
    }

    pub(super) fn end_attitude(&self) -> UnitQuaternion<f64> {
        match self.law {
            Law::MinimumJerk => self.attitude * UnitQuaternion::from_scaled_axis(self.rotation),
            Law::Sine => self.attitude,
        }
    }

    pub(super) fn end_position(&self) -> Vector3<f64> {
        self.position + self.displacement
    }
}

/// Angular rate and specific force in the sensor frame.
pub(super) struct Inputs {
    pub rate: Vector3<f64>,
    pub force: Vector3<f64>,
}

impl MotionPath {
    /// Length of the path, s.
    pub fn duration_s(&self) -> f64 {
        self.pieces.last().map_or(0.0, Piece::end_s)
    }

    /// The inputs of the sensors at `t_s`, for a sensor that samples every `step_s`.
    ///
    /// A wobble starts with a jump of the angular rate. If such a jump is within the step around
    /// `t_s`, the rates on both sides are weighted by their durations; otherwise the sum of the
    /// rates would have an error of up to half a step.
    pub(super) fn inputs_at(&self, t_s: f64, step_s: f64) -> Inputs {
        let Some(index) = self.index_at(t_s) else {
            return Inputs {
                rate: Vector3::zeros(),
                force: Vector3::z() * self.gravity_mps2,
            };
        };
        let now = self.evaluate(&self.pieces[index], t_s);
        let mut rate = now.rate;
        let (from_s, to_s) = (t_s - 0.5 * step_s, t_s + 0.5 * step_s);
        let nearest = if index > 0 && self.pieces[index].start_s > from_s {
            index
        } else {
            index + 1
        };
        if let (Some(before), Some(after)) = (
            self.pieces.get(nearest.wrapping_sub(1)),
            self.pieces.get(nearest),
        ) && (from_s..to_s).contains(&after.start_s)
        {
            let share = (to_s - after.start_s) / step_s;
            rate = before.rate(1.0) * (1.0 - share) + after.rate(0.0) * share;
        }
        Inputs {
            rate,
            force: self.force(&now),
        }
    }

    /// True if the sensor rests at `t_s`.
    pub fn is_still_at(&self, t_s: f64) -> bool {
        self.piece_at(t_s).is_none_or(Piece::is_still)
    }

    fn piece_at(&self, t_s: f64) -> Option<&Piece> {
        self.pieces.get(self.index_at(t_s)?)
    }

    /// The piece at that time, the first one before the start; `None` for a path without pieces.
    fn index_at(&self, t_s: f64) -> Option<usize> {
        let after = self.pieces.partition_point(|p| p.start_s <= t_s);
        (!self.pieces.is_empty()).then(|| after.saturating_sub(1))
    }

    fn evaluate(&self, piece: &Piece, t_s: f64) -> Kinematics {
        let tau = ((t_s - piece.start_s) / piece.duration_s).clamp(0.0, 1.0);
        let moving = !piece.is_still() && (0.0..=piece.duration_s).contains(&(t_s - piece.start_s));
        if !moving {
            let ended = tau >= 1.0;
            return Kinematics {
                attitude: if ended {
                    piece.end_attitude()
                } else {
                    piece.attitude
                },
                rate: Vector3::zeros(),
                acceleration: Vector3::zeros(),
            };
        }
        let (angle, _) = piece.law.at(tau);
        let (.., acceleration) = minimum_jerk(tau);
        let per_s = 1.0 / piece.duration_s;
        Kinematics {
            attitude: piece.attitude * UnitQuaternion::from_scaled_axis(piece.rotation * angle),
            rate: piece.rate(tau),
            acceleration: piece.displacement * (acceleration * per_s * per_s),
        }
    }

    fn force(&self, now: &Kinematics) -> Vector3<f64> {
        let up = Vector3::z() * self.gravity_mps2;
        now.attitude
            .inverse_transform_vector(&(now.acceleration + up))
    }
}

struct Kinematics {
    attitude: UnitQuaternion<f64>,
    rate: Vector3<f64>,
    acceleration: Vector3<f64>,
}
