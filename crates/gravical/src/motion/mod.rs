//! From acceleration to velocity and position, with an error band.

pub mod samples;
pub mod still;
