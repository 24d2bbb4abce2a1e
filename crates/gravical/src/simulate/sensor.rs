//! Parameters of one virtual sensor, drawn from the seed or given.

use nalgebra::{Matrix3, Vector3};

use super::options::SimulateOptions;
use super::random::{Purpose, normal, stream, three, uniform};
use super::truth::{AccelerometerTruth, GyroscopeTruth};

/// Standard gravity, m/s²: one "g" of the part, at any location.
pub(super) const STANDARD_GRAVITY_MPS2: f64 = 9.80665;

/// Temperature at the start, °C, for which biases are given.
pub(super) const START_TEMPERATURE_C: f64 = 25.0;

/// Counts per °C and °C at count 0 (MPU6050 register map, 4.18).
pub(super) const TEMPERATURE_LSB_PER_C: f64 = 340.0;
pub(super) const TEMPERATURE_AT_ZERO_C: f64 = 36.53;

/// Widths of the errors: cross-axis ±2 % by the data sheet as an angle (sd), bias ±50 mg, gyroscope ±3 % and
/// ±2 °/s, its sensitivity to acceleration 0.1 °/s per g (sd).
const MISALIGNMENT_SD_DEG: f64 = 1.0;
const ACCEL_BIAS_MPS2: f64 = 0.5;
const GYRO_SCALE: f64 = 0.03;
const GYRO_BIAS_DEG_S: f64 = 2.0;
const G_SENSITIVITY_SD_DEG_S: f64 = 0.1;
/// White noise, Allan N, m/s/√s and °/√s; of a reading of the thermometer, °C.
pub(super) const ACCEL_NOISE_MPS_RTS: f64 = 3.3e-3;
pub(super) const GYRO_NOISE_DEG_RTS: f64 = 0.005;
pub(super) const TEMPERATURE_NOISE_C: f64 = 0.02;

/// Errors and scales of one part.
#[derive(Debug, Clone)]
pub(super) struct Sensor {
    pub accel_matrix: Matrix3<f64>,
    pub accel_bias: Vector3<f64>,
    pub accel_drift_per_c: Vector3<f64>,
    pub gyro_matrix: Matrix3<f64>,
    pub gyro_bias: Vector3<f64>,
    pub gyro_drift_per_c: Vector3<f64>,
    pub g_sensitivity: Matrix3<f64>,
    pub accel_lsb: f64,
    pub gyro_lsb: f64,
}

impl Sensor {
    /// Everything is always drawn, in this order, so that giving one parameter or changing one
    /// width leaves the others unaffected.
    pub(super) fn draw(options: &SimulateOptions) -> Self {
        let o = &options.sensor;
        let mut rng = stream(options.seed, Purpose::Parameters, 0);
        let scale_sd = o.scale_sd_percent / 100.0;
        let k = o.error_factor;
        let misalignment_sd = k * MISALIGNMENT_SD_DEG.to_radians();

        let scale = three(|| 1.0 + scale_sd * normal(&mut rng));
        let cross = matrix(|| misalignment_sd * normal(&mut rng));
        let accel_matrix = scaled_and_misaligned(scale, cross);
        let accel_bias = three(|| k * ACCEL_BIAS_MPS2 * uniform(&mut rng));
        let drift = o.bias_drift_mg_per_c * 1e-3 * STANDARD_GRAVITY_MPS2;
        let accel_drift_per_c = three(|| drift.copysign(uniform(&mut rng)));

        let scale = three(|| 1.0 + k * GYRO_SCALE * uniform(&mut rng));
        let cross = matrix(|| misalignment_sd * normal(&mut rng));
        let gyro_matrix = scaled_and_misaligned(scale, cross);
        let limit = k * GYRO_BIAS_DEG_S.to_radians();
        let gyro_bias = three(|| limit * uniform(&mut rng));
        let per_g = k * G_SENSITIVITY_SD_DEG_S.to_radians();
        let g_sensitivity = matrix(|| per_g / STANDARD_GRAVITY_MPS2 * normal(&mut rng));

        let drift = options.scenario.gyro_drift_deg_s_per_c().to_radians();
        let gyro_drift_per_c = three(|| drift.copysign(uniform(&mut rng)));

        Self {
            accel_matrix: o.accel_matrix.map_or(accel_matrix, from_rows),
            accel_bias: o.accel_bias_mps2.map_or(accel_bias, Vector3::from),
            accel_drift_per_c,
            gyro_matrix,
            gyro_bias,
            gyro_drift_per_c,
            g_sensitivity,
            accel_lsb: STANDARD_GRAVITY_MPS2 / (32768.0 / f64::from(o.accel_range_g)),
            gyro_lsb: (1.0 / o.gyro_lsb_per_deg_s().unwrap_or(f64::NAN)).to_radians(),
        }
    }

    /// Reading of the accelerometer without noise, m/s².
    pub(super) fn read_accel(&self, force: Vector3<f64>, warmer_c: f64) -> Vector3<f64> {
        self.accel_matrix * force + self.accel_bias + self.accel_drift_per_c * warmer_c
    }

    /// Reading of the gyroscope without noise, rad/s.
    pub(super) fn read_gyro(
        &self,
        rate: Vector3<f64>,
        force: Vector3<f64>,
        warmer_c: f64,
    ) -> Vector3<f64> {
        self.gyro_matrix * rate
            + self.gyro_bias
            + self.gyro_drift_per_c * warmer_c
            + self.g_sensitivity * force
    }

    pub(super) fn accel_truth(&self, options: &SimulateOptions) -> AccelerometerTruth {
        AccelerometerTruth {
            matrix: to_rows(&self.accel_matrix),
            bias_mps2: self.accel_bias.into(),
            bias_drift_mps2_per_c: self.accel_drift_per_c.into(),
            noise_mps_rts: options.sensor.noise_factor * ACCEL_NOISE_MPS_RTS,
            lsb_mps2: self.accel_lsb,
        }
    }

    pub(super) fn gyro_truth(&self, options: &SimulateOptions) -> GyroscopeTruth {
        GyroscopeTruth {
            matrix: to_rows(&self.gyro_matrix),
            bias_rad_s: self.gyro_bias.into(),
            bias_drift_rad_s_per_c: options
                .scenario
                .soak()
                .map(|_| self.gyro_drift_per_c.into()),
            g_sensitivity_rad_s_per_mps2: to_rows(&self.g_sensitivity),
            noise_rad_rts: options.sensor.noise_factor * GYRO_NOISE_DEG_RTS.to_radians(),
            lsb_rad_s: self.gyro_lsb,
        }
    }
}

/// K (I + E), E off the diagonal only.
fn scaled_and_misaligned(scale: Vector3<f64>, mut cross: Matrix3<f64>) -> Matrix3<f64> {
    cross.set_diagonal(&Vector3::repeat(1.0));
    Matrix3::from_diagonal(&scale) * cross
}

/// Nine values of `draw`, row by row.
fn matrix(mut draw: impl FnMut() -> f64) -> Matrix3<f64> {
    let mut m = Matrix3::zeros();
    for row in 0..3 {
        for column in 0..3 {
            m[(row, column)] = draw();
        }
    }
    m
}

fn from_rows(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    // nalgebra's arrays are column-major.
    Matrix3::from(rows).transpose()
}

fn to_rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    m.transpose().into()
}
