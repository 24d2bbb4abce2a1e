//! Walks whose truth is known: a foot that swings and stands, and how it moves while it stands.

use gravical_motion::{Ends, Motion, Move, Samples, estimate_motion};
use nalgebra::{Matrix3, Rotation3, SVector, Vector3};

use crate::simulated::{BIAS_SD, Draw, FORCE_SD, G, RATE_SD, drawn, level};
use crate::study::{Study, not_interpolated, options};

type V3 = Vector3<f64>;
/// Position, m, pitch and heading, rad, of the foot.
type Pose = SVector<f64, 5>;

const REST_S: f64 = 3.0;
/// Noise densities of an MPU-6050, m/s²/√Hz and rad/s/√Hz.
const NOISE: [f64; 2] = [3.3e-3, 1e-4];
/// Parts of a sampling period that a sample is the mean of.
const PARTS: usize = 8;
/// Standard deviation of a heel strike, s: its position is a Gaussian.
const STRIKE_S: f64 = 0.005;
/// What the sensor is above the point that the foot rolls about, m.
const LEVER_M: f64 = 0.1;

/// A kind of walk; each seed is a person and a sensor.
#[derive(Debug, Clone)]
pub struct Walk {
    pub name: &'static str,
    pub rate_hz: f64,
    /// Turns by so much, rad, at one step in five.
    pub turn_rad: f64,
    /// Share of the steps after which the foot stands for 1.5 to 4 s.
    pub stops: f64,
    /// Acceleration of a heel strike, m/s².
    pub strike_mps2: f64,
    /// Standard deviations of the velocity of the sensor in a stance, m/s: up and along the step, the same in all
    /// stances, and independent along each axis.
    pub common_mps: f64,
    pub independent_mps: f64,
}

/// A swing, a stance or a rest: a polynomial of fifth degree without acceleration at its ends.
#[derive(Default)]
struct Piece {
    start_s: f64,
    seconds: f64,
    pose: Pose,
    moved: Pose,
    /// Change of the pose by second at both ends.
    speed: [Pose; 2],
    /// How far a swing lifts the foot and pitches it both ways.
    lift_m: f64,
    pitch_rad: f64,
}

impl Piece {
    /// Pose and acceleration of the position at a time.
    fn at(&self, t: f64) -> (Pose, V3) {
        let u = (t - self.start_s) / self.seconds;
        let linear = self.speed[0] * self.seconds;
        let (d, w) = (
            self.moved - linear,
            (self.speed[1] - self.speed[0]) * self.seconds,
        );
        let [a, b, c] = [d * 10.0 - w * 4.0, w * 7.0 - d * 15.0, d * 6.0 - w * 3.0];
        let mut pose = self.pose + linear * u + (a + (b + c * u) * u) * u.powi(3);
        let bend = (a * 6.0 + (b * 12.0 + c * 20.0 * u) * u) * u;
        let mut acceleration = bend.fixed_rows::<3>(0) / self.seconds.powi(2);
        let (q, back) = (u * (1.0 - u), 1.0 - 2.0 * u);
        pose[2] += self.lift_m * 64.0 * q.powi(3);
        acceleration.z += self.lift_m * 64.0 * 6.0 * q * (back * back - q) / self.seconds.powi(2);
        // The toe points down, then up; at most 1.
        pose[3] += self.pitch_rad * 268.9 * q.powi(3) * back;
        (pose, acceleration)
    }
}

