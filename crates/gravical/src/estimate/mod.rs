//! Estimators: from the means of placements to the parameters of a sensor.

pub mod accelerometer;
#[doc(hidden)]
pub mod ferraris;
#[doc(hidden)]
pub mod gyro;
#[doc(hidden)]
pub mod joint;
mod observability;
#[doc(hidden)]
pub mod pose_noise;
#[doc(hidden)]
pub mod proposal;
#[doc(hidden)]
pub mod reliability;
#[doc(hidden)]
pub mod solve;

pub use observability::in_words;
