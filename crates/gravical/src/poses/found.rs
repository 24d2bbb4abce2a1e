//! Poses that are found: the longest quiet part of a file that rests one, or
//! all rests of a continuous recording.

use std::ops::Range;
use std::path::Path;

use gravical_core::matrix3;

use crate::recording::{Finding, FindingKind, Recording};
use crate::{Error, Result};

use super::face::{Claim, angle_deg, claim};
use super::named::first_rows;
use super::rests::{find_quiet, find_rests, why_never_static};
use super::{Interval, SegmentOptions, Selection};
use crate::stats::moments;

/// Poses of one recording of a session. What is in the file decides how
/// many: a recording that stands alone, or whose rests point in more directions
/// than its name speaks of, is continuous and gives all its rests; any other
/// gives the longest rest of every direction, in each stretch between blank
/// rows.
///
/// # Errors
///
/// `never-static` for a lone recording that is nowhere, or hardly ever, at rest, or for a few rows that are
/// neither a pose nor a table of means.
pub(super) fn in_recording(
    index: usize,
    recordings: &[Recording],
    options: &SegmentOptions,
    findings: &mut Vec<Finding>,
) -> Result<Vec<Interval>> {
    let recording = &recordings[index];
    let alone = recordings.len() == 1;
    let found = find_rests(recording);
    if found.is_worn {
        findings.push(
            Finding::new(
                FindingKind::WornSensor,
                "half a day with many static intervals: the sensor is worn, and rests of less than 10 s are not used",
            )
            .in_file(&recording.name),
        );
    }
    let rests = longest_per_pose(recording, found.spans);
    let rows_at_rest: usize = rests.iter().map(|r| r.len()).sum();
    let hardly_static = rows_at_rest * 10 < recording.rows();
    if alone && is_table_of_means(recording, hardly_static) {
        return Ok(rows_as_poses(index, recording, findings));
    }
    if rests.is_empty() && recording.rows() < FEW_ROWS {
        if let Some(means) = means_of_rows(index, recording, findings)
            && (alone || means.is_ok())
        {
            return means;
        }
        if alone {
            // Too short to look for rests in: a handful of rows of one pose.
            return Ok(intervals_of(
                index,
                recording.segments(),
                None,
                Selection::Given,
            ));
        }
    }
    if alone && rests.is_empty() {
        return Err(never_still(recordings));
    }
    // Without a rate a rest may be a pause of a motion.
    let (rows, assumed) = (recording.rows(), recording.working_rate_hz().1);
    if alone && (rows_at_rest * 50 < rows && rests.len() < 6 || assumed && hardly_static) {
        return Err(hardly_still(
            recording,
            rows_at_rest,
            directions(recording, &rests, None).len(),
        ));
    }
    let stem = gravical_recording::source::stem(&recording.name);
    let segments = recording.segments();
    // A name with a sign speaks of one pose; with two stretches in the
    // file it can speak of neither.
    let claimed = claim(&stem).filter(|c| {
        matches!(c, Claim::Axis(_)) || (matches!(c, Claim::Face(_)) && segments.len() == 1)
    });
    let expected = if matches!(claimed, Some(Claim::Axis(_))) {
        2
    } else {
        1
    };
    if alone || directions(recording, &rests, claimed).len() > expected * segments.len() {
        let parts = match options.rows {
            None => {
                return Ok(intervals_of(
                    index,
                    rests,
                    (!alone).then_some(&stem),
                    Selection::Found,
                ));
            }
            Some(_) if alone && segments.len() > 1 => segments,
            Some(_) => rests,
        };
        let spans = parts
            .into_iter()
            .flat_map(|p| first_rows(vec![p], options.rows))
            .collect();
        return Ok(intervals_of(
            index,
            spans,
            (!alone).then_some(&stem),
            Selection::Given,
        ));
    }
    let mut intervals = Vec::new();
    let mut quiet: Option<Vec<Range<usize>>> = None;
    for (at, segment) in segments.iter().enumerate() {
        let label = if segments.len() > 1 {
            format!("{stem} part {}", at + 1)
        } else {
            stem.clone()
        };
        let mut interval = |rows, selection, claim| {
            intervals.push(Interval {
                label: label.clone(),
                recording: index,
                rows: vec![rows],
                selection,
                claim,
            });
        };
        if options.rows.is_some() {
            for rows in first_rows(vec![segment.clone()], options.rows) {
                interval(rows, Selection::Given, claimed);
            }
            continue;
        }
        let inside: Vec<_> = rests
            .iter()
            .filter(|s| s.start >= segment.start && s.end <= segment.end)
            .cloned()
            .collect();
        let mut spans = directions(recording, &inside, claimed);
        if !spans.is_empty() {
            tell_motion(recording, segment, &spans, &inside, findings);
        } else if let Some(held) =
            longest_within(quiet.get_or_insert_with(|| find_quiet(recording)), segment)
        {
            findings.push(held_by_hand(recording, &label, &held));
            spans.push(held);
        }
        if spans.is_empty() {
            if let Some(rows) = without_rest(recording, segment, &label, findings) {
                interval(rows, Selection::Given, claimed);
            }
            continue;
        }
        for span in spans {
            interval(span, Selection::Found, claimed);
        }
    }
    Ok(intervals)
}

