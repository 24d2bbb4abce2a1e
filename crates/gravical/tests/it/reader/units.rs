//! Wrong units and ranges in headers.

use super::*;

/// Counts of an MPU6050 at ±`range` g, at rest with z up.
fn counts(range: f64) -> Vec<u8> {
    let sensor = Sensor {
        unit: 32768.0 / range / 9.80665,
        decimals: 0,
        ..Sensor::default()
    };
    sensor.file([0.0, 0.0, 1.0], ROWS, 3).into_bytes()
}

#[test]
fn a_wrong_full_scale_setting_is_reported() {
    // ±4 g was set and ±2 g is claimed: the claim is used, with a warning.
    let claim =
        |accel_unit| read_options(|o| (o.accel_unit, o.accel_range_g) = (accel_unit, Some(2.0)));
    for (unit, kind, words) in [
        (None, "range-mismatch", "corresponds to ±4.000 g"),
        (Some(AccelUnit::Counts), "unit-mismatch", "0.53 g"),
    ] {
        let recording = read_with(&counts(4.0), &claim(unit));
        assert_eq!(recording.accel_scale.lsb_per_g, Some(16384.0));
        let message = &finding(&recording, kind).message;
        assert!(message.contains(words), "{message}");
    }
}
