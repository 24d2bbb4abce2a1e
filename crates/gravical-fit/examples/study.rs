//! What a fit and its grade are worth: simulated sessions whose truth is known.
//!
//! ```console
//! $ cargo run --release -p gravical-fit --example study -- 300
//! ```
//!
//! Every line is a kind of session under one disturbance: shares of the grades, results that are called
//! better than they are, how often the error claimed for the worst direction holds, and how many of the
//! 95 % intervals of M and b hold the truth. The number is that of sensors; a word selects lines.

use gravical_fit::model::sphere;
use gravical_fit::{Face, Fit, Grade, Hint, Options, Pose, fit};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

type V = Vector3<f64>;
const G: f64 = 9.80665;
const MG: f64 = G / 1000.0;

fn normal(rng: &mut impl Rng) -> f64 {
    rng.sample(StandardNormal)
}

fn direction(rng: &mut impl Rng) -> V {
    V::from_fn(|_, _| normal(rng)).normalize()
}

/// A sensor of a cheap kind.
#[derive(Clone)]
struct Sensor {
    m: Matrix3<f64>,
    b: V,
    cubic: f64,
    quadratic: f64,
}

impl Sensor {
    fn draw(rng: &mut impl Rng) -> Sensor {
        let m = Matrix3::from_fn(|r, c| {
            if r == c {
                1.0 + 0.02 * normal(rng)
            } else {
                1_f64.to_radians() * normal(rng)
            }
        });
        Sensor {
            m,
            b: V::from_fn(|_, _| rng.random_range(-0.5..0.5)),
            cubic: 0.0,
            quadratic: 0.0,
        }
    }

