//! What a calibration takes from recordings: means at rest, and what is known of their directions.

pub(crate) mod from_segments;

/// Nobody places a sensor in so many poses: they are found in days of wear, and enough to test a model on
/// eighths of them.
pub(crate) const MANY_POSES: usize = 64;
