//! Guided sessions of simulated sensors whose truth is known, by hands that follow what is asked
//! for, most of them clumsy.
//!
//! ```console
//! $ cargo run --release -p gravical --example live_sessions -- 1000
//! ```
//!
//! The number is that of sessions a line; a second number is the first seed.
// The exemption of tests in clippy.toml does not reach examples.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../../../../tests/support/each.rs"]
mod each;
#[allow(dead_code, reason = "the tests use more of it")]
mod hand;

use each::each;
use hand::{Clumsiness, Hand};

/// Median, 95 % and largest.
fn quantiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1) as f64;
    [0.5, 0.95, 1.0].map(|q| {
        let at = (q * last) as usize;
        values.get(at).copied().unwrap_or(f64::NAN)
    })
}

fn main() {
    let mut numbers = std::env::args().skip(1).map(|a| a.parse::<usize>());
    let count = numbers.next().and_then(Result::ok).unwrap_or(100);
    let first = numbers.next().and_then(Result::ok).unwrap_or(0);
    println!(
        "| hand | good | time to good, s (median, 95 %) | poses | bias within 95 % | error of ‖a‖ of good, mg rms (median, 95 %, worst) |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    for clumsiness in Clumsiness::ALL {
        let all = each(count, |index| {
            let ended = Hand::new((first + index) as u64, clumsiness).run();
            let file = ended.file.as_ref();
            let poses = file.map_or(0, |f| f.poses.len());
            let good = ended
                .is_good()
                .then(|| ended.good_s.zip(ended.norm_error_mg()));
            (poses, ended.covered(), good.flatten())
        });
        let poses: usize = all.iter().map(|(poses, ..)| poses).sum();
        let covered: Vec<bool> = all.iter().filter_map(|(_, c, _)| *c).flatten().collect();
        let within = covered.iter().filter(|c| **c).count() as f64 / covered.len().max(1) as f64;
        let good: Vec<(f64, [f64; 2])> = all.iter().filter_map(|(.., good)| *good).collect();
        let [time, late, _] = quantiles(good.iter().map(|(good_s, _)| *good_s).collect());
        let [usual, high, worst] = quantiles(good.iter().map(|(_, [rms, _])| *rms).collect());
        println!(
            "| {clumsiness:?} | {} | {time:.0}, {late:.0} | {:.1} | {:.1} % | {usual:.2}, {high:.2}, {worst:.2} |",
            good.len(),
            poses as f64 / count as f64,
            100.0 * within,
        );
    }
}