    fn read(&self, n: &V) -> V {
        (self.m * n * G + self.b)
            .map(|u| u + G * (self.cubic * (u / G).powi(3) + self.quadratic * (u / G).powi(2)))
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Plan {
    /// Faces, with so many free poses as proposed after the six and after every three more.
    Proposed(usize),
    Spread(usize),
    /// Free poses over the sphere.
    Free(usize),
    /// Edges, then corners, leaned on by hand.
    Edges(usize),
    Again(usize),
}

impl Plan {
    fn name(self) -> String {
        match self {
            Plan::Proposed(0) => "6 faces".into(),
            Plan::Proposed(n) => format!("6 faces + {n} proposed"),
            Plan::Spread(n) => format!("6 faces + {n} spread"),
            Plan::Free(n) => format!("{n} free"),
            Plan::Edges(n) => format!("{n} edges and corners"),
            Plan::Again(n) => format!("each face {n} times"),
        }
    }
}

const PLANS: [Plan; 12] = [
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

#[derive(Clone, Copy, PartialEq)]
enum Disturbance {
    Nothing,
    OnePose,
    Drift,
    Cubic(f64),
    Quadratic(f64),
}

impl Disturbance {
    fn name(self) -> String {
        match self {
            Disturbance::Nothing => "nothing".into(),
            Disturbance::OnePose => "20 mg in one pose".into(),
            Disturbance::Drift => "drift of 20 mg".into(),
            Disturbance::Cubic(c) => format!("cubic {:.1} %", 100.0 * c),
            Disturbance::Quadratic(c) => format!("quadratic {:.1} %", 100.0 * c),
        }
    }
}

const DISTURBANCES: [Disturbance; 9] = [
    Disturbance::Nothing,
    Disturbance::OnePose,
    Disturbance::Drift,
    Disturbance::Cubic(0.003),
    Disturbance::Cubic(0.005),
    Disturbance::Cubic(0.008),
    Disturbance::Cubic(0.01),
    Disturbance::Quadratic(0.005),
    Disturbance::Quadratic(0.01),
];

struct Session {
    rng: ChaCha8Rng,
    sensor: Sensor,
    noise: f64,
    tilt: f64,
}

impl Session {
    fn new(seed: u64) -> Session {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let sensor = Sensor::draw(&mut rng);
        Session {
            rng,
            sensor,
            noise: 1.5e-3,
            tilt: 1_f64.to_radians(),
        }
    }

    fn face(&mut self, face: Face) -> V {
        let n = V::from(face.direction());
        let lean = V::from_fn(|_, _| self.tilt * normal(&mut self.rng));
        let lean = lean - n * n.dot(&lean);
        Rotation3::new(lean) * n
    }

    fn by_hand(&mut self, n: V) -> V {
        (n + 0.15 * direction(&mut self.rng)).normalize()
    }

    fn directions(&mut self, plan: Plan) -> Vec<V> {
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
                    all.push(Rotation3::from_axis_angle(&axis, lean) * far.unwrap());
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
                let signs = [1.0, -1.0];
                let mut all = Vec::new();
                for axis in 0..3 {
                    for a in signs {
                        for b in signs {
                            let mut n = V::zeros();
                            n[(axis + 1) % 3] = a;
                            n[(axis + 2) % 3] = b;
                            all.push(n.normalize());
                        }
                    }
                }
                for a in signs {
                    for b in signs {
                        for c in signs {
                            all.push(V::new(a, b, c).normalize());
                        }
                    }
                }
                let corners = all[12..].to_vec();
                all.extend(corners);
                all.truncate(n);
                all.into_iter().map(|n| self.by_hand(n)).collect()
            }
            Plan::Again(times) => (0..times)
                .flat_map(|_| faces)
                .map(|f| self.face(f))
                .collect(),
        }
    }

    fn pose(&mut self, n: &V, more: V) -> Pose {
        let u = self.sensor.read(n) + more;
        Pose {
            mean: std::array::from_fn(|i| u[i] + self.noise * normal(&mut self.rng)),
            sd: [self.noise; 3],
            temperature_c: None,
            hint: Hint::Open,
        }
    }

    /// Fit, and the largest error of ‖a‖ over the sphere.
    fn run(&mut self, plan: Plan, disturbance: Disturbance) -> Option<(Fit, f64)> {
        match disturbance {
            Disturbance::Cubic(c) => self.sensor.cubic = c,
            Disturbance::Quadratic(c) => self.sensor.quadratic = c,
            _ => {}
        }
        let options = Options {
            nominal: Some(1.0),
            gravity: G,
            ..Options::default()
        };
        let mut directions = self.directions(plan);
        if let Plan::Proposed(count) = plan {
            while directions.len() < 6 + count {
                let poses: Vec<Pose> = directions
                    .clone()
                    .iter()
                    .map(|n| self.pose(n, V::zeros()))
                    .collect();
                let found = fit(&poses, &options).ok()?;
                let next: Vec<V> = found.next(3).iter().map(|n| V::from(n.direction)).collect();
                directions.extend(next.into_iter().map(|n| self.by_hand(n)));
            }
        }
        let hit = self.rng.random_range(0..directions.len());
        let way = direction(&mut self.rng);
        let count = directions.len();
        let poses: Vec<Pose> = directions
            .iter()
            .enumerate()
            .map(|(k, n)| {
                let more = match disturbance {
                    Disturbance::OnePose if k == hit => way * 20.0 * MG,
                    Disturbance::Drift => way * 20.0 * MG * (k as f64 / (count - 1) as f64 - 0.5),
                    _ => V::zeros(),
                };
                self.pose(n, more)
            })
            .collect();
        let found = fit(&poses, &options).ok()?;
        let m = found.model();
        let inverse = Matrix3::from_fn(|r, c| m[r][c]).try_inverse()?;
        let b = V::from(found.bias());
        let error = |n: V| ((inverse * (self.sensor.read(&n) - b)).norm() - G).abs();
        let worst = sphere(1000).map(error).fold(0.0, f64::max);
        Some((found, worst))
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let count: u64 = arguments
        .first()
        .and_then(|a| a.parse().ok())
        .unwrap_or(100);
    let only = arguments.get(1).cloned().unwrap_or_default();
    println!(
        "| session | disturbed by | good | fair | not verifiable | poor | refused | wrong good | wrong fair | error, mg | claimed, mg | holds | undetected, mg | intervals of b | of M |"
    );
    println!("|{}", " --- |".repeat(15));
    for plan in PLANS {
        for disturbance in DISTURBANCES {
            if !plan.name().contains(&only) && !disturbance.name().contains(&only) {
                continue;
            }
            line(plan, disturbance, count);
        }
    }
}

/// How many 95 % intervals hold, of how many: the elements of M, or without faces what a rotation of
/// the frame leaves alone, the lengths of its rows and the products of them.
fn element_intervals(found: &Fit, truth: &Matrix3<f64>) -> (usize, usize) {
    let (m, c) = (found.model(), found.covariance());
    let m = Matrix3::from_fn(|r, k| m[r][k]);
    let c = nalgebra::DMatrix::from_fn(9, 9, |i, k| c[i][k]);
    let holds = |difference: f64, variance: f64| difference.abs() < 1.96 * variance.sqrt();
    if found.oriented {
        let each = (0..9).map(|i| holds(m[(i / 3, i % 3)] - truth[(i / 3, i % 3)], c[(i, i)]));
        return (each.filter(|h| *h).count(), 9);
    }
    let products = |m: &Matrix3<f64>| m * m.transpose();
    let difference = products(&m) - products(truth);
    let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
    let each = pairs.map(|(p, q)| {
        let mut h = nalgebra::DVector::zeros(9);
        for k in 0..3 {
            h[3 * p + k] += m[(q, k)];
            h[3 * q + k] += m[(p, k)];
        }
        holds(difference[(p, q)], (h.transpose() * &c * &h)[0])
    });
    (each.iter().filter(|h| **h).count(), 6)
}

fn line(plan: Plan, disturbance: Disturbance, count: u64) {
    let (mut grades, mut wrong, mut refused) = ([0; 4], [0; 2], 0);
    let (mut errors, mut claims, mut hidden) = (vec![], vec![], vec![]);
    let (mut holds, mut bias, mut model, mut elements) = (0, 0, 0, 0);
    for seed in 0..count {
        let mut session = Session::new(seed);
        let Some((found, worst)) = session.run(plan, disturbance) else {
            refused += 1;
            continue;
        };
        let trust = found.trust();
        let grade = trust.grade();
        let at = [Grade::Good, Grade::Fair, Grade::NotVerifiable, Grade::Poor];
        grades[at.iter().position(|g| *g == grade).unwrap()] += 1;
        wrong[0] += usize::from(grade == Grade::Good && worst > 5.0 * MG);
        wrong[1] += usize::from(grade == Grade::Fair && worst > 20.0 * MG);
        errors.push(worst / MG);
        claims.push(trust.worst.error_mps2 / MG);
        hidden.push(trust.undetected.map_or(f64::INFINITY, |u| u.effect_mps2) / MG);
        holds += usize::from(worst <= trust.worst.error_mps2);
        let (b, c) = (found.bias(), found.covariance());
        for i in 0..3 {
            bias += usize::from((b[i] - session.sensor.b[i]).abs() < 1.96 * c[9 + i][9 + i].sqrt());
        }
        let within = element_intervals(&found, &session.sensor.m);
        model += within.0;
        elements += within.1;
    }
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let done = (count - refused) as f64;
    println!(
        "| {} | {} | {} | {} | {} | {} | {refused} | {} | {} | {:.2} | {:.2} | {:.2} | {:.1} | {:.3} | {:.3} |",
        plan.name(),
        disturbance.name(),
        grades[0],
        grades[1],
        grades[2],
        grades[3],
        wrong[0],
        wrong[1],
        median(&mut errors),
        median(&mut claims),
        holds as f64 / done,
        median(&mut hidden),
        bias as f64 / done / 3.0,
        model as f64 / f64::from(elements as u32),
    );
}
