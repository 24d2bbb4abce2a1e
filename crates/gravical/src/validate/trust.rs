//! How far a result can be trusted, in numbers: predicted error, leave-one-out errors, the
//! least consistent pose, what would improve it, and the budget of the uncertainty.

use gravical_core::matrix3;
use gravical_core::unit::STANDARD_GRAVITY_MPS2;

use crate::calibration_file::{
    AccelerometerSection, Budget, ContradictedPose, Contribution, Covariance, Deviations, GOOD_MG,
    GravitySource, KnownGravity, LeastConsistentPose, NextPose, PoseResult, TemperatureRange,
    UndetectedError, WorstDirection,
};
use crate::estimate::accelerometer::{Estimate, Method};
use crate::estimate::in_words;
use crate::estimate::joint::{NORMAL_95, Source};
use crate::gravity::Gravity;
use crate::numfmt::milli_g;
use crate::stats::{median, standard_deviation};
use crate::uncertainty::{Covariance12, invariant_derivatives, of_gravity, sum};

use crate::estimate::proposal::Proposals;
use crate::predicted;

/// Free poses that are proposed.
const PROPOSED: usize = 3;
/// Bias of an MPU6050 over temperature, m/s² per °C: ±35 mg from −40 to 85 °C
/// on x and y, ±60 mg on z by its data sheet, 0.4 mg/°C in the middle.
pub(crate) const DRIFT_MPS2_PER_C: f64 = 0.4e-3 * STANDARD_GRAVITY_MPS2;
/// k of the expanded uncertainty.
const COVERAGE: f64 = 2.0;

/// The section with all that follows from the covariance and from poses left out; its poses and
/// degrees of freedom are there.
#[must_use]
pub fn trust(
    section: AccelerometerSection,
    estimate: &Estimate,
    gravity: &Gravity,
    temperature: Option<&TemperatureRange>,
    temperatures: &[f64],
) -> AccelerometerSection {
    let poses = &section.poses;
    let g = gravity.value_mps2;
    let matrix = &estimate.calibration.matrix;
    let gravity_sd = gravity.uncertainty_mps2();
    let covariance = estimate
        .covariance
        .as_ref()
        .map(|c| sum(c, &of_gravity(&estimate.model, gravity_sd, g)));
    let norm_error = |c: &Covariance12| predicted::norm_error(matrix, c, g);
    let predicted = covariance.as_ref().and_then(norm_error);
    let by_readings = estimate.covariance.as_ref().and_then(norm_error);
    let left_out: Vec<f64> = estimate
        .uses
        .iter()
        .filter_map(|u| u.left_out_error)
        .collect();
    let reliability = estimate.joint.as_ref().and_then(|f| f.reliability.as_ref());
    AccelerometerSection {
        covariance: covariance.as_ref().map(|c| Covariance {
            parameters: Covariance::parameter_names(),
            values: c.iter().map(|row| row.to_vec()).collect(),
        }),
        gravity_sd_mps2: gravity_sd,
        predicted_norm_error_mps2: predicted,
        worst_direction: covariance
            .as_ref()
            .map(|c| worst_direction(estimate, c, g))
            .filter(|w| w.error_mps2.is_finite()),
        undetected: reliability
            .and_then(|r| r.undetected(matrix, g))
            .filter(|u| u.effect_mps2.is_finite())
            .map(|u| UndetectedError {
                label: poses[u.pose].called(),
                reading_mps2: u.reading_mps2,
                effect_mps2: u.effect_mps2,
                direction: u.direction,
                hint: in_words(u.direction),
            }),
        contradicted: reliability
            .and_then(|r| r.contradiction())
            .map(|(pose, excess)| ContradictedPose {
                label: poses[pose].called(),
                excess,
            }),
        deviations: covariance.as_ref().map(|c| deviations(estimate, c)),
        leave_one_out_rms_mps2: rms(&left_out),
        fit: estimate.quality,
        least_consistent_pose: worst(estimate, poses, rms(&left_out)),
        next_poses: next_poses(estimate, g, gravity_sd),
        known_gravity: by_readings
            .zip(predicted)
            .and_then(|(by_readings, now)| known_gravity(gravity, by_readings, now)),
        budget: budget(estimate, by_readings, gravity, temperature, temperatures),
        pose_tilt_deg: estimate.tilt,
        ..section
    }
}

fn rms(values: &[f64]) -> Option<f64> {
    let squares: f64 = values.iter().map(|v| v * v).sum();
    (!values.is_empty()).then(|| (squares / values.len() as f64).sqrt())
}

