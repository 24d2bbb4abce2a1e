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

use gravical_core::unit::MPU6050_GYROSCOPE_LSB_PER_DEG_S;
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
    /// 0: text in SI units, 1: text in counts, 3: text with calibrated values. Older firmware had 2:
    /// counts in a binary coding, which the logger wrote as text.
    pub format: u8,
    /// The sensor is an MPU-6500 or one of its relatives.
    pub is_mpu6500: bool,
}

impl BoardSettings {
    /// Rows under both settings mean the same.
    pub(crate) fn has_units_of(&self, other: &Self) -> bool {
        let units = |s: &Self| (s.accel_range_g, s.gyro_range_deg_s, s.format);
        units(self) == units(other)
    }

    /// Parses the line that starts with `# gravical mpu6050_logger`; `None` for other lines.
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
    pub fn is_counts(&self) -> bool {
        self.format == 1 || self.format == 2
    }

    /// True if the board calibrates: m/s² and rad/s.
    pub fn is_calibrated(&self) -> bool {
        self.format == 3
    }

    /// Counts per g of a 16-bit converter with this range.
    pub(crate) fn lsb_per_g(&self) -> f64 {
        32768.0 / f64::from(self.accel_range_g)
    }

    /// °C of a count: 1/340 °C each and 36.53 °C at 0 for the MPU6050 (MPU-6000 and MPU-6050
    /// Register Map 4.2, register 65), 1/333.87 °C and 21 °C for the MPU-6500 (MPU-6500
    /// Product Specification 1.3, section 3.4.2, and Register Map 2.1, register 65).
    pub(crate) fn celsius(&self, count: f64) -> f64 {
        if self.is_mpu6500 {
            count / 333.87 + 21.0
        } else {
            count / 340.0 + 36.53
        }
    }

    /// Counts per °/s; `None` for a range that the sensor does not have.
    pub(crate) fn lsb_per_deg_s(&self) -> Option<f64> {
        let mut ranges = MPU6050_GYROSCOPE_LSB_PER_DEG_S.into_iter();
        let range = ranges.find(|(range, _)| *range == self.gyro_range_deg_s);
        range.map(|(_, lsb)| lsb)
    }

    /// The last settings line above the rows.
    pub(crate) fn last(metadata: &[String]) -> Option<Self> {
        metadata.iter().rev().find_map(|line| Self::parse(line))
    }
}

#[cfg(test)]
mod tests {
    use crate::{Origin, ReadOptions, Recording, TimeUnit, read_bytes};

    const LINE: &str = "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-4 g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 500.00 Hz, format 0";

    /// Three seconds of counts as a board sends them, at rest or
    /// shaken.
    fn file(board: &str, shaken: bool, header: &str) -> Recording {
        let mut text = format!(
            "# gravical 0.1.0 log, 2026-01-01T00:00:00Z, port\n{board}\n# rate: 500.00 Hz\n{header}\n"
        );
        for i in 0..1500_i64 {
            let [a, b, c, d, e, f] = [1, 2, 3, 4, 5, 6].map(|k| (i * 7919 + 131 * k) % 61 - 30);
            let shake = [0, 9000, 4000, -9000, -16000][if shaken { i as usize % 5 } else { 0 }];
            let [x, y, z] = [shake + a, shake / 3 + b, 8192 - shake / 2 + c];
            // The stamps wrap at 32 bits.
            let (stamp, t, gx) = (4_294_000_000 + 2000 * i, -3920 + i % 2, 100 + d);
            text += &format!("{stamp},{x},{y},{z},{t},{gx},{e},{f}\n");
        }
        read_bytes(text.as_bytes(), "fast.csv", &ReadOptions::default()).unwrap()
    }

    const HEADER: &str = "Timestamp (us),ax,ay,az,temp,gx,gy,gz";

    fn board(format: u8) -> String {
        LINE.replace("format 0", &format!("format {format}"))
    }

    fn kinds(recording: &Recording) -> Vec<&str> {
        recording.findings.iter().map(|f| &*f.kind).collect()
    }

    #[test]
    fn settings_line_gives_the_units_of_counts() {
        let recording = file(&board(2), false, HEADER);
        assert!(kinds(&recording).is_empty() && !recording.format.is_calibrated());
        let (accel, gyro) = (&recording.units.accel, recording.units.gyro.unwrap());
        let by_gravity = (Some(8192.0), Origin::Data);
        assert_eq!((accel.lsb_per_g, accel.origin), by_gravity);
        let by_line = (Some(65.5), Origin::Header);
        assert_eq!((gyro.lsb_per_deg_s, gyro.origin), by_line);
        let t = recording.temperature_c.as_ref().unwrap();
        assert!((t[0] - 25.0).abs() < 0.01 && (t[1] - t[0] - 1.0 / 340.0).abs() < 1e-9);
        assert_eq!(recording.clock.unit, Some(TimeUnit::Microsecond));
        assert!((recording.clock.rate_hz().unwrap() - 500.0).abs() < 1e-6);
        assert_eq!(recording.clock.nominal_rate_hz, Some(500.0));
        // While the sensor is shaken, the magnitude does not show gravity.
        let shaken = file(&board(1), true, HEADER).units.accel;
        assert_eq!(
            (shaken.lsb_per_g, shaken.origin),
            (Some(8192.0), Origin::Header)
        );
        // Gravity overrides the line.
        let recording = file(&board(2).replace("+-4 g", "+-2 g"), false, HEADER);
        assert_eq!(recording.units.accel.lsb_per_g, Some(8192.0));
        assert!(kinds(&recording).contains(&"range-mismatch"));
        // A board that calibrates says so, whatever its columns are called.
        let calibrated = file(&board(3), false, "t_us,ax,ay,az,temp,gx,gy,gz");
        assert!(calibrated.format.is_calibrated() && calibrated.format.is_calibrated_by_board());
        // A board that writes SI units, or a header with units.
        let si = "t_us,ax_mps2,ay_mps2,az_mps2,temp (C),gx_rad_s,gy_rad_s,gz_rad_s";
        for (board, header) in [(board(0), HEADER), (board(2), si)] {
            let recording = file(&board, false, header);
            assert_eq!(recording.units.gyro.unwrap().lsb_per_deg_s, None);
            assert!(recording.temperature_c.is_none());
        }
    }
}
