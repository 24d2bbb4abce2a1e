//! Checks that can show a calibration wrong.

mod fit;

use crate::calibration_file::{AccelerometerSection, Method, TiltSource};
use crate::numfmt::milli_g;
use crate::poses::Pose;
use crate::poses::face::{AxisMap, Claim, Face};
use crate::recording::why_calibrated;
use crate::recording::{Finding, FindingKind, Recording};

use crate::poses::MANY_POSES;

use super::estimate::{By, Estimate};

/// Scale further from nominal than this is wrong rather than inaccurate, %.
/// The data sheet allows 3 %, a second range is 100 % away.
const SCALE_GATE_PERCENT: f64 = 10.0;
/// Scale further from nominal than this is worth a word, %.
const SCALE_NOTE_PERCENT: f64 = 5.0;
/// A bias above this is no MPU6050's, m/s² (0.35 g).
const BIAS_GATE_MPS2: f64 = 0.35 * 9.80665;
/// A bias above this is worth a word, m/s²: twice the ±60 mg of a data sheet.
const BIAS_NOTE_MPS2: f64 = 1.2;
/// Above this a face is accepted with a note, degrees.
const FACE_NOTE_DEG: f64 = 10.0;

/// Of many free poses some have to be beyond this on both sides of each axis, g: the limit of van
/// Hees et al. (2014) and GGIR.
const LEAST_COVERED_G: f64 = 0.3;

/// Oblique placements further off than so many times the predicted error
/// contradict the result.
const OBLIQUE_GATE: f64 = 3.0;

/// Many free poses that leave a side of an axis out. What people do with a sensor that they wear is
/// no plan: where it never points, nothing tests the result, and what bends the readings of a
/// restless wrist is not the noise that the covariance knows.
fn orientations(estimate: &Estimate) -> Option<Finding> {
    let fitted = estimate.uses.iter().filter(|u| u.fitted);
    if fitted.clone().filter(|u| u.face.is_none()).count() < MANY_POSES {
        return None;
    }
    let range = |axis: usize| {
        let of = fitted.clone().filter_map(|u| Some(u.direction?[axis]));
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        of.fold(none, |[low, high], v| [low.min(v), high.max(v)])
    };
    let ranges: Vec<[f64; 2]> = (0..3).map(range).collect();
    let covered = |[low, high]: &[f64; 2]| *low < -LEAST_COVERED_G && *high > LEAST_COVERED_G;
    if ranges.iter().all(covered) {
        return None;
    }
    let list: Vec<String> = ["x", "y", "z"]
        .iter()
        .zip(&ranges)
        .map(|(axis, [low, high])| format!("{axis} {low:+.2} to {high:+.2} g"))
        .collect();
    Some(Finding::new(
        FindingKind::FewOrientations,
        format!(
            "not enough orientations: only {} are covered; each axis has to be beyond ±{LEAST_COVERED_G} g on both sides",
            list.join(", ")
        ),
    ))
}

/// Checks of the accelerometer's parameters and placements; `offset` is the zero
/// offset in its bias.
#[must_use]
pub(super) fn accelerometer(
    section: &AccelerometerSection,
    estimate: &Estimate,
    placements: &[Pose],
    offset: f64,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let axes = ["x", "y", "z"];
    if let Some(deviation) = section.scale_deviation_percent {
        let beyond = |limit: f64| -> Option<String> {
            let off: Vec<String> = (0..3)
                .filter(|&i| deviation[i].abs() > limit)
                .map(|i| format!("{} {:+.1} %", axes[i], deviation[i]))
                .collect();
            (!off.is_empty()).then(|| off.join(", "))
        };
        if let Some(off) = beyond(SCALE_GATE_PERCENT) {
            findings.push(Finding::new(
                FindingKind::ScaleOff,
                format!(
                    "the scale is off by more than {SCALE_GATE_PERCENT} % ({off}): a data sheet allows 3; is the unit or the range right?"
                ),
            ));
        } else if let Some(off) = beyond(SCALE_NOTE_PERCENT) {
            findings.push(Finding::new(
                FindingKind::ScaleHigh,
                format!("the scale is further from nominal than usual ({off})"),
            ));
        }
    }
    let bias_mps2: [f64; 3] =
        std::array::from_fn(|i| (section.bias[i] - offset) / section.scale[i]);
    let above = |limit: f64| -> Option<String> {
        let large: Vec<String> = (0..3)
            .filter(|&i| bias_mps2[i].abs() > limit)
            .map(|i| format!("{} {:+.2} m/s²", axes[i], bias_mps2[i]))
            .collect();
        // The zero of unsigned counts is a way of reading, which no data sheet limits.
        (!large.is_empty() && offset == 0.0).then(|| large.join(", "))
    };
    if let Some(large) = above(BIAS_GATE_MPS2) {
        findings.push(Finding::new(
            FindingKind::LargeBias,
            format!("a bias above 0.35 g ({large}): no sensor of this kind has that"),
        ));
    } else if let Some(high) = above(BIAS_NOTE_MPS2) {
        findings.push(Finding::new(
            FindingKind::BiasHigh,
            format!(
                "the bias is {:.1} times what a data sheet allows, ±0.6 m/s² ({high}): was every side that is named really up, and is the unit right?{}",
                bias_mps2.iter().fold(0.0_f64, |m, b| m.max(b.abs())) / (0.5 * BIAS_NOTE_MPS2),
                match section.fit.filter(|fit| fit.prior) {
                    Some(_) => " If the part is like that, --prior off leaves the data sheet out",
                    None => "",
                }
            ),
        ));
    }
    for (index, placement) in placements.iter().enumerate() {
        if estimate.uses[index].fitted && placement.clipped > 0 {
            findings.push(
                Finding::new(
                    FindingKind::ClippedPose,
                    format!(
                        "{}: {} samples at the end of the range; its mean is too small",
                        placement.label, placement.clipped
                    ),
                )
                .in_file(&placement.source),
            );
        }
    }
    findings.extend(oblique(section));
    findings.extend(tilts(section, estimate, placements));
    findings.extend(orientations(estimate));
    findings.extend(fit::findings(section, estimate, placements));
    findings
}