/// Where ‖a‖ is known least, and a limit of its error there.
fn worst_direction(estimate: &Estimate, c: &Covariance12, gravity: f64) -> WorstDirection {
    let matrix = &estimate.calibration.matrix;
    let (direction, sd_mps2) = predicted::weakest(matrix, c, gravity);
    let h = predicted::sensitivity(matrix, direction, gravity);
    let fit = estimate.joint.as_ref();
    let factor = fit.map_or(1.0, |f| f.widening(&h, sd_mps2 * sd_mps2));
    let coverage_factor = COVERAGE * factor;
    WorstDirection {
        direction,
        hint: in_words(direction),
        sd_mps2,
        coverage_factor,
        error_mps2: coverage_factor * sd_mps2,
    }
}

/// Standard deviations by propagation.
fn deviations(estimate: &Estimate, c: &Covariance12) -> Deviations {
    let m = &estimate.model;
    let mut factor = NORMAL_95;
    let mut out = Deviations {
        bias: std::array::from_fn(|i| c[9 + i][9 + i].max(0.0).sqrt()),
        scale: [0.0; 3],
        axis_angle_deg: [0.0; 3],
        coverage_factor_95: NORMAL_95,
    };
    // One factor for all: the largest that any of them needs.
    let mut needs = |h: &[f64; 12]| {
        let own = estimate.joint.as_ref().map(|f| f.coverage_factor_95(h));
        factor = factor.max(own.unwrap_or(NORMAL_95));
    };
    for (row, h) in invariant_derivatives(m).iter().enumerate() {
        needs(h);
        let sd = predicted::variance(c, h).max(0.0).sqrt();
        match row {
            0..3 => out.scale[row] = sd,
            3..6 => out.axis_angle_deg[row - 3] = sd.to_degrees(),
            _ => {}
        }
    }
    out.coverage_factor_95 = factor;
    out
}

