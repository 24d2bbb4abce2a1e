//! Calibration of one row.

use gravical_core::calibration::{Calibration, GyroscopeCalibration};

use crate::calibration_file::CalibrationFile;
use crate::poses::face::AxisMap;
use crate::recording::row::{ACCEL, GYRO, Values};

use super::drift::Drift;

/// Calibrations of both sensors and orientation of the board.
pub(crate) struct Sensor {
    accel: Calibration<f64>,
    pub gyro: Option<GyroscopeCalibration<f64>>,
    /// The gyroscope has g-sensitivity: its calibration needs the acceleration.
    g_sensitive: bool,
    axes: AxisMap,
    rate_axes: AxisMap,
    /// Temperature drift, subtracted before calibrating.
    pub drift: Option<Drift>,
}

impl Sensor {
    pub fn new(calibration: &CalibrationFile, with_gyro: bool, axes: AxisMap) -> Self {
        let gyro = calibration.gyroscope_calibration().filter(|_| with_gyro);
        Self::of(calibration.accelerometer_calibration(), gyro, axes)
    }

    /// From values of the file to SI units.
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

    /// Adds the temperature correction.
    pub fn with_drift(mut self, drift: Option<Drift>) -> Self {
        self.drift = drift;
        self
    }

    /// Specific force in m/s² and angular rate in rad/s of the row in `line`; all axes of a
    /// sensor are NaN if one is missing.
    #[inline]
    pub fn calibrate(&mut self, values: &Values, line: u64) -> [f64; 6] {
        let mut calibrated = if self.drift.is_none() {
            self.calibrate_values(values)
        } else {
            self.calibrate_with_drift(values, line)
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

    // Separate function: the loop without a temperature model stays small.
    #[inline(never)]
    fn calibrate_with_drift(&mut self, values: &Values, line: u64) -> [f64; 6] {
        match &mut self.drift {
            Some(drift) => {
                let corrected = drift.subtract(values, line);
                self.calibrate_values(&corrected)
            }
            None => self.calibrate_values(values),
        }
    }

    #[inline]
    fn calibrate_values(&self, values: &Values) -> [f64; 6] {
        let accel = self
            .accel
            .apply([values[ACCEL], values[ACCEL + 1], values[ACCEL + 2]]);
        let [ax, ay, az] = self.axes.to_case(accel);
        let Some(gyro) = &self.gyro else {
            return [ax, ay, az, f64::NAN, f64::NAN, f64::NAN];
        };
        let accel_for_gyro = if self.g_sensitive { accel } else { [0.0; 3] };
        let rate = gyro.apply(
            [values[GYRO], values[GYRO + 1], values[GYRO + 2]],
            accel_for_gyro,
        );
        let [gx, gy, gz] = self.rate_axes.to_case(rate);
        [ax, ay, az, gx, gy, gz]
    }
}
