//! One virtual sensor: its parameters, drawn from the seed or given, and its readings.

use std::array::from_fn;

use gravical_core::filter::biquad::Biquad;
use gravical_core::filter::butterworth::{Pass, design};
use gravical_core::matrix3::mul_vec;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::options::SimulateOptions;
use crate::random::{Purpose, normal, stream, uniform};
use crate::scenario::Plan;
use crate::truth::{AccelerometerTruth, GyroscopeTruth, Truth};

/// Temperature at the start, °C, for which biases are given.
const START_TEMPERATURE_C: f64 = 25.0;

/// Counts per °C and °C at count 0 (MPU6050 register map, 4.18).
const TEMPERATURE_LSB_PER_C: f64 = 340.0;
const TEMPERATURE_AT_ZERO_C: f64 = 36.53;

/// One count of the gyroscope at its range of ±250 °/s.
const GYRO_LSB_DEG_S: f64 = 1.0 / 131.0;

/// Widths of the errors: cross-axis ±2 % by the data sheet as an angle (sd), bias ±50 mg, gyroscope ±3 % and
/// ±2 °/s, its sensitivity to acceleration 0.1 °/s per g (sd).
const MISALIGNMENT_SD_DEG: f64 = 1.0;
const ACCEL_BIAS_MPS2: f64 = 0.5;
const GYRO_SCALE: f64 = 0.03;
const GYRO_BIAS_DEG_S: f64 = 2.0;
const G_SENSITIVITY_SD_DEG_S: f64 = 0.1;
/// White noise, Allan N, m/s/√s and °/√s; of a reading of the thermometer, °C.
pub(crate) const ACCEL_NOISE_MPS_RTS: f64 = 3.3e-3;
pub(crate) const GYRO_NOISE_DEG_RTS: f64 = 0.005;
const TEMPERATURE_NOISE_C: f64 = 0.02;

/// Cutoff (−3 dB) of the low-pass, Hz. It is a second-order Butterworth, since the real filter is not published:
/// its data sheet gives a delay of 4.9 ms for this setting, this one has 0.225/f, 5.1 ms.
pub(crate) const LOW_PASS_HZ: f64 = 44.0;

type Matrix = [[f64; 3]; 3];

impl Truth {
    /// The errors and scales of one part, without recordings. Everything is always drawn, in this order, so
    /// that giving one parameter or changing one width leaves the others unaffected.
    pub(crate) fn draw(options: &SimulateOptions) -> Self {
        let o = &options.sensor;
        let mut rng = stream(options.seed, Purpose::Parameters, 0);
        let scale_sd = o.scale_sd_percent / 100.0;
        let misalignment_sd = MISALIGNMENT_SD_DEG.to_radians();

        let scale = from_fn(|_| 1.0 + scale_sd * normal(&mut rng));
        let cross = from_fn(|_| from_fn(|_| misalignment_sd * normal(&mut rng)));
        let matrix = scaled_and_misaligned(scale, cross);
        let bias = from_fn(|_| ACCEL_BIAS_MPS2 * uniform(&mut rng));
        let drift = o.bias_drift_mg_per_c * 1e-3 * STANDARD_GRAVITY_MPS2;
        let accelerometer = AccelerometerTruth {
            matrix: o.accel_matrix.unwrap_or(matrix),
            bias_mps2: o.accel_bias_mps2.unwrap_or(bias),
            bias_drift_mps2_per_c: from_fn(|_| drift.copysign(uniform(&mut rng))),
            noise_mps_rts: o.noise_factor * ACCEL_NOISE_MPS_RTS,
            lsb_mps2: STANDARD_GRAVITY_MPS2 / (32768.0 / f64::from(o.accel_range_g)),
        };

        let scale = from_fn(|_| 1.0 + GYRO_SCALE * uniform(&mut rng));
        let cross = from_fn(|_| from_fn(|_| misalignment_sd * normal(&mut rng)));
        let matrix = scaled_and_misaligned(scale, cross);
        let limit = GYRO_BIAS_DEG_S.to_radians();
        let bias = from_fn(|_| limit * uniform(&mut rng));
        let per_g = G_SENSITIVITY_SD_DEG_S.to_radians();
        let per_mps2 = per_g / STANDARD_GRAVITY_MPS2;
        let g_sensitivity = from_fn(|_| from_fn(|_| per_mps2 * normal(&mut rng)));
        let gyroscope = GyroscopeTruth {
            matrix,
            bias_rad_s: bias,
            g_sensitivity_rad_s_per_mps2: g_sensitivity,
            noise_rad_rts: o.noise_factor * GYRO_NOISE_DEG_RTS.to_radians(),
            lsb_rad_s: GYRO_LSB_DEG_S.to_radians(),
        };
        Self {
            format: "gravical-truth/1".to_owned(),
            tool: gravical_recording::output::TOOL.to_owned(),
            seed: options.seed,
            gravity_mps2: options.gravity_mps2,
            accelerometer,
            gyroscope,
            files: Vec::new(),
            options: options.clone(),
        }
    }

    /// Accelerometer, m/s², then gyroscope, rad/s, without noise.
    fn measure(&self, [force, rate]: [[f64; 3]; 2], warmer_c: f64) -> [f64; 6] {
        let (a, g) = (&self.accelerometer, &self.gyroscope);
        let accel = mul_vec(&a.matrix, &force);
        let turned = mul_vec(&g.matrix, &rate);
        let bent = mul_vec(&g.g_sensitivity_rad_s_per_mps2, &force);
        from_fn(|channel| match (channel / 3, channel % 3) {
            (0, i) => accel[i] + a.bias_mps2[i] + a.bias_drift_mps2_per_c[i] * warmer_c,
            (_, i) => turned[i] + g.bias_rad_s[i] + bent[i],
        })
    }
}

