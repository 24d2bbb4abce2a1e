//! Placements that are found: the longest quiet part of a file that holds one, or
//! all holds of a continuous recording.

use std::ops::Range;
use std::path::Path;

use gravical_core::matrix3;

use crate::recording::{Finding, FindingKind, Recording};
use crate::{Error, Result};

use super::face::{Claim, angle_deg, claim};
use super::named::first_rows;
use super::spikes;
use super::still::{StillOptions, Stills, find_stills, unsteady};
use super::{Draft, SegmentOptions, Selection};
use crate::still::moments;

/// Placements of one recording of a session. What is in the file decides how
/// many: a recording that stands alone, or whose stills point in more directions
/// than its name speaks of, is continuous and gives all its holds; any other
/// gives the longest still of every direction, in each stretch between blank
/// rows.
///
/// # Errors
///
/// `never-static` for a lone recording that is nowhere, or hardly ever, at rest, or for a few rows that are
/// neither a hold nor a table of means.
pub(super) fn in_recording(
    index: usize,
    recordings: &[Recording],
    options: &SegmentOptions,
    findings: &mut Vec<Finding>,
) -> Result<Vec<Draft>> {
    let mut recording = &recordings[index];
    let alone = recordings.len() == 1;
    let mut stills = find_stills(recording, &options.still);
    if stills.worn {
        findings.push(
            Finding::new(
                FindingKind::WornSensor,
                "the sensor is worn: most of its rests are too restless for its noise; static is what stays within 13 mg on each axis for 10 s or more",
            )
            .in_file(&recording.name),
        );
    }
    // Spikes all over a recording hide its stills.
    let mut despiked = None;
    if stills.spans.is_empty() {
        let mut other = recording.clone();
        let step = other.accel_resolution();
        if spikes::take_out(&mut other.accel, step) > 0 {
            stills = find_stills(&other, &options.still);
            recording = despiked.insert(other);
        }
    }
    let mut spans = stills.spans;
    if !spans.is_empty() {
        spans.extend(hidden_by_spikes(recording, &spans, &options.still));
        spans.sort_by_key(|s| s.start);
    }
    let holds = longest_per_hold(recording, spans);
    if alone && is_table_of_means(recording, holds.is_empty()) {
        return Ok(rows_as_poses(index, recording, findings));
    }
    if holds.is_empty() && recording.rows_in_file() < FEW_ROWS {
        if let Some(means) = means_of_rows(index, recording, findings)
            && (alone || means.is_ok())
        {
            return means;
        }
        if alone {
            // Too short to look for stills in: a handful of rows of one placement.
            return Ok(drafts_of(
                index,
                recording.segments(),
                None,
                Selection::Given,
            ));
        }
    }
    let held: usize = holds.iter().map(|h| recording.length(h)).sum();
    if alone && holds.is_empty() {
        return Err(never_still(&recording.name, 1));
    }
    if alone && held * 50 < recording.rows_in_file() && holds.len() < 6 {
        return Err(hardly_still(
            recording,
            held,
            directions(recording, &holds, None).len(),
        ));
    }
    let stem = crate::recording::open::stem(&recording.name);
    let segments = recording.segments();
    // A name with a sign speaks of one placement; with two stretches in the
    // file it can speak of neither.
    let claimed = claim(&stem).filter(|c| {
        matches!(c, Claim::Axis(_)) || (matches!(c, Claim::Face(_)) && segments.len() == 1)
    });
    let expected = if matches!(claimed, Some(Claim::Axis(_))) {
        2
    } else {
        1
    };
    if alone || directions(recording, &holds, claimed).len() > expected * segments.len() {
        let parts = match options.rows {
            None => {
                return Ok(drafts_of(
                    index,
                    holds,
                    (!alone).then_some(&stem),
                    Selection::Found,
                ));
            }
            Some(_) if alone && segments.len() > 1 => segments,
            Some(_) => holds,
        };
        let spans = parts
            .into_iter()
            .flat_map(|p| first_rows(vec![p], options.rows))
            .collect();
        return Ok(drafts_of(
            index,
            spans,
            (!alone).then_some(&stem),
            Selection::Given,
        ));
    }
    let mut drafts = Vec::new();
    for (at, segment) in segments.iter().enumerate() {
        let label = if segments.len() > 1 {
            format!("{stem} part {}", at + 1)
        } else {
            stem.clone()
        };
        let mut draft = |rows, selection, claim| {
            drafts.push(Draft {
                label: label.clone(),
                recording: index,
                rows: vec![rows],
                selection,
                claim,
            });
        };
        if options.rows.is_some() {
            for rows in first_rows(vec![segment.clone()], options.rows) {
                draft(rows, Selection::Given, claimed);
            }
            continue;
        }
        let inside: Vec<_> = holds
            .iter()
            .filter(|s| s.start >= segment.start && s.end <= segment.end)
            .cloned()
            .collect();
        let mut spans = directions(recording, &inside, claimed);
        if spans.is_empty() {
            let shaky = find_stills(recording, &StillOptions::unsteady());
            spans = shaky
                .spans
                .iter()
                .filter(|s| s.start >= segment.start && s.end <= segment.end)
                .max_by_key(|s| recording.length(s))
                .into_iter()
                .cloned()
                .collect();
            tell_unsteady(recording, &label, &spans, &shaky, findings);
        } else {
            tell_motion(recording, segment, &spans, &inside, findings);
        }
        if spans.is_empty() {
            if let Some(rows) = without_still(recording, segment, &label, findings) {
                draft(rows, Selection::Given, claimed);
            }
            continue;
        }
        for span in spans {
            draft(span, Selection::Found, claimed);
        }
    }
    Ok(drafts)
}

