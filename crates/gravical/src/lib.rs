//! Turn a cheap IMU into an instrument you can trust.
//!
//! # Overview
//!
//! The way of the data, one module a stage:
//!
//! 1. [`recording`] reads what was recorded, whatever its shape, and names what
//!    is wrong with it; [`inspect`] says what is in it.
//! 2. [`segment`] finds where the sensor lay still and which face was up.
//! 3. [`calibrate`] estimates the parameters ([`estimate`]), holds them against
//!    what can show them wrong ([`validate`]) and says how far to trust them.
//!    Read it first: it is the whole method in order.
//! 4. [`calibration_file`] keeps them; [`apply`] calibrates recordings of any
//!    size with them, [`check`] says whether one still fits new recordings,
//!    [`compare`] whether two of them differ by more than their uncertainty.
//! 5. [`denoise`] filters a recording and says what that does to its noise.
//!
//! [`simulate`] makes recordings of a sensor whose truth is known; [`report`] says
//! what there is to say of a result, as one [`document`] that is written as text, as
//! HTML or as Markdown. What a microcontroller runs lives in the crate
//! `gravical-core`.
//!
//! # Example
//!
//! ```
//! use gravical::calibrate::{CalibrateOptions, calibrate};
//! use gravical::recording::{ReadOptions, read};
//! use gravical::simulate::{Scenario, SimulateOptions, SixPositionOptions, simulate, write};
//!
//! // Six still placements of a virtual sensor, one file each …
//! let folder = tempfile::tempdir()?;
//! let options = SimulateOptions::new(Scenario::SixPosition(SixPositionOptions::default()));
//! let files = write(&simulate(&options)?, folder.path(), false)?;
//!
//! // … read and calibrated.
//! let mut session = Vec::new();
//! for path in files.iter().filter(|p| p.extension().is_some_and(|e| e == "csv")) {
//!     session.push(read(path, &ReadOptions::default())?);
//! }
//! let result = calibrate(&session, &CalibrateOptions::default())?;
//! assert_eq!(result.file.accelerometer.positions.len(), 6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(missing_docs)]

pub mod apply;
pub mod calibrate;
pub mod calibration_file;
pub mod check;
pub mod compare;
pub mod denoise;
pub mod document;
mod error;
pub mod estimate;
pub mod excerpt;
pub mod figure;
pub mod finding;
pub mod gravity;
mod hash;
pub mod inspect;
pub mod motion;
pub mod output;
pub mod recording;
pub mod report;
pub mod scan;
pub mod segment;
pub mod simulate;
mod stats;
pub mod still;
pub mod temperature;
mod uncertainty;
pub mod validate;

pub use error::{Category, Error, Location, Result};

/// The programs of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
