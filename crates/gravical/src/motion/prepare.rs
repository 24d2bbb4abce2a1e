//! From a recording to samples: units, drift with temperature, values that are no measurement,
//! calibration, time.

use std::ops::Range;
use std::path::Path;

use gravical_core::calibration::{Calibration, GyroscopeCalibration};
use gravical_core::matrix3;
use gravical_motion::{Bridged, Samples, bridge_odd};

use super::options::{MotionOptions, Procedure};
use crate::calibration_file::CalibrationFile;
use crate::finding::finding;
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

/// What a motion is computed from.
pub(super) struct Prepared {
    /// By the calibration.
    pub samples: Samples,
    /// The same rows by the nominal scales alone; none without a calibration.
    pub plain: Option<Samples>,
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
    file: Option<&CalibrationFile>,
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
        Error::input(
            "unit-unknown",
            "the unit of the accelerometer is unknown, so there is no velocity in m/s",
        )
        .at(Path::new(&recording.name), None)
        .with_hint("give it, and the range for counts; or give a calibration")
        .advise("accel_unit", "")
        .advise("accel_range", "")
        .advise("calibration", "")
    })?;
    // The recording's columns have their zero offset subtracted, a calibration file takes the file's numbers.
    let accel = Calibration {
        matrix: matrix3::diagonal([1.0 / per_mps2; 3]),
        bias: [recording.units.zero_offset; 3],
    };
    // Where nothing is turned the gyroscope has no part in the result.
    let [gyro, own_gyro] = if options.procedure == Procedure::Strapdown {
        gyroscope(recording, file, &rests, findings)
    } else {
        [None; 2]
    };
    let drift = file.and_then(CalibrationFile::drift_model);

    let t_s = times(recording)?;
    let axes = &options.axes;
    let units = [accel.matrix[0][0], gyro.map_or(0.0, |g| g.matrix[0][0])];
    let full_scales = [
        FULL_SCALES_G.map(|g| g * 9.80665).to_vec(),
        FULL_SCALES_DEG_S.map(f64::to_radians).to_vec(),
    ];
    let rates = recording.gyro.as_ref().filter(|_| gyro.is_some());
    let columns = [Some(&recording.accel), rates].into_iter().flatten();
    let (mut values, mut bridged, mut steps) = ([Vec::new(), Vec::new()], Vec::new(), [0.0; 6]);
    for (k, channels) in columns.enumerate() {
        let row = |i: usize| channels.each_ref().map(|c| c[i]);
        values[k] = (0..t_s.len()).map(row).collect();
        let ranges = full_scales[k].iter().map(|end| end / units[k]);
        let ranges: Vec<f64> = ranges.chain([COUNTS]).collect();
        let min_spike = MIN_SPIKE[k] / units[k];
        let found = bridge_odd(&t_s, &mut values[k], &ranges, min_spike);
        bridged.extend(found.into_iter().map(|b| Bridged {
            channel: 3 * k + axes.case_axis(b.channel),
            sd: b.sd * units[k],
            ..b
        }));
        for axis in 0..3 {
            steps[3 * k + axes.case_axis(axis)] = recording.units.resolution[k][axis] * units[k];
        }
    }
    let [mut force, rate] = values;
    // Calibrations take the numbers of the file.
    let offset = recording.units.zero_offset;
    force.iter_mut().flatten().for_each(|v| *v += offset);
    let temperature_c = recording.temperature_c.as_deref().unwrap_or_default();
    let first_c = temperature_c.iter().copied().find(|t| t.is_finite());
    if let (Some(model), None) = (drift, first_c) {
        findings.push(not_applied(model, "the recording has no temperatures"));
    }
    // m/s² and rad/s of a row, along the axes of the case.
    let convert = |row: usize,
                   accel: Calibration<f64>,
                   gyro: Option<GyroscopeCalibration<f64>>,
                   [x, y, z, u, v, w]: [f64; 6]| {
        let force = accel.apply(matrix3::sub(&force[row], &[x, y, z]));
        let rate = gyro.zip(rate.get(row)).map(|(gyro, rate)| {
            let rate = gyro.apply(matrix3::sub(rate, &[u, v, w]), force);
            axes.of_rates().to_case(rate)
        });
        (axes.to_case(force), rate)
    };
    let own_accel = file.map(CalibrationFile::accelerometer_calibration);
    // The last that came, before that the first.
    let mut now_c = first_c;
    let rows = t_s.iter().enumerate().map(|(row, t_s)| {
        let t_c = temperature_c.get(row).copied();
        now_c = t_c.filter(|t| t.is_finite()).or(now_c);
        let drift = drift.zip(now_c).map(|(model, t_c)| model.drift_at(t_c));
        let (accel, gyro) = (own_accel.unwrap_or(accel), own_gyro.or(gyro));
        let (force, rate) = convert(row, accel, gyro, drift.unwrap_or_default());
        (*t_s, force, rate)
    });
    let samples = Samples::new(rows, bridged, steps).with_breaks(&recording.breaks);
    if samples.len() < 2 {
        let (complete, all) = (samples.len(), t_s.len());
        let text =
            format!("{complete} of {all} rows hold a complete sample; two at least are needed");
        return Err(Error::input("no-samples", text)
            .at(Path::new(&recording.name), None)
            .with_hint("`gravical inspect` shows what is in it"));
    }
    let by_nominal_scales = |row: usize| convert(row, accel, gyro, [0.0; 6]);
    Ok(Prepared {
        plain: own_accel.map(|_| samples.with_values(by_nominal_scales)),
        samples,
        gyro_calibrated: own_gyro.is_some(),
        per_mps2,
    })
}

