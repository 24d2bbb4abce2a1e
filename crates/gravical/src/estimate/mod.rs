//! Estimators: from the means of placements to the parameters of a sensor.

pub mod ferraris;
pub mod joint;
pub mod solve;
