//! What the joint fit itself shows to be odd.

use crate::calibration_file::{AccelerometerSection, TiltSource};
use crate::estimate::accelerometer::{Estimate, Method, UNUSUAL_TILT};
use crate::numfmt::milli_g;
use crate::predicted::{sensitivity, variance};
use crate::recording::{Finding, FindingKind};
use crate::segment::Placement;
use crate::segment::face::{Claim, Face};

/// Nine parameters of the magnitude with a condition above this hang on details.
const CONDITION_NOTE: f64 = 30.0;
/// Two axes further from a right angle than this are no MPU6050's, cosine:
/// two and a half times the ±2 % of the data sheet.
const CROSS_AXIS_GATE: f64 = 0.05;
/// A sensor that misses the model by more than this, m/s², does something that
/// the model has no word for.
const MODEL_ERROR_NOTE: f64 = 0.02;

/// Findings about poses and parameters of the joint fit.
pub(super) fn findings(
    section: &AccelerometerSection,
    estimate: &Estimate,
    placements: &[Placement],
    gravity: f64,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let cosines = cosines(section);
    if let Some((pair, cosine)) = cosines
        .into_iter()
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
        && cosine.abs() > CROSS_AXIS_GATE
    {
        findings.push(Finding::new(
            FindingKind::CrossAxisHigh,
            format!(
                "the axes {pair} are {:.1}° from a right angle; a data sheet allows about 1.6°: too few or too similar poses for so many parameters",
                cosine.asin().to_degrees().abs()
            ),
        ));
    }
    for (k, own) in estimate.uses.iter().enumerate() {
        if let Some(chance) = own.bad {
            findings.push(
                Finding::new(
                    FindingKind::BadPose,
                    format!(
                        "{}: reads {:+.1} mg off the magnitude that all others agree on (chance {chance:.0e}); left out. Was it moving?",
                        section.poses[k].called(),
                        milli_g(magnitude(section, k))
                    ),
                )
                .in_file(&placements[k].source),
            );
        }
        let named = matches!(placements[k].claim, Some(Claim::Face(_)));
        if named && own.face.is_none() && own.bad.is_none() && placements[k].face.is_some() {
            findings.push(
                Finding::new(
                    FindingKind::NoFace,
                    format!(
                        "{} is named a face but lies {:.1}° off it, much further than the others: taken as a free pose (--face-pose {} keeps it)",
                        placements[k].label,
                        placements[k].angle_deg,
                        crate::escape::shell_word(&placements[k].label)
                    ),
                )
                .in_file(&placements[k].source),
            );
        }
    }
    let weak = section
        .fit
        .and_then(|f| f.condition)
        .filter(|c| *c > CONDITION_NOTE);
    let Some(fit) = &estimate.joint else {
        return findings;
    };
    if estimate.noise.assumed {
        findings.push(Finding::new(
            FindingKind::NoiseAssumed,
            "each row is a mean of unknown standard error: 4 mm/s² were assumed for the uncertainty",
        ));
    }
    if estimate.method != Method::Joint {
        findings.extend(weak.map(|condition| {
            Finding::warning(
                FindingKind::IllConditioned,
                format!(
                    "the poses determine the parameters badly (condition {condition:.0}, more than {CONDITION_NOTE}): small errors become large ones. The default method uses faces and data sheet too"
                ),
            )
        }));
        if section.fit.is_some_and(|f| !f.oriented) {
            findings.push(orientation_open(
                "the length of gravity alone does not determine the orientation of the sensor in its case",
            ));
        }
        return findings;
    }
    findings.extend(fit.disputed.iter().map(|sides| disputed(section, sides)));
    findings.extend(face_twice(estimate, placements).or_else(|| missing_face(estimate, gravity)));
    if let Some(quality) = &section.fit {
        if let Some(condition) = weak {
            findings.push(Finding::note(
                FindingKind::IllConditioned,
                format!(
                    "the magnitudes of {} poses alone determine their nine parameters badly (condition {condition:.0}, more than {CONDITION_NOTE}): known faces and the data sheet carry the rest",
                    section.poses.len()
                ),
            ));
        }
        if quality.model_error_mps2 > MODEL_ERROR_NOTE {
            findings.push(Finding::new(
                FindingKind::ModelError,
                format!(
                    "the poses differ from the model by {:.0} mm/s² beyond their noise: was the sensor at rest, and warm?",
                    1000.0 * quality.model_error_mps2
                ),
            ));
        }
    }
    if !fit.oriented {
        findings.push(orientation_open(
            "faces on fewer than two axes: the orientation of the sensor in its case is unknown",
        ));
    }
    if fit.shared_tilts {
        findings.push(Finding::new(
            FindingKind::SamePose,
            "some repeats of a face have the same tilt: they reduce noise, not tilt. Turn the sensor by 180° on the table between repeats",
        ));
    }
    if let Some(tilt) = section.pose_tilt_deg
        && tilt.source == TiltSource::Estimated
        && tilt.value > UNUSUAL_TILT
    {
        let list: Vec<String> = section
            .poses
            .iter()
            .filter_map(|p| {
                Some(format!(
                    "{} {:.1} ± {:.1}°",
                    p.label, p.tilt_deg?, p.tilt_sd_deg?
                ))
            })
            .take(12)
            .collect();
        findings.push(Finding::new(
            FindingKind::PoseTilt,
            format!(
                "the poses lie {:.1}° off their faces in each of two components ({}). A box or a jig would help",
                tilt.value,
                list.join(", ")
            ),
        ));
    }
    findings
}

