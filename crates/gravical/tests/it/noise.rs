//! N, B and K of samples of known noise.

use gravical::noise::{Term, noise_of_samples};

#[path = "../../../../tests/support/noise.rs"]
mod known;

/// N, B and K are found within their intervals.
#[test]
fn known_noise_is_found() {
    // At 100 Hz the fastest of the processes of B add less than 0.1 % to N.
    let truth = [3.3e-3, 8e-4, 6e-5];
    let mut inside = [0; 3];
    for seed in 0..4 {
        let samples = known::samples(1_080_000, 0.01, truth, seed);
        let channel = noise_of_samples("ax", &samples, 0.01, 0.0);
        for (i, term) in [Term::N, Term::B, Term::K].into_iter().enumerate() {
            if let Some(e) = channel.estimate(term) {
                inside[i] += usize::from(e.low < truth[i] && truth[i] < e.high);
            }
        }
    }
    // One interval of twenty misses the truth.
    assert!(inside.iter().all(|n| *n >= 3), "{inside:?}");
}
