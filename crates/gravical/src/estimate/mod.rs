//! Estimators: from the means of placements to the parameters of a sensor.

pub mod accelerometer;
pub mod ferraris;
pub mod gyro;
pub mod joint;
pub mod linear;
pub mod magnitude;
pub mod pose_noise;
mod reading;
pub mod solve;
mod undetermined;
mod wanted;

pub use reading::Reading;
pub use undetermined::in_words;