/// Fewer rows than these are too few to look for rests in.
const FEW_ROWS: usize = 40;

/// Poses one after the other, `pose 1` …, with the name of their file where
/// there are several.
pub(crate) fn intervals_of(
    index: usize,
    spans: Vec<Range<usize>>,
    stem: Option<&String>,
    selection: Selection,
) -> Vec<Interval> {
    let file = stem.map_or_else(String::new, |stem| format!(" of {stem}"));
    let interval = |(i, rows)| Interval {
        label: format!("pose {}{file}", i + 1),
        recording: index,
        rows: vec![rows],
        selection,
        claim: None,
    };
    spans.into_iter().enumerate().map(interval).collect()
}

/// Directions further apart than this are two poses, degrees: a pose
/// that is taken up and put down again comes back within a few.
const APART_DEG: f64 = 10.0;

/// Beside the pose that the name of a file speaks of, a rest shorter than
/// this share of it is handling.
const HANDLING: f64 = 0.25;

/// The longest rest of every direction, in order.
fn directions(
    recording: &Recording,
    rests: &[Range<usize>],
    claimed: Option<Claim>,
) -> Vec<Range<usize>> {
    let mut found: Vec<([f64; 3], Range<usize>)> = Vec::new();
    for span in rests {
        let (mean, _) = moments(&recording.accel, span.clone());
        match found
            .iter_mut()
            .find(|(other, _)| angle_deg(*other, mean) < APART_DEG)
        {
            Some((_, kept)) if kept.len() < span.len() => {
                *kept = span.clone();
            }
            Some(_) => {}
            None => found.push((mean, span.clone())),
        }
    }
    if matches!(claimed, Some(Claim::Face(_))) {
        let longest = found.iter().map(|(_, s)| s.len()).max().unwrap_or(0);
        found.retain(|(_, s)| s.len() as f64 >= HANDLING * longest as f64);
    }
    found.sort_by_key(|(_, s)| s.start);
    found.into_iter().map(|(_, s)| s).collect()
}

