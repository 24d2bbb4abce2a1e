//! Acceptance tests of the calibration: comparison with simulated truth, invariances, whether a calibration still
//! fits.
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[macro_use]
#[path = "../../../../tests/support/sampled.rs"]
mod sampled;

mod compare_check;
mod later;
mod moved;
mod pauses;
mod properties;
#[path = "../../../../tests/support/library.rs"]
mod support;
mod truth;
mod wearables;
mod without_clock;
