//! What a microcontroller would call of `gravical-core`, in single precision:
//! Ferraris, the calibration of a sample of both sensors, and filters.
#![no_std]

use gravical_core::calibration::{GyroscopeCalibration, LinearCalibration};
use gravical_core::filter::biquad::{Biquad, settle, update};
use gravical_core::filter::butterworth::{Pass, design};
use gravical_core::six_position::{SixPositionMeans, ferraris_accelerometer};
use gravical_core::unit::local_gravity_mps2;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

/// Six placements of three channels: x, y, z up, then x, y, z down.
pub type Means = [[f32; 3]; 6];

fn means(values: &Means) -> SixPositionMeans<f32> {
    let [a, b, c, d, e, f] = *values;
    SixPositionMeans {
        plus: [a, b, c],
        minus: [d, e, f],
    }
}

/// Calibrates the accelerometer; 0 when it worked.
#[unsafe(no_mangle)]
pub extern "C" fn probe_accelerometer(
    readings: &Means,
    latitude_deg: f32,
    out: &mut LinearCalibration<f32>,
) -> i32 {
    let gravity = local_gravity_mps2(latitude_deg, 0.0);
    let Ok(parameters) = ferraris_accelerometer(&means(readings), gravity) else {
        return 1;
    };
    let Some(calibration) = parameters.calibration() else {
        return 2;
    };
    *out = calibration;
    0
}

/// Calibrates one sample of each sensor in place.
#[unsafe(no_mangle)]
pub extern "C" fn probe_apply(
    accelerometer: &LinearCalibration<f32>,
    gyroscope: &GyroscopeCalibration<f32>,
    accel: &mut [f32; 3],
    gyro: &mut [f32; 3],
) {
    *accel = accelerometer.apply(*accel);
    *gyro = gyroscope.apply(*gyro, *accel);
}

/// Calibrates one sample of counts of the accelerometer: what `.ci/run` counts the
/// instructions of.
#[unsafe(no_mangle)]
pub extern "C" fn probe_apply_counts(
    accelerometer: &LinearCalibration<f32>,
    counts: &[i16; 3],
    out: &mut [f32; 3],
) {
    *out = accelerometer.apply(counts.map(f32::from));
}

/// The filters of one channel: low- and high-pass.
pub struct Filters {
    low: [Biquad<f32>; 2],
    high: [Biquad<f32>; 1],
}

/// Designs the filters of a channel at `rate_hz` and starts them at `first`; 0 when
/// it worked.
#[unsafe(no_mangle)]
pub extern "C" fn probe_filter_design(rate_hz: f32, first: f32, out: &mut Option<Filters>) -> i32 {
    let mut filters = Filters {
        low: [Biquad::default(); 2],
        high: [Biquad::default(); 1],
    };
    let designed = design(Pass::Low, 4, 20.0, rate_hz, &mut filters.low)
        .and_then(|()| design(Pass::High, 2, 0.5, rate_hz, &mut filters.high));
    if designed.is_err() {
        return 1;
    }
    settle(&mut filters.low, first);
    settle(&mut filters.high, first);
    *out = Some(filters);
    0
}

/// One sample through each filter.
#[unsafe(no_mangle)]
pub extern "C" fn probe_filter(filters: &mut Filters, sample: f32, out: &mut [f32; 2]) {
    *out = [
        update(&mut filters.low, sample),
        update(&mut filters.high, sample),
    ];
}
