//! Poses and turns that the user names: a section list or a label column.

use std::ops::Range;

use crate::recording::{Finding, FindingKind, Recording};
use crate::{Error, Result};

use super::face::{Claim, claim};
use super::sections::Section;
use super::{Interval, SegmentOptions, Selection, Turn};

/// Poses and turns of a section list.
pub(super) fn by_sections(
    recording: &Recording,
    sections: &[Section],
    options: &SegmentOptions,
) -> Result<(Vec<Interval>, Vec<Turn>)> {
    let rows = recording.rows();
    if let Some(beyond) = sections.iter().find(|s| s.rows.end > rows) {
        return Err(Error::input(
            "sections-range",
            format!(
                "section \"{}\" ends at row {}, the recording has {rows} rows",
                beyond.label, beyond.rows.end
            ),
        )
        .at(recording.name.as_ref(), None)
        .with_hint("rows are data rows counted from 0 (header and blank lines do not count), the end is exclusive"));
    }
    let named = sections
        .iter()
        .map(|s| (s.label.clone(), vec![s.rows.clone()]));
    split(0, recording, named.collect(), options)
}

/// Poses and turns of a label column; none when there is no such column
/// or its labels claim no pose.
pub(super) fn by_labels(
    index: usize,
    recording: &Recording,
    options: &SegmentOptions,
    findings: &mut Vec<Finding>,
) -> Option<Result<(Vec<Interval>, Vec<Turn>)>> {
    let labels = recording.labels.as_ref()?;
    let mut stretches: Vec<Vec<Range<usize>>> = vec![Vec::new(); labels.names.len()];
    let mut from = 0;
    for row in 1..=labels.of_row.len() {
        if row == labels.of_row.len() || labels.of_row[row] != labels.of_row[from] {
            stretches[labels.of_row[from] as usize].push(from..row);
            from = row;
        }
    }
    let mut named = Vec::new();
    let mut unknown = Vec::new();
    for (name, rows) in labels.names.iter().zip(stretches) {
        match claim(name) {
            Some(_) => named.push((name.clone(), rows)),
            None if is_pose(name) => named.push((name.clone(), rows)),
            None => unknown.push((name.clone(), rows)),
        }
    }
    let poses = named
        .iter()
        .filter(|(n, _)| !matches!(claim(n), Some(Claim::Turn(_))))
        .count();
    if poses < 2 {
        return None;
    }
    if !unknown.is_empty() {
        let names: Vec<&str> = unknown.iter().map(|(n, _)| n.as_str()).collect();
        let rows: usize = unknown.iter().flat_map(|(_, r)| r).map(|r| r.len()).sum();
        findings.push(
            Finding::new(
                FindingKind::LabelsLeftOut,
                format!(
                    "{rows} rows labelled \"{}\" name no pose or turn; left out",
                    names.join("\", \"")
                ),
            )
            .counting(rows as u64)
            .in_file(&recording.name),
        );
    }
    Some(split(index, recording, named, options))
}

fn split(
    index: usize,
    recording: &Recording,
    named: Vec<(String, Vec<Range<usize>>)>,
    options: &SegmentOptions,
) -> Result<(Vec<Interval>, Vec<Turn>)> {
    let (mut intervals, mut turns) = (Vec::new(), Vec::new());
    for (label, rows) in named {
        match claim(&label) {
            Some(Claim::Turn(axis)) => {
                if recording.gyro.is_none() {
                    return Err(Error::input(
                        "missing-gyro",
                        format!("\"{label}\" is a turn, but the recording has no gyroscope"),
                    )
                    .at(recording.name.as_ref(), None)
                    .with_hint(
                        "leave the turns out, or name the gyroscope's columns with --columns",
                    ));
                }
                // A turn is one motion: its stretches belong together only if
                // they follow each other.
                turns.extend(rows.into_iter().map(|rows| Turn {
                    label: label.clone(),
                    axis,
                    recording: index,
                    integrated: rows.clone(),
                    rows,
                }));
            }
            // Parted by other labels it is a repeat of the pose, which may
            // lie a little differently.
            claim => intervals.extend(rows.into_iter().map(|rows| Interval {
                label: label.clone(),
                recording: index,
                rows: first_rows(vec![rows], options.rows),
                selection: Selection::Given,
                claim,
            })),
        }
    }
    Ok((intervals, turns))
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

/// The first `limit` rows of several stretches.
pub(super) fn first_rows(stretches: Vec<Range<usize>>, limit: Option<usize>) -> Vec<Range<usize>> {
    let Some(mut left) = limit else {
        return stretches;
    };
    let mut out = Vec::new();
    for stretch in stretches {
        let take = stretch.len().min(left);
        if take > 0 {
            out.push(stretch.start..stretch.start + take);
        }
        left -= take;
    }
    out
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
