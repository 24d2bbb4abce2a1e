//! Settings line of the project's firmware (`firmware/mpu6050_logger`). In a recording of counts
//! it gives their sensitivities.
//!
//! # Example
//!
//! ```
//! use gravical_recording::BoardSettings;
//!
//! let line = "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-4 g, \
//!     gyroscope +-500 deg/s, low-pass 44 Hz, rate 250.00 Hz, format 1";
//! let settings = BoardSettings::parse(line).ok_or("another line")?;
//! assert_eq!((settings.accel_range_g, settings.rate_hz), (4, 250.0));
//! assert!(settings.is_counts());
//! # Ok::<(), &str>(())
//! ```

use gravical_core::unit::mpu6050_gyroscope_lsb_per_deg_s;
use serde::Serialize;

/// Settings of the firmware.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BoardSettings {
    /// Full scale of the accelerometer, g.
    pub accel_range_g: u16,
    /// Full scale of the gyroscope, °/s.
    pub gyro_range_deg_s: u16,
    /// Low-pass, Hz.
    pub low_pass_hz: u16,
    /// Sampling rate, Hz, as realised by the sensor's divider.
    pub rate_hz: f64,
    /// 0: text in SI units, 1: text in counts, 3: text with calibrated values. Firmware before 1.2
    /// had 2: counts in a binary coding, which the logger wrote as text.
    pub format: u8,
    /// The sensor is an MPU-6500 or one of its relatives.
    pub is_mpu6500: bool,
}

impl BoardSettings {
    /// Rows under both settings mean the same.
    #[must_use]
    pub fn has_units_of(&self, other: &Self) -> bool {
        let units = |s: &Self| (s.accel_range_g, s.gyro_range_deg_s, s.format);
        units(self) == units(other)
    }

    /// Parses the line that starts with `# gravical mpu6050_logger`; `None` for other lines.
    #[must_use]
    pub fn parse(line: &str) -> Option<Self> {
        let text = line.trim().strip_prefix('#')?.trim();
        let text = text.strip_prefix("gravical mpu6050_logger")?;
        let after = |words: &str| -> Option<&str> {
            let rest = text.get(text.find(words)? + words.len()..)?;
            rest.trim_start()
                .split(|c: char| !(c.is_ascii_digit() || c == '.'))
                .next()
        };
        Some(BoardSettings {
            accel_range_g: after("accelerometer +-")?.parse().ok()?,
            gyro_range_deg_s: after("gyroscope +-")?.parse().ok()?,
            low_pass_hz: after("low-pass ")?.parse().ok()?,
            rate_hz: after("rate ")?.parse().ok()?,
            format: after("format ")?.parse().ok()?,
            is_mpu6500: text.contains("MPU6500"),
        })
    }

    /// True if values are counts.
    #[must_use]
    pub fn is_counts(&self) -> bool {
        self.format == 1 || self.format == 2
    }

    /// True if the board calibrates: m/s² and rad/s.
    #[must_use]
    pub fn is_calibrated(&self) -> bool {
        self.format == 3
    }

    /// Counts per g of a 16-bit converter with this range.
    #[must_use]
    pub fn lsb_per_g(&self) -> f64 {
        32768.0 / f64::from(self.accel_range_g)
    }

    /// °C of a count: 1/340 °C each and 36.53 °C at 0 for the MPU6050 (MPU-6000 and MPU-6050
    /// Register Map 4.2, register 65), 1/333.87 °C and 21 °C for the MPU-6500 (MPU-6500
    /// Product Specification 1.3, section 3.4.2, and Register Map 2.1, register 65).
    #[must_use]
    pub fn celsius(&self, count: f64) -> f64 {
        match self.is_mpu6500 {
            true => count / 333.87 + 21.0,
            false => count / 340.0 + 36.53,
        }
    }

    /// Counts per °/s; `None` for a range that the sensor does not have.
    #[must_use]
    pub fn lsb_per_deg_s(&self) -> Option<f64> {
        mpu6050_gyroscope_lsb_per_deg_s(self.gyro_range_deg_s)
    }

    /// The last settings line above the rows.
    #[must_use]
    pub fn last(metadata: &[String]) -> Option<Self> {
        let mut lines = metadata.iter().rev();
        lines.find_map(|line| BoardSettings::parse(line))
    }
}
