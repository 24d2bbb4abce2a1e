//! Checks that a calibration fits a recording: unit and range by the rules of [`decide_accel`],
//! and finally the magnitude of the quietest parts of the head after calibration.

use std::path::Path;

use crate::calibration_file::{Applied, CalibrationFile};
use crate::poses::gyro_unit;
use crate::recording::file::HeadChannels;
use crate::recording::monitor::{Facts, quiet};
use crate::recording::{
    AccelClaim, AccelScale, AccelUnit, Finding, FindingKind, GyroUnit, Origin, ReadOptions,
    decide_accel,
};
use crate::{Error, Result};

use super::drift::Drift;

/// Standard deviation within the quietest blocks, relative to their magnitude, above which the
/// mean of a block is not gravity.
const MOVING: f64 = 0.15;

/// Tolerance for a moving sensor; the ratio of two units is always larger.
const MOVING_FACTOR: f64 = 5.0;

/// What is known of the recording before its first row is calibrated.
pub(super) struct Case<'a> {
    pub calibration: &'a CalibrationFile,
    pub head: &'a HeadChannels,
    /// The head is the whole recording.
    pub whole: bool,
    pub facts: &'a Facts,
    pub claim: AccelClaim,
    pub options: &'a ReadOptions,
    pub drift: Option<&'a Drift>,
    pub name: &'a str,
}

/// Results of the check.
pub(super) struct Judged {
    pub accel: AccelScale,
    /// Unit of the gyroscope, if it is calibrated.
    pub gyro: Option<GyroUnit>,
    pub quiet_norm_mps2: Option<f64>,
}

/// # Errors
///
/// `all-zero`, and `unit-mismatch` as in [`super::apply`].
pub(super) fn judge(case: &Case<'_>, findings: &mut Vec<Finding>) -> Result<Judged> {
    let (head, options) = (case.head, case.options);
    let given = options.accel_unit.is_some();
    let all_zero = head.rows() > 0 && head.accel.iter().flatten().all(|v| *v == 0.0);
    if all_zero && (case.whole || !given) {
        return Err(all_zero_error(head.rows() as u64, case.name));
    }
    let zero_offset = case.facts.zero_offset;
    let unsigned = options.zero_offset.is_none() && zero_offset != 0.0;
    let shifted = head
        .accel
        .each_ref()
        .map(|c| c.iter().map(|v| v - zero_offset).collect());
    let raw = quiet(&shifted);
    let accelerometer = case.calibration.accelerometer_calibration();
    let calibrated = quiet(&head.calibrated(|raw, t_c| {
        accelerometer.apply(case.drift.map_or(raw, |d| d.accel_at(raw, t_c)))
    }));
    let (by_data, mut unit_findings) = {
        let mut found = Vec::new();
        let quiet = raw.map(|q| (q.norm, q.integers));
        (
            decide_accel(quiet, unsigned, case.claim, options, &mut found).0,
            found,
        )
    };
    let mut applied = Applied {
        calibration: case.calibration,
        name: case.name,
        scale: by_data,
        given,
        norm_mps2: calibrated.map(|q| q.norm),
        gravity_mps2: case.calibration.gravity_mps2,
        at_rest: &format!("the quietest parts of its first {} rows", head.rows()),
        moves: false,
    };
    let fits = applied.measures_gravity();
    let moving = raw.is_none_or(|q| q.spread > MOVING * q.norm);
    let wanted = case.calibration.accelerometer.input_unit;
    let is_assumed = by_data.unit == AccelUnit::Unknown && fits && wanted != AccelUnit::Unknown;
    if !given && !fits && moving && case.claim.unit.is_some() {
        findings.push(Finding::new(
            FindingKind::UnitUnverified,
            format!(
                "the sensor moves throughout the first {} rows, so gravity does not determine the unit; that of the header is used",
                head.rows()
            ),
        ));
        let near = |norm: f64| {
            let ratio = norm / case.calibration.gravity_mps2;
            (1.0 / MOVING_FACTOR..=MOVING_FACTOR).contains(&ratio)
        };
        applied.scale = decide_accel(None, unsigned, case.claim, options, &mut Vec::new()).0;
        applied.moves = applied.norm_mps2.is_none_or(near);
    } else if !is_assumed {
        findings.append(&mut unit_findings);
    }
    applied.judge(findings)?;
    let mut accel = applied.scale;
    if is_assumed {
        (accel.unit, accel.lsb_per_g, accel.origin) = (wanted, None, Origin::Assumed);
    }
    let header_is_wrong = (case.claim.unit).is_some_and(|claim| claim != accel.unit);
    Ok(Judged {
        accel,
        gyro: gyroscope(case, header_is_wrong, findings)?,
        quiet_norm_mps2: applied.norm_mps2,
    })
}

fn all_zero_error(rows: u64, name: &str) -> Error {
    Error::input(
        "all-zero",
        format!("the accelerometer reads zero or nothing in all {rows} rows: it did not answer"),
    )
    .at(Path::new(name), None)
    .with_hint("check the wiring (SDA, SCL, power) and that the sketch wakes the sensor")
}

/// The unit of the gyroscope, if it is to be calibrated: by the rule of [`gyro_unit`], without
/// turns, since only the head is known.
fn gyroscope(
    case: &Case<'_>,
    header_is_wrong: bool,
    findings: &mut Vec<Finding>,
) -> Result<Option<GyroUnit>> {
    let (Some(section), Some(gyro), Some(scale)) = (
        &case.calibration.gyroscope,
        &case.head.gyro,
        case.facts.gyro,
    ) else {
        return Ok(None);
    };
    let mut evidence = gyro_unit::Evidence::default();
    evidence.add_rest(gyro, std::slice::from_ref(&(0..case.head.rows())));
    let claims = gyro_unit::Claims {
        file: case.name,
        scale,
        calibration: Some(section),
        header_is_wrong,
    };
    let scale = gyro_unit::decide(claims, &evidence, findings);
    match gyro_unit::mismatch(section, &scale) {
        None => Ok(Some(section.input_unit)),
        Some(why) => Err(Error::input("unit-mismatch", why)
            .at(Path::new(case.name), None)
            .with_hint(format!(
                "give --gyro-unit {} if that is its unit",
                section.input_unit.name()
            ))),
    }
}
