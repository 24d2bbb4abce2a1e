//! Units and calibrations of a recording: what turns its numbers into SI.

use std::ops::Range;
use std::path::Path;

use gravical_core::calibration::{Calibration, GyroscopeCalibration};
use gravical_core::matrix3;

use super::options::{GravityRemoval, MotionOptions};
use crate::calibration_file::CalibrationFile;
use crate::poses::gyro_unit::{Claims, Evidence, decide, mismatch};
use crate::poses::rests::find_rests;
use crate::poses::turns::motions;
use crate::recording::{Finding, FindingKind, Recording};
use crate::{Error, Result};

/// What turns the file's numbers into SI.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales {
    /// The accelerometer, as calibrated.
    pub accel: Calibration<f64>,
    /// The gyroscope, as calibrated; none where it is not used.
    pub gyro: Option<GyroscopeCalibration<f64>>,
    /// The gyroscope's own calibration is applied.
    pub gyro_calibrated: bool,
    /// The accelerometer by its nominal scale alone.
    pub by_scale: Calibration<f64>,
    /// The gyroscope likewise.
    pub by_gyro_scale: Option<GyroscopeCalibration<f64>>,
}

impl Scales {
    /// rad/s of one unit of the file; 0 without a gyroscope.
    pub fn rate_per_unit(&self) -> f64 {
        self.by_gyro_scale.map_or(0.0, |g| g.matrix[0][0])
    }
}

/// Units and calibrations, judged by the samples.
pub(super) fn scales(
    recording: &Recording,
    file: Option<&CalibrationFile>,
    options: &MotionOptions,
    findings: &mut Vec<Finding>,
) -> Result<Scales> {
    let coarse = find_rests(recording).spans;

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
            .with_hint("say it with --accel-unit, and --accel-range for counts; or give a calibration with -c"));
        }
    };
    let by_scale = Calibration {
        matrix: matrix3::diagonal([1.0 / nominal; 3]),
        bias: [0.0; 3],
    };

    // The gyroscope.
    let scale = match &recording.gyro {
        // Nothing is turned: it has no part in the result.
        _ if options.gravity_removal != GravityRemoval::Strapdown => None,
        None => None,
        Some(gyro) if is_dead(gyro) => {
            findings.push(Finding::new(
                FindingKind::DeadGyro,
                "the gyroscope never changes; motion is computed without it",
            ));
            None
        }
        Some(_) => {
            let section = file.and_then(|f| f.gyroscope.as_ref());
            let evidence = Evidence::of(recording, &coarse, &motions(recording, &coarse));
            Claims::of(recording, section).map(|claims| decide(claims, &evidence, findings))
        }
    };
    let gyro_nominal = scale.and_then(|s| s.nominal());
    if scale.is_some() && gyro_nominal.is_none() {
        findings.push(Finding::new(
            FindingKind::GyroNotUsed,
            "the unit of the gyroscope is unknown, so it is not used: the tilt between rests is not measured; say it with --gyro-unit, and --gyro-range for counts",
        ));
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
            findings.push(Finding::new(
                FindingKind::UnitMismatch,
                format!("{why}; it is used uncalibrated"),
            ));
        }
        differs.is_none().then_some(calibration)
    });

    let by_scale = shifted(by_scale, -recording.zero_offset);
    Ok(Scales {
        accel: file.map_or(by_scale, CalibrationFile::accelerometer_calibration),
        gyro: gyro_calibration.or(by_gyro_scale),
        gyro_calibrated: gyro_calibration.is_some(),
        by_scale,
        by_gyro_scale,
    })
}

/// A calibration whose input has `by` added: the recording's columns have their
/// zero offset subtracted already, a calibration file takes the file's numbers.
fn shifted(mut calibration: Calibration<f64>, by: f64) -> Calibration<f64> {
    calibration.bias = calibration.bias.map(|b| b - by);
    calibration
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
    if norms.is_empty() {
        return Ok(());
    }
    let gravity = options.gravity.map_or(file.gravity_mps2, |g| g.value_mps2);
    let from = findings.len();
    crate::calibration_file::judge_unit(file, recording, &mut norms, gravity, findings)?;
    // A file is named once, at the end.
    findings[from..].iter_mut().for_each(|f| f.file = None);
    Ok(())
}
