//! Checks that can show a calibration wrong.

use gravical_core::matrix3::unit;
use gravical_fit::{Fit, FittedPose};

use crate::calibration_file::{Calibration, Method, PoseKind, PoseResult, TiltSource};
use crate::finding::{Case, Finding, finding};
use crate::numfmt::milli_g;
use crate::poses::Pose;
use crate::poses::face::{AXES, AxisMap, Claim, Face};
use crate::poses::rests::MANY_POSES;
use crate::recording::{Recording, already_calibrated};

use super::estimate::{Estimate, UNUSUAL_TILT};

/// Scale further from nominal than this is wrong rather than inaccurate, %.
/// The data sheet allows 3 %, a second range is 100 % away.
const SCALE_GATE_PERCENT: f64 = 10.0;
/// A bias above this is no MPU6050's, m/s² (0.35 g).
const BIAS_GATE_MPS2: f64 = 0.35 * 9.80665;
/// Of many free poses some have to be beyond this on both sides of each axis, g: the limit of van
/// Hees et al. (2014) and GGIR.
const MIN_COVERED_G: f64 = 0.3;
/// Oblique placements further off than so many times the predicted error
/// contradict the result.
const OBLIQUE_GATE: f64 = 3.0;
/// A sensor that misses the model by more than this, m/s², does something that
/// the model has no word for.
const MODEL_ERROR_NOTE: f64 = 0.02;

/// Checks of the accelerometer's parameters and placements; `offset` is the zero
/// offset in its bias.
pub(super) fn accelerometer(
    file: &Calibration,
    estimate: &Estimate,
    placements: &[Pose],
    offset: f64,
) -> Vec<Finding> {
    let (section, reliability) = (&file.accelerometer, &file.reliability);
    // What is wrong with the session comes before what is wrong with the result.
    let mut findings = of_poses(&file.poses, &estimate.poses, placements);
    findings.extend(orientations(&file.poses));
    if let Some((fit, _)) = &estimate.fit {
        findings.extend(of_fit(estimate, fit, placements));
    }
    let deviation = section.scale_deviation_percent.unwrap_or_default();
    if let Some(off) = beyond(deviation, SCALE_GATE_PERCENT, |v| format!("{v:+.1} %")) {
        findings.push(finding!(
            ScaleOff,
            "the scale is off by more than {SCALE_GATE_PERCENT} % ({off}): a data sheet allows 3; is the unit or the range right?"
        ));
    }
    let scale = section.scale();
    let bias_mps2 = [0, 1, 2].map(|i| section.bias[i] / scale[i]);
    // The zero of unsigned counts is a way of reading, which no data sheet limits.
    if let Some(large) = beyond(bias_mps2, BIAS_GATE_MPS2, |v| format!("{v:+.2} m/s²"))
        && offset == 0.0
    {
        findings.push(Case::LargeBias { bias: large }.finding());
    }
    // Placements that took no part in the fit and contradict it.
    if let Some(predicted) = reliability.predicted_mps2
        && let Some((error, count)) = file.free_norm_error()
        && section.method == Method::Ferraris
        && error > OBLIQUE_GATE * predicted
    {
        findings.push(finding!(
            FreePoseOff,
            "{count} free poses, which took no part in the fit, read the magnitude off by {:.0} mg rms, more than {OBLIQUE_GATE} times what was predicted: was the sensor moving there, or is one of the faces wrong?",
            milli_g(error)
        ));
    }
    // A tilt that is larger than a box on a table leaves.
    if let Some(tilt) = reliability.pose_tilt_deg
        && tilt.source == TiltSource::Estimated
        && tilt.value > UNUSUAL_TILT
    {
        findings.push(finding!(
            PoseTilt,
            "the poses lie {:.1}° off their faces in each of two components. A box or a jig would help",
            tilt.value
        ));
    }
    findings
}

/// The axes on which a value is beyond the limit, and these values.
fn beyond(values: [f64; 3], limit: f64, shown: impl Fn(f64) -> String) -> Option<String> {
    let axes = (0..3).filter(|&i| values[i].abs() > limit);
    let list: Vec<String> = axes
        .map(|i| format!("{} {}", AXES[i], shown(values[i])))
        .collect();
    (!list.is_empty()).then(|| list.join(", "))
}