/// Fewer rows than these are too few to look for stills in.
const FEW_ROWS: usize = 40;

/// Placements one after the other, `pose 1` …, with the name of their file where
/// there are several.
pub(crate) fn drafts_of(
    index: usize,
    spans: Vec<Range<usize>>,
    stem: Option<&String>,
    selection: Selection,
) -> Vec<Draft> {
    let file = stem.map_or_else(String::new, |stem| format!(" of {stem}"));
    let draft = |(i, rows)| Draft {
        label: format!("pose {}{file}", i + 1),
        recording: index,
        rows: vec![rows],
        selection,
        claim: None,
    };
    spans.into_iter().enumerate().map(draft).collect()
}

/// Directions further apart than this are two placements, degrees: a placement
/// that is taken up and put down again comes back within a few.
const APART_DEG: f64 = 10.0;

/// Beside the placement that the name of a file speaks of, a still shorter than
/// this share of it is handling.
const HANDLING: f64 = 0.25;

/// The longest still of every direction, in order.
fn directions(
    recording: &Recording,
    stills: &[Range<usize>],
    claimed: Option<Claim>,
) -> Vec<Range<usize>> {
    let mut found: Vec<([f64; 3], Range<usize>)> = Vec::new();
    for span in stills {
        let (mean, _) = moments(&recording.accel, span.clone());
        match found
            .iter_mut()
            .find(|(other, _)| angle_deg(*other, mean) < APART_DEG)
        {
            Some((_, kept)) if recording.length(kept) < recording.length(span) => {
                *kept = span.clone();
            }
            Some(_) => {}
            None => found.push((mean, span.clone())),
        }
    }
    if matches!(claimed, Some(Claim::Face(_))) {
        let length = |s: &Range<usize>| recording.length(s);
        let longest = found.iter().map(|(_, s)| length(s)).max().unwrap_or(0);
        found.retain(|(_, s)| length(s) as f64 >= HANDLING * longest as f64);
    }
    found.sort_by_key(|(_, s)| s.start);
    found.into_iter().map(|(_, s)| s).collect()
}

