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

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};

use form::Writing;
use judge::Judge;

use crate::support::Noise;

/// As many as `GRAVICAL_WRITINGS` says, from the seed `GRAVICAL_WRITINGS_SEED`: in 2000 every two
/// choices that can be made of one writing meet: of a few draws the one with most new pairs is taken.
#[test]
fn drawn_at_random() {
    let number =
        |name: &str, default: u64| std::env::var(name).map_or(default, |v| v.parse().unwrap());
    let count = number("GRAVICAL_WRITINGS", 20);
    let mut noise = Noise::new(number("GRAVICAL_WRITINGS_SEED", 7));
    let mut judge = Judge::default();
    let (mut wrong, mut met) = (Vec::new(), HashSet::new());
    for _ in 0..count {
        let draws = (0..4).map(|_| Writing::random(|n| (noise.uniform() * n as f64) as usize));
        let is_new = |pair: &[(usize, usize); 2]| !met.contains(pair);
        let new_pairs = |writing: &Writing| writing.pairs().into_iter().filter(is_new).count();
        let writing = draws.max_by_key(new_pairs).unwrap();
        met.extend(writing.pairs());
        match catch_unwind(AssertUnwindSafe(|| judge.judge(&writing))) {
            Ok(judged) => wrong.extend(judged),
            Err(_) => wrong.push(format!("{writing:?}\n  panicked")),
        }
    }
    let (number, wrong) = (wrong.len(), wrong.join("\n"));
    assert!(number == 0, "{number} of {count} writings:\n{wrong}");
}
