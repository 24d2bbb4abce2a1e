//! What columns of measurements show of clock, unit and defects, and the types of findings and errors.
//!
//! The API is internal to gravical and may change.
//!
//! # Overview
//!
//! - Functions over slices: [`clock`] (stamps to times and a rate), [`accel_unit`] (the unit in which rows at rest show
//!   gravity), [`resolution`], [`Encoding`], and defects: [`detect_stuck`], [`frozen_axes`], [`repeated_rows`].
//!   [`full_scale`]: values at the end of a range.
//! - [`units`]: units and sensitivities by their names; [`utc`]: times; [`numfmt`]: numbers as text.
//! - [`ReadOptions`]: what the user says of a recording.
//! - [`Error`] and [`Finding`]: what all crates say, by tables of cases that [`errors!`] and [`findings!`] make.
//!
//! # Example
//!
//! ```
//! use gravical_judge::{ClockOptions, clock};
//!
//! let stamps = (0..100).map(|row| f64::from(20 * row)).collect();
//! let times = clock(stamps, ClockOptions::default()).map_err(|fault| format!("{fault:?}"))?;
//! assert_eq!((times.unit_s, times.rate_hz), (1e-3, 50.0));
//! # Ok::<(), String>(())
//! ```
#![deny(missing_docs)]

mod accel_unit;
mod advice;
mod cells;
mod clock;
mod defects;
mod encoding;
mod error;
pub mod escape;
#[doc(hidden)]
pub mod finding;
pub mod full_scale;
mod meter;
pub mod numfmt;
#[doc(hidden)]
pub mod option_text;
mod options;
mod problem;
mod resolution;
mod role;
mod spans;
pub mod units;
pub mod utc;

pub use accel_unit::{AccelClaim, Jump, accel_unit, find_jump, quiet_norm, shows_gravity};
pub use advice::Advice;
pub use cells::{median, trend};
pub use clock::{
    ClockFault, ClockOptions, GAP_PERIODS, RATES_HZ, Times, breaks, clock, counts_rows,
    holds_steps, regular_blanks, regularity, sum_steps,
};
pub use defects::{count_changes, detect_stuck, frozen_axes, repeated_rows, unread_runs};
pub use encoding::{Encoding, are_unsigned};
pub use error::{Category, Error, Location, Result};
pub use finding::{Finding, Severity};
pub use meter::{Meter, Progress, tap};
pub use options::{ColumnsSpec, ReadOptions};
pub use resolution::resolution;
pub use role::Role;
pub use spans::{LineSpans, format_spans};
