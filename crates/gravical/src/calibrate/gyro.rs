//! The gyroscope of a session: by three known turns, by the motions between its static intervals, or
//! the bias alone.

mod readings;
#[cfg(test)]
mod tests;
pub(super) mod turns;

use gravical_core::calibration::Calibration;
use gravical_core::matrix3;
use gravical_fit::{FittedMotion, GyroOptions, GyroRest, GyroUndetermined, MIN_MOTIONS, MotionFit};

use crate::calibration_file::{Covariance, GyroMethod, GyroscopeSection, MotionCounts};
use crate::finding::finding;
use crate::poses::Segmentation;
use crate::poses::face::AXES;
use crate::recording::units::GyroUnit;
use crate::recording::{Finding, FindingKind, LineSpans, Recording};

use readings::Readings;

/// A scale that is further from nominal is not the one of the data sheet.
const SCALE_OFF: f64 = 0.1;

/// A gyroscope, or why there is none.
#[derive(Debug, Clone, Default)]
pub struct Gyroscope {
    /// The parameters; none where not even a nominal scale is known.
    pub section: Option<GyroscopeSection>,
    /// What is odd.
    pub findings: Vec<Finding>,
}

impl Gyroscope {
    /// With what was found about known turns before: that some are missing matters only where the motions
    /// do not do without them.
    pub(super) fn or_after(mut self, turns: Vec<Finding>) -> Self {
        if self
            .section
            .as_ref()
            .is_none_or(|s| s.method != GyroMethod::Motion)
        {
            self.findings.splice(0..0, turns);
        }
        self
    }
}

/// The gyroscope from the motions of all recordings of a session ([`gravical_fit::gyro`]), or the bias alone
/// where they do not determine more: that is a finding. Neither section nor finding where there is no
/// gyroscope.
///
/// `accelerometer` calibrates the values of [`Recording::accel`] (its zero offset taken off) to m/s²; its
/// axes become those of the gyroscope.
#[must_use]
pub fn of_session(
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
            section(&fit.rest, motions, readings.left_out)
        }
        open => {
            let open = open.as_ref().and_then(|o| o.as_ref().err());
            odd.extend(open.map(|open| undetermined(open, nominal)));
            odd.extend(nominal.is_none().then(|| scale_unknown(&fit.rest)));
            nominal.map(|nominal| bias_alone(&fit.rest, nominal))
        }
    };
    // What concerns several recordings stands in no file.
    let in_file = |finding: Finding| match recordings {
        [one] => finding.in_file(&one.name),
        _ => finding,
    };
    findings.extend(odd.into_iter().map(in_file));
    let unit = session.gyro_scale.map_or(GyroUnit::Unknown, |s| s.unit);
    let section = section.map(|section| GyroscopeSection {
        input_unit: unit,
        ..section
    });
    Gyroscope { section, findings }
}

