//! How accurate the noise parameters are, by experiment:
//!
//!     cargo run --release -p gravical --example noise_accuracy -- [RECORDINGS [KIND]]
//!
//! It prints the table that docs/accuracy-noise.md sums up.

use std::f64::consts::PI;

use gravical::noise::{ChannelNoise, Term, noise_of_samples};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

#[path = "../../../../tests/support/noise.rs"]
mod noise;
use noise::samples;

const PERIOD_S: f64 = 0.01;
/// No test uses seeds from here on.
const FIRST_SEED: u64 = 500_000;
const N: f64 = 3.3e-3;
const WHITE: [f64; 3] = [N, 0.0, 0.0];
const FLICKER: [f64; 3] = [N, 8e-4, 0.0];
const WALK: [f64; 3] = [N, 8e-4, 6e-5];

/// What is done to the noise of the sensor.
#[derive(Clone, Copy)]
enum Change {
    None,
    /// Rounded to steps of so many standard deviations
    Step(f64),
    /// A low-pass of one or two poles, −3 dB at this share of half the rate
    OnePole(f64),
    TwoPoles(f64),
    /// Warms up by 0.01 to 0.1 m/s² with a time constant of 2 to 60 min
    Exponential,
    /// Drifts by 0.01 to 0.1 m/s² per hour
    Linear,
}

use Change::*;

/// Simulated recordings: hours, N, B and K in SI units, change.
const KINDS: [(&str, f64, [f64; 3], Change); 22] = [
    ("3 h", 3.0, WALK, None),
    ("1 h", 1.0, WALK, None),
    ("10 min", 1.0 / 6.0, WALK, None),
    ("1 h, white noise", 1.0, WHITE, None),
    ("– step of 0.5 σ", 1.0, WHITE, Step(0.5)),
    ("– step of 1 σ", 1.0, WHITE, Step(1.0)),
    ("– step of 1.6 σ", 1.0, WHITE, Step(1.6)),
    ("– step of 2.2 σ", 1.0, WHITE, Step(2.2)),
    ("– step of 3 σ", 1.0, WHITE, Step(3.0)),
    ("1 h, no K", 1.0, FLICKER, None),
    ("– one pole at 0.44", 1.0, FLICKER, OnePole(0.44)),
    ("– one pole at 0.2", 1.0, FLICKER, OnePole(0.2)),
    ("– one pole at 0.1", 1.0, FLICKER, OnePole(0.1)),
    ("– two poles at 0.44", 1.0, FLICKER, TwoPoles(0.44)),
    ("– two poles at 0.2", 1.0, FLICKER, TwoPoles(0.2)),
    ("– one pole at 0.8", 1.0, FLICKER, OnePole(0.8)),
    ("– two poles at 0.9", 1.0, FLICKER, TwoPoles(0.9)),
    ("– two poles at 0.1", 1.0, FLICKER, TwoPoles(0.1)),
    ("– exponential warm-up", 1.0, FLICKER, Exponential),
    ("– linear warm-up", 1.0, FLICKER, Linear),
    ("3 h, exponential warm-up", 3.0, WALK, Exponential),
    ("3 h, linear warm-up", 3.0, WALK, Linear),
];

fn main() {
    let mut args = std::env::args().skip(1);
    let recordings: u64 = args.next().and_then(|a| a.parse().ok()).unwrap_or(200);
    let wanted = args.next().unwrap_or_default();
    println!(
        "| recording | trend | term | known | rms error, % | mean error, % | 95 % intervals hold | upper limits hold |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (i, (name, hours, truth, change)) in KINDS.into_iter().enumerate() {
        if !name.contains(&wanted) {
            continue;
        }
        let first = FIRST_SEED + 10_000 * i as u64;
        let half = recordings / 2;
        let run = |seeds: std::ops::Range<u64>| -> Vec<ChannelNoise> {
            seeds
                .map(|seed| run(hours, truth, change, first + seed))
                .collect()
        };
        let results = std::thread::scope(|scope| {
            let other = scope.spawn(|| run(half..recordings));
            let mut results = run(0..half);
            results.extend(other.join().into_iter().flatten());
            results
        });
        let has_drift = |r: &&ChannelNoise| r.fit.is_some_and(|fit| fit.drift.is_some());
        let drifting = results.iter().filter(has_drift).count() as f64 / recordings as f64;
        let mut name = format!("{name} | {:.0} %", 100.0 * drifting);
        for (term, truth) in Term::ALL.into_iter().zip(truth) {
            print_row(&name, &results, term, truth);
            name = " | ".to_owned();
        }
    }
}