/// Placements that took no part in the fit and contradict it.
fn oblique(section: &AccelerometerSection) -> Option<Finding> {
    let predicted = section.predicted_norm_error_mps2?;
    if section.method != Method::Ferraris {
        return None;
    }
    let (error, count) = section.free_norm_error()?;
    (error > OBLIQUE_GATE * predicted).then(|| {
        Finding::new(
            FindingKind::FreePoseOff,
            format!(
                "{count} free poses, which took no part in the fit, read the magnitude off by {:.0} mg rms, more than {OBLIQUE_GATE} times what was predicted: was the sensor moving there, or is one of the faces wrong?",
                milli_g(error)
            ),
        )
    })
}

/// Inputs that do not belong into a session: a recording that is calibrated
/// already, or the same one twice.
#[must_use]
pub(super) fn inputs(recordings: &[Recording]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (i, recording) in recordings.iter().enumerate() {
        if recording.is_calibrated {
            findings.push(
                Finding::new(
                    FindingKind::AlreadyCalibrated,
                    format!(
                        "{}: a session needs raw recordings",
                        why_calibrated(recording.is_calibrated_by_board)
                    ),
                )
                .in_file(&recording.name),
            );
        }
        let twin = recordings[..i]
            .iter()
            .find(|other| recording.sha256.is_some() && other.sha256 == recording.sha256);
        if let Some(twin) = twin {
            findings.push(
                Finding::new(
                    FindingKind::SameFileTwice,
                    format!(
                        "it is the same as {}, byte for byte, and counts twice",
                        twin.name
                    ),
                )
                .in_file(&recording.name),
            );
        }
    }
    findings
}

/// Tilts: of single faces that lie far off, and of all when they are larger
/// than the uncertainty assumes.
fn tilts(section: &AccelerometerSection, estimate: &Estimate, placements: &[Pose]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut list = Vec::new();
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for (index, placement) in placements.iter().enumerate() {
        let Some(face) = estimate.uses[index].face else {
            continue;
        };
        let tilt = estimate.uses[index]
            .tilt_deg
            .map_or(placement.angle_deg, |(t, _)| t);
        list.push(format!("{} {tilt:.1}°", face.name()));
        (low, high) = (low.min(tilt), high.max(tilt));
        if tilt > FACE_NOTE_DEG {
            findings.push(
                Finding::new(
                    FindingKind::FaceTilt,
                    format!(
                        "{} lies {tilt:.1}° off its face (raw, bias included): more than {FACE_NOTE_DEG}° costs accuracy",
                        face.name()
                    ),
                )
                .in_file(&placement.source),
            );
        }
    }
    let Some(tilt) = section.pose_tilt_deg else {
        return findings;
    };
    if let By::Ferraris {
        face_angle_rms_deg, ..
    } = estimate.by
        && tilt.source == TiltSource::Estimated
    {
        findings.push(Finding::new(
            FindingKind::PoseTilt,
            format!(
                "the poses lie {low:.1}–{high:.1}° off their faces ({}), {face_angle_rms_deg:.1}° rms without the bias. Six faces cannot tell pose from misalignment, R shows both{}. A box or a jig would help",
                list.join(", "),
                if section.covariance.is_some() {
                    format!("; the uncertainty is computed with a tilt of {:.1}°", tilt.value)
                } else {
                    String::new()
                }
            ),
        ));
    }
    findings
}

/// Names that, taken together, describe a mirrored sensor: placements were
/// swapped. All six the other way round is a convention, and a turned board a
/// mounting; both keep the data's word.
#[must_use]
pub(super) fn names(axes: &AxisMap, placements: &[Pose], by_name: bool) -> Vec<Finding> {
    if by_name {
        return Vec::new();
    }
    // Where the names send each face of the data.
    let mut sent: [Option<Face>; 6] = [None; 6];
    for placement in placements {
        if let (Some(Claim::Face(claimed)), Some(face)) = (placement.claim, placement.face) {
            sent[face.index()] = Some(claimed);
        }
    }
    let [Some(a), Some(b), Some(c), Some(d), Some(e), Some(f)] = sent else {
        return Vec::new();
    };
    let all = [a, b, c, d, e, f];
    if all == Face::all() {
        return Vec::new();
    }
    if all == Face::all().map(Face::opposite) {
        return vec![Finding::new(
            FindingKind::NamesReversed,
            "every name says the opposite of the data, which are believed: either a sign means the axis that points down here, or the sensor reads −g where an axis points up, as iPhones do; then --axes -x,-y,-z gives calibrated values the usual sign",
        )];
    }
    if let Some(map) = axes.renamed(&all) {
        return vec![Finding::new(
            FindingKind::NamesTurned,
            if axes.is_identity() {
                format!(
                    "the names describe a board that sits turned in its case; the calibration is in axes of the board. If the case is meant, --axes {map} explains all names"
                )
            } else {
                format!(
                    "the names describe another way of sitting in the case than --axes {axes} does, which is believed; --axes {map} explains all names"
                )
            },
        )];
    }
    vec![Finding::new(
        FindingKind::NamesMirrored,
        "the names contradict the data in a way that no mounting explains (two poses swapped?); the faces were taken from the data, but check which recording is which",
    )]
}
