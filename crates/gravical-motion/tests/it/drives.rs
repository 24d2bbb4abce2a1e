//! Drives whose truth is known: pieces of moving and turning, one after the other.

use gravical_motion::{Ends, Samples, estimate_motion};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::simulated::{BIAS_SD, FORCE_SD, G, RATE_SD, drawn, level};
use crate::study::{not_interpolated, options};

type V3 = Vector3<f64>;

const STEP_S: f64 = 0.01;
/// Noise of a sample, m/s² and rad/s.
const NOISE: [f64; 2] = [0.033, 1e-3];
/// Time constant of a gyroscope that warms up, s.
const WARMING_S: f64 = 20.0;

/// A rest if nothing in it moves.
#[derive(Debug, Clone, Copy)]
struct Piece {
    seconds: f64,
    /// Of the speeding up, and of the slowing down; half of the piece is a minimum-jerk move.
    ramp_s: f64,
    /// Displacement, along the axes of the body at its start, levelled, m, and rotation vector, body axes, rad.
    moved: V3,
    turned: V3,
    /// White noise more, m/s² and rad/s.
    shakes: [f64; 2],
}

fn rest(seconds: f64) -> Piece {
    Piece {
        seconds,
        ramp_s: 0.5 * seconds,
        moved: V3::zeros(),
        turned: V3::zeros(),
        shakes: [0.0; 2],
    }
}

fn go(seconds: f64, moved: V3) -> Piece {
    Piece {
        moved,
        ..rest(seconds)
    }
}

fn turn(seconds: f64, ramp_s: f64, degrees: f64) -> Piece {
    Piece {
        ramp_s,
        turned: V3::z() * degrees.to_radians(),
        ..rest(seconds)
    }
}

impl Piece {
    fn is_rest(&self) -> bool {
        self.moved == V3::zeros() && self.turned == V3::zeros()
    }

    /// Done of the piece at a time, 0 to 1, its speed and acceleration.
    fn shape(&self, t: f64) -> [f64; 3] {
        let (r, s) = (self.ramp_s, self.seconds);
        if 2.0 * r >= s {
            let u = t / s;
            let done = u.powi(3) * (10.0 + u * (6.0 * u - 15.0));
            let speed = 30.0 * (u * (1.0 - u)).powi(2) / s;
            return [
                done,
                speed,
                60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (s * s),
            ];
        }
        // The speed rises as 3u² − 2u³.
        let top = 1.0 / (s - r);
        let rise = |t: f64| {
            let u = (t / r).min(1.0);
            let done = top * (r * u.powi(3) * (1.0 - 0.5 * u) + (t - r).max(0.0));
            [
                done,
                top * u * u * (3.0 - 2.0 * u),
                top * 6.0 * u * (1.0 - u) / r,
            ]
        };
        if t < s - r {
            return rise(t);
        }
        let [left, speed, slowing] = rise(s - t);
        [1.0 - left, speed, -slowing]
    }
}

/// A name, the pieces, and what is wrong with the gyroscope, rad/s: what its bias falls by as it warms up, what it
/// jumps by in the middle of the first move, and the steps in which it is written.
pub struct Drive(pub String, Vec<Piece>, [f64; 3]);

/// Of many recordings of a drive.
#[derive(Debug, Default)]
pub struct Outcome {
    pub count: usize,
    /// Ends that are off by more than 4σ on an axis, and no move is open or unusable.
    pub beyond: usize,
    /// Moves that are open or unusable.
    pub open: usize,
    /// Rests that are found, and those that there are.
    pub rests: [usize; 2],
    /// Of the others, the squared error of the end, m², and its standard deviation, m.
    pub squares_m2: Vec<f64>,
    pub sds_m: Vec<f64>,
}

