//! From a recording to samples: units, drift with temperature, values that are no measurement,
//! calibration, time.

use std::ops::Range;
use std::path::Path;

use gravical_calibrate::samples::{Calibrated, Columns, samples};
use gravical_core::calibration::GyroscopeCalibration;
use gravical_core::matrix3;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_motion::Samples;
use gravical_signal::interpolate_outliers;

use super::options::{MotionOptions, Procedure};
use crate::Result;
use crate::calibration_file::Calibration;
use crate::finding::{Case, RecordingCase};
use crate::poses::gyro_unit::{judge, mismatch};
use crate::poses::rests::find_rests;
use crate::problem::Problem;
use crate::recording::full_scale::FULL_SCALES_DEG_S;
use crate::recording::{Finding, Recording};
use crate::temperature::{NoTemperature, not_applied};

/// Full scales of accelerometers, g.
const FULL_SCALES_G: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];
/// End of the range of 16-bit counts.
const MAX_COUNT: f64 = 32767.0;
/// Lower spikes may be motion: five times the noise of a hand at rest, m/s² and rad/s.
const MIN_SPIKE: f64 = 5.0;

/// What a motion is computed from.
pub(super) struct Prepared {
    /// By the calibration.
    pub samples: Samples,
    /// The same rows by the nominal scales alone; none without a calibration.
    pub uncalibrated: Option<Samples>,
    /// The gyroscope's own calibration is applied.
    pub gyro_calibrated: bool,
    /// Units of the file in 1 m/s², by its nominal scale.
    pub per_mps2: f64,
}

/// Judges units and calibration by the samples, and computes samples by them; what is odd is added to `findings`.
///
/// # Errors
///
/// `unit-mismatch`, `unit-unknown`; `rate-unknown` without time stamps and rate, `no-samples` with fewer than two.
pub(super) fn prepare(
    recording: &Recording,
    file: Option<&Calibration>,
    options: &MotionOptions,
    findings: &mut Vec<Finding>,
) -> Result<Prepared> {
    let rests = find_rests(recording);
    if let Some(file) = file {
        judge_unit(recording, file, &rests, options, findings)?;
        findings.extend(file.poor_finding());
    }
    // Of unknown counts the calibration knows the scale.
    let by_file = || file.map(|file| file.accelerometer.mean_scale());
    let per_mps2 = recording.units.accel.nominal().or_else(by_file);
    let per_mps2 = per_mps2.ok_or_else(|| {
        let error = Problem::UnitUnknown.error();
        let error = error.at(Path::new(&recording.name), None);
        let error = error.advise("accel_unit", "").advise("accel_range", "");
        error.advise("calibration", "")
    })?;
    // Where nothing is turned the gyroscope has no part in the result.
    let (per_rad_s, gyro_calibration) = if options.procedure == Procedure::Strapdown {
        gyroscope(recording, file, &rests, findings)
    } else {
        (None, None)
    };
    let drift = file.and_then(Calibration::drift_model);
    let temperatures = recording.temperature_c.iter().flatten();
    if let (Some(model), false) = (drift, temperatures.copied().any(f64::is_finite)) {
        findings.push(not_applied(model, NoTemperature::NotRecorded));
    }

    let time_s = times(recording)?;
    let full_scales = FULL_SCALES_G.map(|g| g * STANDARD_GRAVITY_MPS2);
    let accel = interpolated(&time_s, &recording.accel, per_mps2, &full_scales);
    let full_scales = FULL_SCALES_DEG_S.map(f64::to_radians);
    let gyro = recording.gyro.as_ref().zip(per_rad_s);
    let gyro = gyro.map(|(read, per_rad_s)| interpolated(&time_s, read, per_rad_s, &full_scales));
    let calibrated = file.map(|file| Calibrated {
        accel: file.accelerometer_calibration(),
        gyro: gyro_calibration,
        drift,
    });
    let (samples, uncalibrated) = samples(
        recording,
        &time_s,
        &accel,
        gyro.as_ref(),
        &options.axes,
        calibrated.as_ref(),
    );
    if samples.len() < 2 {
        let (complete, rows) = (samples.len(), time_s.len());
        let error = Problem::FewSamples { complete, rows }.error();
        return Err(error.at(Path::new(&recording.name), None));
    }
    Ok(Prepared {
        uncalibrated,
        samples,
        gyro_calibrated: gyro_calibration.is_some(),
        per_mps2,
    })
}

