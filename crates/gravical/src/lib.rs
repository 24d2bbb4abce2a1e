//! Turn a cheap IMU into an instrument you can trust.
//!
//! # Overview
//!
//! The stages of processing, one module each:
//!
//! 1. [`recording`] reads recordings in many formats and reports their faults; [`inspect`]
//!    summarises their contents.
//! 2. [`poses`] finds the static intervals and the face that was up in each.
//! 3. [`calibrate`] estimates the parameters and gives a verdict on their accuracy. Read it first: it contains the whole method in order.
//! 4. [`calibration_file`] stores them; [`apply`] calibrates recordings of any size with them,
//!    [`check`] determines whether one still fits new recordings, [`compare`] whether two of them
//!    differ by more than their uncertainty; [`export`] writes them as code or parameters for
//!    other programs.
//! 5. [`motion`](mod@motion) turns acceleration into attitude, velocity and position with their bands.
//! 6. [`denoise`] filters a recording and reports the effect on its noise; [`noise`] determines the
//!    noise itself.
//!
//! What is not shown here serves the program `gravical` and may change with every release.
//!
//! [`simulate`] computes recordings of a sensor with known parameters. Documents and figures of a
//! result are in the crate `gravical-report`, code for microcontrollers in `gravical-core`.
//!
//! # Example
//!
//! ```
//! use gravical::calibrate::{CalibrateOptions, calibrate};
//! use gravical::recording::{ReadOptions, read};
//! use gravical::simulate::{Scenario, SimulateOptions, SixPositionOptions, simulate_to};
//!
//! // Six static poses of a virtual sensor, one file each …
//! let folder = tempfile::tempdir()?;
//! let options = SimulateOptions::new(Scenario::SixPosition(SixPositionOptions::default()));
//! let (_, files) = simulate_to(&options, folder.path(), false)?;
//!
//! // … read and calibrated.
//! let mut session = Vec::new();
//! for path in files.iter().filter(|p| p.extension().is_some_and(|e| e == "csv")) {
//!     session.push(read(path, &ReadOptions::default())?);
//! }
//! let result = calibrate(&session, &CalibrateOptions::default())?;
//! assert_eq!(result.file.poses.len(), 6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(missing_docs)]

pub mod apply;
pub mod convert;
pub mod denoise;
#[doc(hidden)]
pub mod export;
pub mod finding;
pub mod inspect;
pub mod motion;
pub mod noise;
mod rewrite;
pub mod session;
#[doc(hidden)]
pub mod targets;

#[doc(inline)]
pub use gravical_calibrate::{
    calibrate, calibration_file, check, compare, gravity, poses, recording,
};
#[doc(hidden)]
pub use gravical_calibrate::{numfmt, temperature};
use gravical_calibrate::{rounding, stats};
#[doc(hidden)]
pub use gravical_recording::output;
#[doc(hidden)]
pub use gravical_recording::output::TOOL;

/// The part that runs on a microcontroller, too: calibrations and filters of one sample,
/// closed-form estimation.
pub use gravical_core as core;
#[doc(hidden)]
pub use gravical_fit as fit;
/// Guided calibration: a recording that grows and commands in, events out.
pub use gravical_live as live;
#[doc(hidden)]
pub use gravical_recording::escape;
use gravical_recording::option_text;
pub use gravical_recording::{Category, Error, Location, Result, utc};
/// A virtual sensor with known parameters.
pub use gravical_sim as simulate;

/// The programs of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
