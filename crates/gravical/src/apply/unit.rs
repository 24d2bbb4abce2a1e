//! Units of calibrated specific force.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use serde::Serialize;

use crate::recording::layout::CALIBRATED;

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

    /// Converts from m/s².
    #[inline]
    pub(super) fn convert(self, mps2: &mut [f64]) {
        if self == OutputUnit::StandardGravity {
            for value in mps2 {
                *value /= STANDARD_GRAVITY_MPS2;
            }
        }
    }
}
