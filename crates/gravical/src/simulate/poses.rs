//! Directions and attitudes of poses.

use nalgebra::{Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::random::{Purpose, normal, stream};
use crate::poses::face::Face;
use gravical_fit::model::{sphere, tangents};

/// Standard deviation of a free pose from the planned one, per component, rad.
const FREE_POSE_SD: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Draws poses with their tilt.
pub(super) struct Draws {
    tilts: ChaCha8Rng,
    tilt_sd: f64,
}

impl Draws {
    pub(super) fn new(seed: u64, tilt_sd_deg: f64) -> Self {
        Self {
            tilts: stream(seed, Purpose::Tilts, 0),
            tilt_sd: tilt_sd_deg.to_radians(),
        }
    }

    /// Nominal and true direction of up for a pose on a face.
    pub(super) fn face_pose(&mut self, face: Face) -> (Vector3<f64>, Vector3<f64>) {
        let nominal = Vector3::from(face.direction());
        let tilted = tilted(nominal, &mut self.tilts, self.tilt_sd);
        (nominal, tilted)
    }
}

/// The face with z up.
pub(super) const Z_UP: Face = Face { axis: 2, up: true };

/// Rotates `direction` by two random normal components tangent to it, sd in rad each.
fn tilted(direction: Vector3<f64>, rng: &mut ChaCha8Rng, sd: f64) -> Vector3<f64> {
    let [first, second] = tangents(&direction);
    let delta = sd * (first * normal(rng) + second * normal(rng));
    let angle = delta.norm();
    if angle == 0.0 {
        return direction;
    }
    direction * angle.cos() + delta * (angle.sin() / angle)
}

/// Angle between two unit vectors, rad; also accurate for small angles.
pub(super) fn tilt_between(a: Vector3<f64>, b: Vector3<f64>) -> f64 {
    a.cross(&b).norm().atan2(a.dot(&b))
}

/// Attitude (sensor → world) in which `up` points up and the horizontal component of the sensor's
/// x points along the world's x; that of y if x is up.
pub(super) fn attitude_of(up: Vector3<f64>) -> UnitQuaternion<f64> {
    let reference = if up.x.abs() > 0.9 {
        Vector3::y()
    } else {
        Vector3::x()
    };
    let x = (reference - up * up.dot(&reference)).normalize();
    let rows = Matrix3::from_columns(&[x, up.cross(&x), up]).transpose();
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rows))
}

/// The rotation with the smallest angle from `from` to `to` (unit vectors).
pub(super) fn shortest_turn(from: Vector3<f64>, to: Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = tilt_between(from, to);
    let axis = from.cross(&to);
    // Between opposite directions the axis is arbitrary.
    let axis = if axis.norm() > 1e-9 {
        axis
    } else {
        tangents(&from)[0]
    };
    UnitQuaternion::from_axis_angle(&Unit::new_normalize(axis), angle)
}

/// `count` directions far from the six faces and from each other: each is the one of 400 on a
/// Fibonacci sphere that is farthest from all before, with a random error of some degrees as by
/// hand.
pub(super) fn spread_directions(count: usize, seed: u64) -> Vec<[f64; 3]> {
    let candidates: Vec<_> = sphere(400).collect();
    let mut taken = Face::all()
        .map(|face| Vector3::from(face.direction()))
        .to_vec();
    let mut rng = stream(seed, Purpose::FreePoses, 0);
    let mut found = Vec::with_capacity(count);
    for _ in 0..count {
        let closeness = |c: &Vector3<f64>| {
            taken
                .iter()
                .map(|t| t.dot(c))
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let farthest = candidates
            .iter()
            .min_by(|a, b| closeness(a).total_cmp(&closeness(b)));
        if let Some(&direction) = farthest {
            taken.push(direction);
            found.push(tilted(direction, &mut rng, FREE_POSE_SD).into());
        }
    }
    found
}
