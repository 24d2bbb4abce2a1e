//! The gyroscope from the placements and the known turns.

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use gravical_core::six_position::{TurnIntegral, ferraris_gyroscope, g_sensitivity};

use super::Gyroscope;
use crate::calibrate::estimate::Estimate;
use crate::calibrate::ferraris::{Faces, six_positions, turns_are_singular};
use crate::calibrate::session::Session;
use crate::calibration_file::GyroscopeSection;
use crate::finding::finding;
use crate::poses::Pose;
use crate::poses::face::{Face, axes_where};
use crate::poses::turns::sample_period_s;
use crate::recording::Recording;
use crate::recording::units::GyroUnit;
use crate::{Error, Result};

/// Fits the gyroscope from its readings at rest and the known turns; nothing without turns or without all
/// six faces.
///
/// # Errors
///
/// `missing-gyro` when there are turns and no gyroscope, `rate-unknown` when
/// neither stamps nor `--rate` tell the time, `singular`.
pub(super) fn gyroscope(session: &Session<'_>, estimate: &Estimate) -> Result<Gyroscope> {
    let mut fit = Gyroscope::default();
    let (cut, gravity) = (session.segmentation, session.gravity_mps2());
    let Some(faces) = estimate.faces.as_ref().filter(|_| !cut.turns.is_empty()) else {
        return Ok(fit);
    };
    let angle_rad = session.options.segment.turn_angle_deg.to_radians();
    let missing = axes_where(|axis| cut.turns.iter().all(|t| t.axis != axis));
    if !missing.is_empty() {
        fit.findings.push(finding!(
            TurnsIncomplete,
            "no full turn about {}: the turns do not calibrate the gyroscope",
            missing.join(" and ")
        ));
        return Ok(fit);
    }
    let (bias, means) = at_rest(&cut.poses, faces)?;
    let means = six_positions(&means);
    let sensitivity = g_sensitivity(&means, gravity).map_err(turns_are_singular)?;
    let mut turns = [[0.0; 3]; 3];
    for (axis, sum) in turns.iter_mut().enumerate() {
        let about: Vec<_> = cut.turns.iter().filter(|t| t.axis == axis).collect();
        for turn in &about {
            let recording = &session.recordings[turn.recording];
            let integral = integrate(
                recording,
                turn.integrated.clone(),
                bias,
                sensitivity,
                &estimate.calibration,
            )?;
            (0..3).for_each(|i| sum[i] += integral[i] / about.len() as f64);
        }
    }
    let parameters =
        ferraris_gyroscope(bias, &means, gravity, &turns, angle_rad).map_err(turns_are_singular)?;
    let calibration = parameters.calibration().ok_or_else(|| {
        Error::input(
            "singular",
            "the three turns do not span space: were two about the same axis?",
        )
    })?;
    let in_case = session
        .axes()
        .of_rates()
        .rows_to_case(&parameters.orientation);
    let diagonal = [0, 1, 2].map(|i| in_case[i][i]);
    let backwards = axes_where(|axis| diagonal[axis] < 0.0);
    if !backwards.is_empty() {
        let degrees = angle_rad.to_degrees();
        let turned = finding!(
            TurnedOtherWay,
            "about {} the sensor turned the other way than {degrees}°, or its gyroscope is left-handed: R_g has {} on its diagonal and det {:.3}; with the angle {} it comes out right-handed",
            backwards.join(", "),
            diagonal.map(|d| format!("{d:.3}")).join(", "),
            matrix3::det(&in_case),
            -degrees,
        );
        let other_way = (-degrees).to_string();
        fit.findings.push(turned.advise("turn_angle", other_way));
    }
    let unit = cut.gyro_scale.map_or(GyroUnit::Unknown, |s| s.unit);
    fit.section = Some(GyroscopeSection {
        input_unit: unit,
        output_unit: GyroUnit::RadianPerSecond,
        bias: parameters.bias,
        matrix: calibration.matrix,
        scale: parameters.scale,
        orientation: parameters.orientation,
        g_sensitivity: parameters.g_sensitivity,
        ..GyroscopeSection::default()
    });
    Ok(fit)
}

/// Bias (mean over all samples of the six faces) and the mean of each face.
fn at_rest(placements: &[Pose], faces: &Faces) -> Result<([f64; 3], [[f64; 3]; 6])> {
    let (mut total, mut rows) = ([0.0; 3], 0);
    let mut means = [[0.0; 3]; 6];
    for (mean, face) in means.iter_mut().zip(Face::all()) {
        let (mut sum, mut count) = ([0.0; 3], 0);
        let of_face = faces.of_face[face.index()].iter();
        for (s, n) in of_face.filter_map(|&i| placements[i].gyro_sum) {
            sum = matrix3::add(&sum, &s);
            count += n;
        }
        if count == 0 {
            let what = format!(
                "the pose {} has no reading of the gyroscope, which the turns need",
                face.name()
            );
            return Err(Error::input("missing-gyro", what).with_hint(
                "record all poses with the gyroscope's columns, or leave the turns out",
            ));
        }
        total = matrix3::add(&total, &sum);
        rows += count;
        *mean = sum.map(|s| s / count as f64);
    }
    Ok((total.map(|t| t / rows as f64), means))
}

fn integrate(
    recording: &Recording,
    rows: std::ops::Range<usize>,
    bias: [f64; 3],
    sensitivity: [[f64; 3]; 3],
    accelerometer: &Calibration<f64>,
) -> Result<[f64; 3]> {
    let Some(gyro) = &recording.gyro else {
        return Err(Error::input("missing-gyro", "a turn needs a gyroscope")
            .at(recording.name.as_ref(), None));
    };
    let mut integral = TurnIntegral::new(bias, sensitivity);
    for row in rows {
        let period = sample_period_s(recording, row).ok_or_else(|| {
            Error::input(
                "rate-unknown",
                "there are no time stamps, and a turn needs the time between samples",
            )
            .at(recording.name.as_ref(), None)
            .with_hint("give the true sampling rate of this recording; a wrong one scales the gyroscope wrongly")
            .advise("rate", "")
        })?;
        let rate: [f64; 3] = std::array::from_fn(|i| gyro[i][row]);
        let accel = accelerometer.apply(recording.accel_at(row));
        if rate.iter().chain(&accel).all(|v| v.is_finite()) {
            integral.add(rate, accel, period);
        }
    }
    Ok(integral.finish())
}
