//! From a scenario to paths and the events on them.

use nalgebra::{UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::options::SimulateOptions;
use super::path::{Law, MotionPath, Piece};
use super::poses::{Draws, FACES, attitude_of, shortest_turn, spread_directions, tilt_between};
use super::random::{Purpose, either_way, stream, three};
use super::scenario_options::{
    LineOptions, PosesOptions, Scenario, SixPositionOptions, StaticOptions,
};
use super::truth::{MoveTruth, PoseKind, PoseTruth, TurnTruth};

/// One recording to be made.
pub(super) struct Plan {
    pub name: String,
    pub path: MotionPath,
    pub poses: Vec<PoseTruth>,
    pub turns: Vec<TurnTruth>,
    pub moves: Vec<MoveTruth>,
}

/// The recordings of `options.scenario`.
pub(super) fn plan(options: &SimulateOptions) -> Vec<Plan> {
    let mut draws = Draws::new(options.seed, options.tilt_sd_deg);
    match &options.scenario {
        Scenario::SixPosition(o) if o.continuous => vec![session(options, o, &mut draws)],
        Scenario::SixPosition(o) => six_files(options, o, &mut draws),
        Scenario::Poses(o) => vec![poses(options, o, &mut draws)],
        Scenario::Static(o) => vec![still(options, o, &mut draws)],
        Scenario::Line(o) => vec![line(options, o, &mut draws)],
    }
}

fn six_files(options: &SimulateOptions, o: &SixPositionOptions, draws: &mut Draws) -> Vec<Plan> {
    let mut plans = Vec::with_capacity(6);
    for (axis, positive, label) in FACES {
        let (nominal, up) = draws.placement(axis, positive);
        let mut build = Builder::new(options, up);
        build.hold(label, PoseKind::Face, Some(nominal), o.hold_s);
        let letter = ["x", "y", "z"][axis];
        let way = if positive { "pos" } else { "neg" };
        plans.push(build.finish(format!("{letter}_axis_{way}.csv")));
    }
    plans
}

fn session(options: &SimulateOptions, o: &SixPositionOptions, draws: &mut Draws) -> Plan {
    let mut build = faces(options, o.hold_s, draws);
    for (axis, label) in ["x", "y", "z"].into_iter().enumerate() {
        let (nominal, up) = draws.placement(axis, true);
        build.carry_to(up);
        build.rest(nominal, o.rest_s);
        build.turn(label, up, o.turn_angle_deg, o.turn_time_s);
        build.rest(nominal, o.rest_s);
    }
    build.finish("session.csv".to_owned())
}

fn poses(options: &SimulateOptions, o: &PosesOptions, draws: &mut Draws) -> Plan {
    let mut build = faces(options, o.hold_s, draws);
    for (i, up) in spread_directions(o.free as usize, options.seed)
        .into_iter()
        .enumerate()
    {
        build.carry_to(up);
        build.hold(&format!("free{}", i + 1), PoseKind::Free, None, o.hold_s);
    }
    build.finish("poses.csv".to_owned())
}

/// The six faces one after the other, carried by hand.
fn faces(options: &SimulateOptions, hold_s: f64, draws: &mut Draws) -> Builder {
    let placed = FACES.map(|(axis, positive, label)| {
        let (nominal, up) = draws.placement(axis, positive);
        (nominal, up, label)
    });
    let mut build = Builder::new(options, placed[0].1);
    for (nominal, up, label) in placed {
        if !build.pieces.is_empty() {
            build.carry_to(up);
        }
        build.hold(label, PoseKind::Face, Some(nominal), hold_s);
    }
    build
}

fn still(options: &SimulateOptions, o: &StaticOptions, draws: &mut Draws) -> Plan {
    let (nominal, up) = draws.placement(2, true);
    let mut build = Builder::new(options, up);
    build.hold("+z", PoseKind::Face, Some(nominal), o.duration_s);
    build.finish("static.csv".to_owned())
}

fn line(options: &SimulateOptions, o: &LineOptions, draws: &mut Draws) -> Plan {
    let (nominal, up) = draws.placement(2, true);
    let mut build = Builder::new(options, up);
    build.rest(nominal, o.rest_s);
    let way = Vector3::new(o.offset_m, o.distance_m, 0.0);
    // About x, because that is what tips gravity into the direction of travel.
    let wobble = Vector3::x() * o.wobble_deg.to_radians();
    build.go(wobble, Law::Sine, way, o.move_time_s);
    build.rest(nominal, o.rest_s);
    build.finish("line.csv".to_owned())
}

/// Appends piece after piece and notes what it was.
struct Builder {
    pieces: Vec<Piece>,
    gravity_mps2: f64,
    first: UnitQuaternion<f64>,
    now_s: f64,
    attitude: UnitQuaternion<f64>,
    position: Vector3<f64>,
    hands: ChaCha8Rng,
    poses: Vec<PoseTruth>,
    turns: Vec<TurnTruth>,
    moves: Vec<MoveTruth>,
    rests: usize,
}

impl Builder {
    fn new(options: &SimulateOptions, up: Vector3<f64>) -> Self {
        let attitude = attitude_of(up);
        Self {
            pieces: Vec::new(),
            gravity_mps2: options.gravity_mps2,
            first: attitude,
            now_s: 0.0,
            attitude,
            position: Vector3::zeros(),
            hands: stream(options.seed, Purpose::Hands, 0),
            poses: Vec::new(),
            turns: Vec::new(),
            moves: Vec::new(),
            rests: 0,
        }
    }

    fn push(&mut self, rotation: Vector3<f64>, law: Law, way: Vector3<f64>, duration_s: f64) {
        let piece = Piece {
            start_s: self.now_s,
            duration_s,
            attitude: self.attitude,
            rotation,
            law,
            position: self.position,
            displacement: way,
        };
        self.attitude = piece.end_attitude();
        self.position = piece.end_position();
        self.now_s = piece.end_s();
        self.pieces.push(piece);
    }

    fn hold(
        &mut self,
        label: &str,
        kind: PoseKind,
        nominal: Option<Vector3<f64>>,
        duration_s: f64,
    ) {
        let up = self.attitude.inverse_transform_vector(&Vector3::z());
        self.poses.push(PoseTruth {
            label: label.to_owned(),
            kind,
            up: up.into(),
            tilt_deg: nominal.map(|n| tilt_between(n, up).to_degrees()),
            start_s: self.now_s,
            end_s: self.now_s + duration_s,
        });
        self.push(
            Vector3::zeros(),
            Law::MinimumJerk,
            Vector3::zeros(),
            duration_s,
        );
    }

    fn rest(&mut self, nominal: Vector3<f64>, duration_s: f64) {
        self.rests += 1;
        let label = format!("rest{}", self.rests);
        self.hold(&label, PoseKind::Rest, Some(nominal), duration_s);
    }

    fn go(&mut self, rotation: Vector3<f64>, law: Law, way: Vector3<f64>, duration_s: f64) {
        let (start_s, before) = (self.now_s, self.attitude);
        self.push(rotation, law, way, duration_s);
        let change = (before.inverse() * self.attitude).scaled_axis();
        self.moves.push(MoveTruth {
            start_s,
            end_s: self.now_s,
            displacement_m: way.into(),
            displacement_sensor_m: self.first.inverse_transform_vector(&way).into(),
            rotation_deg: change.map(f64::to_degrees).into(),
        });
    }

    /// A hand takes the sensor to the attitude in which `up` points up: the
    /// shortest turn, some twist about the vertical as hands do, and a few
    /// centimetres of way that the accelerometer sees.
    fn carry_to(&mut self, up: Vector3<f64>) {
        let from = self.attitude.inverse_transform_vector(&Vector3::z());
        let twist = 30f64.to_radians() * either_way(&mut self.hands);
        let target = UnitQuaternion::from_scaled_axis(Vector3::z() * twist)
            * self.attitude
            * shortest_turn(from, up).inverse();
        let rotation = (self.attitude.inverse() * target).scaled_axis();
        let there = 0.05 * three(|| either_way(&mut self.hands));
        let way = there - self.position;
        let duration_s = 1.0 + rotation.norm() / std::f64::consts::PI;
        self.go(rotation, Law::MinimumJerk, way, duration_s);
    }

    /// A turn flat on the table: about the vertical, so that the axis in the
    /// sensor is `up` with its tilt.
    fn turn(&mut self, label: &str, up: Vector3<f64>, angle_deg: f64, duration_s: f64) {
        self.turns.push(TurnTruth {
            label: label.to_owned(),
            axis: up.into(),
            angle_deg,
            start_s: self.now_s,
            end_s: self.now_s + duration_s,
        });
        let rotation = up * angle_deg.to_radians();
        self.push(rotation, Law::MinimumJerk, Vector3::zeros(), duration_s);
    }

    fn finish(self, name: String) -> Plan {
        Plan {
            name,
            path: MotionPath {
                pieces: self.pieces,
                gravity_mps2: self.gravity_mps2,
            },
            poses: self.poses,
            turns: self.turns,
            moves: self.moves,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::poses::face;
    use super::*;

    #[test]
    fn every_pose_points_where_it_was_meant_to() {
        let options = SimulateOptions {
            tilt_sd_deg: 0.0,
            ..SimulateOptions::new(Scenario::SixPosition(SixPositionOptions {
                continuous: true,
                ..Default::default()
            }))
        };
        let session = plan(&options).remove(0);
        let labels: Vec<_> = session.poses.iter().map(|p| p.label.as_str()).collect();
        assert_eq!(labels[..6], ["+x", "-x", "+y", "-y", "+z", "-z"]);
        assert_eq!(labels[6..].len(), 6);
        for pose in &session.poses {
            let middle = 0.5 * (pose.start_s + pose.end_s);
            let state = session.path.state_at(middle);
            assert!(state.still);
            let force = Vector3::from(state.specific_force_mps2);
            let up = Vector3::from(pose.up) * options.gravity_mps2;
            assert!((force - up).norm() < 1e-9, "{}", pose.label);
            assert!(pose.tilt_deg.unwrap() < 1e-5, "{:?}", pose.tilt_deg);
        }
        for (turn, axis) in session.turns.iter().zip(0..) {
            assert!((Vector3::from(turn.axis) - face(axis, true)).norm() < 1e-12);
        }
        for m in &session.moves {
            assert!((1.0..=2.1).contains(&(m.end_s - m.start_s)));
        }
    }

    #[test]
    fn the_world_of_a_line_has_x_along_the_sensors_x() {
        let plan = plan(&SimulateOptions::new(
            Scenario::Line(LineOptions::default()),
        ))
        .remove(0);
        let m = &plan.moves[0];
        assert_eq!(m.displacement_m, [0.02, 0.7, 0.0]);
        let q = plan.path.state_at(0.0).attitude;
        let attitude =
            UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]));
        let x = attitude * Vector3::x();
        assert!(x.y.abs() < 1e-12 && x.x > 0.99);
        let back = attitude * Vector3::from(m.displacement_sensor_m);
        assert!((back - Vector3::from(m.displacement_m)).norm() < 1e-12);
    }
}
