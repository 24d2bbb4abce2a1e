//! Is a recording in the unit and range that a calibration takes? One rule for every command.

use std::path::Path;

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use super::{AccelerometerSection, CalibrationFile};
use crate::finding::finding;
use crate::recording::{AccelScale, AccelUnit, Finding, FindingKind, Origin, Recording};
use crate::{Error, Result};

/// Largest relative deviation of calibrated gravity, or of counts per g: far beyond any sensor
/// error, far below the ratio of two ranges.
const TOLERANCE: f64 = 0.2;

/// Counts per g of a recording and of a calibration, if they differ.
pub(super) fn other_range(section: &AccelerometerSection, scale: AccelScale) -> Option<[f64; 2]> {
    let is_counts = section.input_unit == AccelUnit::Counts;
    let lsb = scale.lsb_per_g.filter(|_| is_counts)?;
    let expected = section.mean_scale() * STANDARD_GRAVITY_MPS2;
    ((lsb / expected - 1.0).abs() > TOLERANCE).then_some([lsb, expected])
}

/// A recording that a calibration is applied to.
pub(crate) struct Applied<'a> {
    pub calibration: &'a CalibrationFile,
    pub recording: &'a Recording,
    /// Calibrated magnitude at rest, m/s²; `None` if no row is complete.
    pub norm_mps2: Option<f64>,
    pub gravity_mps2: f64,
    /// What rests: `its static intervals`.
    pub at_rest: &'a str,
}

impl Applied<'_> {
    /// Compares unit, counts per g and gravity.
    ///
    /// # Errors
    ///
    /// `unit-mismatch` (input). With a unit that the user gave, a wrong range or size is a finding
    /// of that kind.
    pub fn judge(&self, findings: &mut Vec<Finding>) -> Result<()> {
        let (scale, name) = (self.recording.accel_scale, &self.recording.name);
        let section = &self.calibration.accelerometer;
        let (unit, wanted) = (scale.unit, section.input_unit);
        let unknown = unit == AccelUnit::Unknown || wanted == AccelUnit::Unknown;
        if !unknown && unit != wanted {
            let source = match scale.origin {
                Origin::Given => "as given",
                Origin::Data => "according to gravity",
                Origin::Header => "according to its header",
                Origin::Assumed => "assumed",
            };
            return self.refuse(
                format!("the recording is in {unit} ({source}), the calibration is for {wanted}"),
                &format!("a calibration from recordings in {unit}"),
            );
        }
        let is_gravity = |norm: f64| (norm / self.gravity_mps2 - 1.0).abs() <= TOLERANCE;
        let measured = match self.norm_mps2 {
            Some(norm) => format!("calibrated, {} measure {norm:.2} m/s²", self.at_rest),
            None => "no row is complete".to_owned(),
        };
        let (message, other) = if let Some([lsb, expected]) = other_range(section, scale) {
            let what = format!(
                "the recording has {lsb:.0} counts per g, the calibration is for {expected:.0}: another range"
            );
            (what, "a calibration for this range")
        } else if self.norm_mps2.is_some_and(|norm| !is_gravity(norm)) {
            let what = format!(
                "{measured}, gravity is {:.2}: another sensor, range or unit",
                self.gravity_mps2
            );
            (what, "the calibration of this sensor at this setting")
        } else {
            let unverified = finding!(
                UnitUnverified,
                "the recording is in {unit}, the calibration for {wanted}; taken as the same: {measured}"
            );
            findings.extend(unknown.then(|| unverified.in_file(name)));
            return Ok(());
        };
        if scale.origin != Origin::Given {
            return self.refuse(message, other);
        }
        // Already reported if the given unit itself has the wrong size.
        let is_same = |f: &Finding| {
            let file = f.file.as_deref();
            f.kind == FindingKind::UnitMismatch && file.is_none_or(|f| f == name)
        };
        if !findings.iter().any(is_same) {
            findings.push(finding!(UnitMismatch, "{message}").in_file(name));
        }
        Ok(())
    }

    fn refuse(&self, message: String, other: &str) -> Result<()> {
        let wanted = match self.calibration.accelerometer.input_unit {
            AccelUnit::Unknown => "",
            known => known.name(),
        };
        Err(Error::input("unit-mismatch", message)
            .at(Path::new(&self.recording.name), None)
            .with_hint(format!(
                "use {other}, or give the unit to apply this one regardless"
            ))
            .advise("accel_unit", wanted))
    }
}

/// The same for a recording that is read as a whole; `norms` are the calibrated magnitudes of its
/// static intervals.
///
/// # Errors
///
/// As [`Applied::judge`].
pub(crate) fn judge_unit(
    calibration: &CalibrationFile,
    recording: &Recording,
    norms: &mut [f64],
    gravity_mps2: f64,
    findings: &mut Vec<Finding>,
) -> Result<()> {
    let applied = Applied {
        calibration,
        recording,
        norm_mps2: crate::stats::median(norms),
        gravity_mps2,
        at_rest: "its static intervals",
    };
    applied.judge(findings)
}