/// K (I + E), E off the diagonal only.
fn scaled_and_misaligned(scale: [f64; 3], cross: Matrix) -> Matrix {
    from_fn(|i| from_fn(|j| scale[i] * if i == j { 1.0 } else { cross[i][j] }))
}

/// Result of reading the registers once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Accelerometer x, y, z, m/s².
    pub accel_mps2: [f64; 3],
    /// Gyroscope x, y, z, rad/s.
    pub gyro_rad_s: [f64; 3],
    /// Thermometer, °C.
    pub temperature_c: f64,
    /// A value of accelerometer or gyroscope is at the end of its range.
    pub is_clipped: bool,
}

impl Reading {
    /// Columns of [`row`](Self::row), with a line end.
    pub const HEADER: &str = "Timestamp (ms),aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),gX (rad/s),gY (rad/s),gZ (rad/s)\n";

    /// The reading as a line of text, as a board prints it with so many decimals.
    pub fn row(&self, stamp_ms: u64, decimals: usize) -> String {
        let ([ax, ay, az], [gx, gy, gz]) = (self.accel_mps2, self.gyro_rad_s);
        let t_c = self.temperature_c;
        format!(
            "{stamp_ms},{ax:.decimals$},{ay:.decimals$},{az:.decimals$},{t_c:.decimals$},{gx:.decimals$},{gy:.decimals$},{gz:.decimals$}\n"
        )
    }
}

/// A sensor that is switched on.
pub(crate) struct Part {
    pub truth: Truth,
    filters: [Biquad<f64>; 6],
    noise: rand_chacha::ChaCha8Rng,
    /// Of a sample of accelerometer and gyroscope, and of the thermometer.
    noise_sd: [f64; 2],
    temperature_sd_c: f64,
}

impl Part {
    /// At rest at the start of `plan` for a long time, in steps of `step_s`; `file`: index of the noise
    /// stream; `warmer_c`: °C above those of the start.
    pub(crate) fn new(
        options: &SimulateOptions,
        step_s: f64,
        file: usize,
        plan: &Plan,
        warmer_c: f64,
    ) -> Self {
        let truth = Truth::draw(options);
        let first = truth.measure(plan.force_and_rate(0.0), 0.0);
        let mut filter = [Biquad::default()];
        let designed = design(Pass::Low, 2, LOW_PASS_HZ, 1.0 / step_s, &mut filter);
        debug_assert!(designed.is_ok(), "a step is a millisecond at most");
        let mut filters = [filter[0]; 6];
        for (filter, input) in filters.iter_mut().zip(first) {
            filter.settle(input);
        }
        // White noise whose means over t have the standard deviation N/√t.
        let per_step = 1.0 / step_s.sqrt();
        let densities = [
            truth.accelerometer.noise_mps_rts,
            truth.gyroscope.noise_rad_rts,
        ];
        let mut part = Self {
            truth,
            filters,
            noise: stream(options.seed, Purpose::Noise, file),
            noise_sd: densities.map(|n| n * per_step),
            temperature_sd_c: options.sensor.noise_factor * TEMPERATURE_NOISE_C,
        };
        // The initial state of the low-pass must already be noise.
        for _ in 0..(5.0 / (LOW_PASS_HZ * step_s)).ceil() as usize {
            part.update(plan, 0.0, warmer_c);
        }
        part
    }

    /// One internal time step: accelerometer, then gyroscope.
    pub(crate) fn update(&mut self, plan: &Plan, t_s: f64, warmer_c: f64) -> [f64; 6] {
        let mut values = self.truth.measure(plan.force_and_rate(t_s), warmer_c);
        for (channel, value) in values.iter_mut().enumerate() {
            // Also drawn for a noise of 0: accelerometer and gyroscope share the stream, and one must
            // not depend on the noise of the other.
            *value += self.noise_sd[channel / 3] * normal(&mut self.noise);
        }
        for (filter, value) in self.filters.iter_mut().zip(&mut values) {
            *value = filter.update(*value);
        }
        values
    }

    /// The same, as read from the registers.
    pub(crate) fn read(&mut self, plan: &Plan, t_s: f64, warmer_c: f64) -> Reading {
        let quantise = self.truth.options.sensor.quantise;
        let lsb = [
            self.truth.accelerometer.lsb_mps2,
            self.truth.gyroscope.lsb_rad_s,
        ];
        let mut values = self.update(plan, t_s, warmer_c);
        let mut is_clipped = false;
        for (channel, value) in values.iter_mut().enumerate() {
            let lsb = lsb[channel / 3];
            let counts = *value / lsb;
            let counts = if quantise { counts.round() } else { counts };
            let limited = counts.clamp(f64::from(i16::MIN), f64::from(i16::MAX));
            is_clipped |= limited <= f64::from(i16::MIN) || limited >= f64::from(i16::MAX);
            *value = limited * lsb;
        }
        let [ax, ay, az, gx, gy, gz] = values;
        let noise_c = self.temperature_sd_c * normal(&mut self.noise);
        let temperature_c = START_TEMPERATURE_C + warmer_c + noise_c;
        Reading {
            accel_mps2: [ax, ay, az],
            gyro_rad_s: [gx, gy, gz],
            temperature_c: if quantise {
                temperature_counts(temperature_c) / TEMPERATURE_LSB_PER_C + TEMPERATURE_AT_ZERO_C
            } else {
                temperature_c
            },
            is_clipped,
        }
    }
}

/// Register value of a temperature.
pub(crate) fn temperature_counts(temperature_c: f64) -> f64 {
    ((temperature_c - TEMPERATURE_AT_ZERO_C) * TEMPERATURE_LSB_PER_C).round()
}
