//! How accurate the calibration of worn sensors is, over simulated wrists with known truth: the
//! table of `docs/accuracy.md`.
//!
//! ```console
//! $ cargo run --release --example wearables -- [WRISTS]
//! ```
//!
//! Each wrist is the stills of a few days: means without rows. Their directions gather in a few
//! habits, their temperature follows the hours, and what bends them beyond their noise is the sway
//! of a body that breathes.

use gravical::estimate::joint::{
    JointFit, JointOptions, JointPose, NORMAL_95, Role, joint, test_drift,
};
use gravical::predicted::{sensitivity, sphere, variance};
use gravical_core::matrix3;
use gravical_core::unit::STANDARD_GRAVITY_MPS2 as G;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const STILLS: usize = 300;
/// Standard error of a mean by the noise, g, and what sway adds to it, which nobody knows.
const NOISE_G: f64 = 3e-4;
const SWAY_G: f64 = 1.5e-3;
/// °C at which the true bias holds.
const TRUE_AT_C: f64 = 26.0;

/// M upper triangular, as the convention has it; readings in g.
struct Wrist {
    m: [[f64; 3]; 3],
    b: [f64; 3],
    drift: [f64; 3],
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample(StandardNormal)
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    v.map(|x| x / matrix3::norm(&v))
}

impl Wrist {
    fn new(drift_g_per_c: f64, rng: &mut ChaCha8Rng) -> Self {
        let mut m = [[0.0; 3]; 3];
        for i in 0..3 {
            m[i][i] = (1.0 + 0.015 * normal(rng)) / G;
            for j in i + 1..3 {
                m[i][j] = 0.007 * normal(rng) / G;
            }
        }
        Wrist {
            m,
            b: [0.0; 3].map(|_: f64| 0.03 * normal(rng)),
            drift: [0.0; 3].map(|_: f64| drift_g_per_c * normal(rng)),
        }
    }

    fn bias_at(&self, t_c: f64) -> [f64; 3] {
        std::array::from_fn(|i| self.b[i] + self.drift[i] * (t_c - TRUE_AT_C))
    }

    /// Stills in order of time: half of them in one of eight habits, the others anywhere.
    fn stills(&self, rng: &mut ChaCha8Rng) -> Vec<JointPose> {
        let habits: Vec<[f64; 3]> = (0..8)
            .map(|_| unit([0.0; 3].map(|_: f64| normal(rng))))
            .collect();
        let mut t_c = TRUE_AT_C;
        (0..STILLS)
            .map(|_| {
                t_c = (t_c + 0.8 * normal(rng) + 0.03 * (27.0 - t_c)).clamp(18.0, 34.0);
                let wide = if rng.random::<bool>() { 0.2 } else { 10.0 };
                let habit = habits[rng.random_range(0..habits.len())];
                let n = unit(habit.map(|v| v + wide * normal(rng)));
                let bias = self.bias_at(t_c);
                let scatter = NOISE_G.hypot(SWAY_G);
                JointPose {
                    mean: std::array::from_fn(|i| {
                        G * matrix3::dot(&self.m[i], &n) + bias[i] + scatter * normal(rng)
                    }),
                    standard_error: [NOISE_G; 3],
                    role: Role::Open,
                    temperature_c: Some(t_c),
                }
            })
            .collect()
    }
}

/// Squared errors and intervals that hold, of one quantity over all wrists.
#[derive(Default)]
struct Score {
    squares: f64,
    inside: usize,
    count: usize,
}

impl Score {
    fn add(&mut self, error: f64, sd: f64) {
        self.squares += error * error;
        self.inside += usize::from(error.abs() < NORMAL_95 * sd);
        self.count += 1;
    }

    fn cells(&self, per: f64) -> String {
        let count = self.count as f64;
        let rms = per * (self.squares / count).sqrt();
        format!("{rms:.2} | {:.1} %", 100.0 * self.inside as f64 / count)
    }
}

#[derive(Default)]
struct Scores {
    norm: Score,
    bias: Score,
    scale: Score,
    cross: Score,
    drift: Score,
    drifts: usize,
    failed: usize,
}

impl Scores {
    fn add(&mut self, wrist: &Wrist, found: &JointFit) {
        let sd = |k: usize| found.covariance[k][k].sqrt();
        let at_c = found.drift.map_or(TRUE_AT_C, |d| d.reference_c);
        let bias = wrist.bias_at(at_c);
        for i in 0..3 {
            self.bias.add(found.bias[i] - bias[i], sd(9 + i));
            for j in i..3 {
                let error = (found.model[i][j] - wrist.m[i][j]) * G;
                let score = if i == j {
                    &mut self.scale
                } else {
                    &mut self.cross
                };
                score.add(error, G * sd(3 * i + j));
            }
            if let Some(drift) = found.drift {
                self.drift.add(drift.per_c[i] - wrist.drift[i], drift.sd[i]);
            }
        }
        let Some(inverse) = matrix3::inverse(&found.model) else {
            return;
        };
        for n in sphere(50) {
            let u: [f64; 3] = std::array::from_fn(|i| {
                G * matrix3::dot(&wrist.m[i], &n) + bias[i] - found.bias[i]
            });
            let error = matrix3::norm(&matrix3::mul_vec(&inverse, &u)) - G;
            let h = sensitivity(&inverse, n, G);
            self.norm.add(error, variance(&found.covariance, &h).sqrt());
        }
    }
}

fn run(wrists: u64, drift_g_per_c: f64) -> Scores {
    let mut scores = Scores::default();
    let options = JointOptions {
        nominal: Some(1.0 / G),
        ..JointOptions::default()
    };
    for seed in 0..wrists {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let wrist = Wrist::new(drift_g_per_c, &mut rng);
        let stills = wrist.stills(&mut rng);
        let drift = test_drift(&stills, &options).is_ok_and(|test| test.helps);
        scores.drifts += usize::from(drift);
        match joint(&stills, &JointOptions { drift, ..options }) {
            Ok(found) => scores.add(&wrist, &found),
            Err(_) => scores.failed += 1,
        }
    }
    scores
}

fn main() {
    let wrists: u64 = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(200);
    println!("{wrists} wrists of {STILLS} stills: rms error and 95 % intervals that hold\n");
    println!(
        "| drift of the sensor | fitted in | ‖a‖, mg | | bias, mg | | scale, 10⁻³ | | cross-axis, 10⁻³ | | drift, mg/°C | |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (name, drift_g_per_c) in [("none", 0.0), ("0.3 mg/°C", 3e-4), ("1 mg/°C", 1e-3)] {
        let s = run(wrists, drift_g_per_c);
        println!(
            "| {name} | {} of {wrists} | {} | {} | {} | {} | {} |",
            s.drifts,
            s.norm.cells(1000.0 / G),
            s.bias.cells(1000.0),
            s.scale.cells(1000.0),
            s.cross.cells(1000.0),
            match drift_g_per_c {
                0.0 => "– | –".to_owned(),
                _ => s.drift.cells(1000.0),
            },
        );
        if s.failed > 0 {
            println!("{} of them have no result", s.failed);
        }
    }
}
