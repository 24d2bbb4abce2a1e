//! The accelerometer's section of a calibration file: an estimate in numbers.

use gravical_core::matrix3;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_fit::model::{Covariance as ParameterCovariance, DRIFT};
use gravical_fit::{Fit, Trust, deviations};

use crate::calibration_file::{
    AccelerometerSection, Budget, Contribution, Covariance, PoseKind, PoseResult, Source,
};
use crate::gravity::Gravity;
use crate::poses::Pose;
use crate::recording::AccelUnit;
use crate::stats::pooled_deviation;

use super::estimate::{Basis, Estimate, Use, standard_error};
use super::session::Session;

/// Bias of an MPU6050 over temperature, m/s² per °C: ±35 mg from −40 to 85 °C on x and y, ±60 mg on z by
/// its data sheet, 0.4 mg/°C in the middle.
pub(crate) const DRIFT_MPS2_PER_C: f64 = 0.4e-3 * STANDARD_GRAVITY_MPS2;
/// k of the expanded uncertainty.
const COVERAGE: f64 = 2.0;

/// The section of an estimate.
pub(super) fn accelerometer(session: &Session<'_>, estimate: &Estimate) -> AccelerometerSection {
    let (first, gravity) = (session.recordings.first(), &session.options.gravity);
    // A zero offset is only a way of reading; what is applied to the file's own numbers carries it in
    // the bias.
    let offset = session.zero_offset();
    let scale = matrix3::row_norms(&estimate.model);
    let mut section = AccelerometerSection {
        method: session.options.estimate.method,
        input_unit: first.map_or(AccelUnit::Unknown, |r| r.accel_scale.unit),
        output_unit: AccelUnit::MetrePerSecondSquared,
        bias: estimate.calibration.bias.map(|b| b + offset),
        matrix: estimate.calibration.matrix,
        scale,
        orientation: matrix3::scale_rows(&estimate.model, &scale.map(|k| 1.0 / k)),
        poses: poses(session, estimate),
        scale_deviation_percent: session
            .nominal()
            .map(|n| scale.map(|k| 100.0 * (k / n - 1.0))),
        gravity_sd_mps2: gravity.uncertainty_mps2(),
        pose_tilt_deg: estimate.tilt,
        ..AccelerometerSection::default()
    };
    match &estimate.basis {
        Basis::Fit(fit, _) => by_fit(&mut section, &fit.0, &fit.1),
        Basis::ClosedForm(covariance) => by_ferraris(&mut section, covariance.as_deref(), gravity),
    }
    let parameters = section.parameters().zip(section.covariance_of_parameters());
    section.deviations = parameters.map(|(x, covariance)| deviations(&x, &covariance));
    section.budget = budget(&section, estimate, session);
    section
}

fn by_fit(section: &mut AccelerometerSection, fit: &Fit, trust: &Trust) {
    for (pose, left_out) in section.poses.iter_mut().zip(&trust.left_out) {
        pose.left_out_error_mps2 = left_out.map(|l| l.error_mps2);
        pose.left_out_sd_mps2 = left_out.map(|l| l.sd_mps2);
    }
    section.covariance = Some(Covariance {
        parameters: Covariance::names_with_bends(),
        values: fit.covariance().map(|row| row.to_vec()).to_vec(),
    });
    section.bends = Some(fit.bends());
    section.predicted_norm_error_mps2 = Some(trust.predicted_mps2);
    section.worst_direction = Some(trust.worst).filter(|w| w.error_mps2.is_finite());
    section.leave_one_out_rms_mps2 = trust.left_out_rms();
    // Without a pose that can be left out the data sheet alone would show an error.
    let is_tested = section.leave_one_out_rms_mps2.is_some();
    let undetected = trust.undetected.filter(|u| u.effect_mps2.is_finite());
    section.undetected = undetected.filter(|_| is_tested);
    section.fit = Some(fit.quality);
    section.next_poses = trust.next.clone();
}

/// The closed form leaves no pose out and tests none.
fn by_ferraris(
    section: &mut AccelerometerSection,
    covariance: Option<&ParameterCovariance>,
    gravity: &Gravity,
) {
    let sensor = covariance.and_then(|c| section.sensor(gravity.value_mps2, *c, 0.0));
    let Some(sensor) = sensor else {
        return;
    };
    section.predicted_norm_error_mps2 = Some(sensor.predicted_mps2()).filter(|p| p.is_finite());
    section.worst_direction = Some(sensor.weakest(COVERAGE)).filter(|w| w.error_mps2.is_finite());
    let all = sensor.covariance_with_gravity();
    let row = |i: usize| (0..DRIFT).map(|k| all[(i, k)]).collect();
    section.covariance = Some(Covariance {
        parameters: Covariance::parameter_names(),
        values: (0..DRIFT).map(row).collect(),
    });
}

