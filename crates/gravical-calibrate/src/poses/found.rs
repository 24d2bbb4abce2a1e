//! Poses that are found: the longest quiet part of a file that rests one, or
//! all rests of a continuous recording.

use std::cell::LazyCell;
use std::ops::Range;
use std::path::Path;

use gravical_core::matrix3;
use gravical_fit::Sphere;
use gravical_signal::stats::moments;

use crate::finding::Case;
use crate::problem::Problem;
use crate::recording::{Finding, Recording};
use crate::{Error, Result};

use super::Interval;
use super::face::{Claim, angle_deg, claim};
use super::nominal::NominalSamples;
use super::pauses::unused_pauses;
use super::rests::{directions, quiet_in, rests_in, why_never_static};

/// Fewer rows than these are too few to look for rests in.
const FEW_ROWS: usize = 40;
/// Means of a table point in directions that are further apart, degrees.
const FAR_APART_DEG: f64 = 25.0;

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
    [findings, unused]: [&mut Vec<Finding>; 2],
) -> Result<Vec<Interval>> {
    let recording = &recordings[index];
    let is_alone = recordings.len() == 1;
    let nominal = NominalSamples::new(recording);
    let rests = longest_per_pose(recording, rests_in(recording, &nominal));
    let rows_at_rest: usize = rests.iter().map(ExactSizeIterator::len).sum();
    let is_hardly_static = rows_at_rest * 10 < recording.rows();
    let few = rests.is_empty() && recording.rows() < FEW_ROWS;
    if (is_alone || few) && is_table_of_means(recording, few, is_hardly_static) {
        return Ok(rows_as_poses(index, recording, findings));
    }
    if is_alone {
        let is_brief = rows_at_rest * 50 < recording.rows() && rests.len() < 6;
        // Without a rate a rest may be a pause of a motion.
        let is_assumed = recording.clock.rate_hz().is_none();
        let rows = recording.rows();
        let problem = match &rests[..] {
            [] if few => Problem::FewRows { rows },
            [] => return Err(no_rest(recording)),
            _ if is_brief || is_assumed && is_hardly_static => Problem::HardlyAtRest {
                rows_at_rest,
                rows,
                poses: directions(recording, &rests, None).len(),
            },
            _ => {
                unused.extend(unused_pauses(recording, &nominal, &rests));
                return Ok(intervals_of(index, rests, None));
            }
        };
        return Err(no_static_interval(recording, problem));
    }
    let segments = recording.segments();
    let stem = gravical_recording::source::stem(&recording.name);
    // A name with a sign speaks of one pose; with two stretches in the
    // file it can speak of neither.
    let claimed = claim(&stem).filter(|c| match c {
        Claim::Axis(_) => true,
        Claim::Face(_) => segments.len() == 1,
        Claim::Turn(_) => false,
    });
    let poses_of_name = 1 + usize::from(matches!(claimed, Some(Claim::Axis(_))));
    if directions(recording, &rests, claimed).len() > poses_of_name * segments.len() {
        unused.extend(unused_pauses(recording, &nominal, &rests));
        return Ok(intervals_of(index, rests, Some(&stem)));
    }
    let quiet = LazyCell::new(|| quiet_in(&nominal));
    let mut intervals = Vec::new();
    for (at, segment) in segments.iter().enumerate() {
        let label = if segments.len() > 1 {
            format!("{stem} part {}", at + 1)
        } else {
            stem.clone()
        };
        let is_inside = |s: &&Range<usize>| segment.start <= s.start && s.end <= segment.end;
        let inside: Vec<_> = rests.iter().filter(is_inside).cloned().collect();
        let mut spans = directions(recording, &inside, claimed);
        let mut is_found = true;
        if spans.is_empty() {
            let (found, finding) = fallback_interval(recording, &quiet, segment, &label);
            let finding = finding.in_file(&recording.name);
            match found {
                Some((rows, steady)) => {
                    spans.push(rows);
                    is_found = steady;
                    findings.push(finding);
                }
                None => unused.push(finding),
            }
        }
        intervals.extend(spans.into_iter().map(|rows| Interval {
            label: label.clone(),
            recording: index,
            rows,
            is_found,
            claim: claimed,
        }));
    }
    Ok(intervals)
}

/// What is used of a stretch between blank rows that has no rest, with a warning: its longest part of those
/// that are `quiet`, which is found, or all of its rows where they are too few to judge.
fn fallback_interval(
    recording: &Recording,
    quiet: &[Range<usize>],
    segment: &Range<usize>,
    label: &str,
) -> (Option<(Range<usize>, bool)>, Finding) {
    let pose = label.to_owned();
    let quiet = quiet.iter();
    let inside = quiet.filter(|s| segment.start <= s.start && s.end <= segment.end);
    if let Some(rows) = inside.max_by_key(|s| s.len()) {
        let (mean, variance) = moments(&recording.accel, rows.clone());
        let unsteady = Case::UnsteadyPose {
            pose,
            lines: recording.lines_of(rows),
            rms_mg: 1000.0 * (variance / 3.0).sqrt() / matrix3::norm(&mean),
        };
        (Some((rows.clone(), true)), unsteady.finding())
    } else if is_too_short(segment.len(), recording.working_rate_hz()) {
        let rows = segment.len();
        let short = Case::ShortPose { pose, rows }.finding();
        (Some((segment.clone(), false)), short)
    } else {
        let lines = recording.lines_of(segment);
        (None, Case::PoseNeverAtRest { pose, lines }.finding())
    }
}

