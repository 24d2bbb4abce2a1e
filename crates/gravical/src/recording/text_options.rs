//! The options of this crate as those of the reader of text.

use gravical_recording as new;

use super::ReadOptions;

/// The options for the reader of text.
pub(super) fn text_options(options: &ReadOptions, is_gyroscope: bool) -> new::ReadOptions {
    new::ReadOptions {
        accel_unit: options.accel_unit,
        accel_range_g: options.accel_range_g,
        gyro_unit: options.gyro_unit,
        gyro_range_deg_s: options.gyro_range_deg_s,
        columns: options.columns.clone(),
        sensor: options.sensor.clone(),
        rate_hz: options.rate_hz,
        time_unit: options.time_unit,
        zero_offset: options.zero_offset,
        is_gyroscope,
    }
}
