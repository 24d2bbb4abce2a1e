//! Poses held against names and against each other.

use crate::finding::finding;
use crate::recording::{Finding, Recording};
use crate::stats::floors;
use crate::stats::moments;

use super::Pose;
use super::face::{self, Claim};

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

/// Names that the data contradict. The data win.
pub(super) fn check_names(poses: &[Pose]) -> Vec<Finding> {
    let mismatch = |pose: &Pose| {
        let face = pose.face?;
        let claimed = match pose.claim? {
            Claim::Face(claimed) if claimed != face => claimed.name(),
            Claim::Axis(axis) if axis != face.axis => format!("the {} axis", face::AXES[axis]),
            _ => return None,
        };
        let mismatch = finding!(
            OrientationMismatch,
            "\"{}\" claims {claimed}, but {} points up there; the data are believed",
            pose.label,
            face.name()
        );
        Some(mismatch.in_file(&pose.source))
    };
    poses.iter().filter_map(mismatch).collect()
}
