//! Results as one HTML file that needs nothing else: no network, no fonts, no
//! server; without its script it is complete all the same.
//!
//! Every number comes from the value that is written as JSON. A number of a table
//! carries where it stands there (`data-k`, a JSON pointer of RFC 6901) and its
//! value to the last digit (`data-v`), so that a program can hold the one against
//! the other.
//!
//! # Size
//!
//! Tables end after [`ROWS`] rows and say how many there are; the drawings
//! together stay under [`DRAWINGS`] bytes, and one that does not fit is named
//! instead.

mod calibration;
mod cells;
mod findings;
mod gallery;
mod gyroscope;
mod motion;
mod moves;
mod page;
mod parameters;
mod placements;
mod temperature;
mod truth;

#[cfg(test)]
mod tests;

pub use calibration::calibration_html;
pub use motion::{Provenance, motion_html};

/// Rows of a table that are shown at most.
pub const ROWS: usize = 200;

/// Bytes of all drawings of a page.
pub const DRAWINGS: usize = 4_000_000;
