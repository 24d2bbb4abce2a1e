//! Checks that can show a calibration wrong.

use gravical_core::matrix3::unit;
use gravical_fit::{Explained, Explanation, Fit, FittedPose};

use crate::calibration_file::{Calibration, Method, PoseKind, PoseResult, Reliability, TiltSource};
use crate::finding::{Case, Finding, OrderOf};
use crate::poses::Pose;
use crate::poses::face::{AxisMap, Claim, Face};
use crate::poses::rests::MANY_POSES;
use crate::recording::{Recording, already_calibrated};

use super::estimate::{Estimate, UNUSUAL_TILT};
use super::session::Session;

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
/// Explanations whose results differ by less than this share of the claimed error need no words.
const MATTERS: f64 = 0.1;
/// A sensor that misses the model by more than this, m/s², does something that
/// the model has no word for.
const MODEL_ERROR_NOTE: f64 = 0.02;

/// Checks of the accelerometer's parameters and placements.
pub(super) fn accelerometer(
    file: &Calibration,
    estimate: &Estimate,
    session: &Session<'_>,
) -> Vec<Finding> {
    let (section, reliability) = (&file.accelerometer, &file.reliability);
    let (placements, offset) = (&session.segmentation.poses, session.zero_offset());
    // What is wrong with the session comes before what is wrong with the result.
    let mut findings = of_poses(&file.poses, &estimate.poses, placements);
    findings.extend(orientations(&file.poses));
    if let Some((fit, _)) = &estimate.fit {
        findings.extend(of_fit(estimate, fit, placements));
        findings.extend(explanations(&file.poses, reliability, session.order().1));
    }
    let is_beyond = |values: [f64; 3], limit: f64| values.iter().any(|v| v.abs() > limit);
    let deviation_percent = section.scale_deviation_percent().unwrap_or_default();
    if is_beyond(deviation_percent, SCALE_GATE_PERCENT) {
        let limit_percent = SCALE_GATE_PERCENT;
        let off = Case::ScaleOff {
            deviation_percent,
            limit_percent,
        };
        findings.push(off.finding());
    }
    let scale = section.scale();
    let bias_mps2 = [0, 1, 2].map(|i| section.bias[i] / scale[i]);
    // The zero of unsigned counts is a way of reading, which no data sheet limits.
    if is_beyond(bias_mps2, BIAS_GATE_MPS2) && offset == 0.0 {
        let limit_mps2 = BIAS_GATE_MPS2;
        let large = Case::LargeBias {
            bias_mps2,
            limit_mps2,
        };
        findings.push(large.finding());
    }
    // Placements that took no part in the fit and contradict it.
    if let Some(predicted) = reliability.predicted_mps2
        && let Some((error_mps2, poses)) = file.free_norm_error()
        && section.method == Method::Ferraris
        && error_mps2 > OBLIQUE_GATE * predicted
    {
        let off = Case::FreePosesOff {
            poses,
            error_mps2,
            limit: OBLIQUE_GATE,
        };
        findings.push(off.finding());
    }
    // A tilt that is larger than a box on a table leaves.
    if let Some(tilt) = reliability.pose_tilt_deg
        && tilt.source == TiltSource::Estimated
        && tilt.value > UNUSUAL_TILT
    {
        let tilt_deg = tilt.value;
        findings.push(Case::PoseTilt { tilt_deg }.finding());
    }
    findings
}

