//! What is no slow move, and moves of other shapes.

// One rest is a range in a list.
#![allow(clippy::single_range_in_vec_init)]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::*;
use crate::simulate::StaticOptions;

/// N of 3.3 mm/s/√s and 0.005 °/√s at 100 Hz, and `force` and `rate` along x and
/// about y.
fn with(seed: u64, seconds: f64, force: impl Fn(f64) -> f64, rate: impl Fn(f64) -> f64) -> Samples {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut out = Samples::default();
    let mut rates: [Vec<f64>; 3] = Default::default();
    for i in 0..(100.0 * seconds) as usize {
        let t = 0.01 * i as f64;
        for c in 0..3 {
            let noise: f64 = rng.sample(StandardNormal);
            out.force_mps2[c].push([force(t), 0.0, 9.81][c] + 0.033 * noise);
            let noise: f64 = rng.sample(StandardNormal);
            rates[c].push([0.0, rate(t), 0.0][c] + 8.7e-4 * noise);
        }
        out.t_s.push(t);
    }
    out.rate_rad_s = Some(rates);
    out
}

/// Acceleration that speeds up from 10 s on for `up` s, goes on, and brakes
/// likewise after `seconds`.
fn push(t: f64, seconds: f64, up: f64, size: f64) -> f64 {
    let at = t - 10.0;
    if (0.0..up).contains(&at) {
        size
    } else if (seconds - up..seconds).contains(&at) {
        -size
    } else {
        0.0
    }
}

#[test]
fn moves_of_other_shapes_are_one_too() {
    let mut whole = 0;
    for seed in 0..30 {
        // 0.7 m in 12 s: constant acceleration, then braking; and with a third of
        // the time at constant speed.
        for (up, size) in [(6.0, 0.7 / 36.0), (4.0, 0.7 / 32.0)] {
            let samples = with(seed, 32.0, |t| push(t, 12.0, up, size), |_| 0.0);
            let rests = found(&samples);
            let at = |sample: usize, s: f64| (samples.t_s[sample] - s).abs() < 1.5;
            whole += usize::from(
                rests.len() == 2 && at(rests[0].end - 1, 10.0) && at(rests[1].start, 22.0),
            );
        }
    }
    println!("{whole} of 60");
    assert!(whole >= 54, "{whole}");
}

/// Seconds that are no rest, and doubts.
fn disturbed(samples: &Samples) -> (f64, usize) {
    let rests = find_rests(samples, None);
    let rest: usize = rests.spans.iter().map(Range::len).sum();
    (0.01 * (samples.len() - rest) as f64, rests.doubts.len())
}

#[test]
fn what_drifts_does_not_move() {
    let (mut lost_s, mut doubts) = (0.0, 0);
    for seed in 0..20 {
        for samples in [
            // A bias that drifts, and one that bends.
            with(seed, 60.0, |t| 3e-4 * t, |_| 0.0),
            with(seed, 60.0, |t| 0.01 * (-t / 30.0).exp(), |_| 0.0),
            with(seed, 60.0, |_| 0.0, |_| 0.0),
        ] {
            let (s, n) = disturbed(&samples);
            lost_s += s;
            doubts += n;
        }
    }
    println!("{lost_s:.2} s of 3600 s, {doubts} doubts");
    assert!(lost_s == 0.0, "{lost_s}");
    assert!(doubts <= 2, "{doubts}");
}

/// By 3 mrad there and back, as the gyroscope sees it: its quick part is motion, but
/// there is no slow move in it.
#[test]
fn a_tilt_is_no_move() {
    let mut doubts = 0;
    for seed in 0..20 {
        let samples = with(
            seed,
            60.0,
            |t| -9.81 * 1.5e-3 * (1.0 - (t * 0.25).cos()),
            |t| 1.5e-3 * 0.25 * (t * 0.25).sin(),
        );
        let rests = found(&samples);
        let longest = rests.windows(2).map(|w| w[1].start - w[0].end).max();
        assert!(longest.unwrap_or(0) < 600, "{seed}: {rests:?}");
        doubts += disturbed(&samples).1;
    }
    assert!(doubts <= 1, "{doubts}");
}

#[test]
fn a_step_of_the_force_is_no_move() {
    let mut parts = 0;
    for seed in 0..20 {
        let samples = with(seed, 40.0, |t| if t < 20.0 { 0.0 } else { 0.015 }, |_| 0.0);
        parts += usize::from(disturbed(&samples).0 > 3.0);
    }
    assert_eq!(parts, 0);
}

#[test]
fn a_part_that_warms_up_rests() {
    let (mut lost_s, mut doubts, mut all_s) = (0.0, 0, 0.0);
    for seed in 0..10 {
        let mut options = SimulateOptions::new(Scenario::Static(StaticOptions {
            duration_s: 300.0,
            soak: None,
        }));
        options.seed = seed;
        let (s, n) = disturbed(&samples_of(&simulate(&options).unwrap()));
        (lost_s, doubts, all_s) = (lost_s + s, doubts + n, all_s + 300.0);
    }
    println!("{lost_s:.2} s of {all_s} s, {doubts} doubts");
    assert!(lost_s == 0.0 && doubts <= 1);
}