impl Walk {
    /// Samples, and the true position at each, m.
    pub fn record(&self, seed: u64) -> (Samples, Vec<V3>) {
        let mut draw = drawn(seed, 0);
        let heading = draw.uniform(-3.0, 3.0);
        let mounted = level(&V3::new(0.3 * draw.normal(), 0.3 * draw.normal(), 1.0).normalize());
        let pieces = self.pieces(heading, &mut draw);
        let strikes: Vec<(f64, V3)> = pieces
            .iter()
            .filter(|p| p.lift_m > 0.0)
            .map(|p| {
                let size = V3::new(0.5, 0.5, 1.0).map(|s| s * draw.normal() * self.strike_mps2);
                (p.start_s + p.seconds - 3.0 * STRIKE_S, size)
            })
            .collect();
        let at = |t: f64| {
            let piece = &pieces[pieces.partition_point(|p| p.start_s <= t).max(1) - 1];
            let (pose, mut a) = piece.at(t);
            let next = strikes.partition_point(|s| s.0 < t - 0.1);
            for (strike_s, size) in strikes.iter().skip(next).take(1) {
                let v2 = ((t - strike_s) / STRIKE_S).powi(2);
                a += size * ((v2 - 1.0) * (-0.5 * v2).exp());
            }
            let turned = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
            let attitude = turned(V3::z_axis(), pose[4])
                * turned(V3::y_axis(), pose[3])
                * turned(V3::z_axis(), -heading);
            (
                pose.fixed_rows::<3>(0).into_owned(),
                attitude.into_inner() * mounted,
                a,
            )
        };
        let force_error = Matrix3::from_fn(|_, _| FORCE_SD * draw.normal());
        let rate_error = Matrix3::from_fn(|i, j| RATE_SD[usize::from(i != j)] * draw.normal());
        let (bias, rate_bias) = (draw.vector(BIAS_SD), draw.vector(0.01));
        let [f_sd, w_sd] = NOISE.map(|n| n * self.rate_hz.sqrt());
        let last = &pieces[pieces.len() - 1];
        let count = ((last.start_s + last.seconds) * self.rate_hz) as usize;
        let part_s = 1.0 / (self.rate_hz * PARTS as f64);
        let time_s: Vec<f64> = (1..count).map(|i| i as f64 / self.rate_hz).collect();
        let (mut force, mut rate, mut positions) = (Vec::new(), Vec::new(), Vec::new());
        for t in &time_s {
            let (mut f, mut w) = (V3::zeros(), V3::zeros());
            for part in 0..PARTS {
                let from = t - (PARTS - part) as f64 * part_s;
                let [(_, before, _), (_, body, a), (_, after, _)] =
                    [0.0, 0.5, 1.0].map(|u| at(from + u * part_s));
                f += body.transpose() * (a + V3::z() * G) / PARTS as f64;
                let turned = Rotation3::from_matrix_unchecked(before.transpose() * after);
                w += turned.scaled_axis() * self.rate_hz;
            }
            positions.push(at(*t).0);
            force.push((f - force_error * f - bias + draw.vector(f_sd)).into());
            rate.push((w - rate_error * w + rate_bias + draw.vector(w_sd)).into());
        }
        (not_interpolated(&time_s, &force, &rate), positions)
    }

