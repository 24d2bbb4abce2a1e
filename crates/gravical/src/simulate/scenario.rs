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

/// A turn on the table: its angle, right-handed, and its duration.
const TURN_DEG: f64 = -360.0;
const TURN_S: f64 = 4.0;

/// One planned recording.
pub(super) struct Plan {
    pub path: MotionPath,
    /// The part was switched on that long before, s.
    pub on_s: f64,
    /// Its name and its events; rows are counted while it is recorded.
    pub truth: FileTruth,
}

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
        let mut build = Builder::new(options, up);
        build.hold(&face.name(), PoseKind::Face, Some(nominal), o.hold_s);
        let letter = ["x", "y", "z"][face.axis];
        let sign = if face.up { "pos" } else { "neg" };
        plans.push(build.finish(&format!("{letter}_axis_{sign}.csv")));
    }
    plans
}

fn session(options: &SimulateOptions, o: &SixPositionOptions, draws: &mut Draws) -> Plan {
    let mut build = faces(options, o.hold_s, draws);
    for axis in 0..3 {
        let (nominal, up) = draws.face_pose(Face { axis, up: true });
        build.move_to(up);
        build.rest(nominal, o.turn_rest_s);
        // About the vertical, which is `up` in the sensor, its tilt included.
        build.push(up * TURN_DEG.to_radians(), Vector3::zeros(), TURN_S);
        build.rest(nominal, o.turn_rest_s);
    }
    build.finish("session.csv")
}

fn poses(options: &SimulateOptions, o: &PosesOptions, draws: &mut Draws) -> Plan {
    let mut build = faces(options, o.hold_s, draws);
    for (i, up) in spread_directions(o.free as usize, options.seed)
        .into_iter()
        .enumerate()
    {
        build.move_to(up.into());
        build.hold(&format!("free{}", i + 1), PoseKind::Free, None, o.hold_s);
    }
    build.finish("poses.csv")
}

/// The six faces one after the other, moved by hand.
fn faces(options: &SimulateOptions, hold_s: f64, draws: &mut Draws) -> Builder {
    let placed = Face::all().map(|face| {
        let (nominal, up) = draws.face_pose(face);
        (nominal, up, face.name())
    });
    let mut build = Builder::new(options, placed[0].1);
    for (nominal, up, label) in placed {
        if !build.path.pieces.is_empty() {
            build.move_to(up);
        }
        build.hold(&label, PoseKind::Face, Some(nominal), hold_s);
    }
    build
}

fn still(options: &SimulateOptions, o: &StaticOptions, draws: &mut Draws) -> Plan {
    let (nominal, up) = draws.face_pose(Z_UP);
    let mut build = Builder::new(options, up);
    build.hold("+z", PoseKind::Face, Some(nominal), o.duration_s);
    build.finish("static.csv")
}

fn line(options: &SimulateOptions, o: &LineOptions, draws: &mut Draws) -> Plan {
    let (nominal, up) = draws.face_pose(Z_UP);
    let mut build = Builder::new(options, up);
    build.rest(nominal, o.rest_s);
    let displacement = Vector3::new(LINE_OFFSET_M, o.distance_m, 0.0);
    build.go(Vector3::zeros(), displacement, o.move_time_s);
    build.rest(nominal, o.rest_s);
    build.finish("line.csv")
}

/// Appends pieces to a path and records the events.
pub(super) struct Builder {
    pub path: MotionPath,
    pub attitude: UnitQuaternion<f64>,
    position: Vector3<f64>,
    hands: ChaCha8Rng,
    truth: FileTruth,
    rests: usize,
}

impl Builder {
    pub(super) fn new(options: &SimulateOptions, up: Vector3<f64>) -> Self {
        Self {
            path: MotionPath {
                pieces: Vec::new(),
                gravity_mps2: options.gravity_mps2,
            },
            attitude: attitude_of(up),
            position: Vector3::zeros(),
            hands: stream(options.seed, Purpose::Hands, 0),
            truth: FileTruth::default(),
            rests: 0,
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
        self.rests += 1;
        let label = format!("rest{}", self.rests);
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

    fn finish(self, name: &str) -> Plan {
        Plan {
            path: self.path,
            on_s: 0.0,
            truth: FileTruth {
                name: name.to_owned(),
                ..self.truth
            },
        }
    }
}