/// Poses that are clipped, that the fit left out, or did not take for the face that they are named.
fn of_poses(poses: &[PoseResult], fitted: &[FittedPose], placements: &[Pose]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let poses = poses.iter().zip(fitted);
    for (placement, (pose, fitted)) in placements.iter().zip(poses) {
        let mut tell = |finding: Finding| findings.push(finding.in_file(&placement.source));
        if pose.fitted && placement.clipped > 0 {
            tell(finding!(
                ClippedPose,
                "{}: {} samples at the end of the range; its mean is too small",
                placement.label,
                placement.clipped
            ));
        }
        let is_named = matches!(placement.claim, Some(Claim::Face(_))) && placement.face.is_some();
        if let Some(chance) = fitted.bad {
            tell(finding!(
                BadPose,
                "{}: reads {:+.1} mg off the magnitude that all others agree on (chance {chance:.0e}); left out. Was it moving?",
                pose.called(),
                milli_g(pose.magnitude_error_mps2.unwrap_or(f64::NAN))
            ));
        } else if is_named && fitted.face.is_none() {
            let no_face = finding!(
                NoFace,
                "{} is named a face but lies {:.1}° off it, much further than the others: taken as a free pose, unless it is given as a face",
                placement.label,
                placement.angle_deg,
            );
            tell(no_face.advise("face_pose", &*placement.label));
        }
    }
    findings
}

/// Many free poses that leave a side of an axis out. What people do with a sensor that they wear is
/// no plan: where it never points, nothing tests the result, and what bends the readings of a
/// restless wrist is not the noise that the covariance knows.
fn orientations(poses: &[PoseResult]) -> Option<Finding> {
    let fitted = poses.iter().filter(|p| p.fitted);
    if fitted.clone().filter(|p| p.kind == PoseKind::Free).count() < MANY_POSES {
        return None;
    }
    let ranges = [0, 1, 2].map(|axis: usize| {
        let each = fitted.clone().map(|p| unit(&p.calibrated)[axis]);
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        each.fold(none, |[low, high], v| [low.min(v), high.max(v)])
    });
    let covered = |[low, high]: &[f64; 2]| *low < -MIN_COVERED_G && *high > MIN_COVERED_G;
    let list = AXES.iter().zip(&ranges);
    let list = list.map(|(axis, [low, high])| format!("{axis} {low:+.2} to {high:+.2} g"));
    (!ranges.iter().all(covered)).then(|| {
        finding!(
            FewOrientations,
            "not enough orientations: only {} are covered; each axis has to be beyond ±{MIN_COVERED_G} g on both sides",
            list.collect::<Vec<_>>().join(", ")
        )
    })
}

/// What the joint fit itself shows to be odd.
fn of_fit(estimate: &Estimate, fit: &Fit, placements: &[Pose]) -> Vec<Finding> {
    let mut findings = Vec::new();
    if placements.iter().any(|p| p.standard_error.is_none()) {
        findings.push(finding!(
            NoiseAssumed,
            "each row is a mean of unknown standard error: 4 mm/s² were assumed for the uncertainty"
        ));
    }
    let twice = face_twice(&estimate.poses, placements);
    findings.extend(twice.or_else(|| missing_face(fit, &estimate.poses)));
    if fit.quality.model_error_mps2 > MODEL_ERROR_NOTE {
        findings.push(finding!(
            ModelError,
            "the poses differ from the model by {:.0} mm/s² beyond their noise: was the sensor at rest, and warm?",
            1000.0 * fit.quality.model_error_mps2
        ));
    }
    if !fit.quality.oriented {
        findings.push(finding!(
            OrientationOpen,
            "faces on fewer than two axes: the orientation of the sensor in its case is unknown. The frame was fixed by convention (triangular matrix); magnitudes are not affected"
        ));
    }
    findings
}

/// The faces that none of some poses has up.
fn missing<'a>(poses: impl Iterator<Item = &'a FittedPose> + Clone) -> Vec<Face> {
    let is_missing = |face: &Face| poses.clone().all(|pose| pose.face != Some(*face));
    Face::all().into_iter().filter(is_missing).collect()
}

