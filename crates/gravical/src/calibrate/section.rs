//! The accelerometer's section of a calibration file: an estimate in numbers.

use gravical_core::matrix3;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;
use gravical_fit::model::Covariance as ParameterCovariance;
use gravical_fit::model::DRIFT;
use gravical_fit::{Sensor, deviations};

use crate::calibration_file::{
    AccelerometerSection, Budget, Contribution, Covariance, Deviations, FitErrors, FitQuality,
    PoseKind, PoseResult, Source, TemperatureRange, WorstDirection,
};
use crate::gravity::Gravity;
use crate::poses::Pose;
use crate::stats::standard_deviation;

use super::estimate::{By, Estimate};

/// Bias of an MPU6050 over temperature, m/s² per °C: ±35 mg from −40 to 85 °C on x and y, ±60 mg on z by
/// its data sheet, 0.4 mg/°C in the middle.
pub(crate) const DRIFT_MPS2_PER_C: f64 = 0.4e-3 * STANDARD_GRAVITY_MPS2;
/// k of the expanded uncertainty.
const COVERAGE: f64 = 2.0;

/// `section` with all that follows from covariance, residuals and poses left out.
pub(super) fn complete(
    section: AccelerometerSection,
    estimate: &Estimate,
    gravity: &Gravity,
    temperature: Option<&TemperatureRange>,
    temperatures: &[f64],
) -> AccelerometerSection {
    let section = AccelerometerSection {
        gravity_sd_mps2: gravity.uncertainty_mps2(),
        pose_tilt_deg: estimate.tilt,
        ..section
    };
    let mut section = match &estimate.by {
        By::Fit { .. } => by_fit(section, estimate),
        By::Ferraris { covariance, .. } => by_ferraris(section, covariance.as_deref(), gravity),
    };
    section.deviations = standard_deviations(&section);
    section.budget = budget(estimate, &section, gravity, temperature, temperatures);
    section
}

fn by_fit(section: AccelerometerSection, estimate: &Estimate) -> AccelerometerSection {
    let (Some(fit), Some(trust)) = (estimate.fit(), estimate.trust()) else {
        return section;
    };
    let mut section = section;
    for (pose, left_out) in section.poses.iter_mut().zip(&trust.left_out) {
        pose.left_out_error_mps2 = left_out.map(|l| l.error_mps2);
        pose.left_out_sd_mps2 = left_out.map(|l| l.sd_mps2);
    }
    // Without a pose that can be left out the data sheet alone would show an error.
    let is_tested = trust.left_out_rms().is_some();
    let undetected = trust
        .undetected
        .filter(|u| is_tested && u.effect_mps2.is_finite());
    AccelerometerSection {
        covariance: Some(Covariance {
            parameters: Covariance::names_with_bends(),
            values: fit.covariance().map(|row| row.to_vec()).to_vec(),
        }),
        bends: Some(fit.bends()),
        predicted_norm_error_mps2: Some(trust.predicted_mps2),
        worst_direction: Some(trust.worst).filter(|w| w.error_mps2.is_finite()),
        undetected,
        leave_one_out_rms_mps2: trust.left_out_rms().map(|(rms, _)| rms),
        fit: Some(FitQuality {
            chi2_per_freedom: fit.chi2_per_freedom,
            freedom: fit.freedom,
            model_error_mps2: fit.model_error_mps2(),
            oriented: fit.oriented,
            tilt_degrees_of_freedom: fit.tilt_freedom,
            prior: fit.used_prior(),
        }),
        next_poses: trust.next.clone(),
        ..section
    }
}

/// The closed form leaves no pose out and tests none.
fn by_ferraris(
    section: AccelerometerSection,
    covariance: Option<&ParameterCovariance>,
    gravity: &Gravity,
) -> AccelerometerSection {
    let faces = section.poses.iter().filter(|p| p.kind == PoseKind::Face);
    let errors = FitErrors::of(&faces.map(|p| p.error).collect::<Vec<_>>());
    let sensor = section.parameters().zip(covariance);
    let sensor = sensor.map(|(parameters, covariance)| Sensor {
        parameters,
        covariance: *covariance,
        gravity: gravical_fit::Gravity {
            value_mps2: gravity.value_mps2,
            sd_mps2: gravity.uncertainty_mps2(),
        },
        model_error_mps2: 0.0,
        tilt_freedom: f64::INFINITY,
    });
    let Some(sensor) = sensor else {
        return AccelerometerSection { errors, ..section };
    };
    let (direction, sd_mps2) = sensor.weakest();
    let worst = WorstDirection {
        direction,
        sd_mps2,
        error_mps2: COVERAGE * sd_mps2,
    };
    let all = sensor.covariance_with_gravity();
    let row = |i: usize| (0..DRIFT).map(|k| all[(i, k)]).collect();
    AccelerometerSection {
        predicted_norm_error_mps2: Some(sensor.predicted_mps2()).filter(|p| p.is_finite()),
        worst_direction: Some(worst).filter(|w| w.sd_mps2.is_finite()),
        covariance: Some(Covariance {
            parameters: Covariance::parameter_names(),
            values: (0..DRIFT).map(row).collect(),
        }),
        errors,
        ..section
    }
}

