//! What has to be known about two calibrations before their difference means
//! anything.

use crate::calibration_file::{CalibrationFile, Grade, GravitySource, PoseKind};
use crate::recording::{Finding, FindingKind};
use crate::segment::face::AXES;

/// Sessions further apart than this were at different temperatures, °C: half of
/// it moves an MPU6050's bias by less than a milli-g and a half.
pub(super) const TEMPERATURE_STEP_C: f64 = 3.0;

/// What an MPU6050's bias may move, mg per °C: ±35 mg (x, y) and ±60 mg (z) over
/// 0 to 70 °C (product specification, 6.2).
const BIAS_DRIFT_MG_PER_C: [f64; 2] = [0.5, 0.9];

/// Gravity that differs by less than this share is the same, 0.1 mm/s².
pub(super) const SAME_GRAVITY: f64 = 1e-5;

/// How far the two files are independent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Independence {
    Independent,
    /// Recordings of one are recordings of the other, too.
    SharedRecordings,
    /// The same parameters.
    Same,
}

pub(super) fn independence(
    a: &CalibrationFile,
    b: &CalibrationFile,
    findings: &mut Vec<Finding>,
) -> Independence {
    let (x, y) = (&a.accelerometer, &b.accelerometer);
    if x.matrix == y.matrix && x.bias == y.bias {
        findings.push(Finding::new(
            FindingKind::SameCalibration,
            "both files hold the same parameters: there is nothing to compare; give a calibration of another session",
        ));
        return Independence::Same;
    }
    let shared: Vec<&str> = a
        .recordings()
        .filter(|i| i.sha256.is_some() && b.recordings().any(|j| j.sha256 == i.sha256))
        .map(|i| i.path.as_str())
        .collect();
    if shared.is_empty() {
        return Independence::Independent;
    }
    findings.push(Finding::new(
        FindingKind::SameRecordings,
        format!(
            "{} of {} recordings of the first calibration went into the second one, too ({}): their errors are shared, so that agreement proves nothing",
            shared.len(),
            a.recordings().count(),
            shared[0]
        ),
    ));
    Independence::SharedRecordings
}

/// Sensor, gravity, temperature, quality.
pub(super) fn circumstances(
    a: &CalibrationFile,
    b: &CalibrationFile,
    names: [&str; 2],
    findings: &mut Vec<Finding>,
) {
    if let (Some(x), Some(y)) = (&a.sensor.id, &b.sensor.id)
        && x != y
    {
        findings.push(Finding::new(
            FindingKind::SensorDiffers,
            format!("these are two sensors: \"{x}\" and \"{y}\"; a difference is to be expected"),
        ));
    } else if let (Some(x), Some(y)) = (&a.sensor.model, &b.sensor.model)
        && x != y
    {
        findings.push(Finding::new(
            FindingKind::SensorDiffers,
            format!("these are sensors of two types: \"{x}\" and \"{y}\""),
        ));
    }
    let ratio = b.gravity_mps2 / a.gravity_mps2 - 1.0;
    if ratio.abs() > SAME_GRAVITY {
        findings.push(Finding::new(
            FindingKind::GravityDiffers,
            format!(
                "the scales rest on {:.5} m/s² ({}) and {:.5} m/s² ({}): if both sessions were in one place, {:+.3} % of scale comes from that alone; calibrate both with the same --gravity",
                a.gravity_mps2,
                source(a.gravity_source),
                b.gravity_mps2,
                source(b.gravity_source),
                -100.0 * ratio
            ),
        ));
    }
    if let (Some(x), Some(y)) = (a.temperature_c, b.temperature_c) {
        let step = (y.mean - x.mean).abs();
        if step > TEMPERATURE_STEP_C {
            let [low, high] = BIAS_DRIFT_MG_PER_C;
            findings.push(Finding::new(
                FindingKind::TemperatureDiffers,
                format!(
                    "the biases were taken at {:.1} °C and {:.1} °C: an MPU6050's may move by {low} mg per °C on x and y and {high} on z, here by {:.1} and {:.1} mg; the uncertainties do not include it",
                    x.mean,
                    y.mean,
                    low * step,
                    high * step
                ),
            ));
        }
    }
    for (file, name) in [(a, names[0]), (b, names[1])] {
        if file.accelerometer.covariance.is_none() {
            findings.push(
                Finding::new(
                    FindingKind::CovarianceMissing,
                    "the file has no covariance, so no difference can be tested; calibrate again from the recordings",
                )
                .in_file(name),
            );
        }
        if file.verdict.grade == Grade::Poor {
            findings.push(
                Finding::new(
                    FindingKind::PoorCalibration,
                    "the verdict of the calibration is poor; fix what it names before comparing",
                )
                .in_file(name),
            );
        }
    }
}

fn source(source: GravitySource) -> &'static str {
    match source {
        GravitySource::Given => "given",
        GravitySource::Latitude => "from latitude",
        GravitySource::Standard => "assumed",
    }
}

/// False where the placements do not show how the sensor sits in its case: the
/// fit says so, or there are faces on one axis at most. Files without placements
/// are believed.
pub(super) fn orientation_is_known(file: &CalibrationFile) -> bool {
    if let Some(fit) = &file.accelerometer.fit {
        return fit.oriented;
    }
    let poses = &file.accelerometer.poses;
    let axes = AXES.iter().filter(|axis| {
        poses
            .iter()
            .any(|p| p.kind == PoseKind::Face && p.label.ends_with(**axis))
    });
    poses.is_empty() || axes.count() >= 2
}
