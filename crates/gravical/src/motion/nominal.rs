//! Calibrated samples, as nominal scales alone read them.

use gravical_core::calibration::{Calibration, GyroscopeCalibration};
use gravical_core::matrix3;

use crate::calibration_file::TemperatureModel;
use crate::segment::face::AxisMap;

/// Drift with temperature, as far as the calibration has a model of it.
#[derive(Debug, Clone)]
pub(super) struct Drift {
    pub model: TemperatureModel,
    /// Temperature of each row, later of each sample, °C: the last one holds until the
    /// next comes.
    pub held_c: Vec<f64>,
}

/// How calibrated samples read by nominal scales alone: the calibration, and the drift with
/// temperature, back to the file's numbers. Its numbers are not held beside the samples.
#[derive(Debug, Clone)]
pub(super) struct Nominal {
    /// From SI to the file's numbers; none where the calibration's matrix is singular.
    pub accel: Option<Calibration<f64>>,
    pub by_scale: Calibration<f64>,
    pub gyro: Option<GyroscopeCalibration<f64>>,
    /// Inverse of its matrix.
    pub gyro_back: Option<[[f64; 3]; 3]>,
    pub by_gyro_scale: Option<GyroscopeCalibration<f64>>,
    pub axes: AxisMap,
    pub drift: Option<Drift>,
}

impl Nominal {
    /// A raw value as it was read at sample `i`.
    fn with_drift(&self, i: usize, channel: usize, value: f64) -> f64 {
        match &self.drift {
            Some(d) => d.model.at_temperature(channel, d.held_c[i], value),
            None => value,
        }
    }

    /// Specific force of sample `i`, m/s², which is calibrated `force`.
    #[inline]
    pub fn force(&self, i: usize, force: [f64; 3]) -> [f64; 3] {
        let Some(back) = &self.accel else {
            return [f64::NAN; 3];
        };
        let raw = back.apply(self.axes.to_board(force));
        let raw = std::array::from_fn(|c| self.with_drift(i, c, raw[c]));
        self.axes.to_case(self.by_scale.apply(raw))
    }

    /// Angular rate of sample `i`, rad/s, which are calibrated `force` and `rate`; zero
    /// without a gyroscope.
    #[inline]
    pub fn rate(&self, i: usize, force: [f64; 3], rate: [f64; 3]) -> [f64; 3] {
        let (Some(gyro), Some(scale)) = (&self.gyro, &self.by_gyro_scale) else {
            return [0.0; 3];
        };
        let axes = self.axes.of_rates();
        let Some(back) = &self.gyro_back else {
            return [f64::NAN; 3];
        };
        let own = matrix3::mul_vec(back, &axes.to_board(rate));
        let reaction = matrix3::mul_vec(&gyro.g_sensitivity, &self.axes.to_board(force));
        let raw =
            std::array::from_fn(|c| self.with_drift(i, 3 + c, own[c] + gyro.bias[c] + reaction[c]));
        // A nominal scale knows nothing of specific force.
        axes.to_case(scale.apply(raw, [0.0; 3]))
    }
}