/// A table of means: every row a placement of its own, where the rows lie far
/// apart and are alike in magnitude. None where the rows point one way.
///
/// # Errors
///
/// `never-static` for rows that point in several directions and are no such table.
fn means_of_rows(
    index: usize,
    recording: &Recording,
    findings: &mut Vec<Finding>,
) -> Option<Result<Vec<Draft>>> {
    const LEAST: usize = 6;
    const FAR_APART_DEG: f64 = 25.0;
    /// What scale and bias of a sensor may make of gravity.
    const ALIKE: f64 = 0.25;
    let rows: Vec<[f64; 3]> = (0..recording.rows())
        .map(|i| recording.accel_at(i))
        .collect();
    let mut apart: Vec<[f64; 3]> = Vec::new();
    for row in &rows {
        if apart
            .iter()
            .all(|other| angle_deg(*other, *row) > FAR_APART_DEG)
        {
            apart.push(*row);
        }
    }
    // Rows of one placement, however shaken, are many in few directions.
    if apart.len() < 2 || rows.len() > 4 * apart.len() {
        return None;
    }
    let norms: Vec<f64> = rows.iter().map(matrix3::norm).collect();
    let usual = crate::stats::median(&mut norms.clone())?;
    let alike = norms.iter().all(|n| (n / usual - 1.0).abs() < ALIKE);
    if alike && apart.len() >= LEAST {
        return Some(Ok(rows_as_poses(index, recording, findings)));
    }
    Some(Err(Error::input(
        "never-static",
        format!(
            "{} rows that point in {} directions more than {FAR_APART_DEG}° apart{}: no recording of a pose, and no table of means",
            rows.len(),
            apart.len(),
            if alike { "" } else { ", and differ in magnitude" }
        ),
    )
    .at(Path::new(&recording.name), None)
    .with_hint("a table of means needs a row for each of six directions or more, or a column \"label\" that names each row (+x, -x … or pose 1 …); a recording needs 3 s at rest in each pose")))
}

/// Every row a pose of its own.
fn rows_as_poses(index: usize, recording: &Recording, findings: &mut Vec<Finding>) -> Vec<Draft> {
    findings.push(
        Finding::new(
            FindingKind::RowsAsPoses,
            format!(
                "{} rows without a static interval; they lie far apart and are alike in magnitude, so that each is used as the mean of a pose",
                recording.rows()
            ),
        )
        .in_file(&recording.name),
    );
    let draft = |row: usize| Draft {
        label: format!("line {}", recording.line(row)),
        recording: index,
        rows: std::iter::once(row..row + 1).collect(),
        selection: Selection::Given,
        claim: None,
    };
    (0..recording.rows()).map(draft).collect()
}

/// Rows that point everywhere and lie on a sphere are means, however many they are: of orientations in
/// no order, of which one follows another far off, or of stills of days, which have no time stamps.
fn is_table_of_means(recording: &Recording, never_static: bool) -> bool {
    const LEAST_DIRECTIONS: usize = 12;
    const FAR_APART_DEG: f64 = 25.0;
    /// One row lies so far from the one before in a table without order.
    const JUMP_DEG: f64 = 10.0;
    /// Deviation of means from a sphere that scale and misalignment make, of its radius, rms.
    const ON_SPHERE: f64 = 0.05;
    let rows: Vec<[f64; 3]> = (0..recording.rows())
        .map(|i| recording.accel_at(i))
        .filter(|row| row.iter().all(|v| v.is_finite()))
        .collect();
    let mut jumps: Vec<f64> = rows.windows(2).map(|w| angle_deg(w[0], w[1])).collect();
    let jump = crate::stats::median(&mut jumps).unwrap_or(0.0);
    if !(jump > JUMP_DEG || (never_static && recording.time_s.is_none())) {
        return false;
    }
    let mut directions: Vec<[f64; 3]> = Vec::new();
    for row in &rows {
        let is_new = |d: &[f64; 3]| angle_deg(*d, *row) > FAR_APART_DEG;
        if directions.len() < LEAST_DIRECTIONS && directions.iter().all(is_new) {
            directions.push(*row);
        }
    }
    directions.len() == LEAST_DIRECTIONS && off_sphere(&rows).is_some_and(|off| off < ON_SPHERE)
}

