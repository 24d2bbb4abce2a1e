//! Two calibrations in one unit: nominal m/s², so that counts and g compare.

use gravical_core::matrix3::inverse;

use crate::calibration_file::{AccelerometerSection, CalibrationFile, TiltSource};
use crate::recording::{AccelUnit, Finding, FindingKind};
use crate::uncertainty::{Covariance12, covariance_at_its_gravity, covariance_of};
use crate::{Error, Result};

/// Scales within this share of each other are of one unit and range: far beyond
/// any sensor, far below the next range.
const SAME_SCALE: f64 = 0.2;

/// One calibration: u = M a + b with u in nominal m/s².
pub(super) struct NominalModel {
    /// M, near 1.
    pub model: [[f64; 3]; 3],
    /// M⁻¹.
    pub matrix: [[f64; 3]; 3],
    /// b, m/s².
    pub bias: [f64; 3],
    /// Covariance of M and b in these units.
    pub covariance: Option<Covariance12>,
    /// Gravity of its session, m/s².
    pub gravity: f64,
    /// Tilt components that its σ_tilt was estimated from; none where that was not
    /// estimated.
    pub tilt_degrees_of_freedom: Option<f64>,
}

/// Brings both calibrations to nominal m/s².
///
/// # Errors
///
/// `units-differ` (input) where a nominal scale is not known and the units or
/// ranges are not the same; `calibration-values` for a singular matrix.
pub(super) fn sides(
    a: &CalibrationFile,
    b: &CalibrationFile,
    names: [&str; 2],
    findings: &mut Vec<Finding>,
) -> Result<[NominalModel; 2]> {
    // Two sessions that rest on one and the same gravity share its error.
    let shared = a.gravity_mps2 == b.gravity_mps2 && a.gravity_source == b.gravity_source;
    sides_with(a, b, names, shared, findings)
}

/// The same; with `without_gravity` the covariances leave out the error of gravity.
///
/// # Errors
///
/// As [`sides`].
pub(super) fn sides_with(
    a: &CalibrationFile,
    b: &CalibrationFile,
    names: [&str; 2],
    without_gravity: bool,
    findings: &mut Vec<Finding>,
) -> Result<[NominalModel; 2]> {
    let [sa, sb] = [&a.accelerometer, &b.accelerometer];
    let (per_a, per_b) = match (sa.nominal_per_mps2(), sb.nominal_per_mps2()) {
        (Some(na), Some(nb)) => (na, nb),
        _ => {
            let (ka, kb) = (mean_scale(sa), mean_scale(sb));
            let compatible = sa.input_unit == sb.input_unit
                || sa.input_unit == AccelUnit::Unknown
                || sb.input_unit == AccelUnit::Unknown;
            if !compatible || (kb / ka - 1.0).abs() > SAME_SCALE {
                return Err(units_differ(sa, sb, names));
            }
            if sa.input_unit == AccelUnit::Unknown || sb.input_unit == AccelUnit::Unknown {
                findings.push(Finding::new(
                    FindingKind::UnitUnverified,
                    format!(
                        "the input unit is {} in {} and {} in {}; their scales are alike, so they are taken as the same",
                        sa.input_unit.name(),
                        names[0],
                        sb.input_unit.name(),
                        names[1]
                    ),
                ));
            }
            // One unit for both: the nominal one where it is known, else what
            // the first calibration calls 1 m/s².
            let per = sa
                .nominal_per_mps2()
                .or(sb.nominal_per_mps2())
                .unwrap_or(ka);
            (per, per)
        }
    };
    if sa.input_unit != sb.input_unit
        && sa.nominal_per_mps2().is_some()
        && sb.nominal_per_mps2().is_some()
    {
        findings.push(Finding::new(
            FindingKind::UnitsConverted,
            format!(
                "{} takes {}, {} takes {}: both were brought to m/s² by the nominal scale",
                names[0],
                sa.input_unit.name(),
                names[1],
                sb.input_unit.name()
            ),
        ));
    }
    let offsets = [sa.zero_offset(), sb.zero_offset()];
    if offsets[0] != offsets[1] {
        findings.push(Finding::new(
            FindingKind::UnitsConverted,
            "one calibration takes unsigned counts, the other signed ones: 32768 was taken off its bias",
        ));
    }
    Ok([
        side(a, per_a, offsets[0], without_gravity, names[0])?,
        side(b, per_b, offsets[1], without_gravity, names[1])?,
    ])
}

fn side(
    file: &CalibrationFile,
    per_mps2: f64,
    offset: f64,
    without_gravity: bool,
    name: &str,
) -> Result<NominalModel> {
    let section = &file.accelerometer;
    let covariance = if without_gravity {
        covariance_at_its_gravity(section, file.gravity_mps2)
    } else {
        covariance_of(section)
    };
    let matrix = section.matrix.map(|row| row.map(|v| v * per_mps2));
    let model = inverse(&matrix).ok_or_else(|| {
        Error::input(
            "calibration-values",
            "the accelerometer's matrix is singular",
        )
        .at(name.as_ref(), None)
    })?;
    Ok(NominalModel {
        model,
        matrix,
        bias: section.bias.map(|b| (b - offset) / per_mps2),
        covariance: covariance.map(|c| c.map(|row| row.map(|v| v / (per_mps2 * per_mps2)))),
        gravity: file.gravity_mps2,
        tilt_degrees_of_freedom: section
            .fit
            .map(|fit| fit.tilt_degrees_of_freedom)
            .filter(|_| {
                section
                    .pose_tilt_deg
                    .is_some_and(|t| t.source == TiltSource::Estimated)
            }),
    })
}

fn mean_scale(section: &AccelerometerSection) -> f64 {
    section.scale.iter().sum::<f64>() / 3.0
}

fn units_differ(a: &AccelerometerSection, b: &AccelerometerSection, names: [&str; 2]) -> Error {
    let say = |s: &AccelerometerSection| {
        format!(
            "{} ({:.5} per m/s²{})",
            s.input_unit.name(),
            mean_scale(s),
            if s.nominal_per_mps2().is_none() {
                ", nominal scale unknown"
            } else {
                ""
            }
        )
    };
    Error::input(
        "units-differ",
        format!(
            "the calibrations are for different units: {} for {}, {} for {}",
            names[0],
            say(a),
            names[1],
            say(b)
        ),
    )
    .with_hint(
        "calibrate again with the range given (--accel-unit counts --accel-range 2), so that counts can be converted",
    )
}
