//! The gyroscope of a session: by full turns, by the motions between its static intervals, or the
//! bias alone.

mod readings;
#[cfg(test)]
mod tests;
mod turns;

use gravical_core::calibration::LinearCalibration;
use gravical_core::matrix3;
use gravical_fit::{FittedMotion, GyroOptions, GyroRest, GyroUndetermined, MotionFit};
use gravical_judge::GAP_PERIODS;
use gravical_signal::stats::rms;

use crate::calibrate::session::Session;
use crate::calibration_file::{Covariance, GyroMethod, Gyroscope, MotionCounts};
use crate::finding::{Case, Finding};
use crate::poses::face::axes_where;
use crate::recording::LineSpans;
use crate::recording::units::GyroUnit;

use readings::{LeftOut, MAX_MOTION_S, Readings};

/// A scale that is further from nominal is not the one of the data sheet.
const SCALE_OFF: f64 = 0.1;

/// A gyroscope, or why there is none.
#[derive(Debug, Clone, Default)]
pub(super) struct FittedGyroscope {
    /// The parameters; none where not even a nominal scale is known or found.
    pub section: Option<Gyroscope>,
    /// What is odd.
    pub findings: Vec<Finding>,
}

/// The gyroscope of a session, by a full turn about each axis if it has them, else by its motions.
pub(super) fn of_session(
    session: &Session<'_>,
    accelerometer: &LinearCalibration<f64>,
) -> FittedGyroscope {
    let cut = session.segmentation;
    let readings = Readings::new(session.recordings, cut);
    if let Some(section) = turns::by_turns(session, &readings, accelerometer) {
        return FittedGyroscope {
            section: Some(section),
            findings: Vec::new(),
        };
    }
    let mut found = gyroscope(readings, accelerometer);
    if !cut.turns.is_empty() {
        found.findings.push(Case::TurnsNotUsed.finding());
    }
    found
}

/// The gyroscope from the motions of all recordings of a session ([`gravical_fit::gyro`]), or the bias alone
/// where they do not determine more: that is a finding. Neither section nor finding where there is no
/// gyroscope.
///
/// `accelerometer` calibrates the values of the recordings (their zero offset taken off) to m/s²; its axes
/// become those of the gyroscope.
fn gyroscope(
    mut readings: Readings<'_>,
    accelerometer: &LinearCalibration<f64>,
) -> FittedGyroscope {
    let nominal = readings.nominal();
    let options = GyroOptions {
        nominal,
        noise: readings.noise,
        rounding: readings.rounding,
    };
    let (intervals, motions) = (&readings.intervals, &readings.motions);
    let Some(fit) = gravical_fit::gyro(intervals, motions, accelerometer, &options) else {
        return FittedGyroscope::default();
    };
    let mut odd = Vec::new();
    let mut section = match &fit.by_motions {
        Some(Ok(motions)) => {
            let each = readings.places.iter().zip(&motions.motions);
            let outliers = each.filter(|(_, motion)| !motion.used);
            let outliers = outliers.map(|(place, _)| (LeftOut::Outlier, place.clone()));
            readings.left_out.extend(outliers);
            odd.extend(gyro_findings(motions, nominal));
            by_motions(&readings, motions)
        }
        open => {
            let open = open.as_ref().and_then(|o| o.as_ref().err());
            odd.extend(open.map(|open| undetermined(open, motions.len(), nominal)));
            nominal.map(|nominal| bias_alone(&readings, &fit.rest, nominal))
        }
    };
    if section.is_none() {
        let bias = fit.rest.bias;
        let unknown = Case::GyroScaleUnknown { bias }.finding();
        odd.push(unknown.advise("gyro_unit", "").advise("gyro_range", ""));
    }
    // What concerns several recordings stands in no file.
    let in_file = |finding: Finding| match readings.recordings {
        [one] => finding.in_file(&one.name),
        _ => finding,
    };
    let mut findings = std::mem::take(&mut readings.findings);
    findings.extend(motions_left_out(&readings));
    findings.extend(odd.into_iter().map(in_file));
    if let Some(section) = &mut section {
        section.g_sensitivity = fit.rest.g_sensitivity;
    }
    FittedGyroscope { section, findings }
}

