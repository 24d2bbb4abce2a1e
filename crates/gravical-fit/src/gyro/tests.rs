//! Simulated sensors whose truth is known.

use std::ops::Range;

use super::*;
use nalgebra::Rotation3;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Readings are calibrated already.
const IDENTITY: LinearCalibration<f64> = LinearCalibration {
    matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    bias: [0.0; 3],
};

const G: f64 = 9.81;
const RATE_HZ: f64 = 100.0;
const DEG: f64 = std::f64::consts::PI / 180.0;

/// A session of simulated sensors.
#[derive(Debug, Clone, Copy)]
struct World {
    motions: usize,
    /// Allan N, rad/√s.
    noise: f64,
    /// Bias drift, rad/s, and its correlation time, s.
    drift: [f64; 2],
    /// Standard deviation of the mean of the accelerometer, m/s².
    accel_sd: f64,
    /// … of the elements of its matrix, which nobody knows of.
    accel_error: f64,
}

const CHEAP: World = World {
    motions: 17,
    noise: 0.005 * DEG,
    drift: [0.0, 1.0],
    accel_sd: 0.002,
    accel_error: 0.0,
};

#[derive(Clone)]
struct Session {
    stills: Vec<StaticInterval>,
    motions: Vec<Motion>,
    model: Matrix3<f64>,
    bias: Vector3<f64>,
}

fn normal(rng: &mut impl Rng) -> f64 {
    rng.sample(StandardNormal)
}

fn vector(rng: &mut impl Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(rng))
}

impl World {
    fn session(&self, seed: u64) -> Session {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let model = Matrix3::identity() + Matrix3::from_fn(|_, _| 0.017 * normal(rng));
        let bias = 0.02 * vector(rng);
        let error = Matrix3::from_fn(|_, _| self.accel_error * normal(rng));
        let distortion = Matrix3::identity() + 0.5 * (error + error.transpose());
        let sd = self.noise * RATE_HZ.sqrt();
        let mut drift = self.drift[0] * vector(rng);
        let keep = (-1.0 / RATE_HZ / self.drift[1]).exp();
        let mut read = |rng: &mut ChaCha8Rng, omega: Vector3<f64>| -> [f64; 3] {
            drift = keep * drift + (1.0 - keep * keep).sqrt() * self.drift[0] * vector(rng);
            (model * omega + bias + drift + sd * vector(rng)).into()
        };
        let mut attitude = Rotation3::new(vector(rng));
        let (mut stills, mut motions) = (Vec::new(), Vec::new());
        for k in 0..=self.motions {
            let rows = 300;
            let mut sum = Vector3::zeros();
            let mut last = [0.0; 3];
            for _ in 0..rows {
                last = read(rng, Vector3::zeros());
                sum += Vector3::from(last);
            }
            let accel =
                distortion * attitude.inverse() * Vector3::z() * G + self.accel_sd * vector(rng);
            stills.push(StaticInterval {
                rate: (sum / f64::from(rows)).into(),
                seconds: f64::from(rows) / RATE_HZ,
                accel: accel.into(),
                accel_sd: [self.accel_sd; 3],
            });
            if k == self.motions {
                break;
            }
            // From one attitude to the next with a wobble on the way.
            let turn = vector(rng).normalize() * rng.random_range(0.8..2.8);
            let wobble = 0.3 * vector(rng);
            let seconds: f64 = rng.random_range(1.2..3.0);
            let at = |t: f64| {
                let s = (t / seconds).clamp(0.0, 1.0);
                let share = s - (std::f64::consts::TAU * s).sin() / std::f64::consts::TAU;
                let swing = (std::f64::consts::PI * s).sin().powi(4);
                attitude * Rotation3::new(turn * share) * Rotation3::new(wobble * swing)
            };
            let count = (seconds * RATE_HZ).ceil() as usize;
            let sample = |rate| Sample {
                rate,
                accel: accel.into(),
                step_s: 1.0 / RATE_HZ,
            };
            let mut samples = vec![sample(last)];
            for i in 1..=count + 1 {
                let t = (i as f64 - 0.5) / RATE_HZ;
                let small = (at(t - 1e-4).inverse() * at(t + 1e-4)).into_inner();
                let omega = Vector3::new(small[(2, 1)], small[(0, 2)], small[(1, 0)]) / 2e-4;
                samples.push(sample(read(rng, omega)));
            }
            motions.push(Motion {
                before: k,
                after: k + 1,
                samples,
            });
            attitude = at(seconds);
        }
        Session {
            stills,
            motions,
            model,
            bias,
        }
    }

    fn options(&self) -> GyroOptions {
        GyroOptions {
            nominal: Some(1.0),
            noise: [self.noise; 3],
            rounding: [0.0; 3],
        }
    }

    /// Errors of M and b over their standard deviations.
    fn scores(&self, session: &Session) -> Vec<f64> {
        let fit = fit(session, &self.options()).by_motions.unwrap().unwrap();
        let found = Matrix3::from(fit.matrix).transpose().try_inverse().unwrap();
        let error = (found - session.model).transpose();
        let bias = Vector3::from(fit.bias) - session.bias;
        let errors = error.iter().chain(bias.iter());
        let score = |(i, e): (usize, &f64)| e / fit.covariance[i][i].sqrt();
        errors.enumerate().map(score).collect()
    }
}

/// Shares of the elements of M and of the biases of `count` sensors within their intervals of 95 %.
fn coverage(world: World, count: u64) -> [f64; 2] {
    let scores = (0..count).map(|seed| world.scores(&world.session(seed)));
    let scores: Vec<Vec<f64>> = scores.collect();
    [0..9, 9..12].map(|part: Range<usize>| {
        let all = scores.iter().flat_map(|z| &z[part.clone()]);
        let within = all.filter(|z| z.abs() < 1.96).count();
        within as f64 / (scores.len() * part.len()) as f64
    })
}