fn section(rest: &GyroRest, fit: &MotionFit, left_out: usize) -> Option<GyroscopeSection> {
    let model = matrix3::inverse(&fit.matrix)?;
    let scale = matrix3::row_norms(&model);
    let used: Vec<&FittedMotion> = fit.motions.iter().flatten().filter(|m| m.used).collect();
    let lengths: Vec<f64> = used.iter().map(|m| m.residual).collect();
    let without: Option<Vec<f64>> = used.iter().map(|m| m.left_out).collect();
    let values = fit.covariance.map(|row| row.to_vec()).to_vec();
    Some(GyroscopeSection {
        method: GyroMethod::Motion,
        bias: fit.bias,
        matrix: fit.matrix,
        scale,
        orientation: matrix3::scale_rows(&model, &scale.map(f64::recip)),
        g_sensitivity: rest.g_sensitivity,
        covariance: Some(Covariance {
            parameters: Covariance::parameter_names(),
            values,
        }),
        residual_deg: Some(rms_deg(&lengths)),
        motions: Some(MotionCounts {
            used: used.len() as u32,
            left_out: (left_out + fit.motions.len() - used.len()) as u32,
        }),
        leave_one_out_deg: without.map(|lengths| rms_deg(&lengths)),
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
        g_sensitivity: rest.g_sensitivity,
        covariance: Some(Covariance {
            parameters: ["bias_x", "bias_y", "bias_z"].map(str::to_owned).to_vec(),
            values: variances.map(|row| row.to_vec()).to_vec(),
        }),
        ..GyroscopeSection::default()
    }
}

fn scale_unknown(rest: &GyroRest) -> Finding {
    finding!(
        GyroScaleUnknown,
        "the gyroscope reads {} at rest, and its scale follows neither from its unit nor from rotations: it is not calibrated; give --gyro-unit and, for counts, --gyro-range",
        rest.bias.map(|b| format!("{b:.4}")).join(", ")
    )
}

/// What has to be turned more.
fn undetermined(open: &GyroUndetermined, nominal: Option<f64>) -> Finding {
    let motions = open.motions;
    let names = |weak: bool| -> String {
        let axes = (0..3).filter(|i| open.axes[*i] == weak);
        let names: Vec<String> = axes.map(|i| AXES[i].to_string()).collect();
        names.join(" and ")
    };
    let strong = open.axes.iter().filter(|weak| !**weak).count();
    let how_well = if open.sd < 10.0 {
        format!("known to {:.0} %", 100.0 * open.sd)
    } else {
        "not known at all".to_owned()
    };
    let then = if nominal.is_some() {
        "it gets its bias only, with the nominal scale"
    } else {
        "it is not calibrated"
    };
    let message = if motions < MIN_MOTIONS {
        format!(
            "{motions} usable motions between static intervals are too few for the gyroscope: {MIN_MOTIONS} are needed, and twice as many are good; {then}"
        )
    } else if strong == 0 {
        format!(
            "the {motions} usable motions between static intervals do not determine the gyroscope: its matrix is {how_well}, no better than the data sheet says; {then}. Turn it more often, by 90° and more about each axis while that axis is level"
        )
    } else {
        format!(
            "the {motions} usable motions between static intervals turn about {strong} of 3 axes enough ({}), but too little about {weak} ({how_well}); {then}. Turn it about {weak} too, by 90° and more, with that axis level",
            names(false),
            weak = names(true)
        )
    };
    Finding::new(FindingKind::GyroUndetermined, message)
}

/// Names the motions that contradict the others, recording by recording.
fn outliers(recordings: &[Recording], readings: &Readings, fit: &MotionFit) -> Vec<Finding> {
    let used = fit.motions.iter().flatten().filter(|m| m.used);
    let usual = rms(&used.map(|m| m.residual).collect::<Vec<f64>>());
    let one = |(index, recording): (usize, &Recording)| {
        let (mut spans, mut all, mut worst, mut count) = (LineSpans::default(), 0, 0.0_f64, 0);
        for ((_, [from, to]), motion) in readings
            .places
            .iter()
            .zip(&fit.motions)
            .filter(|((recording, _), _)| *recording == index)
        {
            let Some(motion) = motion else { continue };
            all += 1;
            if !motion.used {
                spans.push_range(*from, *to, to - from + 1);
                count += 1;
                worst = worst.max(motion.residual);
            }
        }
        (count > 0).then(|| {
            finding!(
                GyroMotionOutlier,
                "{count} of {all} motions contradict the others (gravity off by up to {:.1}°, usually {:.2}°): a bump, lost samples, or turned too fast; left out of the gyroscope's fit",
                chord_deg(worst),
                chord_deg(usual),
            )
            .at_lines(&spans)
            .in_file(&recording.name)
        })
    };
    recordings.iter().enumerate().filter_map(one).collect()
}

/// What is odd about the fit itself.
fn oddities(fit: &MotionFit, nominal: Option<f64>) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut add = |kind, message: String| findings.push(Finding::new(kind, message));
    if fit.is_misfit() {
        add(
            FindingKind::GyroMisfit,
            format!(
                "after a typical motion, gravity rotated by the integrated rate is wrong by {:.1}°: do both sensors have one clock, is the rate right, and the accelerometer's calibration sound?",
                fit.typical_rad.to_degrees()
            ),
        );
    }
    if matrix3::det(&fit.matrix) < 0.0 {
        add(
            FindingKind::GyroLeftHanded,
            "the gyroscope counts left-handed against the axes of the accelerometer: the sign of one axis is inverted in one of the two; after calibration they agree".to_owned(),
        );
    }
    let diagonal: [f64; 3] = std::array::from_fn(|i| fit.matrix[i][i]);
    let Some(nominal) = nominal else {
        let per_deg_s = diagonal.map(|d| format!("{:.4}", 1.0 / d.to_degrees()));
        add(
            FindingKind::GyroScaleFound,
            format!(
                "the scale of the gyroscope is not stated; according to the motions it is {} per °/s about x, y, z",
                per_deg_s.join(", ")
            ),
        );
        return findings;
    };
    let relative = diagonal.map(|d| d * nominal);
    if relative.iter().any(|d| (d - 1.0).abs() > SCALE_OFF) {
        add(
            FindingKind::GyroScaleOff,
            format!(
                "by the motions the gyroscope's scale is {} of nominal about x, y, z: is the range or the unit another one, or are its axes not the accelerometer's?",
                relative.map(|d| format!("{:.3}", 1.0 / d)).join(", ")
            ),
        );
    }
    findings
}

/// Root of the mean square.
fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

fn rms_deg(chords: &[f64]) -> f64 {
    rms(&chords.iter().map(|c| chord_deg(*c)).collect::<Vec<f64>>())
}

/// Angle whose chord has this length, degrees.
fn chord_deg(length: f64) -> f64 {
    2.0 * (0.5 * length).min(1.0).asin().to_degrees()
}