/// Deviation of rows from the sphere that is nearest to them, of its radius, rms: ‖u‖² = 2 c·u + d is
/// linear in the centre c.
fn off_sphere(rows: &[[f64; 3]]) -> Option<f64> {
    let squares = rows.iter().map(|u| matrix3::dot(u, u));
    let right = nalgebra::DVector::from_iterator(rows.len(), squares);
    let left = nalgebra::DMatrix::from_fn(rows.len(), 4, |k, i| match i {
        3 => 1.0,
        _ => 2.0 * rows[k][i],
    });
    let normal = left.tr_mul(&left).cholesky()?;
    let x = normal.solve(&left.tr_mul(&right));
    let centre = [x[0], x[1], x[2]];
    let radius = (x[3] + matrix3::dot(&centre, &centre)).sqrt();
    let off = |u: &[f64; 3]| matrix3::norm(&matrix3::sub(u, &centre)) / radius - 1.0;
    let sum: f64 = rows.iter().map(|u| off(u).powi(2)).sum();
    Some((sum / rows.len() as f64).sqrt()).filter(|off| off.is_finite())
}

/// Stills that only spikes hide, between those that were found: as many rows stand out from their
/// neighbours in a second of them as transmission errors make, and without these it is at rest.
fn hidden_by_spikes(
    recording: &Recording,
    spans: &[Range<usize>],
    options: &StillOptions,
) -> Vec<Range<usize>> {
    const LEAST_S: f64 = 3.0;
    let rate_hz = recording.working_rate_hz().0;
    let (block, least) = (rate_hz.ceil() as usize, (LEAST_S * rate_hz) as usize);
    let starts = std::iter::once(0).chain(spans.iter().map(|s| s.end));
    let ends = spans.iter().map(|s| s.start).chain([recording.rows()]);
    let gaps: Vec<Range<usize>> = starts
        .zip(ends)
        .filter(|(start, end)| start + least < *end)
        .map(|(start, end)| start..end)
        .collect();
    let step = recording.accel_resolution();
    let mut without: Option<Recording> = None;
    for from in gaps
        .iter()
        .flat_map(|gap| gap.clone().step_by(block.max(1)))
    {
        let rows = from..(from + block).min(recording.rows());
        let mut values = recording.accel.each_ref().map(|c| c[rows.clone()].to_vec());
        if spikes::take_out(&mut values, step) > 0 {
            let other = without.get_or_insert_with(|| recording.clone());
            for (channel, values) in other.accel.iter_mut().zip(values) {
                channel[rows.clone()].copy_from_slice(&values);
            }
        }
    }
    let Some(other) = without else {
        return Vec::new();
    };
    let mut found = find_stills(&other, options).spans;
    found.retain(|s| {
        gaps.iter()
            .any(|gap| gap.start <= s.start && s.end <= gap.end)
    });
    found
}

/// Stills that a twitch of less than a second parts and that point the same way
/// are one hold: its longest part is taken.
fn longest_per_hold(recording: &Recording, spans: Vec<Range<usize>>) -> Vec<Range<usize>> {
    const TWITCH_S: f64 = 1.0;
    const SAME_DEG: f64 = 3.0;
    let near = (TWITCH_S * recording.working_rate_hz().0) as usize;
    let mean = |span: &Range<usize>| moments(&recording.accel, span.clone()).0;
    let mut out: Vec<Range<usize>> = Vec::new();
    let mut end = 0;
    for span in spans {
        let twitched = out.last().is_some_and(|last| {
            let between = end - 1..span.start + 1;
            recording.length(&between) < near + 2
                && !recording.is_broken(&between)
                && angle_deg(mean(last), mean(&span)) < SAME_DEG
        });
        end = span.end;
        match out.last_mut() {
            Some(last) if twitched => {
                if recording.length(&span) > recording.length(last) {
                    *last = span;
                }
            }
            _ => out.push(span),
        }
    }
    out
}

pub(super) fn never_still(name: &str, files: usize) -> Error {
    let what = if files > 1 {
        "the recordings are"
    } else {
        "the recording is"
    };
    Error::input(
        "never-static",
        format!("{what} never at rest long enough for a pose"),
    )
    .at(Path::new(name), None)
    .with_hint(
        "lay the sensor down for 3 s or more in each position; `gravical inspect` shows the static intervals",
    )
}

