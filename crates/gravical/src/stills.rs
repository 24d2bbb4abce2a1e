//! Where the sensor seems still, in blocks, while rows arrive: for guided sessions and `log`.
//!
//! Rows are divided into short blocks. The noise is the variance of the quietest blocks; a block is
//! quiet if its variance is below 3² times that (gyroscope: 18²), and a static interval is a run of
//! quiet blocks whose means agree. A recording in memory is judged by `poses::rests`.

mod block;
mod levels;
mod live;
mod runs;

use gravical_core::matrix3::{norm, sub};

use levels::Levels;
pub(crate) use live::{LiveState, MOST_NOISE_AT_REST};
pub use live::{LiveStill, LiveStills};

/// Duration of a block, s, of 5 to 25 rows, and at least 0.05 s.
const BLOCK_S: f64 = 0.2;

/// Number of rows of a block.
fn block_rows(rate_hz: f64) -> usize {
    let wanted = (BLOCK_S * rate_hz).round();
    let least = (0.05 * rate_hz).round().max(5.0);
    wanted.clamp(5.0, 25.0).max(least) as usize
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm(&sub(&a, &b))
}
