//! Acceptance tests of the program: real recordings, the report's numbers, bad
//! input and its exit codes, files and pipes.
//!
//! Real recordings are found through `GRAVICAL_DATA`; without it those tests say
//! that they are skipped.
// The exemption of tests in clippy.toml does not reach helpers outside #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bad_input;
mod calibrated_board;
// A name of a file holds no control characters on Windows.
#[cfg(unix)]
mod control;
mod convert;
mod demo;
mod denoise;
mod docs_complete;
mod each;
mod export;
mod figures;
mod files;
mod folder;
#[cfg(unix)]
mod live;
#[cfg(unix)]
mod live_page;
mod motion;
mod motion_real;
mod noise;
mod outputs;
mod recordings;
mod reports;
mod sessions;
mod shell;
#[cfg(unix)]
mod signals;
mod support;
#[cfg(unix)]
mod terminal;
mod thermal;
