//! What a calibration takes from recordings: means at rest, and what is known of their directions.

pub(crate) mod from_segments;
