//! The same session gives the same result, however it was written.
//!
//! Every writing of `tests/support/writings` is held against the plainest one of the same
//! session: where the sensor lay still, the calibration, the verdict, the moves. Where a
//! writing has lost something, an error or a finding has to name the option that brings
//! it back, and with that option the result has to be the same.
//!
//! `GRAVICAL_WRITINGS=2000 cargo test --test it writings::drawn` tries that many at random.

#[path = "../../../../tests/support/writings/mod.rs"]
mod form;
mod judge;

use std::panic::{AssertUnwindSafe, catch_unwind};

use form::Writing;
use form::cover::pairs;
use judge::Judge;

use crate::support::Noise;

/// Writings of which any is not as it should be, with the reasons.
fn wrong(writings: &[Writing]) -> Vec<String> {
    let mut judge = Judge::default();
    let mut out = Vec::new();
    for writing in writings {
        let judged = catch_unwind(AssertUnwindSafe(|| judge.judge(writing)));
        match judged {
            Ok(judged) => out.extend(judged.wrong(&format!("{writing:?}"))),
            Err(_) => out.push(format!("{writing:?}\n  panicked")),
        }
    }
    out
}

fn report(wrong: &[String], of: usize) {
    assert!(
        wrong.is_empty(),
        "{} of {of} writings:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

#[test]
fn every_two_choices_about_a_writing_meet_and_change_nothing() {
    let mut noise = Noise::new(1);
    let chosen = pairs(30, |n| (noise.uniform() * n as f64) as usize);
    report(&wrong(&chosen), chosen.len());
}

/// As many as `GRAVICAL_WRITINGS` says, from the seed `GRAVICAL_WRITINGS_SEED`.
#[test]
fn drawn_at_random() {
    let number =
        |name: &str, default: u64| std::env::var(name).map_or(default, |v| v.parse().unwrap());
    let count = number("GRAVICAL_WRITINGS", 10);
    let mut noise = Noise::new(number("GRAVICAL_WRITINGS_SEED", 7));
    let drawn: Vec<Writing> = (0..count)
        .map(|_| Writing::random(|n| (noise.uniform() * n as f64) as usize))
        .collect();
    report(&wrong(&drawn), drawn.len());
}
