//! A recording that the sensor feels again.

use gravical::recording::Recording;
use gravical::{Error, Result};

use super::Reading;

/// The readings of a recording, in whatever unit, as a function of time. Each row is held until
/// the next one, so that noise stays as it was recorded; after the last row the recording starts
/// again. Without a gyroscope the rates are 0, without a thermometer it is 25 °C; an empty cell is
/// what it was in the row before.
///
/// # Errors
///
/// `unit-unknown` (input) where the unit of the accelerometer is not known.
pub fn recorded(recording: &Recording) -> Result<impl FnMut(f64) -> Reading + use<>> {
    let Some(per_mps2) = recording.accel_scale.nominal() else {
        let message = format!("{}: the accelerometer's unit is not known", recording.name);
        return Err(Error::input("unit-unknown", message));
    };
    let per_rad_s = recording.gyro_scale.as_ref().and_then(|s| s.nominal());
    let (rate_hz, _) = recording.working_rate_hz();
    let keep = |new: f64, old: f64| if new.is_finite() { new } else { old };
    let (mut last_s, mut last) = (0.0_f64, Reading::default());
    let mut rows: Vec<(f64, Reading)> = Vec::with_capacity(recording.rows());
    for row in 0..recording.rows() {
        for axis in 0..3 {
            let accel = recording.accel[axis][row] / per_mps2;
            last.accel_mps2[axis] = keep(accel, last.accel_mps2[axis]);
            if let (Some(gyro), Some(scale)) = (&recording.gyro, per_rad_s) {
                let rate = (gyro[axis][row] / scale).to_degrees();
                last.gyro_deg_s[axis] = keep(rate, last.gyro_deg_s[axis]);
            }
        }
        if let Some(temperature) = &recording.temperature_c {
            last.temperature_c = keep(temperature[row], last.temperature_c);
        }
        let stamps_s = recording.time_s.as_ref();
        let time_s = stamps_s.map_or(row as f64 / rate_hz, |stamps| stamps[row]);
        // A stamp that is no number or runs backwards is as late as the last.
        last_s = last_s.max(time_s);
        rows.push((last_s, last));
    }
    // The last row lasts as long as the average one.
    let steps = rows.len().saturating_sub(1).max(1);
    let first_s = rows.first().map_or(0.0, |row| row.0);
    let period_s = (last_s - first_s) * (1.0 + 1.0 / steps as f64);
    Ok(move |time_s: f64| {
        let time_s = if period_s > 0.0 {
            time_s.rem_euclid(period_s)
        } else {
            0.0
        };
        // A sensor as fast as the rows takes each of them once: half a
        // millisecond keeps rounding from deciding which.
        let at = rows.partition_point(|(t, _)| *t <= time_s + 5e-4);
        let row = rows.get(at.saturating_sub(1));
        row.map_or_else(Reading::default, |row| row.1)
    })
}
