//! Estimators: from the means of placements to the parameters of a sensor.

pub mod accelerometer;
pub mod ferraris;
pub mod gyro;
pub mod joint;
mod observability;
pub mod pose_noise;
pub mod predicted;
mod reading;
pub mod reliability;
pub mod solve;

pub use observability::in_words;
pub use reading::Reading;