/// Standard deviations by propagation.
fn standard_deviations(section: &AccelerometerSection) -> Option<Deviations> {
    let sd = deviations(&section.parameters()?, &section.covariance_of_parameters()?);
    Some(Deviations {
        bias: [sd[0], sd[1], sd[2]],
        scale: [sd[3], sd[4], sd[5]],
        axis_angle_deg: [sd[6], sd[8], sd[7]].map(f64::to_degrees),
    })
}

fn budget(
    estimate: &Estimate,
    section: &AccelerometerSection,
    gravity: &Gravity,
    temperature: Option<&TemperatureRange>,
    temperatures: &[f64],
) -> Option<Budget> {
    let mut contributions = Vec::new();
    let mut add = |source, norm_mps2| contributions.push(Contribution { source, norm_mps2 });
    if let Some(trust) = estimate.trust() {
        let budget = trust.budget?;
        let rounding = estimate.rounding;
        add(
            Source::Noise,
            Some(budget.noise * (1.0 - rounding * rounding).sqrt()),
        );
        add(Source::Quantisation, Some(budget.noise * rounding));
        add(Source::ModelError, Some(budget.model_error));
        add(Source::Nonlinearity, Some(budget.bends));
        add(Source::PoseTilt, Some(budget.tilt));
        add(Source::DataSheet, Some(budget.data_sheet));
    } else {
        let all = section.predicted_norm_error_mps2?;
        let by_readings = (all * all - section.gravity_sd_mps2.powi(2))
            .max(0.0)
            .sqrt();
        add(Source::NoiseAndTilt, Some(by_readings));
    }
    add(Source::LocalGravity, Some(gravity.uncertainty_mps2()));
    add(
        Source::Temperature,
        temperature.map(|_| match temperatures {
            [] | [_] => 0.0,
            several => standard_deviation(several) * drift_sd(estimate),
        }),
    );
    let squares = contributions
        .iter()
        .filter_map(|c| c.norm_mps2)
        .map(|n| n * n);
    let combined_mps2 = squares.sum::<f64>().sqrt();
    Some(Budget {
        contributions,
        combined_mps2,
        coverage_factor: COVERAGE,
        expanded_mps2: COVERAGE * combined_mps2,
    })
}

/// What the bias may drift by, m/s² per °C; over all directions it is that of one axis.
fn drift_sd(estimate: &Estimate) -> f64 {
    let Some(drift) = estimate.fit().and_then(gravical_fit::Fit::drift) else {
        return DRIFT_MPS2_PER_C;
    };
    let scale = matrix3::row_norms(&estimate.model);
    let squares = (0..3).map(|i| (drift.sd[i] / scale[i]).powi(2));
    (squares.sum::<f64>() / 3.0).sqrt()
}

/// One entry a placement: faces against ±g on their axis, free poses against gravity's length along
/// their own direction. `offset` is added back to the raw means, so that they are the file's numbers.
pub(super) fn poses(
    placements: &[Pose],
    estimate: &Estimate,
    gravity: f64,
    offset: f64,
) -> Vec<PoseResult> {
    let one = |(index, placement): (usize, &Pose)| {
        let calibrated = estimate.calibration.apply(placement.mean);
        let used = &estimate.uses[index];
        let length = matrix3::norm(&calibrated).max(f64::MIN_POSITIVE);
        let expected = match used.face {
            Some(face) => face.direction().map(|d| d * gravity),
            None => calibrated.map(|c| c / length * gravity),
        };
        let error = matrix3::sub(&calibrated, &expected);
        PoseResult {
            label: used
                .face
                .map_or_else(|| placement.label.clone(), |f| f.name()),
            kind: if used.face.is_some() {
                PoseKind::Face
            } else {
                PoseKind::Free
            },
            source: placement.source.clone(),
            rows: placement.count as u64,
            lines: placement.lines,
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
    placements.iter().enumerate().map(one).collect()
}
