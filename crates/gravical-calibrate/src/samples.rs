//! Converts a recording to samples in SI: units, zero offset, calibration, drift with temperature, axes.

use std::borrow::Cow;

use gravical_core::calibration::{GyroscopeCalibration, LinearCalibration};
use gravical_core::matrix3;
use gravical_signal::{Interpolated, Samples};

use crate::axes::AxisMap;
use crate::calibration_file::TemperatureModel;
use crate::recording::Recording;

/// Columns of a sensor, along its own axes.
#[derive(Debug, Clone)]
pub struct Columns<'a> {
    /// x, y, z; values that are not finite were not read.
    pub values: [Cow<'a, [f64]>; 3],
    /// Their units in 1 m/s² or 1 rad/s, by the nominal scale.
    pub per_si: f64,
    /// What in them was interpolated; deviations in their unit.
    pub interpolated: Vec<Interpolated>,
}

impl Columns<'_> {
    fn row(&self, row: usize) -> [f64; 3] {
        self.values.each_ref().map(|c| c[row])
    }
}

/// Sensors of a recording by their calibration, which takes the numbers of the file.
#[derive(Debug, Clone, Copy)]
pub struct Calibrated<'a> {
    /// The accelerometer.
    pub accel: LinearCalibration<f64>,
    /// The gyroscope; none: by its nominal scale.
    pub gyro: Option<GyroscopeCalibration<f64>>,
    /// Drift with temperature; where none was measured, it is the last that was.
    pub drift: Option<&'a TemperatureModel>,
}

/// Samples of a recording at `time_s` (one for each row, s) in m/s² and rad/s along the axes of the case: by
/// `calibrated`, whose gyroscope is not used without columns of one, else by the nominal scales; and where they are
/// calibrated the same rows by the nominal scales.
///
/// Rows that are no measurement are left out ([`Samples::new`]). What was interpolated is along the axes of the case,
/// too, its deviations in SI by the nominal scales.
pub fn samples(
    recording: &Recording,
    time_s: &[f64],
    accel: &Columns<'_>,
    gyro: Option<&Columns<'_>>,
    axes: &AxisMap,
    calibrated: Option<&Calibrated<'_>>,
) -> (Samples, Option<Samples>) {
    let (mut interpolated, mut steps) = (Vec::new(), [0.0; 6]);
    for (k, columns) in [Some(accel), gyro].into_iter().flatten().enumerate() {
        interpolated.extend(columns.interpolated.iter().map(|b| Interpolated {
            channel: 3 * k + axes.case_axis(b.channel),
            sd: b.sd / columns.per_si,
            ..b.clone()
        }));
        for axis in 0..3 {
            steps[3 * k + axes.case_axis(axis)] =
                recording.units.resolution[k][axis] / columns.per_si;
        }
    }
    let scaled = |per_si: f64| matrix3::diagonal([1.0 / per_si; 3]);
    // The recording's columns have their zero offset subtracted, a calibration takes the numbers of the file.
    let offset = recording.units.zero_offset;
    let by_scale = LinearCalibration {
        matrix: scaled(accel.per_si),
        bias: [offset; 3],
    };
    let rates_by_scale = gyro.map(|gyro| GyroscopeCalibration {
        matrix: scaled(gyro.per_si),
        bias: [0.0; 3],
        g_sensitivity: [[0.0; 3]; 3],
    });
    let of_rates = axes.of_rates();
    let convert = |row: usize,
                   by: &LinearCalibration<f64>,
                   rates_by: Option<GyroscopeCalibration<f64>>,
                   [x, y, z, u, v, w]: [f64; 6]| {
        let read = accel.row(row).map(|v| v + offset);
        let force = by.apply(matrix3::sub(&read, &[x, y, z]));
        let rate = rates_by.zip(gyro).map(|(by, gyro)| {
            let rate = matrix3::sub(&gyro.row(row), &[u, v, w]);
            of_rates.to_case(by.apply(rate, force))
        });
        (axes.to_case(force), rate)
    };
    let by = calibrated.map_or(by_scale, |by| by.accel);
    let rates_by = calibrated.and_then(|by| by.gyro).or(rates_by_scale);
    let drift = calibrated.and_then(|by| by.drift);
    let temperature_c = recording.temperature_c.as_deref().unwrap_or_default();
    let mut now_c = temperature_c.iter().copied().find(|t| t.is_finite());
    let rows = time_s.iter().enumerate().map(|(row, time_s)| {
        let t_c = temperature_c.get(row).copied();
        now_c = t_c.filter(|t| t.is_finite()).or(now_c);
        let drift = drift.zip(now_c).map(|(model, t_c)| model.drift_at(t_c));
        let (force, rate) = convert(row, &by, rates_by, drift.unwrap_or_default());
        (*time_s, force, rate)
    });
    let samples = Samples::new(rows, interpolated, steps).with_breaks(&recording.breaks);
    let uncalibrated = |row: usize| convert(row, &by_scale, rates_by_scale, [0.0; 6]);
    let uncalibrated = calibrated.map(|_| samples.with_values(uncalibrated));
    (samples, uncalibrated)
}
