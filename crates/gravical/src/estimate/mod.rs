//! Estimators: from the means of placements to the parameters of a sensor.

#[doc(hidden)]
pub mod ferraris;
#[doc(hidden)]
pub mod gyro;
#[doc(hidden)]
pub mod solve;
