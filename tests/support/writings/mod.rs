//! Writings: one recording in the forms that loggers, apps and people give it.
//!
//! [`Writing`] is a choice from every list of `choices`: which session, at which
//! rate, in which unit, with which delimiter, header, names, clock …
//! [`write`](write::write) makes the bytes of its files from the columns of a
//! [`Session`](session::Session).
#![allow(dead_code)] // each test crate uses its part

pub mod choices;
pub mod session;
pub mod write;

pub use choices::*;
