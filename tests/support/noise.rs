//! Samples of known noise.

use std::f64::consts::PI;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

/// White noise N, flicker noise B as a sum of processes that forget exponentially (Ornstein–Uhlenbeck), two in a
/// decade of time constants, and a random walk K: samples `period_s` apart.
pub fn samples(count: usize, period_s: f64, [n, b, k]: [f64; 3], seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let ratio = 10_f64.sqrt();
    let each = b * (ratio.ln() / PI).sqrt();
    let mut processes = Vec::new();
    let mut constant_s = period_s;
    while b > 0.0 && constant_s < 30.0 * count as f64 * period_s {
        processes.push((each * normal(), (-period_s / constant_s).exp()));
        constant_s *= ratio;
    }
    let mut walk = 0.0;
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        let mut value = n / period_s.sqrt() * normal() + walk;
        walk += k * period_s.sqrt() * normal();
        for (state, keep) in &mut processes {
            value += *state;
            *state = *keep * *state + each * (1.0 - *keep * *keep).sqrt() * normal();
        }
        out.push(value);
    }
    out
}
