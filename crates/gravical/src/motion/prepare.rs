//! From a recording to samples: units, drift with temperature, values that are no measurement,
//! calibration, time.

use std::ops::Range;
use std::path::Path;

use gravical_core::calibration::{Calibration, GyroscopeCalibration};
use gravical_core::matrix3;
use gravical_motion::{Bridged, Samples, Sensor, bridge_odd};

use super::options::{MotionOptions, Procedure};
use crate::calibration_file::{CalibrationFile, TemperatureModel};
use crate::finding::finding;
use crate::poses::face::AxisMap;
use crate::poses::gyro_unit::{judge, mismatch};
use crate::poses::rests::find_rests;
use crate::recording::{Finding, Recording};
use crate::temperature::not_applied;
use crate::{Error, Result};
use gravical_recording::full_scale::FULL_SCALES_DEG_S;

/// Full scales of accelerometers, g.
const FULL_SCALES_G: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];
/// Ends of the range of 16-bit counts.
const COUNTS: f64 = 32767.0;
/// Lower spikes may be motion: five times the noise of a hand at rest, m/s² and rad/s.
const MIN_SPIKE: [f64; 2] = [5.0, 5.0];

/// Samples by the calibration, and with a calibration also by the nominal scales alone; what is odd is added to
/// `findings`.
///
/// # Errors
///
/// `rate-unknown` without time stamps and rate, `no-samples` with fewer than two.
pub(super) fn samples(
    recording: &Recording,
    scales: &Scales,
    findings: &mut Vec<Finding>,
) -> Result<(Samples, Option<Samples>)> {
    let t_s = times(recording)?;
    let rows = |channels: &[Vec<f64>; 3]| -> Vec<[f64; 3]> {
        let row = |i: usize| channels.each_ref().map(|c| c[i]);
        (0..t_s.len()).map(row).collect()
    };
    let mut force = rows(&recording.accel);
    let has_gyro = scales.nominal.gyro.is_some();
    let gyro = recording.gyro.as_ref().filter(|_| has_gyro);
    let mut rate = gyro.map(rows).unwrap_or_default();
    let axes = &scales.nominal.axes;
    let units = scales.nominal.units();
    let full_scales: [Vec<f64>; 2] = [
        FULL_SCALES_G.iter().map(|g| g * 9.80665).collect(),
        FULL_SCALES_DEG_S.iter().map(|r| r.to_radians()).collect(),
    ];
    let sensors = [
        (Sensor::Accelerometer, &mut force),
        (Sensor::Gyroscope, &mut rate),
    ];
    let (mut bridged, mut steps) = (Vec::new(), [0.0; 6]);
    for (k, (sensor, values)) in sensors.into_iter().enumerate() {
        if values.is_empty() {
            continue;
        }
        let ranges = full_scales[k].iter().map(|end| end / units[k]);
        let ranges: Vec<f64> = ranges.chain([COUNTS]).collect();
        let found = bridge_odd(&t_s, values, sensor, &ranges, MIN_SPIKE[k] / units[k]);
        bridged.extend(found.into_iter().map(|b| Bridged {
            axis: axes.case_axis(b.axis),
            sd: b.sd * units[k],
            ..b
        }));
        for axis in 0..3 {
            steps[3 * k + axes.case_axis(axis)] = recording.resolution[k][axis] * units[k];
        }
    }
    // Calibrations take the numbers of the file.
    let offset = recording.zero_offset;
    force.iter_mut().flatten().for_each(|v| *v += offset);
    let model = scales.calibrated.drift.as_ref();
    let temperature_c = model.map_or_else(Vec::new, |m| held(recording, m, findings));
    let by = |conversion: &Conversion| {
        let rows = t_s.iter().zip(&force).enumerate();
        let rows = rows.map(|(row, (t_s, force))| {
            let rate = rate.get(row).copied().unwrap_or_default();
            let t_c = temperature_c.get(row).copied().unwrap_or(f64::NAN);
            let (force, rate) = conversion.apply(*force, rate, t_c);
            (*t_s, force, rate)
        });
        let samples = Samples::new(rows, bridged.clone(), steps).with_breaks(&recording.breaks);
        if samples.len() < 2 {
            let (complete, all) = (samples.len(), t_s.len());
            let text =
                format!("{complete} of {all} rows hold a complete sample; two at least are needed");
            return Err(Error::input("no-samples", text)
                .at(Path::new(&recording.name), None)
                .with_hint("`gravical inspect` shows what is in it"));
        }
        Ok(samples)
    };
    let plain = scales.is_calibrated.then(|| by(&scales.nominal));
    Ok((by(&scales.calibrated)?, plain.transpose()?))
}

