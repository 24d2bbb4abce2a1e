//! Conversion of motion to readings by the part.

use gravical_core::filter::biquad::Biquad;
use gravical_core::filter::butterworth::low_pass;
use nalgebra::Vector3;

use super::options::{SensorOptions, SimulateOptions};
use super::path::MotionPath;
use super::random::{Purpose, normal, stream, three};
use super::sensor::{
    ACCEL_NOISE_MPS_RTS, GYRO_NOISE_DEG_RTS, START_TEMPERATURE_C, Sensor, TEMPERATURE_AT_ZERO_C,
    TEMPERATURE_LSB_PER_C, TEMPERATURE_NOISE_C,
};

/// Result of reading the registers once.
pub(super) struct Reading {
    /// m/s².
    pub accel: [f64; 3],
    /// rad/s.
    pub gyro: [f64; 3],
    pub temperature_c: f64,
    pub clipped: bool,
}

/// State of the part.
pub(super) struct Part {
    sensor: Sensor,
    options: SensorOptions,
    /// Second-order Butterworth. The real filter is not published; its data sheet gives a delay of
    /// 4.9 ms for the 44 Hz setting, this one has 5.1 ms.
    filters: Option<[Biquad<f64>; 6]>,
    noise: rand_chacha::ChaCha8Rng,
    accel_sd: f64,
    gyro_sd: f64,
    step_s: f64,
}

impl Part {
    /// At rest at the start of `path` for a long time, except for the noise; `file`: index of the
    /// noise stream.
    pub(super) fn new(
        sensor: &Sensor,
        options: &SimulateOptions,
        step_s: f64,
        file: usize,
        path: &MotionPath,
    ) -> Self {
        let o = &options.sensor;
        let inputs = path.inputs_at(0.0, step_s);
        let first = [
            sensor.read_accel(inputs.force, 0.0),
            sensor.read_gyro(inputs.rate, inputs.force, 0.0),
        ];
        // The options are valid: the cutoff is below half of the rate.
        let designed = |cutoff_hz| {
            let mut filter = [Biquad::default()];
            low_pass(2, cutoff_hz, 1.0 / step_s, &mut filter).ok()?;
            Some(filter)
        };
        let filters = o.low_pass_hz.and_then(designed).map(|[filter]| {
            let mut filters = [filter; 6];
            for (filter, &input) in filters.iter_mut().zip(first.iter().flatten()) {
                filter.settle(input);
            }
            filters
        });
        // White noise whose means over t have the standard deviation N/√t.
        let per_step = 1.0 / step_s.sqrt();
        Self {
            sensor: sensor.clone(),
            options: o.clone(),
            filters,
            noise: stream(options.seed, Purpose::Noise, file),
            accel_sd: o.noise_factor * ACCEL_NOISE_MPS_RTS * per_step,
            gyro_sd: o.noise_factor * GYRO_NOISE_DEG_RTS.to_radians() * per_step,
            step_s,
        }
    }

    /// One internal time step: acceleration, then angular rate.
    pub(super) fn update(&mut self, path: &MotionPath, t_s: f64, warmer_c: f64) -> [f64; 6] {
        let inputs = path.inputs_at(t_s, self.step_s);
        let accel = self.sensor.read_accel(inputs.force, warmer_c) + self.draw(self.accel_sd);
        let gyro =
            self.sensor.read_gyro(inputs.rate, inputs.force, warmer_c) + self.draw(self.gyro_sd);
        let mut values = [accel.x, accel.y, accel.z, gyro.x, gyro.y, gyro.z];
        if let Some(filters) = &mut self.filters {
            for (filter, value) in filters.iter_mut().zip(&mut values) {
                *value = filter.update(*value);
            }
        }
        values
    }

    fn draw(&mut self, sd: f64) -> Vector3<f64> {
        // Also drawn for a noise of 0: accelerometer and gyroscope share the stream, and one must
        // not depend on the noise of the other.
        sd * three(|| normal(&mut self.noise))
    }

    /// The same, as read from the registers.
    pub(super) fn read(&mut self, path: &MotionPath, t_s: f64, warmer_c: f64) -> Reading {
        let [ax, ay, az, gx, gy, gz] = self.update(path, t_s, warmer_c);
        let mut clipped = false;
        let quantise = self.options.quantise;
        let mut give = |value: f64, lsb: f64| {
            let counts = value / lsb;
            let counts = if quantise { counts.round() } else { counts };
            let limited = counts.clamp(f64::from(i16::MIN), f64::from(i16::MAX));
            clipped |= limited <= f64::from(i16::MIN) || limited >= f64::from(i16::MAX);
            limited * lsb
        };
        let (accel_lsb, gyro_lsb) = (self.sensor.accel_lsb, self.sensor.gyro_lsb);
        let accel = [ax, ay, az].map(|v| give(v, accel_lsb));
        let gyro = [gx, gy, gz].map(|v| give(v, gyro_lsb));
        let noise_c = self.options.noise_factor * TEMPERATURE_NOISE_C * normal(&mut self.noise);
        let temperature_c = START_TEMPERATURE_C + warmer_c + noise_c;
        let counts = temperature_counts(temperature_c);
        Reading {
            accel,
            gyro,
            temperature_c: if quantise {
                counts / TEMPERATURE_LSB_PER_C + TEMPERATURE_AT_ZERO_C
            } else {
                temperature_c
            },
            clipped,
        }
    }
}

/// Register value of a temperature.
pub(super) fn temperature_counts(temperature_c: f64) -> f64 {
    ((temperature_c - TEMPERATURE_AT_ZERO_C) * TEMPERATURE_LSB_PER_C).round()
}
