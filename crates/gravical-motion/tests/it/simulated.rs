//! Recordings whose truth is known: rests and straight moves, and what makes them hard.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

type V3 = Vector3<f64>;

pub const G: f64 = 9.81;
const RATE_HZ: f64 = 100.0;

/// What happens in a move, or after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trouble {
    None,
    /// A sine of tilt, rad.
    Wobble(f64),
    /// 2 % of the rows lost, stamps ± 1 ms.
    Drops,
    /// White noise of both sensors while it moves, m/s² and rad/s; with its speed.
    Cart(f64, f64),
    VariedCart(f64, f64),
    /// Knocks of 25 m/s².
    Knocks,
    /// Vibration of so many m/s² around the sampling rate.
    Vibration(f64),
    /// Constant acceleration, then as much back.
    Jerk,
    /// The bias is another one from some time of the move on.
    BiasStep(f64),
    /// A hand that trembles for a second after the move.
    Tremble,
    /// Tilt that changes in the move to come back, or to stay, rad.
    Tilt(f64),
    LastingTilt(f64),
    /// Rows of +15 m/s² on x.
    Spikes(usize),
    /// All channels stand for 1.4 s from the start of the move on.
    Hang,
}

#[derive(Debug, Clone)]
pub struct Scene {
    pub seed: u64,
    pub trouble: Trouble,
    /// Distance, along a direction in the plane that is drawn, m, and duration, s.
    pub distance_m: f64,
    pub move_s: f64,
    /// Rests before and after each move.
    pub rests_s: [f64; 2],
    pub moves: usize,
    pub gyro: bool,
    /// Noise of a sample.
    pub noise: [f64; 2],
    /// Range of the accelerometer and the gyroscope.
    pub ranges: [f64; 2],
    /// Errors of the calibration in units of what is assumed of it.
    pub miscalibrated: f64,
    /// Cut off at the start, s.
    pub cut_s: f64,
}

impl Scene {
    pub fn new(seed: u64, trouble: Trouble) -> Self {
        Scene {
            seed,
            trouble,
            distance_m: 0.7,
            move_s: 2.0,
            rests_s: [5.0, 5.0],
            moves: 1,
            gyro: true,
            noise: [0.033, 1e-3],
            ranges: [1e3, 1e3],
            miscalibrated: 1.0,
            cut_s: 0.0,
        }
    }

    /// The scene with a change.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }
}

#[derive(Debug, Clone)]
pub struct Recording {
    pub time_s: Vec<f64>,
    pub force: Vec<[f64; 3]>,
    /// Empty without a gyroscope.
    pub rate: Vec<[f64; 3]>,
    /// Displacement of a move.
    pub displacement: V3,
    /// Start and end of each, s.
    pub moves_s: Vec<(f64, f64)>,
}

/// Standard deviations of the calibration: relative, of force, and scale and cross-axis of a rate that is
/// known by a data sheet; of the bias, m/s².
pub const FORCE_SD: f64 = 2e-4;
pub const RATE_SD: [f64; 2] = [0.02, 0.01];
pub const BIAS_SD: f64 = 2e-3;

/// Acceleration of a minimum-jerk move of length 1 in time 1.
fn minimum_jerk(u: f64) -> f64 {
    60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)
}

/// Acceleration of the position 16 (s (1 − s))² sin(ωs)/ω², which begins and ends at rest.
fn tremor(omega: f64, s: f64) -> f64 {
    let (w, slope, bend) = (
        16.0 * (s * (1.0 - s)).powi(2),
        32.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
        32.0 * (1.0 - 6.0 * s + 6.0 * s * s),
    );
    let (sin, cos) = (omega * s).sin_cos();
    -w * sin + 2.0 * slope * cos / omega + bend * sin / omega.powi(2)
}

/// Attitude whose first axis is forward.
pub fn level(up: &V3) -> Matrix3<f64> {
    let x = (V3::x() - up * up.x).normalize();
    Matrix3::from_rows(&[x.transpose(), up.cross(&x).transpose(), up.transpose()])
}

