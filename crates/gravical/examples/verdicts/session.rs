//! A session of a virtual part: placements held for some seconds each, one
//! recording a placement, with or without something that no model knows of.

use gravical::calibrate::{CalibrateOptions, calibrate};
use gravical::calibration_file::{CalibrationFile, Grade};
use gravical::fit::model::sphere;
use gravical::gravity::Gravity;
use gravical::poses::face::Face;
use gravical::recording::{ReadOptions, Recording, SampleColumns};
use gravical::simulate::spread_directions;
use gravical_core::matrix3;
use nalgebra::Vector3;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const G: f64 = 9.80665;
const MG: f64 = G / 1000.0;
const RATE_HZ: f64 = 100.0;
/// Length of a hold.
const HOLD_S: f64 = 5.0;
/// White noise: 3.3e-3 m/s/√s at 100 Hz.
const NOISE_MPS2: f64 = 0.033;
/// Directions in which the truth is looked at.
const DIRECTIONS: usize = 1000;

/// Seed of the parts.
const SEED: u64 = 5;
/// Standard deviation of a scale, relative.
const SCALE_SD: f64 = 0.02;
/// Standard deviation of the off-diagonal elements of R, and of the two components of the tilt of a
/// pose, rad.
const ANGLE_SD_RAD: f64 = std::f64::consts::PI / 180.0;
/// Biases are uniformly distributed over ± this, m/s².
const BIAS_LIMIT_MPS2: f64 = 0.5;

/// A virtual part with known parameters: a cheap one.
#[derive(Clone)]
struct Part {
    model: [[f64; 3]; 3],
    bias: [f64; 3],
    tilts: ChaCha8Rng,
}

impl Part {
    /// Each part has its own random streams, so that it does not depend on the other parts, and
    /// separate ones for parameters and tilts.
    fn draw(index: u64) -> Self {
        let mut rng = stream(1, index);
        let mut model = [[0.0; 3]; 3];
        for (i, row) in model.iter_mut().enumerate() {
            let scale = 1.0 + SCALE_SD * normal(&mut rng);
            for (j, element) in row.iter_mut().enumerate() {
                let off = ANGLE_SD_RAD * normal(&mut rng);
                *element = scale * if i == j { 1.0 } else { off };
            }
        }
        let bias = std::array::from_fn(|_| BIAS_LIMIT_MPS2 * uniform(&mut rng));
        let mut tilts = stream(2, index);
        // What a table that is not level would take: published figures are of the tilts after it.
        for _ in 0..2 {
            normal(&mut tilts);
        }
        for _ in 0..6 {
            uniform(&mut tilts);
        }
        Part { model, bias, tilts }
    }

    /// The directions of the six faces, +x −x +y −y +z −z, each with a tilt of its own.
    fn faces(&mut self) -> Vec<[f64; 3]> {
        Face::all().map(|face| self.tilted(face)).to_vec()
    }

    fn tilted(&mut self, face: Face) -> [f64; 3] {
        let nominal = Vector3::from(face.direction());
        let first = nominal.cross(&Vector3::ith(nominal.iamin(), 1.0));
        let first = first.normalize();
        let second = nominal.cross(&first);
        let [p, q] = [0, 1].map(|_| ANGLE_SD_RAD * normal(&mut self.tilts));
        let delta = first * p + second * q;
        let angle = delta.norm();
        (nominal * angle.cos() + delta * (angle.sin() / angle)).into()
    }

    /// Reading without noise, m/s².
    fn read(&self, direction: [f64; 3]) -> [f64; 3] {
        let force = matrix3::mul_vec(&self.model, &direction);
        std::array::from_fn(|i| G * force[i] + self.bias[i])
    }
}

/// The stream of random numbers of one purpose, as the simulator has it.
fn stream(purpose: u64, index: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    rng.set_stream((index << 8) | purpose);
    rng
}

fn normal(rng: &mut impl Rng) -> f64 {
    rng.sample(StandardNormal)
}

fn uniform(rng: &mut impl Rng) -> f64 {
    2.0 * rng.random::<f64>() - 1.0
}

/// Which placements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Plan {
    /// Six faces, and so many that a calibration of those before proposed, three at a
    /// time.
    Proposed(usize),
    /// Six faces and so many far from each other.
    Spread(usize),
    /// So many spread over the sphere, none of them meant as a face.
    Free(usize),
    /// Each face four times, with a tilt of its own.
    Faces,
    /// Six faces, and one of them once more.
    Again,
}

