//! Scenarios as paths, built piece by piece with the true events on them.

use nalgebra::{UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::options::{
    LINE_OFFSET_M, LineOptions, PosesOptions, Scenario, SimulateOptions, SixPositionOptions,
    StaticOptions,
};
use super::path::{MotionPath, Piece};
use super::poses::{Draws, Z_UP, attitude_of, shortest_turn, spread_directions, tilt_between};
use super::random::{Purpose, stream, uniform};
use super::truth::{FileTruth, MoveTruth, PoseKind, PoseTruth};
use crate::poses::face::Face;

/// Seconds between two recordings of one simulation; the part stays switched on and continues to
/// warm up.
const BETWEEN_FILES_S: f64 = 10.0;

/// A turn on the table: its angle, right-handed, its duration, and the rests before and after it.
const TURN_DEG: f64 = -360.0;
const TURN_S: f64 = 4.0;
const TURN_REST_S: f64 = 3.0;

/// The recordings of `options.scenario`.
pub(super) fn plan(options: &SimulateOptions) -> Vec<Plan> {
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
        on_s += plan.path.duration_s() + BETWEEN_FILES_S;
    }
    plans
}

fn six_files(options: &SimulateOptions, o: &SixPositionOptions, draws: &mut Draws) -> Vec<Plan> {
    let mut plans = Vec::with_capacity(6);
    for face in Face::all() {
        let (nominal, up) = draws.face_pose(face);
        let letter = ["x", "y", "z"][face.axis];
        let sign = if face.up { "pos" } else { "neg" };
        let mut plan = Plan::new(options, &format!("{letter}_axis_{sign}.csv"), up);
        plan.hold(&face.name(), PoseKind::Face, Some(nominal), o.hold_s);
        plans.push(plan);
    }
    plans
}

fn session(options: &SimulateOptions, o: &SixPositionOptions, draws: &mut Draws) -> Plan {
    let mut plan = faces(options, "session.csv", o.hold_s, draws);
    for axis in 0..3 {
        let (nominal, up) = draws.face_pose(Face { axis, up: true });
        plan.move_to(up);
        plan.rest(nominal, TURN_REST_S);
        // About the vertical, which is `up` in the sensor, its tilt included.
        plan.push(up * TURN_DEG.to_radians(), Vector3::zeros(), TURN_S);
        plan.rest(nominal, TURN_REST_S);
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
        if !plan.path.pieces.is_empty() {
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

/// One recording, planned piece by piece with the true events on it.
pub(super) struct Plan {
    pub path: MotionPath,
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
    pub(super) fn new(options: &SimulateOptions, name: &str, up: Vector3<f64>) -> Self {
        Self {
            path: MotionPath {
                pieces: Vec::new(),
                gravity_mps2: options.gravity_mps2,
            },
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

    /// End of the path, s.
    pub(super) fn now_s(&self) -> f64 {
        self.path.duration_s()
    }

    fn push(&mut self, rotation: Vector3<f64>, displacement: Vector3<f64>, duration_s: f64) {
        self.path.pieces.push(Piece {
            start_s: self.now_s(),
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
            start_s: self.now_s(),
            end_s: self.now_s() + duration_s,
        });
        self.push(Vector3::zeros(), Vector3::zeros(), duration_s);
    }

    pub(super) fn rest(&mut self, nominal: Vector3<f64>, duration_s: f64) {
        let poses = self.truth.poses.iter();
        let rests = poses.filter(|pose| pose.kind == PoseKind::Rest).count();
        let label = format!("rest{}", rests + 1);
        self.hold(&label, PoseKind::Rest, Some(nominal), duration_s);
    }

    pub(super) fn go(
        &mut self,
        rotation: Vector3<f64>,
        displacement: Vector3<f64>,
        duration_s: f64,
    ) {
        let start_s = self.now_s();
        self.push(rotation, displacement, duration_s);
        self.truth.moves.push(MoveTruth {
            start_s,
            end_s: self.now_s(),
            displacement_m: displacement.into(),
        });
    }

    /// A hand moves the sensor to the attitude in which `up` points up: the shortest rotation, a
    /// random rotation about the vertical, and a displacement of a few centimetres.
    pub(super) fn move_to(&mut self, up: Vector3<f64>) {
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
}