pub struct Draw(ChaCha8Rng);

impl Draw {
    pub fn normal(&mut self) -> f64 {
        self.0.sample(StandardNormal)
    }
    pub fn vector(&mut self, sd: f64) -> V3 {
        V3::from_fn(|_, _| self.normal() * sd)
    }
    pub fn uniform(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.0.random::<f64>()
    }
}

pub fn drawn(seed: u64, stream: u64) -> Draw {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    Draw(rng)
}

/// Time in a move: fraction done.
fn phase(t: f64, moves_s: &[(f64, f64)]) -> Option<f64> {
    let (a, b) = moves_s.iter().find(|(a, b)| (*a..*b).contains(&t))?;
    Some((t - a) / (b - a))
}

pub fn norm(v: [f64; 3]) -> f64 {
    V3::from(v).norm()
}

impl Scene {
    pub fn record(&self) -> Recording {
        let mut draw = drawn(self.seed, 0);
        let up = V3::new(0.03 * draw.normal(), 0.03 * draw.normal(), 1.0).normalize();
        let attitude = level(&up);
        let heading = draw.uniform(0.0, TAU);
        let direction = V3::new(heading.cos(), heading.sin(), 0.0);
        let tilt_axis = draw.vector(1.0).normalize();
        let period = self.rests_s[0] + self.move_s;
        // No move begins at a sample.
        let offset_s = drawn(self.seed, 4).uniform(0.0, 1.0) / RATE_HZ;
        let moves_s: Vec<(f64, f64)> = (0..self.moves)
            .map(|k| self.rests_s[0] + k as f64 * period + offset_s)
            .map(|t| (t, t + self.move_s))
            .collect();
        let end = moves_s.last().map_or(self.rests_s[0], |m| m.1) + self.rests_s[1];
        // Errors of the sensor.
        let force_error = Matrix3::from_fn(|_, _| draw.normal() * FORCE_SD * self.miscalibrated);
        let bias = draw.vector(BIAS_SD * self.miscalibrated);
        let rate_error = Matrix3::from_fn(|i, j| {
            let scale = draw.uniform(-0.03, 0.03);
            let cross = draw.normal() * 0.005;
            self.miscalibrated * if i == j { scale } else { cross }
        });
        let rate_bias = draw.vector(0.01);
        let knocks: [(f64, V3); 4] = std::array::from_fn(|_| {
            let at = draw.uniform(0.1, 0.9);
            (at, draw.vector(1.0).normalize() * 25.0 * 1.65)
        });
        let mut vibration_phase = draw.vector(3.0);
        let stepped_at = draw.uniform(0.1, 0.9);
        let step = draw.vector(1.0).normalize();
        let tremble: [(f64, V3); 2] =
            std::array::from_fn(|_| (draw.uniform(5.0, 11.0), draw.vector(0.15)));
        let mut noise = drawn(self.seed, 1);
        let mut clock = drawn(self.seed, 2);
        let mut lost = drawn(self.seed, 3);
        let drops = self.trouble == Trouble::Drops;
        let mut out = Recording {
            time_s: Vec::new(),
            force: Vec::new(),
            rate: Vec::new(),
            displacement: direction * self.distance_m,
            moves_s: moves_s.clone(),
        };
        for i in 0..(end * RATE_HZ) as usize {
            let jitter = drops.then(|| clock.uniform(-1e-3, 1e-3));
            let t = i as f64 / RATE_HZ + jitter.unwrap_or(0.0);
            let mut a = V3::zeros();
            let (mut shake, mut spin) = (self.noise[0], self.noise[1]);
            let mut extra = V3::zeros();
            if let Some(u) = phase(t, &moves_s) {
                let shape = match self.trouble {
                    Trouble::Jerk => 4.0 * (0.5 - u).signum(),
                    _ => minimum_jerk(u),
                };
                a += direction * (shape * self.distance_m / self.move_s.powi(2));
                match self.trouble {
                    Trouble::Cart(f, w) => (shake, spin) = (shake.hypot(f), spin.hypot(w)),
                    Trouble::VariedCart(f, w) => {
                        let speed = 16.0 * (u * (1.0 - u)).powi(2);
                        (shake, spin) = (shake.hypot(f * speed), spin.hypot(w * speed));
                    }
                    Trouble::Knocks => {
                        let s = 0.005;
                        for (at, height) in &knocks {
                            let v = (u - at) * self.move_s / s;
                            a -= height * (v * (-0.5 * v * v).exp());
                        }
                    }
                    Trouble::Vibration(f) => {
                        // Its frequency wanders around the sampling rate.
                        vibration_phase += V3::from_fn(|_, _| 0.5 * noise.normal());
                        extra = vibration_phase.map(|p| f * p.sin());
                    }
                    Trouble::BiasStep(b) if u > stepped_at => extra = step * b,
                    _ => {}
                }
            }
            let after_s = t - moves_s.last().map_or(f64::INFINITY, |last| last.1);
            if self.trouble == Trouble::Tremble && (0.0..1.0).contains(&after_s) {
                for (hz, size) in &tremble {
                    a += size * tremor(TAU * hz, after_s);
                }
            }
            let turn = |t: f64| tilt_axis * self.turned(t, &moves_s);
            // A sensor keeps the integral of a rate, even where it jumps: the mean over the period.
            let rate = (turn(t + 0.5 / RATE_HZ) - turn(t - 0.5 / RATE_HZ)) * RATE_HZ;
            let attitude = attitude * Rotation3::new(turn(t)).into_inner();
            let force = attitude.transpose() * (a + V3::z() * G) + extra;
            let reading = force - force_error * force - bias + noise.vector(shake);
            let turned = rate - rate_error * rate + rate_bias + noise.vector(spin);
            let lost = drops && lost.uniform(0.0, 1.0) < 0.02;
            if lost || t < self.cut_s {
                continue;
            }
            // The stamp of the mean over the period around it.
            out.time_s.push(t + 0.5 / RATE_HZ);
            let written = |v: &V3, range: f64| [0, 1, 2].map(|c| v[c].clamp(-range, range));
            out.force.push(written(&reading, self.ranges[0]));
            if self.gyro {
                out.rate.push(written(&turned, self.ranges[1]));
            }
        }
        if self.trouble == Trouble::Knocks {
            // Their velocity is a Gaussian, in the part of it that a move holds nearly all.
            let shares = knocks.map(|k| k.1 * (-0.005_f64.powi(2) * TAU.sqrt()));
            out.displacement -= shares.iter().sum::<V3>();
        }
        self.spoil(&mut out);
        out
    }

