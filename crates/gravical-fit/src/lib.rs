//! Poses in, calibration out: estimation, and how far its result can be trusted.
//!
//! # Overview
//!
//! Numbers only: no files, no rows, no units but those of the readings and SI, no words.
//!
//! 1. [`Pose`]: a mean reading at rest, and what is known of its direction.
//! 2. [`model`]: u = M a + b, and what one pose says of M and b.
//! 3. [`later`]: does a calibration still fit, and do two of them differ?
#![deny(missing_docs)]

pub mod later;
pub mod model;
mod pose;

pub use pose::{Face, Hint, Pose, angle_deg};
