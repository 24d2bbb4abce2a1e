//! Turn a cheap IMU into an instrument you can trust.
//!
//! # Overview
//!
//! [`recording`] reads what was recorded and names what is wrong with it.
//! More in the modules.
#![deny(missing_docs)]

mod error;
pub mod output;
pub mod simulate;

pub use error::{Category, Error, Location, Result};
pub mod apply;
pub mod calibration_file;
pub mod recording;
pub mod scan;
pub mod segment;
