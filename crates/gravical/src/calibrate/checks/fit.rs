//! What the fit itself shows to be odd.

use crate::calibrate::estimate::{Estimate, UNUSUAL_TILT};
use crate::calibration_file::{AccelerometerSection, TiltSource};
use crate::numfmt::milli_g;
use crate::poses::Pose;
use crate::poses::face::{Claim, Face};
use crate::recording::{Finding, FindingKind};

/// Two axes further from a right angle than this are no MPU6050's, cosine:
/// two and a half times the ±2 % of the data sheet.
const CROSS_AXIS_GATE: f64 = 0.05;
/// A sensor that misses the model by more than this, m/s², does something that
/// the model has no word for.
const MODEL_ERROR_NOTE: f64 = 0.02;

/// Findings about poses and parameters of the fit.
pub(super) fn findings(
    section: &AccelerometerSection,
    estimate: &Estimate,
    placements: &[Pose],
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
    let Some(fit) = estimate.fit() else {
        return findings;
    };
    if estimate.noise_assumed {
        findings.push(Finding::new(
            FindingKind::NoiseAssumed,
            "each row is a mean of unknown standard error: 4 mm/s² were assumed for the uncertainty",
        ));
    }
    findings.extend(face_twice(estimate, placements).or_else(|| missing_face(estimate)));
    if fit.model_error_mps2() > MODEL_ERROR_NOTE {
        findings.push(Finding::new(
            FindingKind::ModelError,
            format!(
                "the poses differ from the model by {:.0} mm/s² beyond their noise: was the sensor at rest, and warm?",
                1000.0 * fit.model_error_mps2()
            ),
        ));
    }
    if !fit.oriented {
        findings.push(Finding::new(
            FindingKind::OrientationOpen,
            "faces on fewer than two axes: the orientation of the sensor in its case is unknown. The frame was fixed by convention (triangular matrix); magnitudes are not affected",
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

/// A face that was recorded twice in place of another one, which is missing: by
/// its name, or because there are six placements.
fn face_twice(estimate: &Estimate, placements: &[Pose]) -> Option<Finding> {
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
fn missing_face(estimate: &Estimate) -> Option<Finding> {
    let uses = || estimate.uses.iter().filter(|u| u.fitted);
    let missing: Vec<Face> = Face::all()
        .into_iter()
        .filter(|f| uses().all(|u| u.face != Some(*f)))
        .collect();
    if missing.is_empty() || uses().any(|u| u.face.is_none()) {
        return None;
    }
    let fit = estimate.fit()?;
    let list: Vec<String> = missing
        .iter()
        .map(|face| {
            let (_, sd) = fit.error_along(face.direction());
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