/// The pose with the largest leave-one-out error; where none can be left out, the
/// one with the largest tilt.
fn worst(
    estimate: &Estimate,
    poses: &[PoseResult],
    usual: Option<f64>,
) -> Option<LeastConsistentPose> {
    let mg = 1000.0 / STANDARD_GRAVITY_MPS2;
    let of = |key: &dyn Fn(usize) -> Option<f64>| {
        (0..poses.len())
            .filter(|&k| estimate.uses[k].fitted)
            .filter_map(|k| Some((k, key(k)?)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    };
    if let Some((k, error)) = of(&|k| estimate.uses[k].left_out_error.map(f64::abs)) {
        let others = usual.map_or(String::new(), |u| format!(", rms of all {:.2} mg", u * mg));
        return Some(LeastConsistentPose {
            label: poses[k].called(),
            reason: format!(
                "leave-one-out error {:+.2} mg{others}",
                estimate.uses[k].left_out_error.unwrap_or(error) * mg
            ),
        });
    }
    let (k, tilt) = of(&|k| estimate.uses[k].tilt_deg.map(|(t, _)| t))?;
    Some(LeastConsistentPose {
        label: poses[k].called(),
        reason: format!("tilt {tilt:.1}°, the largest"),
    })
}

/// What it would bring to know gravity, where most of the predicted variance is that of an
/// assumed one.
fn known_gravity(gravity: &Gravity, by_readings: f64, predicted: f64) -> Option<KnownGravity> {
    let assumed = gravity.source == GravitySource::Standard;
    (assumed && 2.0 * by_readings * by_readings < predicted * predicted).then(|| KnownGravity {
        hint: "--latitude or --gravity".to_owned(),
        predicted_norm_error_mps2: by_readings,
    })
}

/// Poses that lower the predicted error most, and once that is good, those that test the others
/// best; none of them determines gravity.
fn next_poses(estimate: &Estimate, gravity: f64, gravity_sd: f64) -> Vec<NextPose> {
    let (Some(fit), Some(covariance)) = (&estimate.joint, &estimate.covariance) else {
        return Vec::new();
    };
    let matrix = &estimate.calibration.matrix;
    let scale = matrix3::row_norms(&estimate.model)[0];
    let mut noises: Vec<f64> = estimate.noise.noise.iter().flatten().copied().collect();
    let noise = median(&mut noises).unwrap_or(0.0).hypot(fit.model_error) / scale;
    let proposals = Proposals {
        matrix: *matrix,
        covariance: *covariance,
        reliability: fit.reliability.clone(),
        recorded: estimate.uses.iter().filter_map(|u| u.direction).collect(),
        noise,
        gravity,
        good_mps2: GOOD_MG * STANDARD_GRAVITY_MPS2 / 1000.0,
    };
    proposals
        .take(PROPOSED)
        .map(|p| NextPose {
            direction: p.direction,
            hint: in_words(p.direction),
            predicted_norm_error_mps2: p.norm_error_mps2.hypot(gravity_sd),
            undetected_effect_mps2: Some(p.undetected_mps2).filter(|effect| effect.is_finite()),
        })
        .collect()
}

fn budget(
    estimate: &Estimate,
    by_readings: Option<f64>,
    gravity: &Gravity,
    temperature: Option<&TemperatureRange>,
    temperatures: &[f64],
) -> Option<Budget> {
    let g = gravity.value_mps2;
    let matrix = &estimate.calibration.matrix;
    let mut contributions = Vec::new();
    let mut add = |source: &str, norm_mps2: Option<f64>, basis: String| {
        contributions.push(Contribution {
            source: source.to_owned(),
            norm_mps2,
            basis,
        });
    };
    let tilt = estimate.tilt.map_or_else(
        || match estimate.method {
            Method::Linear12 => "faces taken as exactly level".to_owned(),
            _ => "no faces".to_owned(),
        },
        |t| format!("σ of {:.2}° in each of two components", t.value),
    );
    match &estimate.joint {
        Some(fit) => {
            for (source, part) in &fit.sources {
                let norm = predicted::norm_error(matrix, part, g);
                match source {
                    Source::Noise => add(
                        "noise",
                        norm,
                        if estimate.noise.assumed {
                            "assumed: the rows are means themselves".to_owned()
                        } else {
                            "standard errors of the means".to_owned()
                        },
                    ),
                    Source::Quantisation => {
                        add("quantisation", norm, "steps of the converter behind that noise".to_owned());
                    }
                    Source::ModelError => add(
                        "model-error",
                        norm,
                        "deviation of the poses from the model, beyond their noise".to_owned(),
                    ),
                    Source::Tilt => add("pose-tilt", norm, tilt.clone()),
                    Source::DataSheet => add(
                        "data-sheet",
                        norm,
                        "scale ±3 %, cross-axis ±2 %, zero-g ±0.6 m/s², where the poses determine less".to_owned(),
                    ),
                }
            }
        }
        None => add(
            "noise-and-tilt",
            by_readings,
            format!("standard errors of the means; {tilt}"),
        ),
    }
    let basis = match gravity.source {
        GravitySource::Given => "taken as exact: it was given",
        GravitySource::Latitude => "anomalies of the field at that latitude",
        GravitySource::Standard => "9.80665 m/s² assumed; 9.780 to 9.832 at sea level",
    };
    add(
        "local-gravity",
        Some(gravity.uncertainty_mps2()),
        basis.to_owned(),
    );
    match temperature {
        Some(range) if temperatures.len() > 1 => {
            let spread = standard_deviation(temperatures);
            // Of the bias, in m/s² per °C; over all directions it is that of one axis.
            let fitted = estimate
                .joint
                .as_ref()
                .and_then(|fit| fit.drift)
                .map(|drift| {
                    let axes = matrix3::row_norms(&estimate.model);
                    let squares = (0..3).map(|i| (drift.sd[i] / axes[i]).powi(2));
                    (squares.sum::<f64>() / 3.0).sqrt()
                });
            let basis = match fitted {
                Some(sd) => format!("by a drift known to {:.3} mg/°C", milli_g(sd)),
                None => "at 0.4 mg/°C".to_owned(),
            };
            add(
                "temperature",
                Some(spread * fitted.unwrap_or(DRIFT_MPS2_PER_C)),
                format!(
                    "{:.1} to {:.1} °C during the session {basis}",
                    range.min, range.max
                ),
            );
        }
        Some(_) => add("temperature", Some(0.0), "one temperature".to_owned()),
        None => add(
            "temperature",
            None,
            "no temperature was recorded".to_owned(),
        ),
    }
    by_readings?;
    let combined = contributions
        .iter()
        .filter_map(|c| c.norm_mps2)
        .map(|n| n * n)
        .sum::<f64>()
        .sqrt();
    Some(Budget {
        contributions,
        combined_mps2: combined,
        coverage_factor: COVERAGE,
        expanded_mps2: COVERAGE * combined,
    })
}
