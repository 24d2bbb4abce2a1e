//! Does the sensor rest: sample by sample, from the noise of the sensor itself.
//!
//! At rest the mean over a window agrees with the mean over the seconds before
//! it, but for noise. [`Statistic`] holds the two against each other, in three
//! windows at once, so that a move of 16 s shows as well as a knock.

mod plan;
mod statistic;

pub use plan::{Plan, RestNoise};
pub use statistic::{Alarm, Statistic};

/// Channels: specific force x, y, z, then angular rate x, y, z.
pub const CHANNELS: usize = 6;