/// Drift is of the bias, °/s, with its time constant, s.
const fn world(motions: usize, accel_sd: f64, accel_error: f64, drift: [f64; 2]) -> World {
    World {
        motions,
        accel_sd,
        accel_error,
        drift: [drift[0] * DEG, drift[1]],
        ..CHEAP
    }
}

/// The conditions of docs/accuracy-gyro.md.
const WORLDS: [World; 10] = [
    world(17, 0.002, 0.0, [0.0, 1.0]),
    world(17, 0.002, 0.0005, [0.05, 5.0]),
    world(8, 0.002, 0.0005, [0.05, 5.0]),
    world(8, 0.002, 0.0, [0.0, 1.0]),
    world(40, 0.002, 0.0, [0.0, 1.0]),
    world(17, 0.01, 0.0, [0.0, 1.0]),
    world(17, 0.002, 0.0, [0.05, 5.0]),
    world(17, 0.002, 0.0, [0.05, 20.0]),
    world(40, 0.002, 0.0, [0.05, 20.0]),
    world(17, 0.002, 0.0005, [0.0, 1.0]),
];

/// Within three standard deviations of the shares.
fn assert_covered(worlds: &[World], count: u64, [matrix, bias]: [f64; 2]) {
    for world in worlds {
        let found = coverage(*world, count);
        println!("{world:?}: {found:.3?}");
        assert!((found[0] - 0.95).abs() <= matrix && (found[1] - 0.95).abs() <= bias);
    }
}

#[test]
fn intervals_of_95_percent_hold_the_truth() {
    // 216 elements, 72 biases: two standard deviations are 0.03 and 0.05.
    assert_covered(&WORLDS[..3], 24, [0.03, 0.05]);
}

#[test]
#[ignore = "slow: 6000 sessions"]
fn study() {
    assert_covered(&WORLDS, 600, [0.02, 0.03]);
}

/// The same session as a gyroscope would give it whose readings are `read` of these.
fn read_as(session: &Session, read: impl Fn([f64; 3]) -> [f64; 3]) -> Session {
    let mut other = session.clone();
    other.stills.iter_mut().for_each(|s| s.rate = read(s.rate));
    let samples = other.motions.iter_mut().flat_map(|m| &mut m.samples);
    samples.for_each(|s| s.rate = read(s.rate));
    other
}

fn fit(session: &Session, options: &GyroOptions) -> GyroFit {
    gyro(&session.stills, &session.motions, &IDENTITY, options).unwrap()
}

#[test]
fn a_reaction_to_gravity_is_found_where_there_is_one() {
    let session = CHEAP.session(4);
    let none = fit(&session, &CHEAP.options()).rest.g_sensitivity;
    assert_eq!(none, [[0.0; 3]; 3]);
    let mut other = session.clone();
    let stills = other.stills.iter_mut();
    stills.for_each(|s| s.rate[0] += 3e-4 * s.accel[2]);
    let found = fit(&other, &CHEAP.options()).rest.g_sensitivity;
    assert!((found[0][2] - 3e-4).abs() < 2e-5, "{found:?}");
    assert_eq!(found[1], [0.0; 3]);
}

#[test]
fn what_the_motions_leave_open() {
    // Turns that the x axis takes no part in, as far as the rates say.
    let still = read_as(&CHEAP.session(5), |[_, y, z]| [0.0, y, z]);
    let found = fit(&still, &CHEAP.options()).by_motions.unwrap();
    assert_eq!(found.unwrap_err().axes, [true, false, false]);
}

#[test]
fn no_input_panics() {
    let session = CHEAP.session(6);
    assert!(gyro(&[], &session.motions, &IDENTITY, &CHEAP.options()).is_none());
    for value in [f64::NAN, f64::INFINITY, 0.0, 1e300, -1e-300] {
        let options = GyroOptions {
            nominal: Some(value),
            noise: [value; 3],
            rounding: [value; 3],
        };
        let _ = gyro(&session.stills, &session.motions, &IDENTITY, &options);
        let mut other = session.clone();
        other.motions[2].samples[3].rate[1] = value;
        other.motions[3].samples[3].step_s = value;
        other.motions[4].samples.clear();
        other.motions[5].after = 1000;
        let _ = gyro(&other.stills, &other.motions, &IDENTITY, &CHEAP.options());
        let all = read_as(&other, |_| [value; 3]);
        let _ = gyro(&all.stills, &all.motions, &IDENTITY, &CHEAP.options());
        for still in &mut other.stills {
            still.accel = [value; 3];
            still.accel_sd = [value; 3];
            still.seconds = value;
        }
        let _ = gyro(&other.stills, &other.motions, &IDENTITY, &CHEAP.options());
    }
}

#[test]
fn readings_that_do_not_differ_leave_what_rounding_does() {
    let mut stills = CHEAP.session(7).stills;
    stills.iter_mut().for_each(|s| s.rate = [0.01; 3]);
    let options = GyroOptions {
        noise: [0.0; 3],
        rounding: [3e-3; 3],
        nominal: Some(1.0),
    };
    let fit = gyro(&stills, &[], &IDENTITY, &options);
    let rest = fit.unwrap().rest;
    assert_eq!(rest.bias, [0.01; 3]);
    assert!((rest.bias_sd[0] - 3e-3).abs() < 1e-12, "{:?}", rest.bias_sd);
}
