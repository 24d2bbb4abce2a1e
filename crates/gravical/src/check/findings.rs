//! What has to be known to read a check.

use super::CheckOptions;
use super::rests::Rest;
use super::types::{Cause, Explanation};
use crate::calibration_file::{CalibrationFile, Grade, GravitySource, InputFile};
use crate::gravity::Gravity;
use crate::numfmt::milli_g;
use crate::recording::board::why_calibrated;
use crate::recording::{Finding, FindingKind, Recording};

/// A static interval this far outside the calibration's temperatures is reported, °C.
const TEMPERATURE_MARGIN_C: f64 = 2.0;

/// Gravity that differs by less than this share is the same.
const SAME_GRAVITY: f64 = 1e-5;

/// Keeps the longest `most` stills in their order.
pub(super) fn keep_longest(rests: &mut Vec<Rest>, most: usize, findings: &mut Vec<Finding>) {
    if rests.len() <= most {
        return;
    }
    let mut counts: Vec<usize> = rests.iter().map(|r| r.count).collect();
    counts.sort_unstable_by(|a, b| b.cmp(a));
    let least = counts[most - 1];
    let all = rests.len();
    rests.retain(|r| r.count >= least);
    rests.truncate(most);
    findings.push(Finding::new(
        FindingKind::IntervalsLeftOut,
        format!(
            "{all} static intervals; the longest {} are compared",
            rests.len()
        ),
    ));
}

/// The inputs of the calibration that are this recording, by its checksum.
fn inputs_of<'a>(
    calibration: &'a CalibrationFile,
    recording: &'a Recording,
) -> impl Iterator<Item = &'a InputFile> {
    let known = recording.sha256.as_ref();
    calibration
        .recordings()
        .filter(move |i| known.is_some() && i.sha256.as_ref() == known)
}

/// True for each static interval that the calibration was fitted to.
pub(super) fn fitted(
    calibration: &CalibrationFile,
    recordings: &[Recording],
    rests: &[Rest],
) -> Vec<bool> {
    let fitted = |rest: &Rest| {
        let recording = &recordings[rest.recording];
        let (first, last) = (recording.line(rest.first()), recording.line(rest.last()));
        inputs_of(calibration, recording).any(|input| {
            let poses = calibration.accelerometer.poses.iter();
            let mut poses = poses.filter(|p| p.fitted && p.source.contains(&input.path));
            // Without lines the pose may be anywhere in the file.
            poses.any(|p| p.lines.is_none_or(|[from, to]| from <= last && first <= to))
        })
    };
    rests.iter().map(fitted).collect()
}

/// Sensor, temperature, gravity, inputs, quality.
pub(super) fn circumstances(
    calibration: &CalibrationFile,
    recordings: &[Recording],
    rests: &[Rest],
    gravity: &Gravity,
    options: &CheckOptions,
    findings: &mut Vec<Finding>,
) {
    if calibration.verdict.grade == Grade::Poor {
        findings.push(Finding::new(
            FindingKind::PoorCalibration,
            "the verdict of the calibration is poor; fix what it names first",
        ));
    }
    if calibration.accelerometer.covariance.is_none() {
        findings.push(Finding::new(
            FindingKind::CovarianceMissing,
            "the calibration has no covariance; calibrate again from the recordings for a sharper check",
        ));
    }
    for recording in recordings {
        if recording.is_calibrated {
            findings.push(
                Finding::new(
                    FindingKind::AlreadyCalibrated,
                    format!(
                        "{}: a check needs the raw recording",
                        why_calibrated(recording.is_calibrated_by_board)
                    ),
                )
                .in_file(&recording.name),
            );
        }
    }
    for recording in recordings {
        if inputs_of(calibration, recording).next().is_some() {
            findings.push(
                Finding::new(
                    FindingKind::SameRecordings,
                    "the calibration was made from this recording: static intervals that it was fitted to cannot test it, and count only where there are no others",
                )
                .in_file(&recording.name),
            );
        }
    }
    for rest in rests.iter().filter(|r| r.clipped > 0) {
        let recording = &recordings[rest.recording];
        findings.push(
            Finding::new(
                FindingKind::ClippedPose,
                format!(
                    "{} samples at the end of the range in lines {} to {}: the mean is too small, and the interval does not count unless there is no other",
                    rest.clipped,
                    recording.line(rest.first()),
                    recording.line(rest.last())
                ),
            )
            .in_file(&recording.name),
        );
    }
    findings.extend(temperature(calibration, rests));
    let off = gravity.value_mps2 - calibration.gravity_mps2;
    if options.gravity.is_some() && off.abs() > SAME_GRAVITY * calibration.gravity_mps2 {
        findings.push(Finding::new(
            FindingKind::GravityDiffers,
            format!(
                "the calibration was computed with g = {:.5} m/s²{}, here g = {:.5}: if it was made here, that alone makes every ‖a‖ {:.1} mg too {}",
                calibration.gravity_mps2,
                match calibration.gravity_source {
                    GravitySource::Standard => " (assumed)",
                    GravitySource::Given | GravitySource::Latitude => "",
                },
                gravity.value_mps2,
                milli_g(off.abs()),
                if off > 0.0 { "small" } else { "large" }
            ),
        ));
    }
}

