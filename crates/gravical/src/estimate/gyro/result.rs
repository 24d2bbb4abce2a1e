//! The result and the findings of a fit.

use gravical_core::matrix3;

use super::{MISFIT_DEG, fit, motions, problem, rest};
use crate::calibration_file::{Covariance, GyroscopeSection, MotionCounts};
use crate::recording::units::GyroUnit;
use crate::recording::{Finding, FindingKind, LineSpans, Recording};

/// A scale that is further from nominal is not the one of the data sheet.
const SCALE_OFF: f64 = 0.1;

/// Root of the mean square.
pub(super) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Angle whose chord has this length, degrees.
pub(super) fn chord_deg(length: f64) -> f64 {
    2.0 * (0.5 * length).min(1.0).asin().to_degrees()
}

pub(super) fn section(
    rest: &rest::Rest,
    motions: &motions::Motions,
    fit: &fit::Fit,
    per_unit: f64,
    unit: GyroUnit,
) -> Option<GyroscopeSection> {
    let matrix = fit.state.e.map(|row| row.map(|v| v * per_unit));
    let model = matrix3::inverse(&matrix)?;
    let scale = matrix3::row_norms(&model);
    let orientation = matrix3::scale_rows(&model, &scale.map(f64::recip));
    let degrees: Vec<f64> = fit.residuals.iter().map(|r| chord_deg(*r)).collect();
    Some(GyroscopeSection {
        method: "motion".to_owned(),
        input_unit: unit,
        output_unit: GyroUnit::RadianPerSecond,
        bias: std::array::from_fn(|i| rest.bias[i] + fit.state.beta[i] / per_unit),
        matrix,
        scale,
        orientation,
        g_sensitivity: rest.g_sensitivity,
        covariance: fit
            .covariance
            .as_ref()
            .and_then(|c| covariance(c, &fit.state, per_unit)),
        residual: Some(rms(&fit.residuals)),
        residual_deg: Some(rms(&degrees)),
        motions: Some(MotionCounts {
            used: fit.kept.len() as u32,
            left_out: (motions.left_out + fit.outliers.len()) as u32,
        }),
        leave_one_out_deg: fit
            .left_out
            .as_ref()
            .map(|lengths| rms(&lengths.iter().map(|r| chord_deg(*r)).collect::<Vec<f64>>())),
    })
}

/// Covariance of M = G⁻¹ and b from that of E and β: δM = −E⁻¹ δE E⁻¹ / g,
/// δb = δβ / g.
fn covariance(c: &fit::Covariance, state: &problem::State, per_unit: f64) -> Option<Covariance> {
    let inverse = matrix3::inverse(&state.e)?;
    let mut to_model = fit::Covariance::zeros();
    for r in 0..3 {
        for k in 0..3 {
            for i in 0..3 {
                for j in 0..3 {
                    to_model[(3 * r + k, 3 * i + j)] = -inverse[r][i] * inverse[j][k] / per_unit;
                }
            }
        }
        to_model[(9 + r, 9 + r)] = per_unit.recip();
    }
    let model = to_model * c * to_model.transpose();
    Some(Covariance {
        parameters: Covariance::parameter_names(),
        values: (0..12)
            .map(|i| {
                (0..12)
                    .map(|j| 0.5 * (model[(i, j)] + model[(j, i)]))
                    .collect()
            })
            .collect(),
    })
}

/// Names the motions that contradict the others, recording by recording.
pub(super) fn tell_outliers(
    recordings: &[&Recording],
    motions: &motions::Motions,
    fit: &fit::Fit,
    findings: &mut Vec<Finding>,
) {
    for (index, recording) in recordings.iter().enumerate() {
        let own = || {
            motions
                .list
                .iter()
                .enumerate()
                .filter(|(_, m)| m.recording == index)
        };
        let mut spans = LineSpans::default();
        let (mut worst, mut count) = (0.0_f64, 0);
        for (_, motion) in own().filter(|(m, _)| fit.outliers.contains(m)) {
            let (from, to) = (
                recording.line(motion.rows.start),
                recording.line(motion.rows.end - 1),
            );
            spans.push_range(from, to, to - from + 1);
            count += 1;
            worst = worst.max(chord_deg(
                problem::Linear::of(motions, motion, &fit.state)
                    .residual
                    .norm(),
            ));
        }
        if count == 0 {
            continue;
        }
        findings.push(
            Finding::new(
                FindingKind::GyroMotionOutlier,
                format!(
                    "{count} of {} motions contradict the others (gravity off by up to {worst:.1}°, usually {:.2}°): a bump, lost samples, or turned too fast; left out of the gyroscope's fit",
                    own().count(),
                    chord_deg(rms(&fit.residuals))
                ),
            )
            .at_lines(&spans)
            .in_file(&recording.name),
        );
    }
}

/// What is odd about the fit itself.
pub(super) fn findings(
    fit: &fit::Fit,
    nominal: Option<f64>,
    per_unit: f64,
    typical: f64,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut add = |finding: Finding| findings.push(finding);
    if typical.to_degrees() > MISFIT_DEG {
        add(Finding::new(
            FindingKind::GyroMisfit,
            format!(
                "after a typical motion, gravity rotated by the integrated rate is wrong by {:.1}°: do both sensors have one clock, is the rate right, and the accelerometer's calibration sound?",
                typical.to_degrees()
            ),
        ));
    }
    if matrix3::det(&fit.state.e) * per_unit < 0.0 {
        add(Finding::new(
            FindingKind::GyroLeftHanded,
            "the gyroscope counts left-handed against the axes of the accelerometer: the sign of one axis is inverted in one of the two; after calibration they agree",
        ));
    }
    let diagonal: [f64; 3] = std::array::from_fn(|i| fit.state.e[i][i]);
    match nominal {
        None => {
            let degrees = 180.0 / std::f64::consts::PI;
            let per_deg_s = diagonal.map(|d| 1.0 / (d * per_unit * degrees));
            add(Finding::new(
                FindingKind::GyroScaleFound,
                format!(
                    "the scale of the gyroscope is not stated; according to the motions it is {} per °/s about x, y, z",
                    per_deg_s.map(|v| format!("{v:.4}")).join(", ")
                ),
            ));
        }
        Some(_) if diagonal.iter().any(|d| (d - 1.0).abs() > SCALE_OFF) => {
            add(Finding::new(
                FindingKind::GyroScaleOff,
                format!(
                    "by the motions the gyroscope's scale is {} of nominal about x, y, z: is the range or the unit another one, or are its axes not the accelerometer's?",
                    diagonal.map(|d| format!("{:.3}", 1.0 / d)).join(", ")
                ),
            ));
        }
        Some(_) => {}
    }
    findings
}
