//! Sessions of simulated sensors, pose by pose: what a session measures, without its rows.

use gravical_fit::model::sphere;
use gravical_fit::{Face, Fit, Hint, Options, Pose, angle_deg, fit};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

pub type V = Vector3<f64>;
pub const G: f64 = 9.80665;
pub const MG: f64 = G / 1000.0;

pub fn normal(rng: &mut impl Rng) -> f64 {
    rng.sample(StandardNormal)
}

pub fn direction(rng: &mut impl Rng) -> V {
    V::from_fn(|_, _| normal(rng)).normalize()
}

/// A sensor of a cheap kind.
#[derive(Clone)]
pub struct Sensor {
    pub m: Matrix3<f64>,
    pub b: V,
    pub cubic: f64,
    pub quadratic: f64,
}

impl Sensor {
    pub fn draw(rng: &mut impl Rng) -> Sensor {
        let m = Matrix3::from_fn(|r, c| {
            let error = normal(rng);
            if r == c {
                1.0 + 0.02 * error
            } else {
                1_f64.to_radians() * error
            }
        });
        Sensor {
            m,
            b: V::from_fn(|_, _| rng.random_range(-0.5..0.5)),
            cubic: 0.0,
            quadratic: 0.0,
        }
    }

    pub fn read(&self, n: &V) -> V {
        (self.m * n * G + self.b)
            .map(|u| u + G * (self.cubic * (u / G).powi(3) + self.quadratic * (u / G).powi(2)))
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Plan {
    /// Faces, with so many free poses as proposed after the six and after every three more.
    Proposed(usize),
    Spread(usize),
    /// Free poses over the sphere.
    Free(usize),
    /// Edges, then corners, leaned on by hand.
    Edges(usize),
    Again(usize),
}

pub const PLANS: [Plan; 12] = [
    Plan::Proposed(0),
    Plan::Proposed(3),
    Plan::Proposed(6),
    Plan::Spread(4),
    Plan::Spread(12),
    Plan::Free(10),
    Plan::Free(12),
    Plan::Free(18),
    Plan::Free(24),
    Plan::Edges(18),
    Plan::Edges(24),
    Plan::Again(4),
];

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Disturbance {
    Nothing,
    /// Poses off by 20 mg.
    OnePose,
    TwoPoses,
    /// The bias moves by so many mg, steadily from the first pose to the last, or once between two of them.
    Drift(f64),
    Jump(f64),
    Cubic(f64),
    Quadratic(f64),
}

pub const DISTURBANCES: [Disturbance; 13] = [
    Disturbance::Nothing,
    Disturbance::OnePose,
    Disturbance::TwoPoses,
    Disturbance::Drift(10.0),
    Disturbance::Drift(20.0),
    Disturbance::Jump(10.0),
    Disturbance::Jump(20.0),
    Disturbance::Cubic(0.003),
    Disturbance::Cubic(0.005),
    Disturbance::Cubic(0.008),
    Disturbance::Cubic(0.01),
    Disturbance::Quadratic(0.005),
    Disturbance::Quadratic(0.01),
];

pub struct Session {
    pub rng: ChaCha8Rng,
    pub sensor: Sensor,
    /// Standard deviation of a mean, m/s².
    pub noise: f64,
    /// … of each component of a tilt, rad.
    pub tilt: f64,
    pub options: Options,
}

impl Session {
    pub fn new(seed: u64) -> Session {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let sensor = Sensor::draw(&mut rng);
        Session {
            rng,
            sensor,
            noise: 1.5e-3,
            tilt: 1_f64.to_radians(),
            options: Options {
                nominal: Some(1.0),
                gravity: G,
                ..Options::default()
            },
        }
    }

    pub fn face(&mut self, face: Face) -> V {
        let n = V::from(face.direction());
        let lean = V::from_fn(|_, _| self.tilt * normal(&mut self.rng));
        let lean = lean - n * n.dot(&lean);
        Rotation3::new(lean) * n
    }

    pub fn by_hand(&mut self, n: V) -> V {
        (n + 0.15 * direction(&mut self.rng)).normalize()
    }

    pub fn directions(&mut self, plan: Plan) -> Vec<V> {
        let faces = Face::all();
        match plan {
            Plan::Proposed(_) => faces.map(|f| self.face(f)).to_vec(),
            Plan::Spread(n) => {
                let mut all = faces.map(|f| self.face(f)).to_vec();
                for _ in 0..n {
                    let far = sphere(400).max_by(|a, b| {
                        let near = |n: &V| all.iter().map(|d| d.dot(n)).fold(-1.0, f64::max);
                        near(b).total_cmp(&near(a))
                    });
                    let lean = 0.09 * normal(&mut self.rng);
                    let axis = Unit::new_normalize(direction(&mut self.rng));
                    all.push(Rotation3::from_axis_angle(&axis, lean) * far.unwrap_or_default());
                }
                all
            }
            Plan::Free(n) => {
                let mut all: Vec<V> = sphere(n).map(|n| self.by_hand(n)).collect();
                for i in (1..all.len()).rev() {
                    all.swap(i, self.rng.random_range(0..=i));
                }
                all
            }
            Plan::Edges(n) => {
                let sign = |k: usize| [1.0, -1.0][k % 2];
                let edges = (0..12).map(|k| {
                    let mut n = V::zeros();
                    n[(k / 4 + 1) % 3] = sign(k / 2);
                    n[(k / 4 + 2) % 3] = sign(k);
                    n
                });
                let corners = (0..8).map(|k| V::new(sign(k / 4), sign(k / 2), sign(k)));
                let all = edges.chain(corners.clone()).chain(corners).take(n);
                all.map(|n| self.by_hand(n.normalize())).collect()
            }
            Plan::Again(times) => {
                let all = (0..times).flat_map(|_| faces);
                all.map(|f| self.face(f)).collect()
            }
        }
    }

    pub fn pose(&mut self, n: &V, more: V) -> Pose {
        let u = self.sensor.read(n) + more;
        Pose {
            mean: std::array::from_fn(|i| u[i] + self.noise * normal(&mut self.rng)),
            sd: [self.noise; 3],
            temperature_c: None,
            hint: Hint::Open,
        }
    }

    /// Fit, and the largest error of ‖a‖ over the sphere, against the mean bias of the session.
    pub fn run(&mut self, plan: Plan, disturbance: Disturbance) -> Option<(Fit, f64)> {
        match disturbance {
            Disturbance::Cubic(c) => self.sensor.cubic = c,
            Disturbance::Quadratic(c) => self.sensor.quadratic = c,
            _ => {}
        }
        let mut directions = self.directions(plan);
        if let Plan::Proposed(count) = plan {
            while directions.len() < 6 + count {
                let pose = |n: &V| self.pose(n, V::zeros());
                let poses: Vec<Pose> = directions.iter().map(pose).collect();
                let found = fit(&poses, &self.options).ok()?;
                let next: Vec<V> = found.next(3).iter().map(|n| V::from(n.direction)).collect();
                directions.extend(next.into_iter().map(|n| self.by_hand(n)));
            }
        }
        let count = directions.len();
        let (hit, way) = (self.rng.random_range(0..count), direction(&mut self.rng));
        let (next, other) = (self.rng.random_range(1..count), direction(&mut self.rng));
        let more = |k: usize| match disturbance {
            Disturbance::OnePose | Disturbance::TwoPoses if k == hit => way * 20.0 * MG,
            Disturbance::TwoPoses if k == (hit + next) % count => other * 20.0 * MG,
            Disturbance::Drift(mg) => way * mg * MG * (k as f64 / (count - 1) as f64),
            Disturbance::Jump(mg) if k >= next => way * mg * MG,
            _ => V::zeros(),
        };
        let more: Vec<V> = (0..count).map(more).collect();
        let both = directions.iter().zip(&more);
        let poses: Vec<Pose> = both.map(|(n, more)| self.pose(n, *more)).collect();
        let found = fit(&poses, &self.options).ok()?;
        if matches!(disturbance, Disturbance::Drift(_) | Disturbance::Jump(_)) {
            self.sensor.b += more.iter().sum::<V>() / count as f64;
        }
        let worst = errors(&found, &self.sensor)?.0;
        Some((found, worst))
    }
}

/// M row-major and b.
pub type Model = ([[f64; 3]; 3], [f64; 3]);

/// Errors of ‖a‖ in mg, of the bias in mg, of the direction of the axes in degrees, rms.
pub fn parameter_errors((m, b): &Model, sensor: &Sensor) -> [f64; 3] {
    let bias = V::from(*b) - sensor.b;
    let axis = |i: usize| angle_deg(m[i], sensor.m.row(i).transpose().into());
    let axes = (0..3).map(|i| axis(i).powi(2)).sum::<f64>() / 3.0;
    let norm = norm_errors(&(*m, *b), sensor).map_or(f64::NAN, |e| e.1);
    [norm / MG, bias.norm() / 3_f64.sqrt() / MG, axes.sqrt()]
}

/// Largest error of ‖a‖ over the sphere and its root mean square, m/s².
pub fn norm_errors((m, b): &Model, sensor: &Sensor) -> Option<(f64, f64)> {
    let inverse = Matrix3::from_fn(|r, c| m[r][c]).try_inverse()?;
    let b = V::from(*b);
    let each = sphere(1000).map(|n| ((inverse * (sensor.read(&n) - b)).norm() - G).abs());
    let errors: Vec<f64> = each.collect();
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    let largest = errors.iter().copied().fold(0.0, f64::max);
    Some((largest, (squares / errors.len() as f64).sqrt()))
}

pub fn errors(found: &Fit, sensor: &Sensor) -> Option<(f64, f64)> {
    norm_errors(&(found.model(), found.bias()), sensor)
}
