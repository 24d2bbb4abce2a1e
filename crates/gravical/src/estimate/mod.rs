//! Estimators: from the means of placements to the parameters of a sensor.

pub mod ferraris;
pub mod joint;
pub mod linear;
pub mod magnitude;
mod reading;
pub mod solve;
mod undetermined;

pub use reading::Reading;
