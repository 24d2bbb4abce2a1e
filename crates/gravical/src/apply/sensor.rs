//! What a calibration does to the values of one row.

use gravical_core::calibration::{Calibration, GyroscopeCalibration};

use crate::calibration_file::CalibrationFile;
use crate::recording::row::{ACCEL, GYRO, Values};
use crate::segment::face::AxisMap;

use super::drift::Drift;

/// Both calibrations and the way the board sits.
pub(crate) struct Sensor {
    accel: Calibration<f64>,
    pub gyro: Option<GyroscopeCalibration<f64>>,
    /// The gyroscope reacts to acceleration: without it there is no rate.
    g_sensitive: bool,
    axes: AxisMap,
    rate_axes: AxisMap,
    /// Drift with temperature, taken off before calibrating.
    pub drift: Option<Drift>,
}

impl Sensor {
    pub fn new(calibration: &CalibrationFile, with_gyro: bool, axes: AxisMap) -> Self {
        let gyro = calibration.gyroscope_calibration().filter(|_| with_gyro);
        Self::of(calibration.accelerometer_calibration(), gyro, axes)
    }

    /// From the file's numbers to SI.
    pub fn of(
        accel: Calibration<f64>,
        gyro: Option<GyroscopeCalibration<f64>>,
        axes: AxisMap,
    ) -> Self {
        Sensor {
            accel,
            g_sensitive: gyro
                .iter()
                .any(|g| g.g_sensitivity.iter().flatten().any(|v| *v != 0.0)),
            gyro,
            axes,
            rate_axes: axes.of_rates(),
            drift: None,
        }
    }

    /// Takes off `drift` as well.
    pub fn without_drift(mut self, drift: Option<Drift>) -> Self {
        self.drift = drift;
        self
    }

    /// Specific force in m/s² and angular rate in rad/s of the row in `line`; NaN on all
    /// axes of a sensor where one is missing.
    #[inline]
    pub fn calibrate(&mut self, values: &Values, line: u64) -> [f64; 6] {
        let mut calibrated = if self.drift.is_none() {
            self.steady(values)
        } else {
            self.without_drift_of(values, line)
        };
        let [ax, ay, az, gx, gy, gz] = calibrated;
        if !(ax + ay + az).is_finite() {
            calibrated[..3].fill(f64::NAN);
        }
        if self.gyro.is_some() && !(gx + gy + gz).is_finite() {
            calibrated[3..].fill(f64::NAN);
        }
        calibrated
    }

    // Most calibrations have no model of it: their loop stays as it was.
    #[inline(never)]
    fn without_drift_of(&mut self, values: &Values, line: u64) -> [f64; 6] {
        match &mut self.drift {
            Some(drift) => {
                let steady = drift.taken_off(values, line);
                self.steady(&steady)
            }
            None => self.steady(values),
        }
    }

    #[inline]
    fn steady(&self, values: &Values) -> [f64; 6] {
        let accel = self
            .accel
            .apply([values[ACCEL], values[ACCEL + 1], values[ACCEL + 2]]);
        let [ax, ay, az] = self.axes.to_case(accel);
        let Some(gyro) = &self.gyro else {
            return [ax, ay, az, f64::NAN, f64::NAN, f64::NAN];
        };
        let felt = if self.g_sensitive { accel } else { [0.0; 3] };
        let rate = gyro.apply([values[GYRO], values[GYRO + 1], values[GYRO + 2]], felt);
        let [gx, gy, gz] = self.rate_axes.to_case(rate);
        [ax, ay, az, gx, gy, gz]
    }
}