    /// Angle by which it is tilted at a time, rad.
    fn turned(&self, t: f64, moves_s: &[(f64, f64)]) -> f64 {
        let after = if t > moves_s[0].0 { 1.0 } else { 0.0 };
        match (self.trouble, phase(t, moves_s)) {
            (Trouble::Wobble(w), Some(u)) => w * (TAU * u).sin(),
            (Trouble::Tilt(w), Some(u)) => w * (PI * u).sin().powi(2),
            (Trouble::LastingTilt(w), Some(u)) => w * (PI * u / 2.0).sin().powi(2),
            (Trouble::LastingTilt(w), None) => w * after,
            _ => 0.0,
        }
    }

    fn spoil(&self, out: &mut Recording) {
        let Some((from, _)) = out.moves_s.first() else {
            return;
        };
        let at = out.time_s.partition_point(|t| *t < from + 0.5);
        match self.trouble {
            Trouble::Spikes(rows) => (at..at + rows).for_each(|i| out.force[i][0] += 15.0),
            Trouble::Hang => {
                let rows = at..at + (1.4 * RATE_HZ) as usize;
                let force = out.force[at];
                out.force[rows.clone()].fill(force);
                if let Some(rate) = out.rate.get(at).copied() {
                    out.rate[rows].fill(rate);
                }
            }
            _ => {}
        }
    }
}
