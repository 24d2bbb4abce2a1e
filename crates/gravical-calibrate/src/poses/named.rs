//! Poses that the user names: a section list or a label column.

use std::ops::Range;

use crate::Result;
use crate::finding::{Case, Finding};
use crate::problem::Problem;
use crate::recording::{Labels, Recording};

use super::face::{AXES, Claim, claim};
use super::sections::Section;
use super::{Interval, Pose};

/// Poses and turns of a section list.
pub(super) fn by_sections(recording: &Recording, sections: &[Section]) -> Result<Vec<Interval>> {
    let rows = recording.rows();
    let is_wrong = |s: &&Section| s.rows.is_empty() || s.rows.end > rows;
    if let Some(Section { label, rows: wrong }) = sections.iter().find(is_wrong) {
        let beyond = Problem::SectionBeyond {
            label: label.clone(),
            section: wrong.clone(),
            rows,
        };
        return Err(beyond.error().at(recording.name.as_ref(), None));
    }
    let named = sections.iter().map(|s| (s.label.as_str(), s.rows.clone()));
    Ok(named.map(|named| interval(0, named)).collect())
}

/// Poses and turns of a label column; no poses where its labels claim fewer than two. Parted by
/// other labels a pose is a repeat, which may lie a little differently.
pub(super) fn by_labels(
    index: usize,
    recording: &Recording,
    findings: &mut Vec<Finding>,
) -> Vec<Interval> {
    let Some(labels) = &recording.labels else {
        return Vec::new();
    };
    let (named, unknown): (Vec<_>, Vec<_>) = stretches(labels)
        .into_iter()
        .partition(|(label, _)| claim(label).is_some() || is_pose(label));
    let named = named.into_iter().map(|named| interval(index, named));
    let (turns, poses): (Vec<_>, Vec<Interval>) = named.partition(Interval::is_turn);
    if poses.iter().all(|pose| pose.label == poses[0].label) {
        return turns;
    }
    if !unknown.is_empty() {
        let mut labels: Vec<String> = unknown.iter().map(|(l, _)| (*l).to_owned()).collect();
        labels.dedup();
        let rows: usize = unknown.iter().map(|(_, rows)| rows.len()).sum();
        let left_out = Case::LabelsLeftOut { rows, labels }.finding();
        findings.push(left_out.counting(rows as u64).in_file(&recording.name));
    }
    poses.into_iter().chain(turns).collect()
}

/// Rows of each label, repeats of one after the other.
fn stretches(labels: &Labels) -> Vec<(&str, Range<usize>)> {
    let mut stretches: Vec<(u32, Range<usize>)> = Vec::new();
    for (row, &label) in labels.of_row.iter().enumerate() {
        match stretches.last_mut() {
            Some((last, rows)) if *last == label => rows.end = row + 1,
            _ => stretches.push((label, row..row + 1)),
        }
    }
    stretches.sort_by_key(|(label, _)| *label);
    let named = stretches.into_iter();
    let named = named.map(|(label, rows)| (labels.names[label as usize].as_str(), rows));
    named.collect()
}

fn interval(recording: usize, (label, rows): (&str, Range<usize>)) -> Interval {
    Interval {
        label: label.to_owned(),
        recording,
        rows,
        is_found: false,
        claim: claim(label),
    }
}

/// Names that the data contradict. The data win.
pub(super) fn check_names(poses: &[Pose]) -> Vec<Finding> {
    let mismatch = |pose: &Pose| {
        let face = pose.face?;
        let claimed = match pose.claim? {
            Claim::Face(claimed) if claimed != face => claimed.name(),
            Claim::Axis(axis) if axis != face.axis => format!("the {} axis", AXES[axis]),
            _ => return None,
        };
        let mismatch = Case::OrientationMismatch {
            pose: pose.label.clone(),
            claimed,
            up: face.name(),
        };
        Some(mismatch.finding().in_file(&pose.source))
    };
    poses.iter().filter_map(mismatch).collect()
}

/// True for a label that counts poses without naming a face: `pose 7`,
/// `free_2`, `p12`, `oblique`. Other words may be anything (`walking`).
fn is_pose(label: &str) -> bool {
    let label = label.trim().to_lowercase();
    let word = label.trim_end_matches(|c: char| c.is_ascii_digit());
    let numbered = word.len() < label.len();
    match word.trim_end_matches([' ', '_', '-', '.', '#']) {
        "free" | "oblique" => true,
        "pose" | "p" | "still" | "hold" | "position" | "placement" => numbered,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::is_pose;

    #[test]
    fn labels_that_count_placements() {
        for label in [
            "pose 7", "Pose_12", "p3", "free", "free-2", "oblique", "still#4",
        ] {
            assert!(is_pose(label), "{label}");
        }
        for label in ["walking", "pose", "p", "rest 3", "step_p3x", ""] {
            assert!(!is_pose(label), "{label}");
        }
    }
}