/// Columns of a sensor with what is clipped or spiked interpolated; the full scales in SI units.
fn interpolated<'a>(
    time_s: &[f64],
    read: &'a [Vec<f64>; 3],
    per_si: f64,
    full_scales: &[f64],
) -> Columns<'a> {
    let ranges = full_scales.iter().map(|end| end * per_si);
    let ranges: Vec<f64> = ranges.chain([MAX_COUNT]).collect();
    let read = read.each_ref().map(Vec::as_slice);
    let (values, interpolated) = interpolate_outliers(time_s, read, &ranges, MIN_SPIKE * per_si);
    Columns {
        values,
        per_si,
        interpolated,
    }
}

/// Units of the file in 1 rad/s, by the nominal scale of the gyroscope, and its own calibration; none where it is not
/// used.
fn gyroscope(
    recording: &Recording,
    file: Option<&Calibration>,
    rests: &[Range<usize>],
    findings: &mut Vec<Finding>,
) -> (Option<f64>, Option<GyroscopeCalibration<f64>>) {
    let is_constant = |channel: &Vec<f64>| {
        let mut known = channel.iter().filter(|v| v.is_finite());
        let first = known.next();
        known.all(|v| Some(v) == first)
    };
    let gyro = recording.gyro.as_ref();
    if gyro.is_some_and(|gyro| gyro.iter().all(is_constant)) {
        findings.push(Case::DeadGyro.finding());
        return (None, None);
    }
    let section = file.and_then(|f| f.gyroscope.as_ref());
    let Some(scale) = judge(recording, section, rests, findings) else {
        return (None, None);
    };
    let Some(per_rad_s) = scale.nominal() else {
        let unused = Case::GyroNotUsed.finding();
        findings.push(unused.advise("gyro_unit", "").advise("gyro_range", ""));
        return (None, None);
    };
    let mut own = file.and_then(Calibration::gyroscope_calibration);
    if let Some(mismatch) = section.and_then(|section| mismatch(section, &scale)) {
        findings.push(RecordingCase::GyroUncalibrated { mismatch }.finding());
        own = None;
    }
    (Some(per_rad_s), own)
}

/// Seconds of each row: the stamps, else rows over the rate.
fn times(recording: &Recording) -> Result<Vec<f64>> {
    let by_rate = |rate: f64| (0..recording.rows()).map(|i| i as f64 / rate).collect();
    let stamps = recording.time_s.clone();
    let times = stamps.or_else(|| recording.clock.rate_hz().map(by_rate));
    times.ok_or_else(|| {
        let error = Problem::MotionWithoutRate.error();
        let error = error.at(Path::new(&recording.name), None);
        error.advise("rate", "").advise("time_unit", "")
    })
}

/// Holds the unit against the calibration, by the magnitude of the stills.
fn judge_unit(
    recording: &Recording,
    file: &Calibration,
    rests: &[Range<usize>],
    options: &MotionOptions,
    findings: &mut Vec<Finding>,
) -> Result<()> {
    let apply = file.accelerometer_calibration();
    let whole = 0..recording.rows();
    let spans = if rests.is_empty() {
        std::slice::from_ref(&whole)
    } else {
        rests
    };
    let mut norms: Vec<f64> = spans
        .iter()
        .map(|rows| {
            let (mean, _) = gravical_signal::stats::moments(&recording.accel, rows.clone());
            matrix3::norm(&apply.apply(mean.map(|m| m + recording.units.zero_offset)))
        })
        .filter(|n| n.is_finite())
        .collect();
    let norm @ Some(_) = gravical_signal::stats::median(&mut norms) else {
        return Ok(());
    };
    let gravity = options.gravity.map_or(file.gravity_mps2, |g| g.value_mps2);
    let at_rest = ("its static intervals", norm);
    crate::calibration_file::judge_unit(file, recording, at_rest, gravity, findings)
}
