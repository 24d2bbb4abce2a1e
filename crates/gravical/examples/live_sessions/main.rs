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

#[path = "../accuracy/each.rs"]
mod each;
#[allow(dead_code, reason = "the tests use more of it")]
mod hand;

use gravical::live::event::Event;

use each::each;
use hand::{Clumsiness, Hand};

fn main() {
    let mut numbers = std::env::args().skip(1).map(|a| a.parse::<usize>());
    let count = numbers.next().and_then(Result::ok).unwrap_or(100);
    let first = numbers.next().and_then(Result::ok).unwrap_or(0);
    println!(
        "| hand | ended with a result | good | time to good, s (median, 95 %) | poses | rejected | bias within 95 % | ‖a‖ rms, mg (median, 95 %, worst of good) | good above 2.5 mg | above 5 mg |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for clumsiness in Clumsiness::ALL {
        let ended = each(count, |index| {
            let ended = Hand::new((first + index) as u64, clumsiness).run();
            let poses = ended
                .file
                .as_ref()
                .map_or(0, |f| f.accelerometer.poses.len());
            let rejected = ended.count(|e| matches!(e, Event::PoseRejected { .. }));
            let error = ended.norm_error_mg().map(|[rms, _]| rms);
            (
                ended.is_good(),
                ended.good_s,
                poses,
                rejected,
                ended.covered(),
                error,
            )
        });
        let quantiles = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            let at = |q: f64| {
                let last = values.len().saturating_sub(1) as f64;
                values.get((q * last) as usize).copied().unwrap_or(f64::NAN)
            };
            [at(0.5), at(0.95), at(1.0)]
        };
        let [time, late, _] = quantiles(ended.iter().filter_map(|e| e.1).collect());
        let good = || ended.iter().filter(|e| e.0);
        let errors: Vec<f64> = good().filter_map(|e| e.5).collect();
        let above = |mg: f64| errors.iter().filter(|e| **e > mg).count();
        let [usual, high, worst] = quantiles(errors.clone());
        let covered: Vec<bool> = ended.iter().filter_map(|e| e.4).flatten().collect();
        let mean = |of: &dyn Fn(
            &(
                bool,
                Option<f64>,
                usize,
                usize,
                Option<[bool; 3]>,
                Option<f64>,
            ),
        ) -> usize| {
            ended.iter().map(|e| of(e) as f64).sum::<f64>() / count as f64
        };
        println!(
            "| {clumsiness:?} | {} | {} | {time:.0}, {late:.0} | {:.1} | {:.1} | {:.1} % | {usual:.2}, {high:.2}, {worst:.2} | {} | {} |",
            ended.iter().filter(|e| e.5.is_some()).count(),
            good().count(),
            mean(&|e| e.2),
            mean(&|e| e.3),
            100.0 * covered.iter().filter(|c| **c).count() as f64 / covered.len().max(1) as f64,
            above(2.5),
            above(5.0),
        );
    }
}
