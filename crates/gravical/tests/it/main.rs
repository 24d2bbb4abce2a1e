//! Acceptance tests of the library: reading of faulty recordings, comparison with simulated
//! truth, invariances, and the format of the calibration file.
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[macro_use]
#[path = "../../../../tests/support/sampled.rs"]
mod sampled;

mod applied;
mod axivity;
mod compare_check;
#[path = "../../../../tests/support/axivity.rs"]
mod cwa;
mod export;
mod file_format;
mod formats;
#[path = "../../examples/live_sessions/hand.rs"]
#[allow(dead_code, reason = "the example uses more of it")]
mod hand;
mod hints;
mod join;
mod later;
mod live;
mod motion_misfit;
mod motion_stories;
mod noise;
mod properties;
mod reader;
mod session;
mod support;
mod truth;
#[path = "../../../../tests/support/wear.rs"]
mod wear;
mod wearables;
mod writings;