impl Plan {
    pub const ALL: [Plan; 7] = [
        Plan::Proposed(3),
        Plan::Proposed(6),
        Plan::Spread(12),
        Plan::Free(10),
        Plan::Free(12),
        Plan::Free(18),
        Plan::Faces,
    ];

    pub fn name(self) -> String {
        match self {
            Plan::Proposed(n) => format!("6 faces + {n} proposed"),
            Plan::Spread(n) => format!("6 faces + {n} spread"),
            Plan::Free(n) => format!("{n} free poses"),
            Plan::Faces => "each face 4 times".to_owned(),
            Plan::Again => "6 faces + 1 again".to_owned(),
        }
    }
}

/// What spoils it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Disturbance {
    None,
    /// 20 mg in one pose, in any direction.
    OnePose,
    /// The bias moves by 20 mg from the first hold to the last.
    Drift,
    /// Every axis reads 0.5 % of the cube (of what it feels in g).
    Cubic,
    /// A third of a second in which the sensor is pushed by 0.3 g.
    Bump,
    /// 30 mg at 23 Hz in all holds.
    Vibration,
    /// Gravity that is given is 0.3 % too large.
    Gravity,
    /// 1 g on a tenth of the rows of one hold.
    Spikes,
}

impl Disturbance {
    pub const ALL: [Disturbance; 8] = [
        Disturbance::None,
        Disturbance::OnePose,
        Disturbance::Drift,
        Disturbance::Cubic,
        Disturbance::Bump,
        Disturbance::Vibration,
        Disturbance::Gravity,
        Disturbance::Spikes,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Disturbance::None => "nothing",
            Disturbance::OnePose => "20 mg in one pose",
            Disturbance::Drift => "a bias that drifts by 20 mg",
            Disturbance::Cubic => "cubic nonlinearity of 0.5 %",
            Disturbance::Bump => "a bump of 0.3 g",
            Disturbance::Vibration => "vibration of 30 mg",
            Disturbance::Gravity => "g given 0.3 % too large",
            Disturbance::Spikes => "spikes of 1 g in 10 % of a pose",
        }
    }
}

/// What came of a session.
pub struct Judged {
    pub grade: Grade,
    /// Largest error of ‖a‖ over all directions, mg.
    pub worst_mg: f64,
    /// The same as the verdict predicts it (95 %), mg.
    pub predicted_mg: f64,
    /// Undetected error by the verdict, mg.
    pub undetected_mg: f64,
}

pub struct Session {
    plan: Plan,
    index: u64,
    part: Part,
    rng: ChaCha8Rng,
}

fn calibrate_at(recordings: &[Recording], gravity: f64) -> Option<CalibrationFile> {
    let options = CalibrateOptions {
        gravity: Gravity::given(gravity).ok()?,
        ..CalibrateOptions::default()
    };
    Some(calibrate(recordings, &options).ok()?.file)
}

/// At the true gravity.
pub fn calibrated(recordings: &[Recording]) -> Option<CalibrationFile> {
    calibrate_at(recordings, G)
}

impl Session {
    pub fn of(plan: Plan, index: u64) -> Session {
        Session {
            plan,
            index,
            part: Part::draw(index),
            rng: ChaCha8Rng::seed_from_u64(1000 + index),
        }
    }

    fn direction(&mut self) -> [f64; 3] {
        let v: [f64; 3] = std::array::from_fn(|_| self.rng.sample(StandardNormal));
        let length = matrix3::norm(&v);
        v.map(|v| v / length)
    }

    /// `count` directions spread over the sphere, each missed by some degrees, in no
    /// particular order.
    fn by_hand(&mut self, count: usize) -> Vec<[f64; 3]> {
        let mut keyed: Vec<(f64, [f64; 3])> = sphere(count)
            .map(|n| {
                let by = self.direction();
                let v: [f64; 3] = std::array::from_fn(|i| n[i] + 0.15 * by[i]);
                let length = matrix3::norm(&v);
                (self.rng.random(), v.map(|v| v / length))
            })
            .collect();
        keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
        keyed.into_iter().map(|(_, direction)| direction).collect()
    }