/// Seconds of each row: the stamps, else rows over the rate.
fn times(recording: &Recording) -> Result<Vec<f64>> {
    if let Some(t) = &recording.time_s {
        return Ok(t.clone());
    }
    let Some(rate) = recording.timing.rate_hz() else {
        return Err(Error::input(
            "rate-unknown",
            "there are no usable time stamps, and no rate is stated",
        )
        .at(Path::new(&recording.name), None)
        .with_hint("give the sampling rate, or the unit of the time stamps if there are any")
        .advise("rate", "")
        .advise("time_unit", ""));
    };
    Ok((0..recording.rows()).map(|i| i as f64 / rate).collect())
}

/// Temperature of each row, °C: the last one that came, before that the first; empty where none came.
fn held(recording: &Recording, model: &TemperatureModel, findings: &mut Vec<Finding>) -> Vec<f64> {
    let mut held_c = recording.temperature_c.clone().unwrap_or_default();
    let Some(mut now) = held_c.iter().copied().find(|t| t.is_finite()) else {
        findings.push(not_applied(model, "the recording has no temperatures"));
        return Vec::new();
    };
    for t in &mut held_c {
        if t.is_finite() {
            now = *t;
        }
        *t = now;
    }
    held_c
}

/// What makes SI in the axes of the case of the file's numbers.
#[derive(Debug, Clone)]
pub(super) struct Conversion {
    accel: Calibration<f64>,
    /// None where the gyroscope is not used.
    gyro: Option<GyroscopeCalibration<f64>>,
    /// Drift with temperature, as far as the calibration has a model of it.
    drift: Option<TemperatureModel>,
    axes: AxisMap,
}

impl Conversion {
    /// Specific force, m/s², and angular rate, rad/s, of a row at `t_c`, NaN where no temperature is known.
    pub fn apply(&self, force: [f64; 3], rate: [f64; 3], t_c: f64) -> ([f64; 3], Option<[f64; 3]>) {
        let drift = self.drift.as_ref().filter(|_| t_c.is_finite());
        let [x, y, z, u, v, w] = drift.map_or([0.0; 6], |model| model.drift_at(t_c));
        let force = self.accel.apply(matrix3::sub(&force, &[x, y, z]));
        let rate = self.gyro.as_ref().map(|gyro| {
            let rate = gyro.apply(matrix3::sub(&rate, &[u, v, w]), force);
            self.axes.of_rates().to_case(rate)
        });
        (self.axes.to_case(force), rate)
    }

    /// m/s² and rad/s of one unit of the file by nominal scales; 0 without a gyroscope.
    pub fn units(&self) -> [f64; 2] {
        let gyro = self.gyro.as_ref().map_or(0.0, |g| g.matrix[0][0]);
        [self.accel.matrix[0][0], gyro]
    }
}

/// Conversions of a recording.
#[derive(Debug, Clone)]
pub(super) struct Scales {
    pub calibrated: Conversion,
    /// By the nominal scales alone.
    pub nominal: Conversion,
    /// There is a calibration.
    is_calibrated: bool,
    /// The gyroscope's own calibration is applied.
    pub gyro_calibrated: bool,
}