fn temperature(calibration: &CalibrationFile, rests: &[Rest]) -> Option<Finding> {
    // Within the range of a temperature model the drift is taken off.
    let (least, most, what) = match (calibration.drift_model(), calibration.temperature_c) {
        (Some(model), _) => (
            model.range_c[0],
            model.range_c[1],
            "its temperature model reaches from",
        ),
        (None, Some(range)) => (range.min, range.max, "the calibration was made at"),
        (None, None) => return None,
    };
    let some = || rests.iter().filter_map(|r| r.temperature_c);
    let low = some().fold(f64::INFINITY, f64::min);
    let high = some().fold(f64::NEG_INFINITY, f64::max);
    let outside = (least - low).max(high - most);
    (outside > TEMPERATURE_MARGIN_C).then(|| {
        Finding::new(
            FindingKind::TemperatureOutside,
            format!(
                "the static intervals are at {low:.1} to {high:.1} °C, {what} {least:.1} to {most:.1} °C: the bias of an MPU6050 moves by 0.5 mg (x, y) to 0.9 mg (z) per °C, which the uncertainty does not include; calibrate at this temperature"
            ),
        )
    })
}

/// Says what would explain a misfit.
pub(super) fn explained(
    explanations: &[Explanation],
    gravity: &Gravity,
    findings: &mut Vec<Finding>,
) {
    let good: Vec<&Explanation> = explanations.iter().filter(|e| e.explains).collect();
    for e in &good {
        if let Some(share) = e.share_percent {
            findings.push(Finding::new(
                FindingKind::OffByShare,
                format!(
                    "all static intervals are wrong by the same fraction, {share:+.3} % ± {:.3} %: the scale, or local gravity, which would be {:.4} m/s² here{}",
                    e.sigma,
                    gravity.value_mps2 * (1.0 + share / 100.0),
                    if good.len() > 1 { " (a bias explains it as well: too few directions to tell)" } else { "" }
                ),
            ));
        }
    }
    let single: Vec<String> = good
        .iter()
        .filter_map(|e| {
            let (axis, at) = match e.cause {
                Cause::BiasX => ("x", 0),
                Cause::BiasY => ("y", 1),
                Cause::BiasZ => ("z", 2),
                Cause::Share | Cause::Bias => return None,
            };
            let value = e.bias_mps2?[at];
            Some(format!("{axis} by {value:+.4} ± {:.4} m/s²", e.sigma))
        })
        .collect();
    if !single.is_empty() {
        findings.push(Finding::new(
            FindingKind::OffAlongAxis,
            format!(
                "a changed bias of one axis explains it: {}; calibrate again",
                single.join(", or ")
            ),
        ));
    }
    if let Some(bias) = good
        .iter()
        .find(|e| e.cause == Cause::Bias)
        .and_then(|e| e.bias_mps2)
    {
        findings.push(Finding::new(
            FindingKind::OffAlongAxis,
            format!(
                "changed biases explain it: x {:+.4}, y {:+.4}, z {:+.4} m/s²; calibrate again",
                bias[0], bias[1], bias[2]
            ),
        ));
    }
}