    fn pieces(&self, heading: f64, draw: &mut Draw) -> Vec<Piece> {
        let steps = draw.uniform(10.0, 61.0) as usize;
        let [step_s, stance_s] = [(1.0, 1.3), (0.4, 0.6)].map(|(a, b)| draw.uniform(a, b));
        let [step_m, lift_m] = [(0.6, 1.4), (0.05, 0.15)].map(|(a, b)| draw.uniform(a, b));
        let pitch_rad = draw.uniform(20.0, 60.0).to_radians();
        let [up, ahead] = [0, 1].map(|_| self.common_mps * draw.normal());
        let (mut pose, mut speed) = (Pose::from([0.0, 0.0, 0.0, 0.0, heading]), Pose::zeros());
        let mut out = vec![Piece {
            seconds: REST_S,
            pose,
            ..Piece::default()
        }];
        let mut add = |piece: Piece| {
            let last = &out[out.len() - 1];
            let (start_s, pose) = (last.start_s + last.seconds, last.pose + last.moved);
            out.push(Piece {
                start_s,
                pose,
                ..piece
            });
            pose + piece.moved
        };
        for step in 1..=steps {
            let mut turn = 0.05 * draw.normal();
            if draw.uniform(0.0, 1.0) < 0.2 {
                turn += self.turn_rad * draw.normal().signum();
            }
            let direction = pose[4] + turn;
            let (sin, cos) = direction.sin_cos();
            let ahead_m = step_m * (1.0 + 0.05 * draw.normal());
            let mut next = Pose::zeros();
            let stops = draw.uniform(0.0, 1.0) < self.stops;
            if step < steps && !stops {
                let own = draw.vector(self.independent_mps);
                let v = own + V3::new(cos * ahead, sin * ahead, up);
                next.fixed_rows_mut::<3>(0).copy_from(&v);
                next[3] = v.z / LEVER_M;
            }
            let mut stance_s = stance_s * (1.0 + 0.05 * draw.normal());
            let swing_s = (step_s - stance_s) * (1.0 + 0.05 * draw.normal());
            if stops {
                stance_s = draw.uniform(1.5, 4.0);
            }
            // The floor is level, so what the sensor rises and rolls by in a stance it loses in a swing.
            let moved = Pose::from([
                cos * ahead_m,
                sin * ahead_m,
                -pose[2] - next[2] * 0.5 * stance_s,
                -pose[3] - next[3] * 0.5 * stance_s,
                turn,
            ]);
            let [lift_m, pitch_rad] = [lift_m, pitch_rad].map(|v| v * (1.0 + 0.1 * draw.normal()));
            add(Piece {
                seconds: swing_s,
                moved,
                speed: [speed, next],
                lift_m,
                pitch_rad,
                ..Piece::default()
            });
            let is_last = step == steps;
            pose = add(Piece {
                seconds: if is_last { REST_S } else { stance_s },
                moved: next * stance_s,
                speed: [next; 2],
                ..Piece::default()
            });
            speed = next;
        }
        out
    }
}

/// Of many walks.
#[derive(Debug, Default)]
pub struct Outcome {
    /// Ends along x, y and z.
    pub axes: [Study; 3],
    /// Ends that are off by more than 4σ on an axis, and those of them of which nothing is said.
    pub beyond: usize,
    pub unwarned: usize,
}

impl Walk {
    pub fn outcome(&self, seeds: impl Iterator<Item = u64>) -> Outcome {
        let mut out = Outcome::default();
        for seed in seeds {
            let (samples, positions) = self.record(seed);
            out.add(&estimate_motion(&samples, &options()), &positions);
        }
        out
    }
}

impl Outcome {
    fn add(&mut self, motion: &Motion, positions: &[V3]) {
        let node = motion.path.last().unwrap();
        let warns = |m: &Move| {
            m.ends != Ends::RestToRest
                || m.unusable.is_some()
                || m.closure.is_some_and(|c| c.widened)
        };
        let mut is_beyond = false;
        for (c, study) in self.axes.iter_mut().enumerate() {
            let (error, sd) = (
                node.position_m[c] - positions[node.sample][c],
                node.position_sd_m[c],
            );
            study.errors.push((error, sd));
            is_beyond |= error.abs() > 4.0 * sd;
        }
        self.beyond += usize::from(is_beyond);
        self.unwarned += usize::from(is_beyond && !motion.moves.iter().any(warns));
    }
}

/// Every kind that is studied.
pub fn walks() -> Vec<Walk> {
    let plain = Walk {
        name: "ahead, 100 Hz",
        rate_hz: 100.0,
        turn_rad: 0.0,
        stops: 0.0,
        strike_mps2: 30.0,
        common_mps: 0.015,
        independent_mps: 0.01,
    };
    let with = |change: fn(&mut Walk)| {
        let mut walk = plain.clone();
        change(&mut walk);
        walk
    };
    vec![
        plain.clone(),
        with(|w| (w.name, w.turn_rad) = ("turns by 90°, 100 Hz", 1.57)),
        with(|w| {
            (w.name, w.turn_rad, w.rate_hz, w.common_mps) =
                ("turns by 45°, 400 Hz", 0.78, 400.0, 0.02)
        }),
        with(|w| (w.name, w.turn_rad, w.stops) = ("stops, 100 Hz", 0.78, 0.15)),
        with(|w| {
            (w.name, w.turn_rad, w.rate_hz, w.strike_mps2) =
                ("hard heels, 200 Hz", 0.78, 200.0, 80.0)
        }),
    ]
}
