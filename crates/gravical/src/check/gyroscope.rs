//! The gyroscope's bias at rest. It moves with every start and with temperature,
//! so that its judgement stands apart from that of the accelerometer.

use gravical_core::matrix3::dot;

use super::intervals::include_slow_noise;
use super::{GyroscopeCheck, Judgement};
use crate::calibration_file::CalibrationFile;
use crate::finding::finding;
use crate::poses::gyro_unit::{judge, mismatch};
use crate::poses::mean::PoseMean;
use crate::poses::{Pose, cut, means_of};
use crate::recording::{Finding, Recording};

/// A calibrated rate at rest above this is worth a new bias, °/s: what an
/// MPU6050 may drift in 3 °C (product specification, 6.1: ±20 °/s over 125 °C).
const GYRO_LIMIT_DEG_S: f64 = 0.5;

/// Standard errors by which a mean has to be beyond the limit: 99 %.
const CONFIDENCE: f64 = 2.576;

impl GyroscopeCheck {
    /// The judgement in words.
    pub(super) fn reason(&self) -> String {
        let largest = self.rate_deg_s.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
        let limit = self.limit_deg_s;
        match self.judgement {
            Judgement::Undecided => {
                format!("gyroscope: too short or unsteady to test its bias against {limit} °/s")
            }
            Judgement::DoesNotFit => format!(
                "gyroscope: its bias has changed, the rate at rest is up to {largest:.2} °/s (limit {limit} °/s); it changes with every power-up"
            ),
            _ => format!(
                "gyroscope: its bias fits, the rate at rest is {largest:.2} °/s at most (limit {limit} °/s)"
            ),
        }
    }
}

/// Mean calibrated rate over all static intervals, weighted by their rows; `accel` is the
/// calibrated specific force of each, m/s².
pub(super) fn gyroscope(
    calibration: &CalibrationFile,
    recordings: &[Recording],
    intervals: &[Pose],
    accel: &[[f64; 3]],
    findings: &mut Vec<Finding>,
) -> Option<GyroscopeCheck> {
    let section = calibration.gyroscope.as_ref()?;
    let apply = calibration.gyroscope_calibration()?;
    for (index, recording) in recordings.iter().enumerate() {
        let rows: Vec<_> = intervals
            .iter()
            .filter(|p| p.recording == index)
            .map(|p| p.rows.clone())
            .collect();
        let scale = judge(recording, Some(section), &rows, findings);
        if let Some(why) = scale.and_then(|scale| mismatch(section, &scale)) {
            findings.push(
                finding!(
                    UnitMismatch,
                    "{why}; it is not tested; give its unit, if this is the right one"
                )
                .advise("gyro_unit", section.input_unit.name())
                .in_file(&recording.name),
            );
            return None;
        }
    }
    let (mut rate, mut raw, mut variance) = ([0.0; 3], [0.0; 3], Some([0.0; 3]));
    let mut rows = 0.0;
    let means = mean_rates(calibration, recordings, intervals);
    for ((interval, hold), accel) in intervals.iter().zip(means).zip(accel) {
        let mean = hold.mean;
        if !mean.iter().all(|m| m.is_finite()) {
            continue;
        }
        let weight = interval.count as f64;
        let calibrated = apply.apply(mean, *accel);
        for i in 0..3 {
            rate[i] += weight * calibrated[i];
            raw[i] += weight * (mean[i] - dot(&section.g_sensitivity[i], accel));
        }
        variance = variance.zip(hold.standard_error).map(|(sum, error)| {
            // Of a board that is turned in its case, axes and channels differ.
            let squares = error.map(|e| (weight * e).powi(2));
            std::array::from_fn(|i| sum[i] + dot(&section.matrix[i].map(|m| m * m), &squares))
        });
        rows += weight;
    }
    if rows == 0.0 {
        return None;
    }
    let rate = rate.map(|r| (r / rows).to_degrees());
    let error = variance.map(|v| v.map(|v| (v.sqrt() / rows).to_degrees()));
    let beyond = |sign: f64| {
        (0..3).any(|i| {
            let slack = error.map_or(0.0, |e| CONFIDENCE * e[i]);
            rate[i].abs() + sign * slack > GYRO_LIMIT_DEG_S
        })
    };
    let judgement = if beyond(-1.0) {
        Judgement::DoesNotFit
    } else if beyond(1.0) {
        Judgement::Undecided
    } else {
        Judgement::Fits
    };
    Some(GyroscopeCheck {
        input_unit: section.input_unit,
        rate_deg_s: rate,
        standard_error_deg_s: error,
        bias_now: raw.map(|r| r / rows),
        limit_deg_s: GYRO_LIMIT_DEG_S,
        judgement,
    })
}

/// Mean rates of static intervals in the input unit, at the reference temperature; NaN without a
/// gyroscope.
fn mean_rates(
    calibration: &CalibrationFile,
    recordings: &[Recording],
    intervals: &[Pose],
) -> Vec<PoseMean> {
    let held = |interval: &Pose| match &recordings[interval.recording].gyro {
        Some(gyro) => cut(gyro, &interval.rows),
        None => Default::default(),
    };
    let held: Vec<[Vec<f64>; 3]> = intervals.iter().map(held).collect();
    let selected = intervals.iter().map(|p| (p.recording, p.selection));
    let (mut means, _) = means_of(recordings, selected, &held, Recording::gyro_resolution);
    let errors = intervals.iter().zip(&mut means);
    let errors = errors.map(|(p, mean)| (p.recording, mean.rows, &mut mean.standard_error));
    include_slow_noise(recordings, &held, errors);
    for (interval, PoseMean { mean, .. }) in intervals.iter().zip(&mut means) {
        if let (Some(model), Some(t_c)) = (calibration.drift_model(), interval.temperature_c) {
            *mean = std::array::from_fn(|i| model.at_reference(3 + i, t_c, mean[i]));
        }
    }
    means
}
