//! How accurate the noise parameters are, by experiment:
//!
//!     cargo run --release -p gravical --example noise_accuracy -- [RECORDINGS]
//!
//! It prints the tables of docs/accuracy-noise.md.

use gravical::noise::{ChannelNoise, Term, noise_of_samples};

#[path = "../../../../tests/support/noise.rs"]
mod noise;
use noise::samples;

const PERIOD_S: f64 = 0.01;
const TERMS: [Term; 3] = [Term::N, Term::B, Term::K];

/// Simulated sensors: hours of recording, and N, B, K in SI units.
const CASES: [(&str, f64, [f64; 3]); 4] = [
    ("3 h, N 3.3e-3, B 8e-4, K 6e-5", 3.0, [3.3e-3, 8e-4, 6e-5]),
    ("1 h, the same", 1.0, [3.3e-3, 8e-4, 6e-5]),
    ("1 h, white noise only", 1.0, [3.3e-3, 0.0, 0.0]),
    (
        "10 min, N 3.3e-3, B 8e-4, K 6e-5",
        1.0 / 6.0,
        [3.3e-3, 8e-4, 6e-5],
    ),
];

fn main() {
    let mut args = std::env::args().skip(1);
    let recordings: u64 = args.find_map(|a| a.parse().ok()).unwrap_or(200);
    println!("{recordings} recordings each");
    println!(
        "| recording | term | known | rms error, % | mean error, % | 95 % intervals hold | upper limits hold |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, hours, truth) in CASES {
        let run = |seed| run(hours, truth, seed);
        let results: Vec<ChannelNoise> = (0..recordings).map(run).collect();
        let has_drift = |r: &&ChannelNoise| r.fit.is_some_and(|fit| fit.drift_per_s.is_some());
        let drifting = results.iter().filter(has_drift).count();
        println!("| {name} | drift | {drifting} | | | | |");
        for (term, truth) in TERMS.into_iter().zip(truth) {
            print_row(name, &results, term, truth);
        }
    }
}

fn run(hours: f64, truth: [f64; 3], seed: u64) -> ChannelNoise {
    let count = (hours * 3600.0 / PERIOD_S) as usize;
    let samples = samples(count, PERIOD_S, truth, seed);
    noise_of_samples("ax", &samples, PERIOD_S)
}

fn print_row(case: &str, results: &[ChannelNoise], term: Term, truth: f64) {
    let known: Vec<_> = results.iter().filter_map(|r| r.estimate(term)).collect();
    let share = known.len() as f64 / results.len() as f64;
    let name = format!("| {case} | {} | {:.0} % |", term.symbol(), 100.0 * share);
    let limits: Vec<f64> = results
        .iter()
        .filter_map(|r| r.missing(term)?.at_most)
        .collect();
    let limits = held(&limits, |limit| truth <= *limit);
    if truth == 0.0 || known.is_empty() {
        println!("{name} – | – | – | {limits} |");
        return;
    }
    let count = known.len() as f64;
    let error = |value: f64| value / truth - 1.0;
    let rms = (known.iter().map(|e| error(e.value).powi(2)).sum::<f64>() / count).sqrt();
    let mean = known.iter().map(|e| error(e.value)).sum::<f64>() / count;
    println!(
        "{name} {:.2} | {:+.2} | {} | {limits} |",
        100.0 * rms,
        100.0 * mean,
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
