//! Estimators: from the means of placements to the parameters of a sensor.

pub mod accelerometer;
pub mod ferraris;
pub mod joint;
pub mod pose_noise;
pub mod solve;
mod undetermined;

pub use undetermined::in_words;
