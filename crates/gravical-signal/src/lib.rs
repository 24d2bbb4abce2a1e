//! Arrays in, arrays out: what samples of an IMU say about themselves.
//!
//! The API is internal to gravical and may change.
//!
//! # Overview
//!
//! SI units only: no files, no names of columns, no words.
//!
//! 1. [`Samples`]: specific force and angular rate over time, in pieces without a gap.
//! 2. [`interpolate_outliers`]: what is clipped or spiked, interpolated before.
//! 3. [`blocks`]: means and variances of short blocks.
//! 4. [`detect_rests`]: where the sensor lay still, or moved by no more than a [`RestTolerance`].
//! 5. [`allan_variances`], [`fit_noise`]: how much its noise is, and of which kind.
//!
//! Below these are [`stats`], and [`rounding`]: what steps of a converter do to noise and means.
#![deny(missing_docs)]

mod blocks;
mod edges;
mod noise;
mod outliers;
mod partition;
mod quantile;
mod quiet;
mod rests;
pub mod rounding;
mod samples;
pub mod stats;
mod steady;

pub use blocks::{Block, block_len, blocks};
pub use noise::{
    AllanPoint, AllanVariance, Drift, Estimate, FittedCurve, Misfit, NoiseFit, NoiseLimit,
    NoiseModel, NoiseTerm, allan_variances, fit_noise, remove_trend,
};
pub use outliers::interpolate_outliers;
pub use quantile::quantile;
pub use quiet::{
    BLOCK_S, MAX_EXCESS, MAX_VARIANCE, MIN_VARIANCE, TREMOR, flips, is_quiet, quiet_level,
    quiet_limit,
};
pub use rests::{RestTolerance, detect_rests};
pub use samples::{Interpolated, Samples};
