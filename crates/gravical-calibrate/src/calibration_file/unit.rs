//! Is a recording in the unit and range that a calibration takes? One rule for every command.

use std::path::Path;

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use super::{Accelerometer, Calibration};
use crate::Result;
use crate::finding::{Case, RecordingCase};
use crate::problem::Problem;
use crate::recording::{AccelScale, AccelUnit, Finding, Origin, Recording};

/// Largest relative deviation of calibrated gravity, or of counts per g: far beyond any sensor
/// error, far below the ratio of two ranges.
const TOLERANCE: f64 = 0.2;

/// Counts per g of a recording and of a calibration, if they differ.
pub fn other_range(section: &Accelerometer, scale: AccelScale) -> Option<[f64; 2]> {
    let is_counts = section.input_unit == AccelUnit::Counts;
    let lsb = scale.lsb_per_g.filter(|_| is_counts)?;
    let expected = section.mean_scale() * STANDARD_GRAVITY_MPS2;
    ((lsb / expected - 1.0).abs() > TOLERANCE).then_some([lsb, expected])
}

/// Compares unit, counts per g and gravity of a recording that a calibration is applied to: what of it is
/// `at_rest` (in words) has the calibrated magnitude `norm_mps2`, or none if no row is complete.
///
/// # Errors
///
/// `unit-mismatch` (input). With a unit that the user gave, a wrong range or size is a finding
/// of that kind.
pub fn judge_unit(
    calibration: &Calibration,
    recording: &Recording,
    (at_rest, norm_mps2): (&str, Option<f64>),
    gravity_mps2: f64,
    findings: &mut Vec<Finding>,
) -> Result<()> {
    let (scale, name) = (recording.units.accel, &recording.name);
    let section = &calibration.accelerometer;
    let (unit, wanted) = (scale.unit, section.input_unit);
    let refuse = |problem: Problem| {
        let known = Some(wanted).filter(|unit| *unit != AccelUnit::Unknown);
        let error = problem.error().at(Path::new(name), None);
        Err(error.advise("accel_unit", known.map_or("", AccelUnit::name)))
    };
    let unknown = unit == AccelUnit::Unknown || wanted == AccelUnit::Unknown;
    if !unknown && unit != wanted {
        return refuse(Problem::OtherUnit {
            unit,
            origin: scale.origin,
            wanted,
        });
    }
    let is_gravity = |norm: f64| (norm / gravity_mps2 - 1.0).abs() <= TOLERANCE;
    let other_gravity = norm_mps2.filter(|norm| !is_gravity(*norm));
    let found = if let Some([lsb_per_g, wanted_lsb_per_g]) = other_range(section, scale) {
        RecordingCase::OtherRange {
            lsb_per_g,
            wanted_lsb_per_g,
        }
    } else if let Some(norm_mps2) = other_gravity {
        RecordingCase::OtherGravity {
            at_rest: at_rest.to_owned(),
            norm_mps2,
            gravity_mps2,
        }
    } else {
        let unverified = Case::UnitTaken {
            unit,
            wanted,
            at_rest: at_rest.to_owned(),
            norm_mps2,
        };
        findings.extend(unknown.then(|| unverified.finding().in_file(name)));
        return Ok(());
    };
    if scale.origin != Origin::Given {
        return refuse(Problem::OtherSetting { found });
    }
    // Already reported if the given unit itself has the wrong size.
    if !recording.units.contradicts_given {
        findings.push(found.finding().in_file(name));
    }
    Ok(())
}
