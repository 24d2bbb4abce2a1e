//! Acceptance tests of the library: reading of faulty recordings, one session in many forms, applications of
//! a calibration, motion, exports, and the formats of the files.
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[macro_use]
#[path = "../../../../tests/support/sampled.rs"]
mod sampled;

mod applied;
mod axivity;
#[path = "../../../../tests/support/axivity.rs"]
mod cwa;
mod export;
mod file_format;
mod formats;
mod hints;
mod join;
mod motion_misfit;
mod motion_stories;
mod noise;
mod reader;
mod session;
#[path = "../../../../tests/support/library.rs"]
mod support;
#[path = "../../../../tests/support/wear.rs"]
mod wear;
mod writings;
