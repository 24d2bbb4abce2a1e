//! Poses held against names and against each other.

use crate::finding::finding;
use crate::recording::{Finding, Recording};
use crate::stats::floors;
use crate::stats::moments;

use super::face::{self, Claim, Face, angle_deg};
use super::{Pose, SegmentOptions};

/// Poses that shake many times as much as the usual one of the session.
pub(super) fn check_steadiness(
    poses: &[Pose],
    held: &[[Vec<f64>; 3]],
    recordings: &[Recording],
    findings: &mut Vec<Finding>,
) {
    let shake = |(p, held): (&Pose, &[Vec<f64>; 3])| -> f64 {
        let variance = moments(held, 0..held[0].len()).1;
        // Rounding shakes that much, whether it shows or not.
        variance
            .max(floors(&recordings[p.recording].accel_resolution()))
            .sqrt()
    };
    let all: Vec<f64> = poses.iter().zip(held).map(shake).collect();
    let Some(usual) = crate::stats::median(&mut all.clone()) else {
        return;
    };
    for (pose, own) in poses.iter().zip(&all) {
        if *own > UNSTEADY * usual && usual > 0.0 {
            let unsteady = finding!(
                UnsteadyPose,
                "{}: shakes {:.0} times as much as the usual pose of this session; was it moving?",
                pose.label,
                own / usual
            );
            findings.push(unsteady.in_file(&pose.source));
        }
    }
}

/// Poses that shake so many times as much as the median one are worth a word.
const UNSTEADY: f64 = 6.0;

/// Compares names with data. The data win, with a warning, unless the user
/// believes the names.
pub(super) fn check_names(
    poses: &mut [Pose],
    options: &SegmentOptions,
    findings: &mut Vec<Finding>,
) {
    for pose in poses {
        let Some(Claim::Face(claimed)) = pose.claim else {
            if let (Some(Claim::Axis(axis)), Some(face)) = (pose.claim, pose.face)
                && axis != face.axis
            {
                findings.push(mismatch(
                    pose,
                    &format!("the {} axis", face::AXES[axis]),
                    face,
                ));
            }
            continue;
        };
        if options.faces_from.are_names() {
            let reading = options.axes.to_case(pose.mean);
            pose.angle_deg = angle_deg(reading, claimed.direction());
            pose.face = Some(claimed);
        } else if let Some(face) = pose.face
            && face != claimed
        {
            findings.push(mismatch(pose, &claimed.name(), face));
        }
    }
}

fn mismatch(pose: &Pose, claimed: &str, face: Face) -> Finding {
    let mismatch = finding!(
        OrientationMismatch,
        "\"{}\" claims {claimed}, but {} points up there; the data are believed",
        pose.label,
        face.name()
    );
    mismatch.in_file(&pose.source)
}
