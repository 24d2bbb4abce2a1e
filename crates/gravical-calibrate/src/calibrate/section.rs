//! What an estimate says of each placement, and the budget of its uncertainty.

use gravical_core::matrix3;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_fit::BiasDrift;
use gravical_signal::stats::{pooled_deviation, rms};

use crate::calibration_file::{Budget, Contribution, PoseKind, PoseResult, Source};
use crate::poses::Pose;

use super::estimate::{Estimate, standard_error};
use super::session::Session;

/// Bias of an MPU6050 over temperature, m/s² per °C: ±35 mg from −40 to 85 °C on x and y, ±60 mg on z by
/// its data sheet, 0.4 mg/°C in the middle.
pub(crate) const DRIFT_MPS2_PER_C: f64 = 0.4e-3 * STANDARD_GRAVITY_MPS2;

/// What the uncertainty of ‖a‖ at rest consists of; the means may have been brought to one temperature meanwhile.
pub(super) fn budget(session: &Session<'_>, estimate: &Estimate) -> Option<Budget> {
    let gravity = session.options.gravity.uncertainty_mps2();
    let placements = session.segmentation.poses.iter();
    let temperatures: Vec<f64> = placements.filter_map(|p| p.temperature_c).collect();
    // What the bias may drift by, m/s² per °C; over all directions it is that of one axis.
    let scale = estimate.accelerometer.scale();
    let per_c = |drift: BiasDrift| rms((0..3).map(|i| drift.sd[i] / scale[i]));
    let per_c = estimate.drift().map_or(DRIFT_MPS2_PER_C, per_c);
    let drift = match &temperatures[..] {
        [] => None,
        [_] => Some(0.0),
        several => Some(pooled_deviation([several].into_iter()) * per_c),
    };
    let mut contributions = if let Some((_, trust)) = &estimate.fit {
        let (budget, rounding) = (trust.budget?, rounding_share(session));
        let noise = budget.noise * (1.0 - rounding * rounding).sqrt();
        vec![
            (Source::Noise, Some(noise)),
            (Source::Quantisation, Some(budget.noise * rounding)),
            (Source::ModelError, Some(budget.model_error)),
            (Source::Nonlinearity, Some(budget.nonlinearity)),
            (Source::PoseTilt, Some(budget.tilt)),
            (Source::DataSheet, Some(budget.data_sheet)),
        ]
    } else {
        let all = estimate.reliability.predicted_mps2?;
        let by_readings = (all * all - gravity.powi(2)).max(0.0).sqrt();
        vec![(Source::NoiseAndTilt, Some(by_readings))]
    };
    contributions.push((Source::LocalGravity, Some(gravity)));
    contributions.push((Source::Temperature, drift));
    let contribution = |(source, norm_mps2)| Contribution { source, norm_mps2 };
    Some(Budget {
        contributions: contributions.into_iter().map(contribution).collect(),
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

/// One entry a placement: faces against ±g on their axis, free poses against gravity's length along
/// their own direction. The zero offset is added back to the raw means, so that they are the file's numbers.
pub(super) fn poses(session: &Session<'_>, estimate: &Estimate) -> Vec<PoseResult> {
    let (gravity, offset) = (session.gravity_mps2(), session.zero_offset());
    let fit = estimate.fit.as_ref();
    let one = |(index, placement): (usize, &Pose)| {
        let pose = &estimate.poses[index];
        let left_out = fit.and_then(|(_, trust)| trust.left_out[index]);
        let calibrated = estimate.calibration.apply(placement.mean);
        let (tilt_deg, tilt_sd_deg) = match pose.tilt {
            Some((tilt, sd)) => (Some(tilt.to_degrees()), Some(sd.to_degrees())),
            None => {
                let off = |up: [f64; 3]| {
                    let across = matrix3::norm(&matrix3::cross(&up, &calibrated));
                    across.atan2(matrix3::dot(&up, &calibrated)).to_degrees()
                };
                (pose.face.map(|face| off(face.direction())), None)
            }
        };
        let length = matrix3::norm(&calibrated).max(f64::MIN_POSITIVE);
        let (label, kind, expected) = match pose.face {
            Some(face) => {
                let expected = face.direction().map(|d| d * gravity);
                (face.name(), PoseKind::Face, expected)
            }
            None => {
                let expected = calibrated.map(|c| c / length * gravity);
                (placement.label.clone(), PoseKind::Free, expected)
            }
        };
        PoseResult {
            label,
            kind,
            source: placement.source.clone(),
            rows: placement.count as u64,
            lines: Some(placement.lines),
            raw: placement.mean.map(|m| m + offset),
            expected,
            calibrated,
            tilt_deg,
            tilt_sd_deg,
            magnitude_error_mps2: Some(length - gravity),
            left_out_error_mps2: left_out.map(|l| l.error_mps2),
            left_out_sd_mps2: left_out.map(|l| l.sd_mps2),
            fitted: fit.map_or(pose.face.is_some(), |_| pose.bad.is_none()),
        }
    };
    let placements = session.segmentation.poses.iter();
    placements.enumerate().map(one).collect()
}