impl Drive {
    pub fn outcome(&self, seeds: impl Iterator<Item = u64>) -> Outcome {
        let mut out = Outcome::default();
        for seed in seeds {
            let (samples, end) = self.record(seed);
            let motion = estimate_motion(&samples, &options());
            let is_open =
                |m: &&gravical_motion::Move| m.ends != Ends::RestToRest || m.unusable.is_some();
            let open = motion.moves.iter().filter(is_open).count();
            out.count += 1;
            out.open += open;
            out.rests[0] += motion.rests.len();
            out.rests[1] += self.1.iter().filter(|p| p.is_rest()).count();
            if let (0, Some(node)) = (open, motion.path.last()) {
                let (error, sd) = (
                    V3::from(node.position_m) - end,
                    V3::from(node.position_sd_m),
                );
                out.beyond += usize::from((0..3).any(|c| error[c].abs() > 4.0 * sd[c]));
                out.squares_m2.push(error.norm_squared());
                out.sds_m.push(sd.norm());
            }
        }
        out
    }

    /// Samples and the true end, m.
    fn record(&self, seed: u64) -> (Samples, V3) {
        let Drive(_, pieces, [warms, jumps, step]) = self;
        let mut draw = drawn(seed, 0);
        let up = V3::new(0.03 * draw.normal(), 0.03 * draw.normal(), 1.0).normalize();
        let (mut attitude, mut position, mut start) = (level(&up), V3::zeros(), 0.0);
        let force_error = Matrix3::from_fn(|_, _| FORCE_SD * draw.normal());
        let rate_error = Matrix3::from_fn(|i, j| RATE_SD[usize::from(i != j)] * draw.normal());
        let (bias, rate_bias) = (draw.vector(BIAS_SD), draw.vector(0.01));
        let off = draw.vector(1.0).normalize();
        let offset_s = draw.uniform(0.0, STEP_S);
        let first = pieces.iter().position(|p| !p.is_rest());
        let (mut time_s, mut force, mut rate) = (Vec::new(), Vec::new(), Vec::new());
        for (k, piece) in pieces.iter().enumerate() {
            let heading = attitude[(1, 0)].atan2(attitude[(0, 0)]);
            let moved = Rotation3::from_axis_angle(&V3::z_axis(), heading) * piece.moved;
            // Turns about the vertical are about the true one.
            let turned = attitude.transpose() * V3::z() * piece.turned.z
                + V3::new(piece.turned.x, piece.turned.y, 0.0);
            loop {
                let t = offset_s + time_s.len() as f64 * STEP_S;
                if t >= start + piece.seconds {
                    break;
                }
                let [done, speed, acceleration] = piece.shape(t - start);
                let body = attitude * Rotation3::new(turned * done).into_inner();
                let f = body.transpose() * (moved * acceleration + V3::z() * G);
                let has_jumped = Some(k) > first || Some(k) == first && done > 0.5;
                let changed = warms * (-t / WARMING_S).exp() + jumps * f64::from(has_jumped);
                let [f_sd, w_sd] = [0, 1].map(|s| NOISE[s].hypot(piece.shakes[s]));
                let w = turned * speed;
                let w = w - rate_error * w + rate_bias + off * changed + draw.vector(w_sd);
                let written = |v: f64| {
                    if *step > 0.0 {
                        (v / step).round() * step
                    } else {
                        v
                    }
                };
                time_s.push(t);
                force.push((f - force_error * f - bias + draw.vector(f_sd)).into());
                rate.push(w.map(written).into());
            }
            attitude *= Rotation3::new(turned).into_inner();
            position += moved;
            start += piece.seconds;
        }
        (not_interpolated(&time_s, &force, &rate), position)
    }
}

