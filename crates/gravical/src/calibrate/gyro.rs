//! The gyroscope of a session: by full turns, by the motions between its static intervals, or the
//! bias alone.

mod readings;
#[cfg(test)]
mod tests;
mod turns;

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use gravical_fit::{FittedMotion, GyroOptions, GyroRest, GyroUndetermined, MIN_MOTIONS, MotionFit};

use crate::calibrate::session::Session;
use crate::calibration_file::{Covariance, GyroMethod, GyroscopeSection, MotionCounts};
use crate::finding::{Finding, finding};
use crate::poses::Segmentation;
use crate::poses::face::axes_where;
use crate::recording::units::GyroUnit;
use crate::recording::{LineSpans, Recording};

use readings::Readings;

/// A scale that is further from nominal is not the one of the data sheet.
const SCALE_OFF: f64 = 0.1;

/// A gyroscope, or why there is none.
#[derive(Debug, Clone, Default)]
pub(super) struct Gyroscope {
    /// The parameters; none where not even a nominal scale is known.
    pub section: Option<GyroscopeSection>,
    /// The turns or motions showed a scale that nothing states.
    pub scale_found: bool,
    /// What is odd.
    pub findings: Vec<Finding>,
}

/// The gyroscope of a session, by a full turn about each axis if it has them, else by its motions.
pub(super) fn of_session(session: &Session<'_>, accelerometer: &Calibration<f64>) -> Gyroscope {
    let cut = session.segmentation;
    if let Some(section) = turns::by_turns(session, accelerometer) {
        return Gyroscope {
            section: Some(section),
            scale_found: cut.gyro_scale.and_then(|scale| scale.nominal()).is_none(),
            findings: Vec::new(),
        };
    }
    let mut found = gyroscope(session.recordings, cut, accelerometer);
    if !cut.turns.is_empty() {
        found.findings.push(finding!(
            LabelsLeftOut,
            "the named turns do not calibrate the gyroscope: that takes all six faces and a full turn about each axis, without a gap or a clipped reading, whose scale is within 10 % of the stated one"
        ));
    }
    found
}

/// The gyroscope from the motions of all recordings of a session ([`gravical_fit::gyro`]), or the bias alone
/// where they do not determine more: that is a finding. Neither section nor finding where there is no
/// gyroscope.
///
/// `accelerometer` calibrates the values of [`Recording::accel`] (its zero offset taken off) to m/s²; its
/// axes become those of the gyroscope.
fn gyroscope(
    recordings: &[Recording],
    session: &Segmentation,
    accelerometer: &Calibration<f64>,
) -> Gyroscope {
    let mut readings = Readings::new(recordings, session);
    let nominal = session.gyro_scale.and_then(|scale| scale.nominal());
    let options = GyroOptions {
        nominal,
        noise: readings.noise,
        rounding: readings.rounding,
    };
    let mut findings = std::mem::take(&mut readings.findings);
    let (intervals, motions) = (&readings.intervals, &readings.motions);
    let Some(fit) = gravical_fit::gyro(intervals, motions, accelerometer, &options) else {
        return Gyroscope::default();
    };
    let mut odd = Vec::new();
    let section = match &fit.by_motions {
        Some(Ok(motions)) => {
            findings.extend(outliers(recordings, &readings, motions));
            odd.extend(oddities(motions, nominal));
            by_motions(motions, readings.left_out)
        }
        open => {
            let open = open.as_ref().and_then(|o| o.as_ref().err());
            odd.extend(open.map(|open| undetermined(open, motions.len(), nominal)));
            if nominal.is_none() {
                let unknown = finding!(
                    GyroScaleUnknown,
                    "the gyroscope reads {} at rest, and its scale follows neither from its unit nor from rotations: it is not calibrated; give its unit and, for counts, its range",
                    fit.rest.bias.map(|b| format!("{b:.4}")).join(", ")
                );
                odd.push(unknown.advise("gyro_unit", "").advise("gyro_range", ""));
            }
            nominal.map(|nominal| bias_alone(&fit.rest, nominal))
        }
    };
    // What concerns several recordings stands in no file.
    let in_file = |finding: Finding| match recordings {
        [one] => finding.in_file(&one.name),
        _ => finding,
    };
    findings.extend(odd.into_iter().map(in_file));
    let section = section.map(|section| GyroscopeSection {
        input_unit: session.gyro_scale.map_or(GyroUnit::Unknown, |s| s.unit),
        output_unit: GyroUnit::RadianPerSecond,
        g_sensitivity: fit.rest.g_sensitivity,
        ..section
    });
    Gyroscope {
        section,
        scale_found: nominal.is_none() && matches!(fit.by_motions, Some(Ok(_))),
        findings,
    }
}

