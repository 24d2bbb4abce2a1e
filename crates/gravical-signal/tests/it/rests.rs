//! Rests: found, to the sample, and nothing else.

use std::ops::Range;

use gravical_signal::{RestTolerance, Samples, detect_rests};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Six channels at 100 Hz.
struct Recording {
    time_s: Vec<f64>,
    force: Vec<[f64; 3]>,
    rate: Vec<[f64; 3]>,
    step: f64,
}

impl Recording {
    /// Noise of `sd` (m/s²; a thirtieth of it in rad/s) around `force` and `rate` of a time.
    fn new(
        seed: u64,
        seconds: f64,
        sd: f64,
        force: impl Fn(f64) -> [f64; 3],
        rate: impl Fn(f64) -> [f64; 3],
    ) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut noise = |sd: f64| -> f64 { sd * rng.sample::<f64, _>(StandardNormal) };
        let time_s: Vec<f64> = (0..(seconds * 100.0) as usize)
            .map(|i| i as f64 * 0.01)
            .collect();
        let force = time_s.iter().map(|t| force(*t).map(|v| v + noise(sd)));
        let force = force.collect();
        let rate = time_s
            .iter()
            .map(|t| rate(*t).map(|v| v + noise(sd / 30.0)));
        Recording {
            force,
            rate: rate.collect(),
            time_s,
            step: 0.0,
        }
    }

    /// Written in steps.
    fn rounded(mut self, step: f64) -> Self {
        for v in self.force.iter_mut().flatten() {
            *v = (*v / step).round() * step;
        }
        self.step = step;
        self
    }

    fn rests(&self) -> Vec<Range<usize>> {
        let row = |i: usize| (self.time_s[i], self.force[i], self.rate.get(i).copied());
        let rows = (0..self.time_s.len()).map(row);
        let resolution = [self.step, self.step, self.step, 0.0, 0.0, 0.0];
        detect_rests(
            &Samples::new(rows, Vec::new(), resolution),
            RestTolerance::CONSTANT,
        )
    }
}

/// Noise of 0.03 m/s² and no rate.
fn at_rest(seed: u64, seconds: f64, force: impl Fn(f64) -> [f64; 3]) -> Recording {
    Recording::new(seed, seconds, 0.03, force, |_| [0.0; 3])
}

/// Poses of 3 s with turns of 1 s between.
fn poses(seed: u64, sd: f64) -> Recording {
    let angle = |t: f64| (t / 4.0).floor() + (t % 4.0 - 3.0).max(0.0);
    let force = move |t: f64| [0.0, 9.81 * angle(t).sin(), 9.81 * angle(t).cos()];
    Recording::new(seed, 39.0, sd, force, move |t| {
        [if t % 4.0 > 3.0 { 1.0 } else { 0.0 }, 0.0, 0.0]
    })
}

#[test]
fn poses_are_found_to_the_sample() {
    for seed in 0..20 {
        let rests = poses(seed, 0.03).rests();
        assert_eq!(rests.len(), 10, "{seed} {rests:?}");
        for (k, rest) in rests.iter().enumerate() {
            let (start, end) = (400 * k, 400 * k + 300);
            // Inside the rest: a ramp fitted to a jump of the rate begins before it.
            let is_inside = (start..start + 15).contains(&rest.start)
                && (end - 15..=end + 1).contains(&rest.end);
            assert!(is_inside, "{seed} {rest:?}");
        }
    }
}

#[test]
fn rests_are_counted_whatever_the_noise_the_resolution_and_the_channels() {
    let mut accelerometer = poses(3, 0.03);
    accelerometer.rate.clear();
    let warming = at_rest(1, 30.0, |t| [0.0, 3e-4 * t, 9.8]);
    // 0.07 g rms of a walk with a phone; 5 °/s of a hand.
    let up = |_| [0.0, 0.0, 9.8];
    let walk = Recording::new(1, 20.0, 0.7, up, |_| [0.0; 3]);
    let hand = Recording::new(1, 20.0, 0.01, up, |t| [0.12 * (9.0 * t).sin(), 0.0, 0.0]);
    for (name, recording, count) in [
        ("1 mm/s²", poses(1, 0.001), 10),
        ("10 mm/s²", poses(1, 0.01), 10),
        ("100 mm/s²", poses(1, 0.1), 10),
        ("200 mm/s²", poses(1, 0.2), 10),
        ("steps of 4 σ", poses(2, 0.01).rounded(0.04), 10),
        ("steps of 15 σ", poses(2, 0.01).rounded(0.15), 10),
        ("three channels", accelerometer, 10),
        ("a warming sensor", warming, 1),
        ("four times the longest segment", at_rest(1, 240.0, up), 1),
        ("a walk", walk, 0),
        ("a hand", hand, 0),
    ] {
        let rests = recording.rests();
        assert_eq!(rests.len(), count, "{name}: {rests:?}");
    }
}

#[test]
fn false_rests_and_splits_are_rare() {
    let rests = |seed| at_rest(seed, 60.0, |_| [0.0, 0.0, 9.8]).rests();
    let split = (0..40).filter(|seed| rests(*seed).len() != 1);
    assert!(split.count() <= 1);
}

#[test]
fn a_slow_turn_is_no_rest() {
    let turn = |t: f64| [0.0, 9.8 * (0.05 * t).sin(), 9.8 * (0.05 * t).cos()];
    let rests = Recording::new(1, 20.0, 0.03, turn, |_| [0.05, 0.0, 0.0]).rests();
    let longest = rests.iter().map(|r| r.len()).max().unwrap_or(0);
    assert!(longest < 150, "{rests:?}");
}

#[test]
fn no_rest_reaches_across_a_gap() {
    let mut recording = at_rest(1, 20.0, |_| [0.0, 0.0, 9.8]);
    recording.time_s[1000..].iter_mut().for_each(|t| *t += 1.0);
    assert_eq!(recording.rests(), [0..1000, 1000..2000]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn whatever_comes_is_answered_in_order(
        numbers in prop::collection::vec(prop_oneof![-20.0..20.0_f64, Just(0.0), Just(f64::NAN), Just(f64::MAX)], 0..300),
        still in 0_usize..300,
        gyro in any::<bool>(),
        step in prop_oneof![Just(0.01), Just(0.0), Just(-1.0), Just(0.3), Just(f64::NAN)],
    ) {
        let mut force: Vec<[f64; 3]> = numbers.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        force.extend((0..still).map(|_| [0.0, 0.0, 9.8]));
        let recording = Recording {
            time_s: (0..force.len()).map(|i| i as f64 * step).collect(),
            rate: if gyro { force.clone() } else { Vec::new() },
            force,
            step: 0.0,
        };
        let rests = recording.rests();
        prop_assert!(rests.iter().all(|r| r.start < r.end && r.end <= recording.force.len()));
        prop_assert!(rests.windows(2).all(|w| w[0].end <= w[1].start));
    }
}
