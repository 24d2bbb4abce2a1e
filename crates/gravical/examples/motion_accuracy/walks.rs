//! A walking foot whose parameters are off by draws from what is known of them.

use gravical::motion::{Calibrated, MotionOptions, motion};
use gravical::recording::Recording;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::recording::recording;
use super::runs::{ACCEL_SD, GYRO_SD, calibration};

type AnyError = Box<dyn std::error::Error>;

const RATE_HZ: f64 = 100.0;
const REST_S: f64 = 5.0;
const GRAVITY_MPS2: f64 = 9.80665;
/// A stride: its length, duration, and how long the foot swings.
const STRIDE_M: f64 = 1.2;
const STRIDE_S: f64 = 1.1;
const SWING_S: f64 = 0.65;
/// After so many strides the walk turns by 90°, within one stride.
const SIDE: usize = 8;
/// Noise: m/s/√s and rad/√s.
const ACCEL_N: f64 = 3.3e-3;
const GYRO_N: f64 = 8.7e-5;
/// What a data sheet says: bias m/s², scale, cross-axis; of the gyroscope scale, cross-axis.
const SHEET: ([f64; 3], [f64; 2]) = ([0.6, 0.03, 0.02], [0.03, 0.02]);

/// Position on the ground, height, yaw and pitch of the foot, `t` seconds into the walk.
fn foot(t: f64, strides: usize) -> [f64; 5] {
    let mut at = [0.0_f64; 5];
    let done = ((t / STRIDE_S).max(0.0) as usize).min(strides);
    let mut yaw = 0.0_f64;
    for k in 0..=done.min(strides.saturating_sub(1)) {
        let u = ((t - k as f64 * STRIDE_S) / SWING_S).clamp(0.0, 1.0);
        let s = u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        at[0] += STRIDE_M * s * yaw.cos();
        at[1] += STRIDE_M * s * yaw.sin();
        let turn = if k % SIDE == SIDE - 1 {
            std::f64::consts::FRAC_PI_2
        } else {
            0.0
        };
        at[3] = yaw + turn * s;
        yaw += turn;
        if u > 0.0 && u < 1.0 {
            let bell = (std::f64::consts::PI * u).sin().powi(2);
            at[2] = 0.12 * bell * bell;
            // Heel up first, then toes.
            at[4] = 1.6 * bell * bell.sqrt() * (std::f64::consts::PI * u).cos();
        }
    }
    at
}

/// A recording and where the walk ends.
fn walk(
    seed: u64,
    strides: usize,
    (accel_sd, gyro_sd): ([f64; 3], [f64; 2]),
) -> Result<(Recording, [f64; 3]), AnyError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x3a1c);
    let mut normal = || rng.sample::<f64, _>(StandardNormal);
    let mut matrix = |scale: f64, cross: f64| -> [[f64; 3]; 3] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| match i == j {
                true => 1.0 + scale * normal(),
                false => cross * normal(),
            })
        })
    };
    let (am, gm) = (
        matrix(accel_sd[1], accel_sd[2]),
        matrix(gyro_sd[0], gyro_sd[1]),
    );
    let bias = [0.0; 3].map(|_: f64| accel_sd[0] * normal());
    let seconds = 2.0 * REST_S + strides as f64 * STRIDE_S;
    let n = (seconds * RATE_HZ) as usize;
    let (mut t_s, mut accel, mut gyro) = (
        Vec::new(),
        [(); 3].map(|()| Vec::new()),
        [(); 3].map(|()| Vec::new()),
    );
    let e = 1e-3;
    for i in 0..n {
        let t = i as f64 / RATE_HZ - REST_S;
        let [a, b, c] = [t - e, t, t + e].map(|t| foot(t, strides));
        let acceleration: [f64; 3] = std::array::from_fn(|i| (a[i] - 2.0 * b[i] + c[i]) / (e * e));
        let (yaw, pitch) = (b[3], b[4]);
        let (dyaw, dpitch) = ((c[3] - a[3]) / (2.0 * e), (c[4] - a[4]) / (2.0 * e));
        let (sy, cy) = yaw.sin_cos();
        let (sp, cp) = pitch.sin_cos();
        // Rz(yaw) Ry(pitch), transposed.
        let up = [
            acceleration[0],
            acceleration[1],
            acceleration[2] + GRAVITY_MPS2,
        ];
        let (x, y) = (cy * up[0] + sy * up[1], -sy * up[0] + cy * up[1]);
        let force = [cp * x - sp * up[2], y, sp * x + cp * up[2]];
        let rate = [-dyaw * sp, dpitch, dyaw * cp];
        t_s.push(i as f64 / RATE_HZ);
        for k in 0..3 {
            let f: f64 = (0..3).map(|j| am[k][j] * force[j]).sum();
            let w: f64 = (0..3).map(|j| gm[k][j] * rate[j]).sum();
            accel[k].push(f + bias[k] + ACCEL_N * RATE_HZ.sqrt() * normal());
            gyro[k].push(w + GYRO_N * RATE_HZ.sqrt() * normal());
        }
    }
    let end = foot(1e6, strides);
    Ok((
        recording("walk", &t_s, &accel, &gyro)?,
        [end[0], end[1], end[2]],
    ))
}

/// Prints how often the band of a walk's end holds the truth.
pub fn print(seeds: u64) -> Result<(), AnyError> {
    let calibrated = (ACCEL_SD, GYRO_SD);
    let file = calibration(calibrated.0, Some(calibrated.1))?;
    println!(
        "| walk | within 1σ, % | within 1.96σ, % | beyond 4σ, % | not usable, % | error (RMS), m | median band (1σ), m |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, strides, sd) in [
        ("11 s, uncalibrated", 10, SHEET),
        ("60 s, uncalibrated", 54, SHEET),
        ("11 s, calibrated", 10, calibrated),
        ("60 s, calibrated", 54, calibrated),
    ] {
        let options = MotionOptions {
            clock_error: 0.0,
            ..MotionOptions::default()
        };
        let known = (sd == calibrated).then_some(Calibrated {
            file: &file,
            name: "truth",
        });
        let (mut held, mut all, mut unusable) = ([0_u32; 3], 0_u32, 0_u32);
        let (mut squares, mut bands) = (0.0, Vec::new());
        for seed in 1..=seeds {
            let (recording, truth) = walk(seed, strides, sd)?;
            let end = motion(&recording, known, &options)?.result.r#final;
            let (Some(p), Some(sigma)) = (end.position_m, end.sigma_m) else {
                unusable += 1;
                continue;
            };
            for i in 0..3 {
                let off = (p[i] - truth[i]).abs();
                for (held, k) in held.iter_mut().zip([1.0, 1.96, 4.0]) {
                    *held += u32::from(off <= k * sigma[i]);
                }
                all += 1;
                squares += off * off;
            }
            bands.push(sigma.iter().map(|s| s * s).sum::<f64>().sqrt());
        }
        bands.sort_by(f64::total_cmp);
        let share = |n: u32| 100.0 * f64::from(n) / f64::from(all.max(1));
        println!(
            "| {name} | {:.1} | {:.1} | {:.1} | {:.1} | {:.2} | {:.2} |",
            share(held[0]),
            share(held[1]),
            100.0 - share(held[2]),
            100.0 * f64::from(unusable) / seeds as f64,
            (3.0 * squares / f64::from(all.max(1))).sqrt(),
            bands.get(bands.len() / 2).copied().unwrap_or(f64::NAN),
        );
    }
    Ok(())
}
