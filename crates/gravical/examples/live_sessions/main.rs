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

use gravical::live::event::Event;

use each::each;
use hand::{Clumsiness, Hand};

/// What is counted of a session.
struct Counted {
    good: bool,
    good_s: Option<f64>,
    poses: usize,
    rejected: usize,
    covered: Option<[bool; 3]>,
    /// Error of ‖a‖, rms of all directions, mg; none without a result.
    rms_mg: Option<f64>,
}

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
        "| hand | ended with a result | good | time to good, s (median, 95 %) | poses | rejected | bias within 95 % | ‖a‖ rms of good, mg (median, 95 %, worst) | good above 2.5 mg | above 5 mg |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for clumsiness in Clumsiness::ALL {
        let all = each(count, |index| {
            let ended = Hand::new((first + index) as u64, clumsiness).run();
            let file = ended.file.as_ref();
            Counted {
                good: ended.is_good(),
                good_s: ended.good_s,
                poses: file.map_or(0, |f| f.accelerometer.poses.len()),
                rejected: ended.count(|e| matches!(e, Event::PoseRejected { .. })),
                covered: ended.covered(),
                rms_mg: ended.norm_error_mg().map(|[rms, _]| rms),
            }
        });
        let good: Vec<&Counted> = all.iter().filter(|c| c.good).collect();
        let errors: Vec<f64> = good.iter().filter_map(|c| c.rms_mg).collect();
        let above = |mg: f64| errors.iter().filter(|e| **e > mg).count();
        let covered: Vec<bool> = all.iter().filter_map(|c| c.covered).flatten().collect();
        let within = covered.iter().filter(|c| **c).count() as f64 / covered.len().max(1) as f64;
        let mean = |of: fn(&Counted) -> usize| {
            all.iter().map(|c| of(c) as f64).sum::<f64>() / count as f64
        };
        let [time, late, _] = quantiles(good.iter().filter_map(|c| c.good_s).collect());
        let [usual, high, worst] = quantiles(errors.clone());
        println!(
            "| {clumsiness:?} | {} | {} | {time:.0}, {late:.0} | {:.1} | {:.1} | {:.1} % | {usual:.2}, {high:.2}, {worst:.2} | {} | {} |",
            all.iter().filter(|c| c.rms_mg.is_some()).count(),
            good.len(),
            mean(|c| c.poses),
            mean(|c| c.rejected),
            100.0 * within,
            above(2.5),
            above(5.0),
        );
    }
}
