//! Files of worn devices (Axivity, `.cwa`) to rows: blocks of samples, each with one time stamp.
//!
//! A "line" of such a file is a sample or a block that is skipped, counted from 1.

mod block;
mod means;
mod samples;

pub use means::{MAX_SAMPLES, read_means};
pub use samples::{MAGIC_BYTES, Samples, is_one, open, whole_blocks};