fn budget(
    section: &AccelerometerSection,
    estimate: &Estimate,
    session: &Session<'_>,
) -> Option<Budget> {
    let gravity = section.gravity_sd_mps2;
    let placements = session.segmentation.poses.iter();
    let temperatures: Vec<f64> = placements.filter_map(|p| p.temperature_c).collect();
    let drift = match &temperatures[..] {
        [] => None,
        [_] => Some(0.0),
        several => Some(pooled_deviation([several].into_iter()) * drift_sd(estimate)),
    };
    let mut contributions = if let Some((_, trust)) = estimate.fit() {
        let (budget, rounding) = (trust.budget?, rounding_share(session));
        let noise = budget.noise * (1.0 - rounding * rounding).sqrt();
        vec![
            (Source::Noise, Some(noise)),
            (Source::Quantisation, Some(budget.noise * rounding)),
            (Source::ModelError, Some(budget.model_error)),
            (Source::Nonlinearity, Some(budget.bends)),
            (Source::PoseTilt, Some(budget.tilt)),
            (Source::DataSheet, Some(budget.data_sheet)),
        ]
    } else {
        let all = section.predicted_norm_error_mps2?;
        let by_readings = (all * all - gravity.powi(2)).max(0.0).sqrt();
        vec![(Source::NoiseAndTilt, Some(by_readings))]
    };
    contributions.push((Source::LocalGravity, Some(gravity)));
    contributions.push((Source::Temperature, drift));
    let known = contributions.iter().filter_map(|(_, norm)| *norm);
    let combined_mps2 = known.map(|n| n * n).sum::<f64>().sqrt();
    let contribution = |(source, norm_mps2)| Contribution { source, norm_mps2 };
    Some(Budget {
        contributions: contributions.into_iter().map(contribution).collect(),
        combined_mps2,
        coverage_factor: COVERAGE,
        expanded_mps2: COVERAGE * combined_mps2,
    })
}

/// Share of the standard errors of all means that rounding makes, root mean square.
fn rounding_share(session: &Session<'_>) -> f64 {
    let (poses, scale) = (&session.segmentation.poses, session.scale());
    let errors = poses.iter().flat_map(|p| standard_error(p, session, scale));
    let all: f64 = errors.map(|e| e * e).sum();
    let rounding = session.segmentation.noise.rounding.map(|q| q * q);
    let rounding = rounding.iter().sum::<f64>() * poses.len() as f64;
    (rounding / all).sqrt().min(1.0)
}

/// What the bias may drift by, m/s² per °C; over all directions it is that of one axis.
fn drift_sd(estimate: &Estimate) -> f64 {
    let Some(drift) = estimate.drift() else {
        return DRIFT_MPS2_PER_C;
    };
    let scale = matrix3::row_norms(&estimate.model);
    let squares = (0..3).map(|i| (drift.sd[i] / scale[i]).powi(2));
    (squares.sum::<f64>() / 3.0).sqrt()
}

/// One entry a placement: faces against ±g on their axis, free poses against gravity's length along
/// their own direction. The zero offset is added back to the raw means, so that they are the file's numbers.
fn poses(session: &Session<'_>, estimate: &Estimate) -> Vec<PoseResult> {
    let (gravity, offset) = (session.gravity_mps2(), session.zero_offset());
    let one = |(placement, used): (&Pose, &Use)| {
        let calibrated = estimate.calibration.apply(placement.mean);
        let length = matrix3::norm(&calibrated).max(f64::MIN_POSITIVE);
        let (label, kind, expected) = match used.face {
            Some(face) => {
                let expected = face.direction().map(|d| d * gravity);
                (face.name(), PoseKind::Face, expected)
            }
            None => {
                let expected = calibrated.map(|c| c / length * gravity);
                (placement.label.clone(), PoseKind::Free, expected)
            }
        };
        let error = matrix3::sub(&calibrated, &expected);
        PoseResult {
            label,
            kind,
            source: placement.source.clone(),
            rows: placement.count as u64,
            lines: Some(placement.lines),
            raw: placement.mean.map(|m| m + offset),
            expected,
            calibrated,
            error,
            error_norm: matrix3::norm(&error),
            tilt_deg: used.tilt_deg.map(|(tilt, _)| tilt),
            tilt_sd_deg: used.tilt_deg.and_then(|(_, sd)| sd),
            magnitude_error_mps2: Some(length - gravity),
            left_out_error_mps2: None,
            left_out_sd_mps2: None,
            fitted: used.fitted,
        }
    };
    let placements = session.segmentation.poses.iter();
    placements.zip(&estimate.uses).map(one).collect()
}
