//! One file a verb: `Args` and `run`.

pub mod simulate;
