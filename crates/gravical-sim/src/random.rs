//! Seeded random streams, one per purpose, so that changing one option does not change the other
//! random values.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Purpose of a stream; the number determines the values of a seed and must not change.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    Parameters = 1,
    Tilts = 2,
    Hands = 3,
    FreePoses = 4,
    Noise = 5,
    Stamps = 6,
    Drops = 7,
}

/// The stream of `purpose` for the file with this index (0 for values common to all files).
pub(crate) fn stream(seed: u64, purpose: Purpose, file: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(((file as u64) << 8) | purpose as u64);
    rng
}

/// Standard normal.
pub(crate) fn normal(rng: &mut impl Rng) -> f64 {
    rng.sample(StandardNormal)
}

/// Uniform from −1 to 1.
pub(crate) fn uniform(rng: &mut impl Rng) -> f64 {
    2.0 * rng.random::<f64>() - 1.0
}
