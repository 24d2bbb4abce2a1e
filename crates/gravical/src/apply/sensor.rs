//! Calibration of rows.

use gravical_core::calibration::{Calibration, GyroscopeCalibration};
use gravical_recording::Readings;

use crate::calibration_file::CalibrationFile;
use crate::poses::face::AxisMap;

use super::drift::Drift;

/// Calibrations of both sensors and orientation of the board.
pub(super) struct Sensor {
    accel: Calibration<f64>,
    gyro: Option<GyroscopeCalibration<f64>>,
    /// What was subtracted from the values of the file, in whose unit the calibration is.
    zero_offset: f64,
    axes: AxisMap,
    rate_axes: AxisMap,
    /// One m/s² in the unit of the output.
    per_mps2: f64,
    /// Temperature drift, subtracted before calibrating.
    pub drift: Option<Drift>,
}

impl Sensor {
    pub fn new(
        calibration: &CalibrationFile,
        with_gyro: bool,
        axes: AxisMap,
        zero_offset: f64,
        per_mps2: f64,
    ) -> Self {
        Sensor {
            accel: calibration.accelerometer_calibration(),
            gyro: calibration.gyroscope_calibration().filter(|_| with_gyro),
            zero_offset,
            axes,
            rate_axes: axes.of_rates(),
            per_mps2,
            drift: None,
        }
    }

    /// Adds the temperature correction.
    pub fn with_drift(mut self, drift: Option<Drift>) -> Self {
        self.drift = drift;
        self
    }

    /// Calibrates rows in place: specific force in the unit of the output, angular rate in rad/s.
    /// All axes of a sensor are NaN if one is missing. Without a calibration of the gyroscope its
    /// channels are dropped.
    pub fn calibrate(&mut self, readings: &mut Readings, lines: &[u32]) {
        if let Some(drift) = &mut self.drift {
            drift.subtract(readings, lines);
        }
        let gyro = self.gyro.as_ref();
        let is_sensitive =
            gyro.is_some_and(|g| g.g_sensitivity.iter().flatten().any(|v| *v != 0.0));
        readings.gyro = readings.gyro.take().filter(|_| gyro.is_some());
        let [ax, ay, az] = &mut readings.accel;
        let mut rates = readings.gyro.as_mut();
        for row in 0..ax.len() {
            let raw = [ax[row], ay[row], az[row]].map(|v| v + self.zero_offset);
            let accel = self.accel.apply(raw);
            if let (Some(gyro), Some([gx, gy, gz])) = (gyro, &mut rates) {
                let raw = [gx[row], gy[row], gz[row]];
                let rate = gyro.apply(raw, if is_sensitive { accel } else { [0.0; 3] });
                [gx[row], gy[row], gz[row]] = complete(self.rate_axes.to_case(rate));
            }
            let accel = complete(self.axes.to_case(accel));
            [ax[row], ay[row], az[row]] = accel.map(|v| v * self.per_mps2);
        }
    }
}

/// NaN on all axes if one is missing.
fn complete(axes: [f64; 3]) -> [f64; 3] {
    let is_complete = (axes[0] + axes[1] + axes[2]).is_finite();
    if is_complete { axes } else { [f64::NAN; 3] }
}