/// So few rows at a rate, Hz, are too few to judge.
#[doc(hidden)]
pub fn is_too_short(rows: usize, rate: f64) -> bool {
    rows < (rate as usize).max(FEW_ROWS)
}

/// Poses one after the other, `pose 1` …, with the name of their file where
/// there are several.
pub(crate) fn intervals_of(
    index: usize,
    spans: Vec<Range<usize>>,
    stem: Option<&String>,
) -> Vec<Interval> {
    let file = stem.map_or_else(String::new, |stem| format!(" of {stem}"));
    let interval = |(i, rows)| Interval {
        label: format!("pose {}{file}", i + 1),
        recording: index,
        rows,
        is_found: true,
        claim: None,
    };
    spans.into_iter().enumerate().map(interval).collect()
}

/// Every row a pose of its own.
fn rows_as_poses(
    index: usize,
    recording: &Recording,
    findings: &mut Vec<Finding>,
) -> Vec<Interval> {
    let rows = recording.rows();
    let means = Case::RowsAsPoses { rows }.finding();
    findings.push(means.in_file(&recording.name));
    let interval = |row: usize| Interval {
        label: format!("line {}", recording.line(row)),
        recording: index,
        rows: row..row + 1,
        is_found: false,
        claim: None,
    };
    (0..rows).map(interval).collect()
}

/// How many directions far apart some readings point in, `most` at most.
fn count_directions(readings: &[[f64; 3]], most: usize) -> usize {
    let mut directions: Vec<[f64; 3]> = Vec::new();
    for reading in readings {
        let is_apart = |d: &[f64; 3]| angle_deg(*d, *reading) > FAR_APART_DEG;
        if directions.len() < most && directions.iter().all(is_apart) {
            directions.push(*reading);
        }
    }
    directions.len()
}

/// Rows that point everywhere, lie on a sphere and jump from one to the next are means, however many they
/// are: of orientations in no order, or of rests of days, which have no time stamps.
fn is_table_of_means(recording: &Recording, few: bool, hardly_static: bool) -> bool {
    /// One row lies so far from the one before in a table without order.
    const JUMP_DEG: f64 = 10.0;
    /// As many tell how far.
    const MANY_ROWS: usize = 10_000;
    let rows = (0..recording.rows()).map(|row| recording.accel_at(row));
    let rows: Vec<[f64; 3]> = rows.filter(|u| u.iter().all(|v| v.is_finite())).collect();
    let some = rows.windows(2).step_by(1 + rows.len() / MANY_ROWS);
    let mut jumps: Vec<f64> = some.map(|w| angle_deg(w[0], w[1])).collect();
    let jump = gravical_signal::stats::median(&mut jumps).unwrap_or(0.0);
    let is_without_clock = hardly_static && recording.time_s.is_none();
    if jump <= JUMP_DEG && !(is_without_clock && jumps_between_rows(&rows)) {
        return false;
    }
    let wanted = if few { 6 } else { 12 };
    count_directions(&rows, wanted) == wanted
        && Sphere::nearest(&rows).is_some_and(|sphere| sphere.is_near())
}

/// True if consecutive rows are not steps of one turn: Σ‖u₊ − 2u + u₋‖² over Σ‖u₊ − u₋‖² is 3 for rows in no
/// order, 1 for steps from one rest to another, and 0.33 where a turn takes two rows.
fn jumps_between_rows(rows: &[[f64; 3]]) -> bool {
    const MIN_ROUGHNESS: f64 = 0.6;
    let (mut bends, mut steps) = (0.0, 0.0);
    for w in rows.windows(3) {
        let [to, on] = [matrix3::sub(&w[1], &w[0]), matrix3::sub(&w[2], &w[1])];
        let bend = matrix3::sub(&on, &to);
        let step = matrix3::sub(&w[2], &w[0]);
        bends += matrix3::dot(&bend, &bend);
        steps += matrix3::dot(&step, &step);
    }
    bends > MIN_ROUGHNESS * steps
}

/// Rests that a twitch of less than a second parts and that point the same way
/// are one pose: its longest part is taken.
fn longest_per_pose(recording: &Recording, spans: Vec<Range<usize>>) -> Vec<Range<usize>> {
    const TWITCH_S: f64 = 1.0;
    const SAME_DEG: f64 = 3.0;
    let near = (TWITCH_S * recording.working_rate_hz()) as usize;
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

/// The error for a session that is never at rest, at its first recording.
pub(super) fn no_rest(recording: &Recording) -> Error {
    let why = why_never_static(recording);
    no_static_interval(recording, Problem::NeverAtRest { why })
}

/// Advises to give the rate of recordings whose rests are counted in rows, or by a clock of no sure unit.
pub(crate) fn advise_rate<'a>(
    error: Error,
    recordings: impl IntoIterator<Item = &'a Recording>,
) -> Error {
    let mut recordings = recordings.into_iter();
    if recordings.any(|r| r.clock.rate_hz().is_none() || r.clock.is_unit_unsure) {
        error.advise("rate", "")
    } else {
        error
    }
}

fn no_static_interval(recording: &Recording, problem: Problem) -> Error {
    let hint = if recording.rows() < FEW_ROWS {
        "a table of means needs a row for each of six directions or more, or a column \"label\" that names each row (+x, -x … or pose 1 …); a recording needs 3 s at rest in each pose"
    } else {
        "lay the sensor down for 3 s or more, and 20 rows, in each of six poses or more, or name the rows of each, in a column \"label\" or in a list, or cut the file to the part with the poses; `gravical inspect` shows the static intervals"
    };
    let error = problem.error().at(Path::new(&recording.name), None);
    advise_rate(error.with_hint(hint), [recording]).advise("sections", "")
}
