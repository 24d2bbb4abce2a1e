//! Calibrated samples in, velocity and position with bands that hold out.
//!
//! The API is internal to gravical and may change.
//!
//! # Overview
//!
//! SI units; no files, no words.
//!
//! 1. [`Samples`]: times, specific force, angular rate; what is clipped or spiked is interpolated before
//!    ([`gravical_signal::interpolate_outliers`]).
//! 2. [`MotionOptions`]: how far the calibration may be off, and what is known.
//! 3. [`estimate_motion`]: rests, an error-state Kalman filter of 42 states with zero-velocity updates and
//!    levelling, its smoother.
//! 4. [`Motion`]: rests, moves with their deviations, path; [`Motion::states`]: every sample.
//!
//! # Example
//!
//! ```
//! use gravical_motion::{MotionOptions, Samples, estimate_motion};
//!
//! // Five seconds on a table, written in steps of 0.01 m/s².
//! let time_s: Vec<f64> = (0..500).map(|i| f64::from(i) * 0.01).collect();
//! let dither = |i: usize| [0.0, 0.01, 0.02, 0.01, 0.0, -0.01, 0.01][i % 7];
//! let force: Vec<[f64; 3]> = (0..500).map(|i| [dither(i), dither(i + 3), 9.81 + dither(i + 1)]).collect();
//! let rows = time_s.iter().zip(&force).map(|(t, force)| (*t, *force, None));
//! let samples = Samples::new(rows, Vec::new(), [0.01; 6]);
//! let motion = estimate_motion(&samples, &MotionOptions::default());
//! assert_eq!((motion.rests, motion.moves.len()), (vec![0..500], 0));
//! ```
#![deny(missing_docs)]

mod chain;
mod closure;
mod estimate;
mod filter;
mod moves;
mod noise;
mod options;
mod result;
mod smooth;
mod stance;
mod state;
mod states;
mod transition;
mod unusable;

pub use closure::Closure;
pub use estimate::estimate_motion;
pub use gravical_signal::{Interpolated, Samples};
pub use noise::NoiseAtRest;
pub use options::{
    CalibrationUncertainty, ElementErrors, ForceCovariance, MotionOptions, RateCovariance,
};
pub use result::{Budget, Ends, Motion, Move, PathNode};
pub use states::SampleState;
pub use unusable::Unusable;
