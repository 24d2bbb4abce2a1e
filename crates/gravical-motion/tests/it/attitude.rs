//! Attitude in moves of minutes: they are levelled on the way, and vehicles do not tilt them.

use std::f64::consts::{FRAC_PI_4, TAU};

use gravical_motion::{Samples, estimate_motion};
use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};

use crate::simulated::{G, RATE_SD, drawn};
use crate::stories::noisy;
use crate::study::options_with;

type V3 = Vector3<f64>;

/// Duration of the rests, s.
const REST_S: f64 = 5.0;
/// Bias instability of an MPU-6050: 10 °/h.
const INSTABILITY_RAD_S: f64 = 5e-5;

/// Position, m, and rotation vector, rad, at a time of a move, by its duration, s.
type Pose = fn(f64, f64) -> [V3; 2];
/// Name, pose, duration of the move, s, number of rests around it, standard deviation of a step of
/// the gyroscope's biases in its middle, rad/s, and the limit of the rms of the tilt over that by the gyroscope alone.
type Story = (&'static str, Pose, f64, usize, f64, f64);

/// Moves by 0.2 m and turns by 30°, not twice alike.
fn hand(t: f64, move_s: f64) -> [V3; 2] {
    let wave = |hz: f64| (TAU * hz * t).sin();
    let edge = (FRAC_PI_4 * t.min(move_s - t).clamp(0.0, 2.0))
        .sin()
        .powi(2);
    let position = V3::new(0.2 * wave(0.5), 0.2 * wave(0.31), 0.1 * wave(0.77));
    let turn = V3::new(0.6 * wave(0.6), 0.5 * wave(0.37), 0.8 * wave(0.23));
    [position * edge, turn * edge]
}

/// Reaches a speed, m/s, with an acceleration, m/s², keeps it and brakes as much, while it rocks by 1°.
fn ride(t: f64, move_s: f64, speed: f64, acceleration: f64) -> [V3; 2] {
    let (t, brakes_s) = (t.clamp(0.0, move_s), move_s - speed / acceleration);
    let square_after = |from: f64| (t - from).max(0.0).powi(2);
    let squares = t * t - square_after(move_s - brakes_s) - square_after(brakes_s);
    let rocking = 0.02 * (TAU * 0.7 * t).sin() * t.min(move_s - t).min(1.0);
    [
        V3::x() * (0.5 * acceleration * squares),
        V3::new(rocking, 0.5 * rocking, 0.0),
    ]
}

/// As a gyroscope with that bias, and with errors of its scale as they are assumed, measures it.
fn record((_, pose, move_s, _, step, _): Story, seed: u64) -> Samples {
    const H: f64 = 1e-3;
    let mut draw = drawn(seed, 0);
    let [bias, scale, phase, step] = [0.01, RATE_SD[0], TAU, step].map(|sd| draw.vector(sd));
    noisy(seed, move_s + 2.0 * REST_S, |t| {
        let t = t - REST_S;
        let [before, now, after] = [t - H, t, t + H].map(|t| pose(t, move_s));
        let [from, attitude, to] = [before, now, after].map(|pose| Rotation3::new(pose[1]));
        let acceleration = (before[0] - now[0] * 2.0 + after[0]) / (H * H);
        let force = attitude.inverse() * (acceleration + V3::z() * G);
        let rate = (from.inverse() * to).scaled_axis() / (2.0 * H);
        let wave = phase.map(|p| INSTABILITY_RAD_S * (TAU * t / 200.0 + p).sin());
        let bias = bias + wave + step * f64::from(t > 0.5 * move_s);
        let rate = rate + rate.component_mul(&scale) + bias;
        [force.into(), rate.into()]
    })
}

sampled! {
    tilt_holds_for_minutes(6, 1);
}

/// One in `step` of twelve recordings of each.
fn tilt_holds_for_minutes(step: usize) {
    let train: Pose = |t, move_s| ride(t, move_s, 30.0, 0.5);
    let car: Pose = |t, move_s| ride(t, move_s, 25.0, 4.0);
    for story in [
        ("hand", hand as Pose, 120.0, 2, 0.0, 0.6),
        ("hand until the end", hand, 120.0, 1, 0.0, 0.7),
        ("hand, bias step", hand, 60.0, 2, 1e-3, 0.6),
        ("train", train, 300.0, 2, 0.0, 0.5),
        ("car", car, 60.0, 2, 0.0, 0.5),
        // A larger one takes the heading, which nothing measures, out of its band: of 3e-4 rad/s 0.62 hold.
        ("car, bias step", car, 60.0, 2, 1e-4, 0.5),
    ] {
        let (name, pose, move_s, rests, _, limit) = story;
        let (mut squares, mut inside, mut count) = ([0.0; 2], [0.0; 6], 0.0);
        for samples in (0..12).step_by(step).map(|seed| record(story, seed)) {
            let rest = samples.count_in(REST_S);
            let ends = [0..rest, samples.len() - rest..samples.len()][..rests].to_vec();
            let motion = estimate_motion(&samples, &options_with(|o| o.rests = Some(ends)));
            let bias = V3::from_column_slice(&samples.mean(&(0..rest))[3..]);
            let (mut bare, mut at) = (Rotation3::identity(), rest);
            for node in motion.path.iter().filter(|n| n.sample > rest) {
                for rate in &samples.rate_rad_s[at..node.sample] {
                    bare *= Rotation3::new((V3::from(*rate) - bias) * samples.period_s);
                }
                at = node.sample;
                let [position, turn] = pose(samples.time_s[at] - REST_S, move_s);
                let [w, x, y, z] = node.attitude;
                let found = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)).into();
                let error = |r: Rotation3<f64>| (Rotation3::new(turn) * r.inverse()).scaled_axis();
                squares[0] += error(found).xy().norm_squared();
                squares[1] += error(bare).xy().norm_squared();
                let (turned, moved) = (error(found), position - V3::from(node.position_m));
                for c in 0..3 {
                    inside[c] += f64::from(turned[c].abs() < 2.0 * node.attitude_sd_rad[c]);
                    inside[3 + c] += f64::from(moved[c].abs() < 2.0 * node.position_sd_m[c]);
                }
                count += 1.0;
            }
        }
        let shares = inside.map(|n| n / count);
        let [tilt_deg, bare_deg] = squares.map(|s: f64| (s / count).sqrt().to_degrees());
        println!("{name}: {tilt_deg:.2}° ({bare_deg:.2}°), {shares:.3?}");
        let holds = shares.iter().all(|share| *share > 0.9) && tilt_deg < limit * bare_deg;
        assert!(holds, "{name}");
    }
}
