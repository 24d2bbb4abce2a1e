//! Checks that a calibration fits a recording: its unit and range, and the magnitude of its
//! quietest parts after calibration.

use std::path::Path;

use gravical_core::calibration::Calibration;
use gravical_recording::judge::{self, Quiet};

use crate::calibration_file::{Applied, CalibrationFile};
use crate::poses::gyro_unit;
use crate::poses::rests::find_rests;
use crate::poses::turns::motions;
use crate::recording::{
    AccelScale, AccelUnit, Finding, FindingKind, GyroUnit, Origin, ReadOptions, Recording,
};
use crate::{Error, Result};

use super::drift::Drift;

/// Standard deviation within the quietest blocks, relative to their magnitude, above which the
/// mean of a block is not gravity.
const MOVING: f64 = 0.15;

/// Tolerance for a moving sensor; the ratio of two units is always larger.
const MOVING_FACTOR: f64 = 5.0;

/// Results of the check.
pub(super) struct Judged {
    pub accel: AccelScale,
    /// Unit of the gyroscope, if it is calibrated.
    pub gyro: Option<GyroUnit>,
    pub quiet_norm_mps2: Option<f64>,
}

/// Judges the rows of `recording`: the first of a file, or all.
///
/// # Errors
///
/// `unit-mismatch` as in [`super::apply`].
pub(super) fn judge(
    calibration: &CalibrationFile,
    recording: &Recording,
    options: &ReadOptions,
    drift: Option<&Drift>,
    findings: &mut Vec<Finding>,
) -> Result<Judged> {
    let is_given = options.accel_unit.is_some() || recording.accel_scale.origin == Origin::Given;
    let raw = quiet(recording, |row| recording.accel_at(row));
    let accelerometer: Calibration<f64> = calibration.accelerometer_calibration();
    let temperature = |row: usize| {
        recording
            .temperature_c
            .as_ref()
            .map_or(f64::NAN, |t| t[row])
    };
    let calibrated = quiet(recording, |row| {
        let raw = recording.accel_at(row).map(|v| v + recording.zero_offset);
        accelerometer.apply(drift.map_or(raw, |d| d.accel_at(raw, temperature(row))))
    });
    let mut applied = Applied {
        calibration,
        name: &recording.name,
        scale: recording.accel_scale,
        given: is_given,
        norm_mps2: calibrated.map(|q| q.norm),
        gravity_mps2: calibration.gravity_mps2,
        at_rest: &format!("the quietest parts of its first {} rows", recording.rows()),
        moves: false,
    };
    let fits = applied.measures_gravity();
    let is_moving = raw.is_none_or(|q| q.spread > MOVING * q.norm);
    let wanted = calibration.accelerometer.input_unit;
    let is_assumed =
        applied.scale.unit == AccelUnit::Unknown && fits && wanted != AccelUnit::Unknown;
    if let Some(unit) = recording
        .header_unit
        .filter(|_| !is_given && !fits && is_moving)
    {
        findings.retain(|f| !is_about_unit(f));
        findings.push(Finding::new(
            FindingKind::UnitUnverified,
            format!(
                "the sensor moves throughout the first {} rows, so gravity does not determine the unit; that of the header is used",
                recording.rows()
            ),
        ));
        let is_near = |norm: f64| {
            let ratio = norm / calibration.gravity_mps2;
            (1.0 / MOVING_FACTOR..=MOVING_FACTOR).contains(&ratio)
        };
        (applied.scale.unit, applied.scale.origin) = (unit, Origin::Header);
        applied.moves = applied.norm_mps2.is_none_or(is_near);
    } else if is_assumed {
        findings.retain(|f| !is_about_unit(f));
    }
    applied.judge(findings)?;
    let mut accel = applied.scale;
    if is_assumed {
        (accel.unit, accel.lsb_per_g, accel.origin) = (wanted, None, Origin::Assumed);
    }
    let header_is_wrong = recording
        .header_unit
        .is_some_and(|claim| claim != accel.unit);
    Ok(Judged {
        accel,
        gyro: gyroscope(calibration, recording, header_is_wrong, findings)?,
        quiet_norm_mps2: applied.norm_mps2,
    })
}

fn quiet(recording: &Recording, accel: impl Fn(usize) -> [f64; 3]) -> Option<Quiet> {
    let mut axes: [Vec<f64>; 3] = Default::default();
    for row in 0..recording.rows() {
        let values = accel(row);
        axes.iter_mut()
            .zip(values)
            .for_each(|(axis, v)| axis.push(v));
    }
    judge::quiet(axes.each_ref().map(Vec::as_slice))
}

/// What gravity said of the unit in the raw values.
fn is_about_unit(finding: &Finding) -> bool {
    matches!(
        finding.kind,
        FindingKind::UnitMismatch
            | FindingKind::UnitUnknown
            | FindingKind::UnitAssumed
            | FindingKind::WrongFullScale
            | FindingKind::WithoutGravity
            | FindingKind::RangeMismatch
    )
}

/// The unit of the gyroscope, if it is to be calibrated: by the rule of [`gyro_unit`], without
/// turns where only the head is known.
fn gyroscope(
    calibration: &CalibrationFile,
    recording: &Recording,
    header_is_wrong: bool,
    findings: &mut Vec<Finding>,
) -> Result<Option<GyroUnit>> {
    let (Some(section), Some(gyro), Some(scale)) = (
        &calibration.gyroscope,
        &recording.gyro,
        recording.gyro_scale,
    ) else {
        return Ok(None);
    };
    let evidence = if recording.gyro_file.is_some() {
        let rests = find_rests(recording);
        gyro_unit::Evidence::of(recording, &rests, &motions(recording, &rests))
    } else {
        let mut evidence = gyro_unit::Evidence::default();
        evidence.add_rest(gyro, std::slice::from_ref(&(0..recording.rows())));
        evidence
    };
    let claims = gyro_unit::Claims {
        file: &recording.name,
        scale,
        calibration: Some(section),
        header_is_wrong,
    };
    let scale = gyro_unit::decide(claims, &evidence, findings);
    match gyro_unit::mismatch(section, &scale) {
        None => Ok(Some(section.input_unit)),
        Some(why) => Err(Error::input("unit-mismatch", why)
            .at(Path::new(&recording.name), None)
            .with_hint(format!(
                "give --gyro-unit {} if that is its unit",
                section.input_unit.name()
            ))),
    }
}