    /// Recordings of one session, and the true reading in any direction, the noise and
    /// the accidents of single holds left away.
    pub fn record(
        &mut self,
        disturbance: Disturbance,
    ) -> (Vec<Recording>, impl Fn([f64; 3]) -> [f64; 3] + use<>) {
        let mut places: Vec<[f64; 3]> = match self.plan {
            Plan::Proposed(_) => self.part.faces(),
            Plan::Spread(n) => {
                let spread = spread_directions(n, self.index);
                self.part.faces().into_iter().chain(spread).collect()
            }
            Plan::Free(n) => self.by_hand(n),
            Plan::Faces => (0..4).flat_map(|_| self.part.faces()).collect(),
            Plan::Again => {
                let mut all = self.part.faces();
                all.push(self.part.tilted(Face::all()[self.index as usize % 6]));
                all
            }
        };
        let clean = self.part.clone();
        let cubic = move |u: [f64; 3]| match disturbance {
            Disturbance::Cubic => u.map(|v| v + 0.005 * G * (v / G).powi(3)),
            _ => u,
        };
        let read = move |n: [f64; 3]| cubic(clean.read(n));
        if let Plan::Proposed(count) = self.plan {
            while places.len() < 6 + count {
                let so_far: Vec<Recording> = places
                    .iter()
                    .enumerate()
                    .filter_map(|(k, up)| self.hold(k, read(*up), |_| [0.0; 3]))
                    .collect();
                let Some(file) = calibrated(&so_far) else {
                    break;
                };
                places.extend(file.accelerometer.next_poses.iter().map(|p| p.direction));
            }
        }
        let recordings = self.spoiled(&places, &read, disturbance);
        (recordings, read)
    }

    fn spoiled(
        &mut self,
        places: &[[f64; 3]],
        read: &impl Fn([f64; 3]) -> [f64; 3],
        disturbance: Disturbance,
    ) -> Vec<Recording> {
        let count = places.len();
        let hit = self.rng.random_range(0..count);
        let way = self.direction();
        let phase: f64 = self.rng.random();
        let mut spike = ChaCha8Rng::seed_from_u64(self.index);
        let mut out = Vec::new();
        for (k, place) in places.iter().enumerate() {
            let along = k as f64 / (count - 1) as f64 - 0.5;
            let spikes: Vec<bool> = (0..(RATE_HZ * HOLD_S) as usize)
                .map(|_| spike.random::<f64>() < 0.1)
                .collect();
            let more = |row: usize| match disturbance {
                Disturbance::OnePose if k == hit => way.map(|w| 20.0 * MG * w),
                Disturbance::Drift => way.map(|w| 20.0 * MG * along * w),
                Disturbance::Bump if k == hit && (200..233).contains(&row) => {
                    way.map(|w| 0.3 * G * w)
                }
                Disturbance::Vibration => {
                    let t = row as f64 / RATE_HZ + phase;
                    let s = (std::f64::consts::TAU * 23.0 * t).sin();
                    way.map(|w| 30.0 * MG * s * w)
                }
                Disturbance::Spikes if k == hit && spikes[row] => way.map(|w| G * w),
                _ => [0.0; 3],
            };
            out.extend(self.hold(k, read(*place), more));
        }
        out
    }

    fn hold(
        &mut self,
        k: usize,
        mean: [f64; 3],
        more: impl Fn(usize) -> [f64; 3],
    ) -> Option<Recording> {
        let rows = (RATE_HZ * HOLD_S) as usize;
        let time: Vec<f64> = (0..rows).map(|row| row as f64 / RATE_HZ).collect();
        let mut columns: [Vec<f64>; 3] = Default::default();
        for row in 0..rows {
            let more = more(row);
            for axis in 0..3 {
                let noise: f64 = self.rng.sample(StandardNormal);
                columns[axis].push(mean[axis] + NOISE_MPS2 * noise + more[axis]);
            }
        }
        let samples = SampleColumns {
            time: Some(&time),
            accel: [&columns[0], &columns[1], &columns[2]],
            ..SampleColumns::default()
        };
        let name = format!("hold{k}.csv");
        Recording::from_samples(&name, &samples, &ReadOptions::default()).ok()
    }

    /// Calibrates the session, and holds the result against the truth. None where it
    /// is refused.
    pub fn judge(&mut self, disturbance: Disturbance) -> Option<Judged> {
        let (recordings, read) = self.record(disturbance);
        let gravity = match disturbance {
            Disturbance::Gravity => 1.003 * G,
            _ => G,
        };
        let file = calibrate_at(&recordings, gravity)?;
        let apply = file.accelerometer_calibration();
        let worst = sphere(DIRECTIONS)
            .map(|n| (matrix3::norm(&apply.apply(read(n.into()))) - G).abs())
            .fold(0.0, f64::max);
        Some(Judged {
            grade: file.verdict.grade,
            worst_mg: worst / MG,
            predicted_mg: file
                .accelerometer
                .worst_direction
                .map_or(f64::INFINITY, |w| w.error_mps2 / MG),
            undetected_mg: file
                .accelerometer
                .undetected
                .map_or(f64::INFINITY, |u| u.effect_mps2 / MG),
        })
    }
}
