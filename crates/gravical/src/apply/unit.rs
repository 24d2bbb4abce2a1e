//! Units of calibrated specific force.

use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use serde::{Deserialize, Serialize};

use gravical_recording::CALIBRATED;

/// Unit in which calibrated specific force is written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum OutputUnit {
    /// m/s².
    #[default]
    #[serde(rename = "m/s^2", alias = "m/s2", alias = "mps2")]
    #[cfg_attr(feature = "clap", value(name = "m/s^2", aliases = ["m/s2", "mps2"]))]
    MetrePerSecondSquared,
    /// Standard gravity, 9.80665 m/s².
    #[serde(rename = "g")]
    #[cfg_attr(feature = "clap", value(name = "g"))]
    StandardGravity,
}

impl OutputUnit {
    /// Name in files and options.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["m/s^2", "g"][self as usize]
    }

    /// Names of the columns, by which they are recognised as calibrated.
    #[must_use]
    pub fn columns(self) -> [&'static str; 3] {
        CALIBRATED[self as usize]
    }

    /// One m/s² in this unit.
    pub(super) fn per_mps2(self) -> f64 {
        [1.0, 1.0 / STANDARD_GRAVITY_MPS2][self as usize]
    }
}