/// Every drive that is studied.
pub fn drives() -> Vec<Drive> {
    let mut out = Vec::new();
    let mut add = |name: String, pieces: &[Piece]| out.push(Drive(name, pieces.to_vec(), [0.0; 3]));
    let ahead = |metres: f64| V3::x() * metres;
    for rate in [1.0, 3.0, 6.0, 11.0, 20.0, 43.0] {
        let seconds = f64::min(90.0 / rate, 20.0);
        let turn = turn(seconds, 0.3, rate * (seconds - 0.3));
        let [first, last] = [rest(4.0), go(3.0, ahead(1.0))];
        let pieces = [first, last, rest(2.0), turn, rest(2.0), last, first];
        add(format!("turns at {rate} °/s between two moves"), &pieces);
    }
    let round = [
        rest(4.0),
        turn(2.0, 1.0, 86.0),
        rest(5.0),
        go(2.0, ahead(0.7)),
        rest(4.0),
    ];
    add("turns by 86° in 2 s".into(), &round);
    let corner = [
        rest(4.0),
        go(2.0, ahead(0.7)),
        turn(2.0, 1.0, 90.0),
        go(2.0, ahead(0.7)),
        rest(4.0),
    ];
    add("a robot's L".into(), &corner);
    let ride = |seconds: f64, ramp_s: f64, moved: V3| Piece {
        ramp_s,
        ..go(seconds, moved)
    };
    for cm in [1.0, 2.0, 3.0, 5.0, 10.0, 20.0] {
        let slide = ride(10.0, 0.5, ahead(0.095 * cm));
        add(format!("slider, {cm} cm/s"), &[rest(5.0), slide, rest(5.0)]);
        let tilts = Piece {
            turned: V3::y() * 0.3_f64.to_radians(),
            ..slide
        };
        add(
            format!("slider, {cm} cm/s, tilts by 0.3°"),
            &[rest(5.0), tilts, rest(5.0)],
        );
    }
    for (metres, speed) in [(10.0, 2.0), (30.0, 2.0), (30.0, 3.0), (75.0, 4.0)] {
        let lift = ride(metres / speed + 2.5, 2.5, V3::z() * metres);
        let lift = Piece {
            shakes: [0.03, 5e-4],
            ..lift
        };
        add(
            format!("lift, {metres} m at {speed} m/s"),
            &[rest(8.0), lift, rest(8.0)],
        );
    }
    add(
        "platform, 0.1 m/s".into(),
        &[rest(5.0), ride(20.0, 1.0, V3::z() * 2.0), rest(5.0)],
    );
    for seconds in [0.5, 1.0, 3.0, 60.0] {
        let go = |metres: f64| go(2.0, ahead(metres));
        let between = rest(seconds);
        let pieces = [
            rest(4.0),
            go(0.7),
            between,
            go(0.7),
            between,
            go(0.5),
            rest(4.0),
        ];
        add(format!("rests of {seconds} s"), &pieces);
    }
    let to_and_fro = [5.0, 2.0, 5.0, 2.0, 5.0].map(rest);
    let pieces: Vec<Piece> = to_and_fro
        .iter()
        .enumerate()
        .map(|(k, piece)| {
            let metres = [0.0, 0.7, 0.0, -0.7, 0.0][k];
            Piece {
                moved: ahead(metres),
                ..*piece
            }
        })
        .collect();
    for (name, degrees, which) in [
        ("gyroscope warms up by 0.2 °/s", 0.2, 0),
        ("gyroscope warms up by 1 °/s", 1.0, 0),
        ("bias jumps by 0.1 °/s", 0.1, 1),
        ("bias jumps by 0.5 °/s", 0.5, 1),
        ("bias jumps by 2 °/s", 2.0, 1),
    ] {
        let mut wrong = [0.0; 3];
        wrong[which] = f64::to_radians(degrees);
        out.push(Drive(name.into(), pieces.clone(), wrong));
    }
    let tilts = Piece {
        turned: V3::y() * 0.9_f64.to_radians(),
        ..go(2.0, ahead(0.7))
    };
    let name = "tilts by 0.9°, gyroscope in steps of 0.57 °/s".into();
    out.push(Drive(
        name,
        vec![rest(5.0), tilts, rest(5.0)],
        [0.0, 0.0, 0.01],
    ));
    out
}
