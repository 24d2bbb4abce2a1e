//! The engine against motions whose truth is known, and against what no sensor sends.
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[macro_use]
#[path = "../../../../tests/support/sampled.rs"]
mod sampled;

mod attitude;
mod cameras;
mod drives;
mod properties;
mod real;
mod simulated;
mod states;
mod stories;
mod study;
mod truth;
mod walks;
