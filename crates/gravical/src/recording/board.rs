//! Settings of the project's firmware in a recording.

pub use gravical_recording::BoardSettings;

/// Why a recording is taken for a calibrated one, for findings.
pub(crate) fn why_calibrated(by_board: bool) -> &'static str {
    match by_board {
        true => {
            "the board calibrated it, as the line with its settings says (`gravical log --format si` records raw values)"
        }
        false => "its columns have the names of calibrated columns",
    }
}

#[cfg(test)]
mod tests {
    use super::BoardSettings;
    use crate::recording::{Origin, ReadOptions, Recording, TimeUnit, read_bytes};

    const LINE: &str = "# gravical mpu6050_logger 1.0, MPU6050, accelerometer +-4 g, gyroscope +-500 deg/s, low-pass 44 Hz, rate 66.66 Hz, format 0";

    #[test]
    fn settings_line_is_parsed() {
        let settings = BoardSettings::parse(LINE).unwrap();
        assert_eq!((settings.low_pass_hz, settings.rate_hz), (44, 66.66));
        for other in [
            "",
            "# overruns 1",
            "#gravical mpu6050_logger",
            "x",
            "# \u{1f600}",
        ] {
            assert_eq!(BoardSettings::parse(other), None, "{other}");
        }
    }

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
        LINE.replace("66.66", "500.00")
            .replace("format 0", &format!("format {format}"))
    }

    fn kinds(recording: &Recording) -> Vec<&str> {
        recording.findings.iter().map(|f| f.kind.name()).collect()
    }

    #[test]
    fn settings_line_gives_the_units_of_counts() {
        let recording = file(&board(2), false, HEADER);
        assert!(kinds(&recording).is_empty());
        let (accel, gyro) = (&recording.accel_scale, recording.gyro_scale.unwrap());
        assert_eq!(
            (accel.lsb_per_g, accel.origin),
            (Some(8192.0), Origin::Data)
        );
        assert_eq!(
            (gyro.lsb_per_deg_s, gyro.origin),
            (Some(65.5), Origin::Header)
        );
        let t = recording.temperature_c.as_ref().unwrap();
        assert!((t[0] - 25.0).abs() < 0.01 && (t[1] - t[0] - 1.0 / 340.0).abs() < 1e-9);
        assert_eq!(recording.timing.unit, Some(TimeUnit::Microsecond));
        assert!((recording.timing.rate_hz().unwrap() - 500.0).abs() < 1e-6);
        assert_eq!(recording.timing.nominal_rate_hz, Some(500.0));
        // While the sensor is shaken, the magnitude does not show gravity.
        let shaken = file(&board(1), true, HEADER).accel_scale;
        assert_eq!(
            (shaken.lsb_per_g, shaken.origin),
            (Some(8192.0), Origin::Header)
        );
    }

    #[test]
    fn gravity_and_headers_override_the_board() {
        let two = board(2).replace("+-4 g", "+-2 g");
        let recording = file(&two, false, HEADER);
        assert_eq!(recording.accel_scale.lsb_per_g, Some(8192.0));
        assert!(kinds(&recording).contains(&"range-mismatch"));
        // A board that calibrates says so, whatever its columns are called.
        let calibrated = file(&board(3), false, "t_us,ax,ay,az,temp,gx,gy,gz");
        assert!(calibrated.is_calibrated && calibrated.is_calibrated_by_board);
        assert!(!recording.is_calibrated);
        // A board that writes SI units, or a header with units.
        let si = "t_us,ax_mps2,ay_mps2,az_mps2,temp (C),gx_rad_s,gy_rad_s,gz_rad_s";
        for (board, header) in [(board(0), HEADER), (board(2), si)] {
            let recording = file(&board, false, header);
            let gyro = recording.gyro_scale.unwrap();
            assert_eq!(gyro.lsb_per_deg_s, None);
            assert!(recording.temperature_c.is_none());
        }
    }
}
