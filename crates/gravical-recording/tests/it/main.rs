//! What a user sees of a reader: files in, columns and notes out.
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod clock;
mod defects;
mod follow;
mod properties;
mod real;
mod shapes;
mod stream;
mod support;
mod write;