fn run(hours: f64, truth: [f64; 3], change: Change, seed: u64) -> ChannelNoise {
    let count = (hours * 3600.0 / PERIOD_S) as usize;
    let mut samples = samples(count, PERIOD_S, truth, seed);
    let mut rng = ChaCha8Rng::seed_from_u64(seed + 1_000_000);
    let mut between = |low: f64, high: f64| low * (high / low).powf(rng.random::<f64>());
    let mut resolution = 0.0;
    let t_s = |k: usize| k as f64 * PERIOD_S;
    match change {
        None => {}
        Step(sigmas) => {
            resolution = sigmas * N / PERIOD_S.sqrt();
            let level = resolution * between(1.0, 2.0);
            samples
                .iter_mut()
                .for_each(|x| *x = ((*x + level) / resolution).round() * resolution);
        }
        OnePole(share) => one_pole(&mut samples, share),
        TwoPoles(share) => two_poles(&mut samples, share),
        Exponential => {
            let (size, constant_s) = (between(0.01, 0.1), between(120.0, 3600.0));
            let all = samples.iter_mut().enumerate();
            all.for_each(|(k, x)| *x += size * (-t_s(k) / constant_s).exp());
        }
        Linear => {
            let per_s = between(0.01, 0.1) / 3600.0;
            samples
                .iter_mut()
                .enumerate()
                .for_each(|(k, x)| *x += per_s * t_s(k));
        }
    }
    noise_of_samples("ax", &samples, PERIOD_S, resolution)
}

fn one_pole(samples: &mut [f64], share: f64) {
    let cos = (PI * share).cos();
    let keep = 2.0 - cos - ((2.0 - cos).powi(2) - 1.0).sqrt();
    let mut state = 0.0;
    for x in samples {
        state = keep * state + (1.0 - keep) * *x;
        *x = state;
    }
}

/// Butterworth.
fn two_poles(samples: &mut [f64], share: f64) {
    let k = (0.5 * PI * share).tan();
    let norm = 1.0 / (1.0 + 2_f64.sqrt() * k + k * k);
    let b = k * k * norm;
    let [a1, a2] = [
        2.0 * (k * k - 1.0) * norm,
        (1.0 - 2_f64.sqrt() * k + k * k) * norm,
    ];
    let [mut z1, mut z2] = [0.0; 2];
    for x in samples {
        let y = b * *x + z1;
        z1 = 2.0 * b * *x - a1 * y + z2;
        z2 = b * *x - a2 * y;
        *x = y;
    }
}

fn print_row(kind: &str, results: &[ChannelNoise], term: Term, truth: f64) {
    let known: Vec<_> = results.iter().filter_map(|r| r.estimate(term)).collect();
    let share = known.len() as f64 / results.len() as f64;
    let name = format!("| {kind} | {} | {:.1} % |", term.symbol(), 100.0 * share);
    let limits = results
        .iter()
        .filter_map(|r| r.missing(term)?.limit.at_most);
    let limits = held(&limits.collect::<Vec<f64>>(), |limit| truth <= *limit);
    if truth == 0.0 || known.is_empty() {
        println!("{name} – | – | – | {limits} |");
        return;
    }
    let mean = |of: &dyn Fn(f64) -> f64| {
        let errors = known.iter().map(|e| of(e.value / truth - 1.0));
        errors.sum::<f64>() / known.len() as f64
    };
    println!(
        "{name} {:.2} | {:+.2} | {} | {limits} |",
        100.0 * mean(&|e| e * e).sqrt(),
        100.0 * mean(&|e| e),
        held(&known, |e| e.low <= truth && truth <= e.high)
    );
}

/// The share for which it holds.
fn held<T>(all: &[T], holds: impl Fn(&T) -> bool) -> String {
    match all.len() {
        0 => "–".to_owned(),
        n => {
            let held = all.iter().filter(|one| holds(one)).count();
            format!("{:.1} %", 100.0 * held as f64 / n as f64)
        }
    }
}
