//! The fit against sensors whose truth is known, what must not matter to it, and real tables of means.
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[macro_use]
#[path = "../../../../tests/support/sampled.rs"]
mod sampled;

mod compare;
mod properties;
#[allow(dead_code, reason = "the example uses more of it")]
mod sessions;
mod truth;
mod wear;
