//! Builds a path piece by piece, with the true events on it.

use nalgebra::{UnitQuaternion, Vector3};
use rand_chacha::ChaCha8Rng;

use super::options::SimulateOptions;
use super::path::{Law, MotionPath, Piece};
use super::poses::{attitude_of, shortest_turn, tilt_between};
use super::random::{Purpose, stream, three, uniform};
use super::truth::{MoveTruth, PoseKind, PoseTruth, TurnTruth};

/// One planned recording.
pub(super) struct Plan {
    pub name: String,
    pub path: MotionPath,
    pub poses: Vec<PoseTruth>,
    pub turns: Vec<TurnTruth>,
    pub moves: Vec<MoveTruth>,
}

/// Appends pieces to a path and records the events.
pub(super) struct Builder {
    pub path: MotionPath,
    pub now_s: f64,
    pub attitude: UnitQuaternion<f64>,
    position: Vector3<f64>,
    hands: ChaCha8Rng,
    poses: Vec<PoseTruth>,
    turns: Vec<TurnTruth>,
    moves: Vec<MoveTruth>,
    rests: usize,
}

impl Builder {
    pub(super) fn new(options: &SimulateOptions, up: Vector3<f64>) -> Self {
        let attitude = attitude_of(up);
        Self {
            path: MotionPath {
                pieces: Vec::new(),
                gravity_mps2: options.gravity_mps2,
            },
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

    pub(super) fn push(
        &mut self,
        rotation: Vector3<f64>,
        law: Law,
        displacement: Vector3<f64>,
        duration_s: f64,
    ) {
        let piece = Piece {
            start_s: self.now_s,
            duration_s,
            attitude: self.attitude,
            rotation,
            law,
            position: self.position,
            displacement,
        };
        self.attitude = piece.end_attitude();
        self.position = piece.end_position();
        self.now_s = piece.end_s();
        self.path.pieces.push(piece);
    }

    pub(super) fn hold(
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

    pub(super) fn rest(&mut self, nominal: Vector3<f64>, duration_s: f64) {
        self.rests += 1;
        let label = format!("rest{}", self.rests);
        self.hold(&label, PoseKind::Rest, Some(nominal), duration_s);
    }

    pub(super) fn go(
        &mut self,
        rotation: Vector3<f64>,
        law: Law,
        displacement: Vector3<f64>,
        duration_s: f64,
    ) {
        let start_s = self.now_s;
        self.push(rotation, law, displacement, duration_s);
        self.moves.push(MoveTruth {
            start_s,
            end_s: self.now_s,
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
        let target_position = 0.05 * three(|| uniform(&mut self.hands));
        let displacement = target_position - self.position;
        let duration_s = 1.0 + rotation.norm() / std::f64::consts::PI;
        self.go(rotation, Law::MinimumJerk, displacement, duration_s);
    }

    /// A turn flat on the table: about the vertical, so that the axis in the sensor is `up`
    /// including its tilt.
    pub(super) fn turn(&mut self, label: &str, up: Vector3<f64>, angle_deg: f64, duration_s: f64) {
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

    pub(super) fn finish(self, name: String) -> Plan {
        Plan {
            name,
            path: self.path,
            poses: self.poses,
            turns: self.turns,
            moves: self.moves,
        }
    }
}
