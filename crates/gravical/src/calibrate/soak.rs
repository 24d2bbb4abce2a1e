//! Calibration from a soak alone: only the temperature drift.

use gravical_core::matrix3::identity;

use crate::calibration_file::{
    AccelerometerSection, CalibrationFile, FORMAT, Grade, GyroscopeSection, TemperatureRange,
    Verdict, creation_time,
};
use crate::recording::{Finding, FindingKind, Recording, Severity};
use crate::segment::check_units;
use crate::{Error, Result};

use super::{CalibrateOptions, recorded};
use crate::temperature::{study_with_levels, summary_finding};

/// A calibration that subtracts the temperature drift, from recordings of a sensor at rest while
/// its temperature falls and rises.
///
/// One pose does not determine scale and bias of the accelerometer: matrix and scale are nominal,
/// the bias is zero. The gyroscope's bias is its reading at rest at the reference temperature,
/// the middle of the soak.
///
/// # Errors
///
/// Those of [`crate::temperature::study`]; `unit-unknown`, `units-differ`, `no-recordings`.
pub fn soak_alone(recordings: &[Recording], options: &CalibrateOptions) -> Result<CalibrationFile> {
    let Some(first) = recordings.first() else {
        return Err(Error::input("no-recordings", "there is no recording"));
    };
    check_units(recordings)?;
    let Some(nominal) = first.accel_scale.nominal() else {
        return Err(Error::input(
            "unit-unknown",
            "counts of unknown range: the counts per g must be known, since a soak does not determine them",
        )
        .at(first.name.as_ref(), None)
        .with_hint("give it, for example --accel-unit counts --accel-range 2"));
    };
    let (model, levels) = study_with_levels(recordings)?;
    let mut findings: Vec<Finding> = recordings
        .iter()
        .flat_map(|r| r.findings.iter().cloned())
        .collect();
    let gyroscope = gyroscope(first, levels, &mut findings);
    findings.push(summary_finding(&model, gyroscope.is_some()));
    findings.sort_by_key(|f| std::cmp::Reverse(f.severity == Severity::Warning));
    let diagonal = |v: f64| {
        let mut m = identity();
        (0..3).for_each(|i| m[i][i] = v);
        m
    };
    Ok(CalibrationFile {
        format: FORMAT.to_owned(),
        created: creation_time(),
        tool: crate::TOOL.to_owned(),
        recorded: recorded(recordings, options),
        sensor: options.sensor.clone(),
        gravity_mps2: options.gravity.value_mps2,
        gravity_source: options.gravity.source,
        temperature_c: Some(TemperatureRange {
            mean: model.reference_c,
            min: model.range_c[0],
            max: model.range_c[1],
        }),
        accelerometer: AccelerometerSection {
            method: "thermal".to_owned(),
            input_unit: first.accel_scale.unit,
            bias: [first.zero_offset; 3],
            matrix: diagonal(1.0 / nominal),
            scale: [nominal; 3],
            ..AccelerometerSection::default()
        },
        gyroscope,
        inputs: model.inputs.clone(),
        findings,
        verdict: verdict(model.any_corrected()),
        command: options.command.clone(),
        temperature_model: Some(model),
        noise: None,
    })
}

fn gyroscope(
    first: &Recording,
    levels: [f64; 6],
    findings: &mut Vec<Finding>,
) -> Option<GyroscopeSection> {
    first.gyro.as_ref()?;
    let scale = first.gyro_scale?;
    let Some(nominal) = scale.nominal() else {
        findings.push(Finding::new(
            FindingKind::GyroUnitUnknown,
            "the unit of the gyroscope is unknown, so it cannot be calibrated to rad/s: `apply` leaves it unchanged; give the unit with --gyro-unit",
        ));
        return None;
    };
    let bias = [levels[3], levels[4], levels[5]];
    if !bias.iter().all(|b| b.is_finite()) {
        return None;
    }
    let mut matrix = identity();
    (0..3).for_each(|i| matrix[i][i] = 1.0 / nominal);
    Some(GyroscopeSection {
        method: "bias".to_owned(),
        input_unit: scale.unit,
        bias,
        matrix,
        scale: [nominal; 3],
        ..GyroscopeSection::default()
    })
}

fn verdict(any_corrected: bool) -> Verdict {
    let geometry = "a soak does not determine the geometry: matrix and scale are nominal, the bias of the accelerometer is assumed to be zero; only the temperature drift is subtracted";
    let mut reasons = Vec::new();
    if !any_corrected {
        reasons.push(
            "the drift of no channel is predictable: there is nothing to subtract".to_owned(),
        );
    }
    reasons.push(geometry.to_owned());
    Verdict {
        grade: if any_corrected {
            Grade::NotVerifiable
        } else {
            Grade::Poor
        },
        reasons,
    }
}
