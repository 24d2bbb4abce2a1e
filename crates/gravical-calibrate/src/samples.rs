//! From a recording to samples: where the units of a file, its zero offset, its drift and the axes of its sensor end.

use std::borrow::Cow;

use gravical_core::calibration::{Calibration, GyroscopeCalibration};
use gravical_core::matrix3;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_signal::{Bridged, Samples, bridge_odd};

use crate::axes::AxisMap;
use crate::calibration_file::TemperatureModel;
use crate::recording::Recording;
use crate::recording::full_scale::FULL_SCALES_DEG_S;

/// Full scales of accelerometers, g.
const FULL_SCALES_G: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];
/// Ends of the range of 16-bit counts.
const COUNTS: f64 = 32767.0;
/// Lower spikes may be motion: five times the noise of a hand at rest, m/s² and rad/s.
const MIN_SPIKE: [f64; 2] = [5.0, 5.0];

/// Sensors of a recording by their nominal scales.
#[derive(Debug, Clone, Copy)]
pub struct Nominal<'a> {
    /// Units of the file in 1 m/s².
    pub per_mps2: f64,
    /// Columns of the gyroscope, and their units in 1 rad/s; none where it is not used.
    pub gyro: Option<(&'a [Vec<f64>; 3], f64)>,
}

/// Sensors of a recording by their calibration, which takes the numbers of the file.
#[derive(Debug, Clone, Copy)]
pub struct Calibrated<'a> {
    /// The accelerometer.
    pub accel: Calibration<f64>,
    /// The gyroscope; none: by its nominal scale.
    pub gyro: Option<GyroscopeCalibration<f64>>,
    /// Drift with temperature; where none was measured, it is the last that was.
    pub drift: Option<&'a TemperatureModel>,
}

/// Samples of a recording at `time_s` (one for each row, s) in m/s² and rad/s along the axes of the case: by
/// `calibrated`, else by `nominal`; and where they are calibrated the same rows by `nominal`.
///
/// What is clipped or spiked is bridged ([`bridge_odd`]); rows that are no measurement are left out
/// ([`Samples::new`]).
pub fn samples(
    recording: &Recording,
    time_s: &[f64],
    nominal: &Nominal<'_>,
    axes: &AxisMap,
    calibrated: Option<&Calibrated<'_>>,
) -> (Samples, Option<Samples>) {
    let per_rad_s = nominal.gyro.map(|(_, per_rad_s)| per_rad_s);
    let full_scales = [
        FULL_SCALES_G.map(|g| g * STANDARD_GRAVITY_MPS2).to_vec(),
        FULL_SCALES_DEG_S.map(f64::to_radians).to_vec(),
    ];
    let sensors = [Some((&recording.accel, nominal.per_mps2)), nominal.gyro];
    let (mut values, mut bridged, mut steps) = (Vec::new(), Vec::new(), [0.0; 6]);
    for (k, (columns, per_si)) in sensors.into_iter().flatten().enumerate() {
        let ranges = full_scales[k].iter().map(|end| end * per_si);
        let ranges: Vec<f64> = ranges.chain([COUNTS]).collect();
        let columns = columns.each_ref().map(Vec::as_slice);
        let (columns, found) = bridge_odd(time_s, columns, &ranges, MIN_SPIKE[k] * per_si);
        values.push(columns);
        bridged.extend(found.into_iter().map(|b| Bridged {
            channel: 3 * k + axes.case_axis(b.channel),
            sd: b.sd / per_si,
            ..b
        }));
        for axis in 0..3 {
            steps[3 * k + axes.case_axis(axis)] = recording.units.resolution[k][axis] / per_si;
        }
    }
    let scaled = |per_si: f64| matrix3::diagonal([1.0 / per_si; 3]);
    // The recording's columns have their zero offset subtracted, a calibration takes the numbers of the file.
    let offset = recording.units.zero_offset;
    let by_scale = Calibration {
        matrix: scaled(nominal.per_mps2),
        bias: [offset; 3],
    };
    let rates_by_scale = per_rad_s.map(|per_rad_s| GyroscopeCalibration {
        matrix: scaled(per_rad_s),
        bias: [0.0; 3],
        g_sensitivity: [[0.0; 3]; 3],
    });
    let of_rates = axes.of_rates();
    let convert = |row: usize,
                   accel: &Calibration<f64>,
                   gyro: Option<GyroscopeCalibration<f64>>,
                   [x, y, z, u, v, w]: [f64; 6]| {
        let read = |sensor: &[Cow<'_, [f64]>; 3]| sensor.each_ref().map(|c| c[row]);
        let force = read(&values[0]).map(|v| v + offset);
        let force = accel.apply(matrix3::sub(&force, &[x, y, z]));
        let rate = gyro.zip(values.get(1)).map(|(gyro, rate)| {
            of_rates.to_case(gyro.apply(matrix3::sub(&read(rate), &[u, v, w]), force))
        });
        (axes.to_case(force), rate)
    };
    let accel = calibrated.map_or(by_scale, |by| by.accel);
    let gyro = calibrated.and_then(|by| by.gyro).or(rates_by_scale);
    let drift = calibrated.and_then(|by| by.drift);
    let temperature_c = recording.temperature_c.as_deref().unwrap_or_default();
    let mut now_c = temperature_c.iter().copied().find(|t| t.is_finite());
    let rows = time_s.iter().enumerate().map(|(row, time_s)| {
        let t_c = temperature_c.get(row).copied();
        now_c = t_c.filter(|t| t.is_finite()).or(now_c);
        let drift = drift.zip(now_c).map(|(model, t_c)| model.drift_at(t_c));
        let (force, rate) = convert(row, &accel, gyro, drift.unwrap_or_default());
        (*time_s, force, rate)
    });
    let samples = Samples::new(rows, bridged, steps).with_breaks(&recording.breaks);
    let plain = |row: usize| convert(row, &by_scale, rates_by_scale, [0.0; 6]);
    let plain = calibrated.map(|_| samples.with_values(plain));
    (samples, plain)
}
