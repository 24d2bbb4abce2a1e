//! Recordings of poses in, a calibration out: its file, its verdict, and whether it still fits.
//!
//! The API is internal to gravical and may change: users call it as `gravical::calibrate` and so on.
//!
//! # Overview
//!
//! 1. [`session`]: the recordings of a session, from files or a folder.
//! 2. [`poses`]: static intervals, the face that was up in each, the unit of the gyroscope.
//! 3. [`calibrate`](mod@calibrate): from poses to parameters and verdict, by the estimators of `gravical_fit`.
//! 4. [`calibration_file`]: the calibration file, and imucal's files.
//! 5. [`temperature`]: drift with temperature.
//! 6. [`check`](mod@check), [`compare`](mod@compare): a calibration against new rests, and two calibrations.
//!
//! Below these are [`recording`] (recordings and their faults), [`finding`] and [`gravity`].
#![deny(missing_docs)]

mod attitude;
#[doc(hidden)]
pub mod axes;
pub mod calibrate;
pub mod calibration_file;
pub mod check;
pub mod compare;
pub mod finding;
pub mod gravity;
mod judgement;
pub mod poses;
mod problem;
pub mod recording;
#[doc(hidden)]
pub mod samples;
pub mod session;
pub mod temperature;

pub use gravical_judge::{Error, Result};
