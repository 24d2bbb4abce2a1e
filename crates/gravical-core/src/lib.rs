//! The part of gravical that a microcontroller runs.
//!
//! Calibrating an accelerometer in closed form, applying a calibration to one sample and
//! filtering it: no `std`, no allocation, no `unsafe`, in `f32` or `f64`.
//!
//! - [`calibration`]: what a calibration is, and how it is applied.
//! - [`six_position`]: estimate that of an accelerometer from six placements.
//! - [`filter`]: Butterworth, sample by sample.
//! - [`mod@unit`]: units, the MPU6050's nominal sensitivities, local gravity.
//! - [`matrix3`]: the 3 × 3 operations behind them.
//!
//! Conventions: an accelerometer measures specific force, so that an axis that
//! points up reads +g at rest; `calibrated = matrix · (raw − bias)`; matrices
//! are row-major `[[T; 3]; 3]`.
//!
//! # Example
//!
//! ```
//! use gravical_core::six_position::{SixPositionMeans, ferraris_accelerometer};
//! use gravical_core::unit::local_gravity_mps2;
//!
//! // Mean readings in m/s² with x, y and z up, then down.
//! let means = SixPositionMeans {
//!     plus: [[10.20_f32, -0.04, -0.10], [0.29, 9.73, 0.49], [0.83, -0.18, 10.42]],
//!     minus: [[-9.43, -0.27, 0.92], [0.46, -9.99, 0.39], [-0.05, -0.08, -9.54]],
//! };
//! let parameters = ferraris_accelerometer(&means, local_gravity_mps2(30.0, 20.0))?;
//! if let Some(calibration) = parameters.calibration() {
//!     let accel_mps2 = calibration.apply([10.0, -0.05, 1.2]);
//!     assert!((accel_mps2[0] - 9.6).abs() < 0.1);
//! }
//! # Ok::<(), gravical_core::six_position::SixPositionError>(())
//! ```
#![no_std]
#![deny(missing_docs)]

#[cfg(test)]
extern crate std;

pub mod calibration;
pub mod filter;
pub mod matrix3;
mod real;
pub mod six_position;
pub mod unit;

pub use real::Real;

/// The programs of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