fn orientation_open(why: &str) -> Finding {
    Finding::new(
        FindingKind::OrientationOpen,
        format!(
            "{why}. The frame was fixed by convention (triangular matrix); magnitudes are not affected"
        ),
    )
}

/// Repeats of one direction that contradict each other with nothing to tell which are right.
fn disputed(section: &AccelerometerSection, sides: &[Vec<usize>; 2]) -> Finding {
    let errors = || sides.iter().flatten().map(|&k| magnitude(section, k));
    let range = errors().fold(f64::NEG_INFINITY, f64::max) - errors().fold(f64::INFINITY, f64::min);
    let [some, others] = sides.each_ref().map(|side| {
        let names = side.iter().map(|&k| section.poses[k].called());
        names.collect::<Vec<_>>().join(", ")
    });
    Finding::new(
        FindingKind::RepeatsContradict,
        format!(
            "poses of one direction differ by up to {:.1} mg in magnitude ({some} against {others}), and nothing tells which are right: all of them count, and the uncertainty is the larger for it. Was the sensor still warming up, or was one of them moved? Record that side again",
            milli_g(range),
        ),
    )
}

/// A face that was recorded twice in place of another one, which is missing: by
/// its name, or because there are six placements.
fn face_twice(estimate: &Estimate, placements: &[Placement]) -> Option<Finding> {
    let up = |k: usize| estimate.uses[k].face;
    let all = || 0..placements.len();
    let missing: Vec<Face> = Face::all()
        .into_iter()
        .filter(|f| all().all(|k| up(k) != Some(*f)))
        .collect();
    let named = |k: usize| match placements[k].claim {
        Some(Claim::Face(f)) => Some(f),
        _ => None,
    };
    let first = |k: usize| all().find(|&j| j != k && up(j) == up(k));
    let wrong = all().filter(|&k| named(k).is_some_and(|f| missing.contains(&f)));
    let by_name = wrong
        .filter(|&k| up(k).is_some())
        .find_map(|k| Some((first(k)?, k)));
    let by_count = || {
        let six = placements.len() == 6 && all().all(|k| up(k).is_some());
        let mut later = all().filter_map(|k| Some((first(k).filter(|&j| j < k)?, k)));
        later.find(|_| six && !missing.is_empty())
    };
    let (one, other) = by_name.or_else(by_count)?;
    let (p, q) = (&placements[one], &placements[other]);
    let copied = p.mean == q.mean && p.count == q.count;
    let absent: Vec<String> = missing.iter().map(|f| f.name()).collect();
    Some(
        Finding::new(
            FindingKind::SameFaceTwice,
            format!(
                "{} points up in \"{}\" and in \"{}\"{}, and no pose has {} up: record {}",
                up(other)?.name(),
                p.label,
                q.label,
                if copied {
                    ", which hold the same readings"
                } else {
                    ""
                },
                absent.join(" or "),
                named(other).filter(|f| missing.contains(f)).map_or_else(
                    || format!("one of them with {} up", absent.join(" and ")),
                    |f| format!("\"{}\" with {} up", q.label, f.name())
                )
            ),
        )
        .in_file(&q.source),
    )
}

/// Faces only, and one of them missing: what that costs.
fn missing_face(estimate: &Estimate, gravity: f64) -> Option<Finding> {
    let uses = || estimate.uses.iter().filter(|u| u.fitted);
    let missing: Vec<Face> = Face::all()
        .into_iter()
        .filter(|f| uses().all(|u| u.face != Some(*f)))
        .collect();
    if missing.is_empty() || uses().any(|u| u.face.is_none()) {
        return None;
    }
    let c = estimate.covariance.as_ref()?;
    let list: Vec<String> = missing
        .iter()
        .map(|face| {
            let h = sensitivity(&estimate.calibration.matrix, face.direction(), gravity);
            let sd = variance(c, &h).max(0.0).sqrt();
            format!("{} up: ±{:.0} mg", face.name(), milli_g(sd))
        })
        .collect();
    Some(Finding::new(
        FindingKind::MissingFace,
        format!(
            "{} of six faces are there; the magnitude is known badly with {} (1σ). Record what is missing, or oblique poses",
            6 - missing.len(),
            list.join(", ")
        ),
    ))
}

fn magnitude(section: &AccelerometerSection, k: usize) -> f64 {
    section
        .poses
        .get(k)
        .and_then(|p| p.magnitude_error_mps2)
        .unwrap_or(f64::NAN)
}

/// Cosines between the sensitive axes.
fn cosines(section: &AccelerometerSection) -> [(&'static str, f64); 3] {
    let r = &section.orientation;
    let dot = |i: usize, j: usize| (0..3).map(|c| r[i][c] * r[j][c]).sum::<f64>();
    [
        ("x and y", dot(0, 1)),
        ("y and z", dot(1, 2)),
        ("z and x", dot(2, 0)),
    ]
}
