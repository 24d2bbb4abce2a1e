//! Is the recording in the unit and range that the calibration takes? The rules
//! of `apply`, for a recording that is read as a whole.

use std::path::Path;

use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::calibration_file::CalibrationFile;
use crate::recording::{AccelUnit, Finding, FindingKind, Origin, Recording};
use crate::{Error, Result};

/// How far calibrated gravity, or counts per g, may be off before another unit,
/// range or sensor is meant: far beyond any drift, far below the next range.
pub(super) const TOLERANCE: f64 = 0.2;

/// Holds unit and range of `recording` against the calibration; `norms` are the
/// calibrated magnitudes of its stills.
///
/// # Errors
///
/// `unit-mismatch` (input); with a unit that the user gave, a wrong size is a
/// finding of that kind.
pub(crate) fn judge(
    calibration: &CalibrationFile,
    recording: &Recording,
    norms: &mut [f64],
    gravity: f64,
    findings: &mut Vec<Finding>,
) -> Result<()> {
    let section = &calibration.accelerometer;
    let (wanted, scale) = (section.input_unit, recording.accel_scale);
    let given = scale.origin == Origin::Given;
    let norm = crate::stats::median(norms).unwrap_or(f64::NAN);
    let fits = (norm / gravity - 1.0).abs() <= TOLERANCE;
    let name = &recording.name;
    let refuse = |message: String| {
        Err(Error::input("unit-mismatch", message)
            .at(Path::new(name), None)
            .with_hint(match wanted {
                AccelUnit::Unknown => "use the calibration of this sensor".to_owned(),
                wanted => format!(
                    "use the calibration of this sensor at this setting, or --accel-unit {} to use this one anyway",
                    wanted.name()
                ),
            }))
    };
    if wanted != AccelUnit::Unknown && scale.unit != AccelUnit::Unknown && scale.unit != wanted {
        return refuse(format!(
            "the recording is in {}, the calibration is for {}",
            scale.unit.name(),
            wanted.name()
        ));
    }
    let mut wrong = None;
    if let Some(lsb) = scale.lsb_per_g
        && wanted == AccelUnit::Counts
    {
        let expected = section.scale.iter().sum::<f64>() / 3.0 * STANDARD_GRAVITY_MPS2;
        if (lsb / expected - 1.0).abs() > TOLERANCE {
            wrong = Some(format!(
                "the recording has {lsb:.0} counts per g, the calibration is for {expected:.0}: another range"
            ));
        }
    }
    if wrong.is_none() && !fits {
        wrong = Some(format!(
            "calibrated, its static intervals measure {norm:.2} m/s², gravity is {gravity:.2}: another sensor, range or unit"
        ));
    }
    match wrong {
        Some(message) if !given => return refuse(message),
        Some(message) => {
            findings.push(Finding::new(FindingKind::UnitMismatch, message).in_file(name));
        }
        None if wanted == AccelUnit::Unknown || scale.unit == AccelUnit::Unknown => {
            findings.push(
                Finding::new(
                    FindingKind::UnitUnverified,
                    format!(
                        "the recording is in {}, the calibration for {}; taken as the same: calibrated, the static intervals measure {norm:.2} m/s²",
                        scale.unit.name(),
                        wanted.name()
                    ),
                )
                .in_file(name),
            );
        }
        None => {}
    }
    Ok(())
}