/// Units and calibrations, judged by the samples.
pub(super) fn scales(
    recording: &Recording,
    file: Option<&CalibrationFile>,
    options: &MotionOptions,
    findings: &mut Vec<Finding>,
) -> Result<Scales> {
    let coarse = find_rests(recording);

    // The accelerometer by its nominal scale.
    let nominal = recording.accel_scale.nominal();
    if let Some(file) = file {
        judge_unit(recording, file, &coarse, options, findings)?;
        findings.extend(file.poor_finding());
    }
    let nominal = match (nominal, file) {
        (Some(n), _) => n,
        // Of unknown counts the calibration knows the scale.
        (None, Some(file)) => file.accelerometer.mean_scale(),
        (None, None) => {
            return Err(Error::input(
                "unit-unknown",
                "the unit of the accelerometer is unknown, so there is no velocity in m/s",
            )
            .at(Path::new(&recording.name), None)
            .with_hint("give it, and the range for counts; or give a calibration")
            .advise("accel_unit", "")
            .advise("accel_range", "")
            .advise("calibration", ""));
        }
    };
    // The gyroscope.
    let scale = match &recording.gyro {
        // Nothing is turned: it has no part in the result.
        _ if options.procedure != Procedure::Strapdown => None,
        None => None,
        Some(gyro) if is_dead(gyro) => {
            findings.push(finding!(
                DeadGyro,
                "the gyroscope never changes; motion is computed without it",
            ));
            None
        }
        Some(_) => {
            let section = file.and_then(|f| f.gyroscope.as_ref());
            judge(recording, section, &coarse, findings)
        }
    };
    let gyro_nominal = scale.and_then(|s| s.nominal());
    if scale.is_some() && gyro_nominal.is_none() {
        let unused = finding!(
            GyroNotUsed,
            "the unit of the gyroscope is unknown, so it is not used: the tilt between rests is not measured; give the unit, and the range for counts"
        );
        findings.push(unused.advise("gyro_unit", "").advise("gyro_range", ""));
    }
    let by_gyro_scale = gyro_nominal.map(|n| GyroscopeCalibration {
        matrix: matrix3::diagonal([1.0 / n; 3]),
        bias: [0.0; 3],
        g_sensitivity: [[0.0; 3]; 3],
    });
    let gyro_file = file
        .filter(|_| gyro_nominal.is_some())
        .and_then(|f| Some((f.gyroscope.as_ref()?, f.gyroscope_calibration()?)));
    let gyro_calibration = gyro_file.and_then(|(section, calibration)| {
        let differs = scale.and_then(|scale| mismatch(section, &scale));
        if let Some(why) = &differs {
            findings.push(finding!(UnitMismatch, "{why}; it is used uncalibrated"));
        }
        differs.is_none().then_some(calibration)
    });

    // The recording's columns have their zero offset subtracted, a calibration file takes the file's numbers.
    let nominal = Conversion {
        accel: Calibration {
            matrix: matrix3::diagonal([1.0 / nominal; 3]),
            bias: [recording.zero_offset; 3],
        },
        gyro: by_gyro_scale,
        drift: None,
        axes: options.axes,
    };
    Ok(Scales {
        calibrated: Conversion {
            accel: file.map_or(nominal.accel, CalibrationFile::accelerometer_calibration),
            gyro: gyro_calibration.or(by_gyro_scale),
            drift: file.and_then(CalibrationFile::drift_model).cloned(),
            axes: options.axes,
        },
        nominal,
        is_calibrated: file.is_some(),
        gyro_calibrated: gyro_calibration.is_some(),
    })
}

fn is_dead(gyro: &[Vec<f64>; 3]) -> bool {
    gyro.iter().all(|channel| {
        let mut some = channel.iter().filter(|v| v.is_finite());
        let first = some.next();
        some.all(|v| Some(v) == first)
    })
}

/// Holds the unit against the calibration, by the magnitude of the stills.
fn judge_unit(
    recording: &Recording,
    file: &CalibrationFile,
    coarse: &[Range<usize>],
    options: &MotionOptions,
    findings: &mut Vec<Finding>,
) -> Result<()> {
    let apply = file.accelerometer_calibration();
    let whole = 0..recording.rows();
    let spans = if coarse.is_empty() {
        std::slice::from_ref(&whole)
    } else {
        coarse
    };
    let mut norms: Vec<f64> = spans
        .iter()
        .map(|rows| {
            let (mean, _) = crate::stats::moments(&recording.accel, rows.clone());
            matrix3::norm(&apply.apply(mean.map(|m| m + recording.zero_offset)))
        })
        .filter(|n| n.is_finite())
        .collect();
    let norm @ Some(_) = crate::stats::median(&mut norms) else {
        return Ok(());
    };
    let gravity = options.gravity.map_or(file.gravity_mps2, |g| g.value_mps2);
    let at_rest = ("its static intervals", norm);
    crate::calibration_file::judge_unit(file, recording, at_rest, gravity, findings)
}
