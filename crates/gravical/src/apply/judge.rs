//! Checks that a calibration fits a recording: unit and range by the rules of [`decide_accel`],
//! and finally the magnitude of the quietest parts of the head after calibration.

use std::path::Path;

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::calibration_file::CalibrationFile;
use crate::recording::monitor::{Facts, Quiet, quiet};
use crate::recording::text::HeadChannels;
use crate::recording::{
    AccelClaim, AccelScale, AccelUnit, Finding, FindingKind, GyroUnit, Origin, ReadOptions,
    decide_accel,
};
use crate::segment::gyro_unit;
use crate::{Error, Result};

use super::drift::Drift;

/// Largest relative deviation of calibrated gravity, or of counts per g: far beyond any sensor
/// error, far below the ratio of two ranges.
const TOLERANCE: f64 = 0.2;

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
    let fit = Fit {
        calibration: case.calibration,
        given,
        rows: head.rows(),
        moving: raw.is_none_or(|q| q.spread > MOVING * q.norm),
        norm_mps2: calibrated.map(|q| q.norm),
        name: case.name,
    };
    let accel = fit.accelerometer(raw, unsigned, case.claim, options, findings)?;
    let header_is_wrong = (case.claim.unit).is_some_and(|claim| claim != accel.unit);
    Ok(Judged {
        accel,
        gyro: gyroscope(case, header_is_wrong, findings)?,
        quiet_norm_mps2: fit.norm_mps2,
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

fn mismatch(message: String, hint: &str, name: &str) -> Error {
    Error::input("unit-mismatch", message)
        .at(Path::new(name), None)
        .with_hint(hint)
}

struct Fit<'a> {
    calibration: &'a CalibrationFile,
    /// The user gave the unit.
    given: bool,
    rows: usize,
    moving: bool,
    /// Calibrated magnitude of the quietest parts.
    norm_mps2: Option<f64>,
    name: &'a str,
}

impl Fit<'_> {
    fn accelerometer(
        &self,
        raw: Option<Quiet>,
        unsigned: bool,
        claim: AccelClaim,
        options: &ReadOptions,
        findings: &mut Vec<Finding>,
    ) -> Result<AccelScale> {
        let wanted = self.calibration.accelerometer.input_unit;
        let gravity = self.calibration.gravity_mps2;
        let ratio = self.norm_mps2.map(|norm| norm / gravity);
        let fits = ratio.is_some_and(|r| (r - 1.0).abs() <= TOLERANCE);
        let measured = match self.norm_mps2 {
            Some(norm) => format!("calibrated, its quietest parts measure {norm:.2} m/s²"),
            None => "no row of its head is complete".to_owned(),
        };
        let mut unit_findings = Vec::new();
        let (by_data, _) = decide_accel(
            raw.map(|q| (q.norm, q.integers)),
            unsigned,
            claim,
            options,
            &mut unit_findings,
        );
        let by_header = !self.given && !fits && self.moving && claim.unit.is_some();
        let accel = if by_header {
            findings.push(Finding::new(
                FindingKind::UnitUnverified,
                format!(
                    "the sensor moves throughout the first {} rows, so gravity does not determine the unit; that of the header is used",
                    self.rows
                ),
            ));
            decide_accel(None, unsigned, claim, options, &mut Vec::new()).0
        } else if by_data.unit == AccelUnit::Unknown && fits && wanted != AccelUnit::Unknown {
            findings.push(Finding::new(
                FindingKind::UnitUnverified,
                format!(
                    "the recording's unit is unknown; that of the calibration, {}, is assumed: {measured}",
                    wanted.name()
                ),
            ));
            AccelScale {
                unit: wanted,
                lsb_per_g: None,
                origin: Origin::Assumed,
            }
        } else {
            findings.append(&mut unit_findings);
            by_data
        };
        if wanted == AccelUnit::Unknown {
            findings.push(Finding::new(
                FindingKind::UnitUnverified,
                format!(
                    "the calibration does not give its input unit; applied to values in {}: {measured}",
                    accel.unit.name()
                ),
            ));
        } else if accel.unit != AccelUnit::Unknown && accel.unit != wanted {
            return Err(self.wrong_unit(accel));
        }
        self.check_range(accel, findings)?;
        let near =
            by_header && ratio.is_none_or(|r| (1.0 / MOVING_FACTOR..=MOVING_FACTOR).contains(&r));
        if ratio.is_some() && !fits && !near {
            let message = format!(
                "in the first {} rows the recording does not fit the calibration: {measured}, gravity is {gravity:.2}; another sensor, range or unit",
                self.rows
            );
            if !self.given {
                return Err(mismatch(
                    message,
                    &self.hint("the calibration of this sensor"),
                    self.name,
                ));
            }
            // Already reported if the unit itself has the wrong size.
            if !findings.iter().any(|f| f.kind == FindingKind::UnitMismatch) {
                findings.push(Finding::new(FindingKind::UnitMismatch, message));
            }
        }
        Ok(accel)
    }

    /// Hint for a refusal.
    fn hint(&self, other: &str) -> String {
        let wanted = match self.calibration.accelerometer.input_unit {
            AccelUnit::Unknown => "UNIT",
            known => known.name(),
        };
        format!("use {other}, or --accel-unit {wanted} to apply this one regardless")
    }

    fn wrong_unit(&self, accel: AccelScale) -> Error {
        let wanted = self.calibration.accelerometer.input_unit.name();
        let source = match accel.origin {
            Origin::Given => "according to --accel-unit",
            Origin::Data => "according to gravity",
            Origin::Header => "according to its header",
            Origin::Assumed => "assumed",
        };
        mismatch(
            format!(
                "the recording is in {} ({source}), the calibration is for {wanted}",
                accel.unit.name()
            ),
            &self.hint(&format!(
                "a calibration from recordings in {}",
                accel.unit.name()
            )),
            self.name,
        )
    }

    /// Counts at another range have the same unit.
    fn check_range(&self, accel: AccelScale, findings: &mut Vec<Finding>) -> Result<()> {
        let section = &self.calibration.accelerometer;
        let Some(lsb) = accel.lsb_per_g else {
            return Ok(());
        };
        let expected = section.scale.iter().sum::<f64>() / 3.0 * STANDARD_GRAVITY_MPS2;
        let counts = accel.unit == AccelUnit::Counts && section.input_unit == AccelUnit::Counts;
        if !counts || (lsb / expected - 1.0).abs() <= TOLERANCE {
            return Ok(());
        }
        let message = format!(
            "the recording has {lsb:.0} counts per g, the calibration is for {expected:.0}: another range"
        );
        if self.given {
            findings.push(Finding::new(FindingKind::UnitMismatch, message));
            return Ok(());
        }
        Err(mismatch(
            message,
            &self.hint("a calibration for this range"),
            self.name,
        ))
    }
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
        Some(why) => Err(mismatch(
            why,
            &format!(
                "give --gyro-unit {} if that is its unit",
                section.input_unit.name()
            ),
            case.name,
        )),
    }
}
