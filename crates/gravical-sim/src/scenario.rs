//! Scenarios as paths, built piece by piece with the true events on them: attitude and position of the
//! sensor as functions of time.
//!
//! Both sensors are computed from a path: angular rate is the derivative of the attitude, specific force
//! is f = Rᵀ(a + g ẑ) with the same attitude R (sensor → world, world z up). The accelerometer is in the
//! centre of every rotation.

use gravical_fit::model::{sphere, tangents};
use nalgebra::{Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use crate::options::{
    LINE_OFFSET_M, LineOptions, PosesOptions, Scenario, SimulateOptions, SixPositionOptions,
    StaticOptions,
};
use crate::random::{Purpose, normal, stream, uniform};
use crate::truth::{FileTruth, MoveTruth, PoseKind, PoseTruth};
use gravical_fit::Face;

/// Seconds between two recordings of one simulation; the part stays switched on and continues to
/// warm up.
const BETWEEN_FILES_S: f64 = 10.0;

/// Standard deviation of a free pose from the planned one, per component, rad.
const FREE_POSE_SD: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// A turn on the table: its angle, right-handed, and its duration.
const TURN_DEG: f64 = -360.0;
const TURN_S: f64 = 4.0;

/// The recordings of `options.scenario`.
pub(crate) fn plan(options: &SimulateOptions) -> Vec<Plan> {
    let mut draws = Draws::new(options.seed, options.tilt_sd_deg);
    let mut plans = match &options.scenario {
        Scenario::SixPosition(o) if o.continuous => vec![session(options, o, &mut draws)],
        Scenario::SixPosition(o) => six_files(options, o, &mut draws),
        Scenario::Poses(o) => vec![poses(options, o, &mut draws)],
        Scenario::Static(o) => vec![still(options, o, &mut draws)],
        Scenario::Line(o) => vec![line(options, o, &mut draws)],
    };
    let mut on_s = 0.0;
    for plan in &mut plans {
        plan.on_s = on_s;
        on_s += plan.duration_s() + BETWEEN_FILES_S;
    }
    plans
}

fn six_files(options: &SimulateOptions, o: &SixPositionOptions, draws: &mut Draws) -> Vec<Plan> {
    let plans = Face::all().map(|face| {
        let (nominal, up) = draws.face_pose(face);
        let letter = ["x", "y", "z"][face.axis];
        let sign = if face.up { "pos" } else { "neg" };
        let mut plan = Plan::new(options, &format!("{letter}_axis_{sign}.csv"), up);
        plan.hold(&face.name(), PoseKind::Face, Some(nominal), o.hold_s);
        plan
    });
    plans.into()
}

fn session(options: &SimulateOptions, o: &SixPositionOptions, draws: &mut Draws) -> Plan {
    let mut plan = faces(options, "session.csv", o.hold_s, draws);
    for axis in 0..3 {
        let (nominal, up) = draws.face_pose(Face { axis, up: true });
        plan.move_to(up);
        plan.rest(nominal, o.turn_rest_s);
        // About the vertical, which is `up` in the sensor, its tilt included.
        plan.push(up * TURN_DEG.to_radians(), Vector3::zeros(), TURN_S);
        plan.rest(nominal, o.turn_rest_s);
    }
    plan
}

fn poses(options: &SimulateOptions, o: &PosesOptions, draws: &mut Draws) -> Plan {
    let mut plan = faces(options, "poses.csv", o.hold_s, draws);
    for (i, up) in spread_directions(o.free as usize, options.seed)
        .into_iter()
        .enumerate()
    {
        plan.move_to(up.into());
        plan.hold(&format!("free{}", i + 1), PoseKind::Free, None, o.hold_s);
    }
    plan
}

/// The six faces one after the other, moved by hand.
fn faces(options: &SimulateOptions, name: &str, hold_s: f64, draws: &mut Draws) -> Plan {
    let placed = Face::all().map(|face| {
        let (nominal, up) = draws.face_pose(face);
        (nominal, up, face.name())
    });
    let mut plan = Plan::new(options, name, placed[0].1);
    for (nominal, up, label) in placed {
        if !plan.pieces.is_empty() {
            plan.move_to(up);
        }
        plan.hold(&label, PoseKind::Face, Some(nominal), hold_s);
    }
    plan
}

fn still(options: &SimulateOptions, o: &StaticOptions, draws: &mut Draws) -> Plan {
    let (nominal, up) = draws.face_pose(Z_UP);
    let mut plan = Plan::new(options, "static.csv", up);
    plan.hold("+z", PoseKind::Face, Some(nominal), o.duration_s);
    plan
}

fn line(options: &SimulateOptions, o: &LineOptions, draws: &mut Draws) -> Plan {
    let (nominal, up) = draws.face_pose(Z_UP);
    let mut plan = Plan::new(options, "line.csv", up);
    plan.rest(nominal, o.rest_s);
    let displacement = Vector3::new(LINE_OFFSET_M, o.distance_m, 0.0);
    plan.go(Vector3::zeros(), displacement, o.move_time_s);
    plan.rest(nominal, o.rest_s);
    plan
}

/// One recording, planned piece by piece with the true events on it: attitude and position as functions
/// of time. The sensor rests before the first and after the last piece.
pub(crate) struct Plan {
    pieces: Vec<Piece>,
    gravity_mps2: f64,
    /// The part was switched on that long before, s.
    pub on_s: f64,
    /// Its name and its events; rows are counted while it is recorded.
    pub truth: FileTruth,
    /// At the end of the path.
    pub attitude: UnitQuaternion<f64>,
    position: Vector3<f64>,
    hands: ChaCha8Rng,
}

impl Plan {
    pub(crate) fn new(options: &SimulateOptions, name: &str, up: Vector3<f64>) -> Self {
        Self {
            pieces: Vec::new(),
            gravity_mps2: options.gravity_mps2,
            on_s: 0.0,
            truth: FileTruth {
                name: name.to_owned(),
                ..FileTruth::default()
            },
            attitude: attitude_of(up),
            position: Vector3::zeros(),
            hands: stream(options.seed, Purpose::Hands, 0),
        }
    }

    /// Length of the path, s.
    pub(crate) fn duration_s(&self) -> f64 {
        let last = self.pieces.last();
        last.map_or(0.0, |p| p.start_s + p.duration_s)
    }

    fn push(&mut self, rotation: Vector3<f64>, displacement: Vector3<f64>, duration_s: f64) {
        self.pieces.push(Piece {
            start_s: self.duration_s(),
            duration_s,
            attitude: self.attitude,
            rotation,
            displacement,
        });
        self.attitude *= UnitQuaternion::from_scaled_axis(rotation);
        self.position += displacement;
    }

    fn hold(
        &mut self,
        label: &str,
        kind: PoseKind,
        nominal: Option<Vector3<f64>>,
        duration_s: f64,
    ) {
        let up = self.attitude.inverse_transform_vector(&Vector3::z());
        self.truth.poses.push(PoseTruth {
            label: label.to_owned(),
            kind,
            up: up.into(),
            tilt_deg: nominal.map(|n| tilt_between(n, up).to_degrees()),
            start_s: self.duration_s(),
            end_s: self.duration_s() + duration_s,
        });
        self.push(Vector3::zeros(), Vector3::zeros(), duration_s);
    }

    pub(crate) fn rest(&mut self, nominal: Vector3<f64>, duration_s: f64) {
        let poses = self.truth.poses.iter();
        let rests = poses.filter(|pose| pose.kind == PoseKind::Rest).count();
        let label = format!("rest{}", rests + 1);
        self.hold(&label, PoseKind::Rest, Some(nominal), duration_s);
    }

    pub(crate) fn go(
        &mut self,
        rotation: Vector3<f64>,
        displacement: Vector3<f64>,
        duration_s: f64,
    ) {
        let start_s = self.duration_s();
        self.push(rotation, displacement, duration_s);
        self.truth.moves.push(MoveTruth {
            start_s,
            end_s: self.duration_s(),
            displacement_m: displacement.into(),
        });
    }

    /// A hand moves the sensor to the attitude in which `up` points up: the shortest rotation, a
    /// random rotation about the vertical, and a displacement of a few centimetres.
    pub(crate) fn move_to(&mut self, up: Vector3<f64>) {
        let from = self.attitude.inverse_transform_vector(&Vector3::z());
        let twist = 30f64.to_radians() * uniform(&mut self.hands);
        let target = UnitQuaternion::from_scaled_axis(Vector3::z() * twist)
            * self.attitude
            * shortest_turn(from, up).inverse();
        let rotation = (self.attitude.inverse() * target).scaled_axis();
        let target_position = Vector3::from_fn(|_, _| 0.05 * uniform(&mut self.hands));
        let displacement = target_position - self.position;
        let duration_s = 1.0 + rotation.norm() / std::f64::consts::PI;
        self.go(rotation, displacement, duration_s);
    }

    /// Specific force, m/s², and angular rate, rad/s, in the sensor frame. The rate is exact, because the
    /// axis of a rotation is also fixed in the sensor.
    pub(crate) fn force_and_rate(&self, t_s: f64) -> [[f64; 3]; 2] {
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

/// One piece of the path: a rotation about a fixed axis and a straight displacement, or rest.
struct Piece {
    start_s: f64,
    duration_s: f64,
    attitude: UnitQuaternion<f64>,
    /// Rotation vector in the sensor frame, rad.
    rotation: Vector3<f64>,
    displacement: Vector3<f64>,
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

/// Draws poses with their tilt.
pub(crate) struct Draws {
    tilts: ChaCha8Rng,
    tilt_sd: f64,
}

impl Draws {
    pub(crate) fn new(seed: u64, tilt_sd_deg: f64) -> Self {
        Self {
            tilts: stream(seed, Purpose::Tilts, 0),
            tilt_sd: tilt_sd_deg.to_radians(),
        }
    }

    /// Nominal and true direction of up for a pose on a face.
    pub(crate) fn face_pose(&mut self, face: Face) -> (Vector3<f64>, Vector3<f64>) {
        let nominal = Vector3::from(face.direction());
        let tilted = tilted(nominal, &mut self.tilts, self.tilt_sd);
        (nominal, tilted)
    }
}

/// The face with z up.
pub(crate) const Z_UP: Face = Face { axis: 2, up: true };

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
fn tilt_between(a: Vector3<f64>, b: Vector3<f64>) -> f64 {
    a.cross(&b).norm().atan2(a.dot(&b))
}

/// Attitude (sensor → world) in which `up` points up and the horizontal component of the sensor's
/// x points along the world's x; that of y if x is up.
pub(crate) fn attitude_of(up: Vector3<f64>) -> UnitQuaternion<f64> {
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
fn shortest_turn(from: Vector3<f64>, to: Vector3<f64>) -> UnitQuaternion<f64> {
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
fn spread_directions(count: usize, seed: u64) -> Vec<[f64; 3]> {
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
