//! Wrong units and ranges in headers.

use super::*;

/// Counts of an MPU6050 at ±`range` g, at rest with z up; with `clip`, a shock that exceeds the
/// range.
fn counts(range: f64, clip: bool) -> Vec<u8> {
    let sensor = Sensor {
        unit: 32768.0 / range / 9.80665,
        decimals: 0,
        ..Sensor::default()
    };
    let mut text = "t_ms,ax,ay,az\n".to_owned();
    for (i, row) in sensor
        .hold([0.0, 0.0, 1.0], ROWS, 3)
        .into_iter()
        .enumerate()
    {
        let z = if clip && (300..310).contains(&i) {
            32767.0
        } else {
            row[2]
        };
        text.push_str(&format!("{},{:.0},{:.0},{z:.0}\n", 10 * i, row[0], row[1]));
    }
    text.into_bytes()
}

#[test]
fn clipped_samples_are_reported_with_their_lines() {
    let recording = read(&counts(2.0, true));
    let found = finding(&recording, "clipped");
    assert_eq!(found.lines, [[302, 311]]);
    assert!(found.message.starts_with("az"), "{}", found.message);
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
        let recording = read_with(&counts(4.0, false), &claim(unit));
        assert_eq!(recording.accel_scale.lsb_per_g, Some(16384.0));
        let message = &finding(&recording, kind).message;
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn unsigned_counts_are_relative_to_their_middle() {
    let text: String = (0..400)
        .map(|i| format!("{},33000,33100,{}\n", 0.01 * f64::from(i), 49000 + i % 3))
        .collect();
    let recording = read(text.as_bytes());
    finding(&recording, "unsigned-counts");
    assert_eq!(recording.zero_offset, 32768.0);
    assert_eq!(recording.accel_scale.lsb_per_g, None, "no range is claimed");
    close(accel_means(&recording)[0], 232.0, 1e-9);
}
