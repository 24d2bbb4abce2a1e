//! Noise of known parts according to their data sheets.

use serde::{Deserialize, Deserializer, Serialize};

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::{Error, Result};

/// A part, with the noise densities of its data sheet.
///
/// Data sheets state the root of the one-sided power spectral density; N of the Allan deviation is
/// smaller by √2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Its name.
    pub name: &'static str,
    /// Noise density of the accelerometer, µg/√Hz.
    pub accel_ug_rthz: f64,
    /// Noise density of the gyroscope, °/s/√Hz.
    pub gyro_deg_s_rthz: f64,
}

/// The parts whose data sheets were read, with typical values: MPU-6000/MPU-6050 revision 3.4 (at
/// 10 Hz), MPU-9250 revision 1.0 (low-noise mode), ICM-42688-P revision 1.7.
pub const PARTS: &[Part] = &[
    Part {
        name: "MPU6050",
        accel_ug_rthz: 400.0,
        gyro_deg_s_rthz: 0.005,
    },
    Part {
        name: "MPU9250",
        accel_ug_rthz: 300.0,
        gyro_deg_s_rthz: 0.01,
    },
    Part {
        name: "ICM42688P",
        accel_ug_rthz: 70.0,
        gyro_deg_s_rthz: 0.0028,
    },
];

impl Part {
    /// The part of that name, whatever its case and hyphens.
    #[must_use]
    pub fn of_name(name: &str) -> Option<&'static Part> {
        let plain = |text: &str| text.replace(['-', ' ', '_'], "").to_ascii_uppercase();
        PARTS.iter().find(|part| plain(part.name) == plain(name))
    }

    /// N of the accelerometer, m/s²/√Hz.
    #[must_use]
    pub fn accel_n(&self) -> f64 {
        self.accel_ug_rthz * 1e-6 * STANDARD_GRAVITY_MPS2 / 2_f64.sqrt()
    }

    /// N of the gyroscope, rad/s/√Hz.
    #[must_use]
    pub fn gyro_n(&self) -> f64 {
        self.gyro_deg_s_rthz.to_radians() / 2_f64.sqrt()
    }
}

/// The part of that name, for options.
///
/// # Errors
///
/// `usage` (usage), with those that are known.
pub(super) fn part(name: &str) -> Result<&'static Part> {
    Part::of_name(name).ok_or_else(|| {
        let known: Vec<&str> = PARTS.iter().map(|part| part.name).collect();
        Error::usage("usage", format!("{name:?} is no part that is known"))
            .with_hint(format!("one of {}", known.join(", ")))
    })
}

/// The same for serde.
pub(super) fn optional<'de, D: Deserializer<'de>>(
    from: D,
) -> Result<Option<&'static Part>, D::Error> {
    let name = Option::<String>::deserialize(from)?;
    name.map(|name| crate::option_text::parse(&name, part))
        .transpose()
}

/// N of a channel beside that of the data sheet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DataSheet {
    /// Name of the part.
    pub part: String,
    /// N by the data sheet: its one-sided density over √2.
    pub n: f64,
    /// N of the recording over it; null if N is not observable.
    pub ratio: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_one_sided_density_of_the_mpu6050() {
        let part = Part::of_name("mpu-6050").unwrap();
        assert!((part.accel_n() - 2.774e-3).abs() < 1e-6);
        // 0.212 °/√h.
        assert!((part.gyro_n().to_degrees() * 60.0 - 0.2121).abs() < 1e-4);
        assert!(Part::of_name("ADXL999").is_none());
    }
}