/// A face that was recorded twice, once under the name of one that is missing.
fn face_twice(poses: &[FittedPose], placements: &[Pose]) -> Option<Finding> {
    let missing = missing(poses.iter());
    (0..poses.len()).rev().find_map(|index| {
        let again = &placements[index];
        let Some(Claim::Face(meant)) = again.claim else {
            return None;
        };
        let face = poses[index].face.filter(|_| missing.contains(&meant))?;
        let is_first = |k: &usize| *k != index && poses[*k].face == Some(face);
        let first = (0..poses.len()).find(is_first)?;
        let (one, other) = (&placements[first].label, &again.label);
        let (face, meant) = (face.name(), meant.name());
        let twice = finding!(
            SameFaceTwice,
            "{face} points up in \"{one}\" and in \"{other}\", and no pose has {meant} up: record \"{other}\" with {meant} up"
        );
        Some(twice.in_file(&again.source))
    })
}

/// Faces only, and one of them missing: what that costs.
fn missing_face(fit: &Fit, poses: &[FittedPose]) -> Option<Finding> {
    let mut fitted = poses.iter().filter(|p| p.bad.is_none());
    let missing = missing(fitted.clone());
    if missing.is_empty() || fitted.any(|p| p.face.is_none()) {
        return None;
    }
    let directions = missing.iter().map(|face| face.direction().into());
    let claims = fit.sensor(1.0).claims(directions).into_iter();
    let costs = missing.iter().zip(claims);
    let costs = costs.map(|(face, claim)| {
        let sd = milli_g(claim.sd_mps2);
        format!("{} up: ±{sd:.0} mg", face.name())
    });
    Some(finding!(
        MissingFace,
        "{} of six faces are there; the magnitude is known badly with {} (1σ). Record what is missing, or oblique poses",
        6 - missing.len(),
        costs.collect::<Vec<_>>().join(", ")
    ))
}

/// Inputs that do not belong into a session: a recording that is calibrated
/// already, or the same one twice.
pub(super) fn inputs(recordings: &[Recording]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (i, recording) in recordings.iter().enumerate() {
        findings.extend(already_calibrated(
            recording,
            "a session needs raw recordings",
        ));
        let is_same = |other: &&Recording| other.sha256 == recording.sha256;
        let twin = recordings[..i].iter().find(is_same);
        if let Some(twin) = twin.filter(|twin| twin.sha256.is_some()) {
            let twice = finding!(
                SameFileTwice,
                "it is the same as {}, byte for byte, and counts twice",
                twin.name
            );
            findings.push(twice.in_file(&recording.name));
        }
    }
    findings
}

/// Names that, taken together, describe a mirrored sensor: placements were
/// swapped. All six the other way round is a convention, and a turned board a
/// mounting; both keep the data's word.
pub(super) fn names(axes: &AxisMap, placements: &[Pose]) -> Option<Finding> {
    // Where the names send each face of the data.
    let mut sent: [Option<Face>; 6] = [None; 6];
    for placement in placements {
        if let (Some(Claim::Face(claimed)), Some(face)) = (placement.claim, placement.face) {
            sent[face.index()] = Some(claimed);
        }
    }
    let all: Vec<Face> = sent.into_iter().flatten().collect();
    let all: [Face; 6] = all.try_into().ok()?;
    if all == Face::all() {
        return None;
    }
    Some(if all == Face::all().map(Face::opposite) {
        finding!(
            NamesReversed,
            "every name says the opposite of the data, which are believed: either a sign means the axis that points down here, or the sensor reads −g where an axis points up, as iPhones do; then other axes give calibrated values the usual sign"
        )
        .advise("axes", "-x,-y,-z")
    } else if let Some(map) = axes.renamed(&all) {
        finding!(
            NamesTurned,
            "the names describe another way of sitting in the case than the axes {axes}, which are believed; {map} explains all names"
        )
        .advise("axes", map.to_string())
    } else {
        finding!(
            NamesMirrored,
            "the names contradict the data in a way that no mounting explains (two poses swapped?); the faces were taken from the data, but check which recording is which"
        )
    })
}