/// A table of means: every row a pose of its own, where the rows lie far
/// apart and are alike in magnitude. None where the rows point one way.
///
/// # Errors
///
/// `never-static` for rows that point in several directions and are no such table.
fn means_of_rows(
    index: usize,
    recording: &Recording,
    findings: &mut Vec<Finding>,
) -> Option<Result<Vec<Interval>>> {
    const MIN_DIRECTIONS: usize = 6;
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
    // Rows of one pose, however shaken, are many in few directions.
    if apart.len() < 2 || rows.len() > 4 * apart.len() {
        return None;
    }
    let norms: Vec<f64> = rows.iter().map(matrix3::norm).collect();
    let usual = crate::stats::median(&mut norms.clone())?;
    let alike = norms.iter().all(|n| (n / usual - 1.0).abs() < ALIKE);
    if alike && apart.len() >= MIN_DIRECTIONS {
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
fn rows_as_poses(
    index: usize,
    recording: &Recording,
    findings: &mut Vec<Finding>,
) -> Vec<Interval> {
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
    let interval = |row: usize| Interval {
        label: format!("line {}", recording.line(row)),
        recording: index,
        rows: std::iter::once(row..row + 1).collect(),
        selection: Selection::Given,
        claim: None,
    };
    (0..recording.rows()).map(interval).collect()
}

/// Rows that point everywhere and lie on a sphere are means, however many they are: of orientations in
/// no order, of which one follows another far off, or of rests of days, which have no time stamps.
fn is_table_of_means(recording: &Recording, hardly_static: bool) -> bool {
    const MIN_DIRECTIONS: usize = 12;
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
    if !(jump > JUMP_DEG || (hardly_static && recording.time_s.is_none())) {
        return false;
    }
    let mut directions: Vec<[f64; 3]> = Vec::new();
    for row in &rows {
        let is_new = |d: &[f64; 3]| angle_deg(*d, *row) > FAR_APART_DEG;
        if directions.len() < MIN_DIRECTIONS && directions.iter().all(is_new) {
            directions.push(*row);
        }
    }
    directions.len() == MIN_DIRECTIONS && off_sphere(&rows).is_some_and(|off| off < ON_SPHERE)
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

/// Rests that a twitch of less than a second parts and that point the same way
/// are one pose: its longest part is taken.
fn longest_per_pose(recording: &Recording, spans: Vec<Range<usize>>) -> Vec<Range<usize>> {
    const TWITCH_S: f64 = 1.0;
    const SAME_DEG: f64 = 3.0;
    let near = (TWITCH_S * recording.working_rate_hz().0) as usize;
    let mean = |span: &Range<usize>| moments(&recording.accel, span.clone()).0;
    let mut out: Vec<Range<usize>> = Vec::new();
    let mut end = 0;
    for span in spans {
        let twitched = out.last().is_some_and(|last| {
            let between = end - 1..span.start + 1;
            between.len() < near + 2
                && !recording.is_broken(&between)
                && angle_deg(mean(last), mean(&span)) < SAME_DEG
        });
        end = span.end;
        match out.last_mut() {
            Some(last) if twitched => {
                if span.len() > last.len() {
                    *last = span;
                }
            }
            _ => out.push(span),
        }
    }
    out
}

pub(super) fn never_still(recordings: &[Recording]) -> Error {
    let first = &recordings[0];
    let what = match recordings {
        [_] => format!(
            "the recording is never at rest: {}",
            why_never_static(first)
        ),
        _ => format!(
            "the recordings are never at rest; {}: {}",
            first.name,
            why_never_static(first)
        ),
    };
    Error::input("never-static", what)
        .at(Path::new(&first.name), None)
        .with_hint(
            "lay the sensor down for 3 s or more in each position; `gravical inspect` shows the static intervals",
        )
}

/// So little of a recording is at rest, and in so few poses, that most of it is something else.
fn hardly_still(recording: &Recording, rows_at_rest: usize, poses: usize) -> Error {
    let (rate, is_assumed) = recording.working_rate_hz();
    let time = |rows: usize| match rows as f64 / rate {
        _ if is_assumed => format!("{rows} rows"),
        short if short < 10.0 => format!("{short:.1} s"),
        long => format!("{long:.0} s"),
    };
    Error::input(
        "never-static",
        format!(
            "at rest for {} of {}, in {}: too little for a calibration",
            time(rows_at_rest),
            time(recording.rows()),
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

fn longest_within(spans: &[Range<usize>], segment: &Range<usize>) -> Option<Range<usize>> {
    let inside = spans
        .iter()
        .filter(|s| segment.start <= s.start && s.end <= segment.end);
    inside.max_by_key(|s| s.len()).cloned()
}

/// A stretch without a rest: its rows when it is too short to judge, else none
/// and a warning.
fn without_rest(
    recording: &Recording,
    segment: &Range<usize>,
    label: &str,
    findings: &mut Vec<Finding>,
) -> Option<Range<usize>> {
    let (rate, _) = recording.working_rate_hz();
    let rows = segment.len();
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
pub(crate) fn is_too_short(rows: usize, rate: f64) -> bool {
    rows < (rate as usize).max(FEW_ROWS)
}

/// Says that a pose was taken from what is no rest.
fn held_by_hand(recording: &Recording, label: &str, rows: &Range<usize>) -> Finding {
    let (mean, variance) = moments(&recording.accel, rows.clone());
    let text = format!(
        "{label}: never quite at rest; the longest quiet part, lines {} to {}, moves by {:.0} mg rms and is used",
        recording.line(rows.start),
        recording.line(rows.end - 1),
        1000.0 * (variance / 3.0).sqrt() / matrix3::norm(&mean)
    );
    Finding::new(FindingKind::UnsteadyPose, text).in_file(&recording.name)
}

/// Says how much of a file is motion or a shorter rest, and thus not in the
/// mean.
fn tell_motion(
    recording: &Recording,
    segment: &Range<usize>,
    spans: &[Range<usize>],
    rests: &[Range<usize>],
    findings: &mut Vec<Finding>,
) {
    let rows = |spans: &[Range<usize>]| spans.iter().map(|s| s.len()).sum::<usize>();
    let (used, all) = (rows(spans), segment.len());
    if used * 10 >= all * 9 {
        return;
    }
    let parts: Vec<String> = spans
        .iter()
        .map(|s| format!("{}-{}", recording.line(s.start), recording.line(s.end - 1)))
        .collect();
    let shorter = rows(rests) - used;
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
