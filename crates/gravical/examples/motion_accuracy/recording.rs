//! Samples in SI units as a recording.

use gravical::recording::{AccelUnit, GyroUnit, ReadOptions, Recording, SampleColumns, TimeUnit};

/// Of the times in s, the specific force in m/s² and the angular rate in rad/s.
pub fn recording(
    name: &str,
    t_s: &[f64],
    accel: &[Vec<f64>; 3],
    gyro: &[Vec<f64>; 3],
) -> Result<Recording, Box<dyn std::error::Error>> {
    let columns = SampleColumns {
        time: Some(t_s),
        accel: accel.each_ref().map(|c| &c[..]),
        gyro: Some(gyro.each_ref().map(|c| &c[..])),
        ..SampleColumns::default()
    };
    let options = ReadOptions {
        accel_unit: Some(AccelUnit::MetrePerSecondSquared),
        gyro_unit: Some(GyroUnit::RadianPerSecond),
        time_unit: Some(TimeUnit::Second),
        ..ReadOptions::default()
    };
    Ok(Recording::from_samples(name, &columns, &options)?)
}