/// So little of a recording is at rest, and in so few poses, that most of it is something else.
fn hardly_still(recording: &Recording, held: usize, poses: usize) -> Error {
    let (rate, _) = recording.working_rate_hz();
    let seconds = |rows: usize| match rows as f64 / rate {
        short if short < 10.0 => format!("{short:.1}"),
        long => format!("{long:.0}"),
    };
    Error::input(
        "never-static",
        format!(
            "at rest for {} s of {} s, in {}: too little for a calibration",
            seconds(held),
            seconds(recording.rows_in_file()),
            match poses {
                1 => "1 pose".to_owned(),
                n => format!("{n} poses"),
            },
        ),
    )
    .at(Path::new(&recording.name), None)
    .with_hint(
        "lay the sensor down for 3 s or more in each of six poses or more, or cut the file to the part with the poses; `gravical inspect` shows the static intervals",
    )
}

/// A stretch without a still: its rows when it is too short to judge, else none
/// and a warning.
fn without_still(
    recording: &Recording,
    segment: &Range<usize>,
    label: &str,
    findings: &mut Vec<Finding>,
) -> Option<Range<usize>> {
    let (rate, _) = recording.working_rate_hz();
    let rows = recording.length(segment);
    let short = is_too_short(rows, rate);
    let finding = if short {
        Finding::new(
            FindingKind::ShortPose,
            format!("{label}: {rows} rows only; all are used"),
        )
    } else {
        Finding::new(
            FindingKind::NoStaticInterval,
            format!(
                "{label} is never at rest in lines {} to {}: left out",
                recording.line(segment.start),
                recording.line(segment.end - 1)
            ),
        )
    };
    findings.push(finding.in_file(&recording.name));
    short.then(|| segment.clone())
}

/// So few rows at a rate, Hz, are too few to judge.
fn is_too_short(rows: usize, rate: f64) -> bool {
    rows < (rate as usize).max(FEW_ROWS)
}

/// Says that a hold was taken from a rest that was none.
fn tell_unsteady(
    recording: &Recording,
    label: &str,
    spans: &[Range<usize>],
    stills: &Stills,
    findings: &mut Vec<Finding>,
) {
    findings.extend(spans.iter().map(|span| {
        let gravity = matrix3::norm(&moments(&recording.accel, span.clone()).0);
        let others = format!(
            " (its quietest blocks by {:.0})",
            1000.0 * stills.noise / gravity
        );
        unsteady(recording, span, &format!("{label}: "), &others)
    }));
}

/// Says how much of a file is motion or a shorter still, and thus not in the
/// mean.
fn tell_motion(
    recording: &Recording,
    segment: &Range<usize>,
    spans: &[Range<usize>],
    stills: &[Range<usize>],
    findings: &mut Vec<Finding>,
) {
    let rows = |spans: &[Range<usize>]| spans.iter().map(|s| recording.length(s)).sum::<usize>();
    let (used, all) = (rows(spans), recording.length(segment));
    if used * 10 >= all * 9 {
        return;
    }
    let parts: Vec<String> = spans
        .iter()
        .map(|s| format!("{}-{}", recording.line(s.start), recording.line(s.end - 1)))
        .collect();
    let shorter = rows(stills) - used;
    findings.push(
        Finding::new(
            FindingKind::MotionLeftOut,
            format!(
                "at rest in lines {} ({used} of {all} rows); the other rows {}",
                parts.join(", "),
                if shorter > 0 {
                    format!(
                        "are motion and shorter static intervals ({shorter} rows), and are left out"
                    )
                } else {
                    "are motion, and are left out".to_owned()
                }
            ),
        )
        .in_file(&recording.name),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{ReadOptions, read_bytes};

    #[test]
    fn what_hardly_rests_is_told_for_how_long() {
        let text = format!("ax,ay,az\n{}", "0.1,0.2,9.8\n".repeat(1000));
        let options = ReadOptions {
            rate_hz: Some(10.0),
            ..ReadOptions::default()
        };
        let recording = read_bytes(text.as_bytes(), "walk.csv", &options).unwrap();
        let said = |held, poses| hardly_still(&recording, held, poses).to_string();
        for (held, poses, expected) in [
            (15, 1, "at rest for 1.5 s of 100 s, in 1 pose:"),
            (120, 5, "at rest for 12 s of 100 s, in 5 poses:"),
        ] {
            let said = said(held, poses);
            assert!(said.contains(expected), "{said}");
        }
    }
}