/// The section of ω = matrix · (u − bias).
fn section(
    readings: &Readings<'_>,
    method: GyroMethod,
    matrix: [[f64; 3]; 3],
    bias: [f64; 3],
) -> Gyroscope {
    Gyroscope {
        method,
        input_unit: readings.scale.map_or(GyroUnit::Unknown, |s| s.unit),
        bias,
        matrix,
        ..Gyroscope::default()
    }
}

fn by_motions(readings: &Readings<'_>, fit: &MotionFit) -> Option<Gyroscope> {
    matrix3::inverse(&fit.matrix)?;
    let used: Vec<&FittedMotion> = fit.motions.iter().filter(|m| m.used).collect();
    let without: Option<Vec<f64>> = used.iter().map(|m| m.left_out).collect();
    Some(Gyroscope {
        covariance: Some(Covariance::new(fit.covariance)),
        residual_deg: Some(rms(used.iter().map(|m| chord_deg(m.residual)))),
        motions: Some(MotionCounts {
            used: used.len() as u32,
            left_out: readings.left_out.len() as u32,
        }),
        left_out_deg: without.map(|chords| rms(chords.into_iter().map(chord_deg))),
        ..section(readings, GyroMethod::Motion, fit.matrix, fit.bias)
    })
}

/// The bias of the static intervals with the nominal matrix.
fn bias_alone(readings: &Readings<'_>, rest: &GyroRest, nominal: f64) -> Gyroscope {
    let matrix = matrix3::diagonal([nominal.recip(); 3]);
    let variances = matrix3::diagonal(rest.bias_sd.map(|sd| sd * sd));
    Gyroscope {
        covariance: Some(Covariance::new(variances)),
        ..section(readings, GyroMethod::Bias, matrix, rest.bias)
    }
}

/// What has to be turned more.
fn undetermined(open: &GyroUndetermined, motions: usize, nominal: Option<f64>) -> Finding {
    Case::GyroUndetermined {
        motions,
        sd: open.sd,
        weak: axes_where(|axis| open.axes[axis]),
        is_scaled: nominal.is_some(),
    }
    .finding()
}

/// Names the motions that take no part, recording by recording and reason by reason.
fn motions_left_out(readings: &Readings<'_>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (index, recording) in readings.recordings.iter().enumerate() {
        for why in [LeftOut::Gap, LeftOut::Clipped, LeftOut::Outlier] {
            let left_out = readings.left_out.iter();
            let meant = left_out.filter(|(own, place)| *own == why && place.recording == index);
            let (mut motions, mut lines) = (0, LineSpans::default());
            for (_, place) in meant {
                let [from, to] = place.lines;
                lines.push_range(from, to, to - from + 1);
                motions += 1;
            }
            if motions > 0 {
                let case = match why {
                    LeftOut::Gap => Case::MotionsBroken {
                        motions,
                        max_s: MAX_MOTION_S,
                        gap_periods: GAP_PERIODS,
                    },
                    LeftOut::Clipped => Case::MotionsClipped { motions },
                    LeftOut::Outlier => Case::MotionsContradict { motions },
                };
                let finding = case.finding().at_lines(&lines);
                findings.push(finding.in_file(&recording.name));
            }
        }
    }
    findings
}

/// What is odd about the fit itself.
fn gyro_findings(fit: &MotionFit, nominal: Option<f64>) -> Vec<Finding> {
    let mut findings = Vec::new();
    if fit.typical_rad > gravical_fit::MISFIT_RAD {
        let angle_deg = fit.typical_rad.to_degrees();
        findings.push(Case::GyroMisfit { angle_deg }.finding());
    }
    if matrix3::det(&fit.matrix) < 0.0 {
        findings.push(Case::GyroLeftHanded.finding());
    }
    let diagonal = [0, 1, 2].map(|i| fit.matrix[i][i]);
    let relative = nominal.map(|nominal| diagonal.map(|d| d * nominal));
    if let Some(relative) = relative
        && relative.iter().any(|d| (d - 1.0).abs() > SCALE_OFF)
    {
        let of_nominal = relative.map(f64::recip);
        findings.push(Case::GyroScaleOff { of_nominal }.finding());
    }
    findings
}

/// Angle whose chord has this length, degrees.
fn chord_deg(length: f64) -> f64 {
    2.0 * (0.5 * length).min(1.0).asin().to_degrees()
}