fn by_motions(fit: &MotionFit, left_out: usize) -> Option<GyroscopeSection> {
    let model = matrix3::inverse(&fit.matrix)?;
    let scale = matrix3::row_norms(&model);
    let used: Vec<&FittedMotion> = fit.motions.iter().filter(|m| m.used).collect();
    let rms_deg = |chords: Vec<f64>| rms(chords.into_iter().map(chord_deg));
    let without: Option<Vec<f64>> = used.iter().map(|m| m.left_out).collect();
    Some(GyroscopeSection {
        method: GyroMethod::Motion,
        bias: fit.bias,
        matrix: fit.matrix,
        scale,
        orientation: matrix3::scale_rows(&model, &scale.map(f64::recip)),
        covariance: Some(Covariance {
            parameters: Covariance::parameter_names(),
            values: fit.covariance.map(|row| row.to_vec()).to_vec(),
        }),
        residual_deg: Some(rms_deg(used.iter().map(|m| m.residual).collect())),
        motions: Some(MotionCounts {
            used: used.len() as u32,
            left_out: (left_out + fit.motions.len() - used.len()) as u32,
        }),
        leave_one_out_deg: without.map(rms_deg),
        ..GyroscopeSection::default()
    })
}

/// The bias of the static intervals with the nominal matrix.
fn bias_alone(rest: &GyroRest, nominal: f64) -> GyroscopeSection {
    let variances = matrix3::diagonal(rest.bias_sd.map(|sd| sd * sd));
    GyroscopeSection {
        method: GyroMethod::Bias,
        bias: rest.bias,
        matrix: matrix3::diagonal([nominal.recip(); 3]),
        scale: [nominal; 3],
        orientation: matrix3::identity(),
        covariance: Some(Covariance {
            parameters: Covariance::parameter_names()[9..].to_vec(),
            values: variances.map(|row| row.to_vec()).to_vec(),
        }),
        ..GyroscopeSection::default()
    }
}

/// What has to be turned more.
fn undetermined(open: &GyroUndetermined, motions: usize, nominal: Option<f64>) -> Finding {
    let weak = axes_where(|axis| open.axes[axis]).join(", ");
    let known = match open.sd {
        sd if sd < 10.0 => format!("known to {:.0} % only", 100.0 * sd),
        _ => "not known".to_owned(),
    };
    let then = match nominal {
        Some(_) => "it gets its bias only, with the nominal scale",
        None => "it is not calibrated",
    };
    finding!(
        GyroUndetermined,
        "{motions} usable motions between static intervals leave the gyroscope's matrix {known}; {then}. Turn it about {weak} by 90° and more, with that axis level, and at least {MIN_MOTIONS} times in all, better twice as often"
    )
}

/// Names the motions that contradict the others, recording by recording.
fn outliers(recordings: &[Recording], readings: &Readings, fit: &MotionFit) -> Vec<Finding> {
    let used = fit.motions.iter().filter(|m| m.used);
    let usual = chord_deg(rms(used.map(|m| m.residual)));
    let one = |(index, recording): (usize, &Recording)| {
        let places = readings.places.iter().zip(&fit.motions);
        let own = places.filter(|((recording, _), _)| *recording == index);
        let contradict = own.clone().filter(|(_, motion)| !motion.used);
        let (mut spans, mut worst) = (LineSpans::default(), 0.0_f64);
        for ((_, [from, to]), motion) in contradict.clone() {
            spans.push_range(*from, *to, to - from + 1);
            worst = worst.max(motion.residual);
        }
        let (count, all) = (contradict.count(), own.count());
        (count > 0).then(|| {
            let outlier = finding!(
                GyroMotionOutlier,
                "{count} of {all} motions contradict the others (gravity off by up to {:.1}°, usually {usual:.2}°): a bump, lost samples, or turned too fast; left out of the gyroscope's fit",
                chord_deg(worst)
            );
            outlier.at_lines(&spans).in_file(&recording.name)
        })
    };
    recordings.iter().enumerate().filter_map(one).collect()
}

/// What is odd about the fit itself.
fn oddities(fit: &MotionFit, nominal: Option<f64>) -> Vec<Finding> {
    let mut findings = Vec::new();
    if fit.is_misfit() {
        findings.push(finding!(
            GyroMisfit,
            "after a typical motion, gravity rotated by the integrated rate is wrong by {:.1}°: do both sensors have one clock, is the rate right, and the accelerometer's calibration sound?",
            fit.typical_rad.to_degrees()
        ));
    }
    if matrix3::det(&fit.matrix) < 0.0 {
        findings.push(finding!(
            GyroLeftHanded,
            "the gyroscope counts left-handed against the axes of the accelerometer: the sign of one axis is inverted in one of the two; after calibration they agree"
        ));
    }
    let diagonal = [0, 1, 2].map(|i| fit.matrix[i][i]);
    let relative = nominal.map(|nominal| diagonal.map(|d| d * nominal));
    if let Some(relative) = relative
        && relative.iter().any(|d| (d - 1.0).abs() > SCALE_OFF)
    {
        findings.push(finding!(
            GyroScaleOff,
            "by the motions the gyroscope's scale is {} of nominal about x, y, z: is the range or the unit another one, or are its axes not the accelerometer's?",
            relative.map(|d| format!("{:.3}", 1.0 / d)).join(", ")
        ));
    }
    findings
}

/// Root of the mean square.
fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (squares, count) = values.fold((0.0, 0.0), |(sum, n), v| (sum + v * v, n + 1.0));
    (squares / count).sqrt()
}

/// Angle whose chord has this length, degrees.
fn chord_deg(length: f64) -> f64 {
    2.0 * (0.5 * length).min(1.0).asin().to_degrees()
}