/// Poses that are clipped, that the fit left out, or did not take for the face that they are named.
fn of_poses(poses: &[PoseResult], fitted: &[FittedPose], placements: &[Pose]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let poses = poses.iter().zip(fitted);
    for (placement, (pose, fitted)) in placements.iter().zip(poses) {
        let mut tell = |finding: Finding| findings.push(finding.in_file(&placement.source));
        if pose.fitted && placement.clipped > 0 {
            let clipped = Case::ClippedPose {
                pose: placement.label.clone(),
                samples: placement.clipped,
            };
            tell(clipped.finding());
        }
        let is_named = matches!(placement.claim, Some(Claim::Face(_))) && placement.face.is_some();
        if let Some(chance) = fitted.bad {
            let bad = Case::BadPose {
                pose: pose.called().to_owned(),
                error_mps2: pose.magnitude_error_mps2.unwrap_or(f64::NAN),
                chance,
            };
            tell(bad.finding());
        } else if is_named && fitted.face.is_none() {
            let no_face = Case::NoFace {
                pose: placement.label.clone(),
                angle_deg: placement.angle_deg,
            };
            tell(no_face.finding().advise("face_pose", &*placement.label));
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
    let ranges_g = [0, 1, 2].map(|axis: usize| {
        let each = fitted.clone().map(|p| unit(&p.calibrated)[axis]);
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        each.fold(none, |[low, high], v| [low.min(v), high.max(v)])
    });
    let covered = |[low, high]: &[f64; 2]| *low < -MIN_COVERED_G && *high > MIN_COVERED_G;
    let least_g = MIN_COVERED_G;
    let few = Case::FewOrientations { ranges_g, least_g };
    (!ranges_g.iter().all(covered)).then(|| few.finding())
}

/// What the joint fit itself shows to be odd.
fn of_fit(estimate: &Estimate, fit: &Fit, placements: &[Pose]) -> Vec<Finding> {
    let mut findings = Vec::new();
    if placements.iter().any(|p| p.standard_error.is_none()) {
        findings.push(Case::NoiseAssumed.finding());
    }
    let twice = face_twice(&estimate.poses, placements);
    findings.extend(twice.or_else(|| missing_face(fit, &estimate.poses)));
    let error_mps2 = fit.quality.model_error_mps2;
    if error_mps2 > MODEL_ERROR_NOTE {
        findings.push(Case::ModelError { error_mps2 }.finding());
    }
    if !fit.quality.oriented {
        findings.push(Case::OrientationOpen.finding());
    }
    findings
}

/// What else than noise, and than a bad pose that is reported by itself, explains the session.
fn explanations(
    poses: &[PoseResult],
    reliability: &Reliability,
    order: OrderOf,
) -> Option<Finding> {
    let all = &reliability.explanations;
    let is_told = |e: &Explained| match e.explanation {
        Explanation::Nothing => true,
        Explanation::BadPose(k) => !poses[k].fitted,
        Explanation::BadPoses => true,
        Explanation::Step(_) | Explanation::Drift => false,
    };
    let difference_mps2 = gravical_fit::rival(all)?.difference_mps2;
    let claimed_mps2 = reliability.worst_direction.map_or(0.0, |w| w.error_mps2);
    if difference_mps2 < MATTERS * claimed_mps2 || all.len() < 2 && all.iter().all(is_told) {
        return None;
    }
    let word = |e: &Explained| {
        let what = match e.explanation {
            Explanation::Nothing => "a nonlinear response".to_owned(),
            Explanation::BadPose(k) => format!("{} is off", poses[k].called()),
            Explanation::BadPoses => "the poses that are left out are off".to_owned(),
            Explanation::Step(k) => format!("the bias moved before {}", poses[k].called()),
            Explanation::Drift => "the bias drifted".to_owned(),
        };
        (what, e.probability)
    };
    let several = Case::SeveralExplanations {
        explanations: all.iter().map(word).collect(),
        order,
        difference_mps2,
    };
    Some(several.finding())
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
        let twice = Case::SameFaceTwice {
            up: face.name(),
            one: placements[first].label.clone(),
            other: again.label.clone(),
            missing: meant.name(),
        };
        Some(twice.finding().in_file(&again.source))
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
    let each = missing.iter().zip(claims);
    let each = each.map(|(face, claim)| (face.name(), claim.sd_mps2));
    let sd_mps2 = each.collect();
    Some(Case::MissingFaces { sd_mps2 }.finding())
}

/// Inputs that do not belong into a session: a recording that is calibrated
/// already, or the same one twice.
pub(super) fn inputs(recordings: &[Recording]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (i, recording) in recordings.iter().enumerate() {
        let case = |by_board| Case::CalibratedForSession { by_board };
        findings.extend(already_calibrated(recording, case));
        let is_same = |other: &&Recording| other.sha256 == recording.sha256;
        let twin = recordings[..i].iter().find(is_same);
        if let Some(twin) = twin.filter(|twin| twin.sha256.is_some()) {
            let file = twin.name.clone();
            let twice = Case::SameFileTwice { file }.finding();
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
        let reversed = Case::NamesReversed.finding();
        reversed.advise("axes", "-x,-y,-z")
    } else if let Some(named) = axes.renamed(&all) {
        let turned = Case::NamesTurned {
            axes: axes.to_string(),
            named: named.to_string(),
        }
        .finding();
        turned.advise("axes", named.to_string())
    } else {
        Case::NamesMirrored.finding()
    })
}