/// The gyroscope by its nominal scale, and by its own calibration; none where it is not used.
fn gyroscope(
    recording: &Recording,
    file: Option<&CalibrationFile>,
    rests: &[Range<usize>],
    findings: &mut Vec<Finding>,
) -> [Option<GyroscopeCalibration<f64>>; 2] {
    let is_constant = |channel: &Vec<f64>| {
        let mut known = channel.iter().filter(|v| v.is_finite());
        let first = known.next();
        known.all(|v| Some(v) == first)
    };
    let gyro = recording.gyro.as_ref();
    if gyro.is_some_and(|gyro| gyro.iter().all(is_constant)) {
        findings.push(finding!(
            DeadGyro,
            "the gyroscope never changes; motion is computed without it",
        ));
        return [None; 2];
    }
    let section = file.and_then(|f| f.gyroscope.as_ref());
    let Some(scale) = judge(recording, section, rests, findings) else {
        return [None; 2];
    };
    let Some(per_rad_s) = scale.nominal() else {
        let unused = finding!(
            GyroNotUsed,
            "the unit of the gyroscope is unknown, so it is not used: the tilt between rests is not measured; give the unit, and the range for counts"
        );
        findings.push(unused.advise("gyro_unit", "").advise("gyro_range", ""));
        return [None; 2];
    };
    let nominal = GyroscopeCalibration {
        matrix: matrix3::diagonal([1.0 / per_rad_s; 3]),
        bias: [0.0; 3],
        g_sensitivity: [[0.0; 3]; 3],
    };
    let mut own = file.and_then(CalibrationFile::gyroscope_calibration);
    if let Some(why) = section.and_then(|section| mismatch(section, &scale)) {
        findings.push(finding!(UnitMismatch, "{why}; it is used uncalibrated"));
        own = None;
    }
    [Some(nominal), own]
}

/// Seconds of each row: the stamps, else rows over the rate.
fn times(recording: &Recording) -> Result<Vec<f64>> {
    let by_rate = |rate: f64| (0..recording.rows()).map(|i| i as f64 / rate).collect();
    let stamps = recording.time_s.clone();
    let times = stamps.or_else(|| recording.clock.rate_hz().map(by_rate));
    times.ok_or_else(|| {
        let text = "there are no usable time stamps, and no rate is stated";
        Error::input("rate-unknown", text)
            .at(Path::new(&recording.name), None)
            .with_hint("give the sampling rate, or the unit of the time stamps if there are any")
            .advise("rate", "")
            .advise("time_unit", "")
    })
}

/// Holds the unit against the calibration, by the magnitude of the stills.
fn judge_unit(
    recording: &Recording,
    file: &CalibrationFile,
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
            let (mean, _) = crate::stats::moments(&recording.accel, rows.clone());
            matrix3::norm(&apply.apply(mean.map(|m| m + recording.units.zero_offset)))
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
