//! Units of calibrated specific force.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use serde::Serialize;

use gravical_recording::CALIBRATED;

/// Unit in which calibrated specific force is written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub enum OutputUnit {
    /// m/s².
    #[default]
    #[serde(rename = "m/s^2")]
    MetrePerSecondSquared,
    /// Standard gravity, 9.80665 m/s².
    #[serde(rename = "g")]
    StandardGravity,
}

impl OutputUnit {
    /// Name in files and options.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            OutputUnit::MetrePerSecondSquared => "m/s^2",
            OutputUnit::StandardGravity => "g",
        }
    }

    /// Names of the columns, by which they are recognised as calibrated.
    #[must_use]
    pub fn columns(self) -> [&'static str; 3] {
        match self {
            OutputUnit::MetrePerSecondSquared => CALIBRATED[0],
            OutputUnit::StandardGravity => CALIBRATED[1],
        }
    }

    /// One m/s² in this unit.
    pub(super) fn per_mps2(self) -> f64 {
        match self {
            OutputUnit::MetrePerSecondSquared => 1.0,
            OutputUnit::StandardGravity => 1.0 / STANDARD_GRAVITY_MPS2,
        }
    }
}
