//! Placements that are found: the longest quiet part of each file, or all
//! holds of one continuous recording.

use std::ops::Range;
use std::path::Path;

use crate::recording::units::GyroScale;
use crate::recording::{Finding, Recording};
use crate::{Error, Result};

use super::face::{Claim, Face, angle_deg, claim};
use super::named::first_rows;
use super::still::{StillOptions, Stills, find_stills, moments};
use super::turns::{Turn, decide_gyro_unit, full_turns, motions};
use super::{Draft, MOST_FACE_ANGLE_DEG, SegmentOptions, Selection};

/// Placements from several files: of each stretch between blank rows the
/// longest still of every face it shows.
pub(super) fn in_files(
    recordings: &[Recording],
    options: &SegmentOptions,
    findings: &mut Vec<Finding>,
) -> Result<Vec<Draft>> {
    let mut drafts = Vec::new();
    for (index, recording) in recordings.iter().enumerate() {
        let stem = stem(&recording.name);
        let claimed = claim(&stem);
        let segments = recording.segments();
        let stills = find_stills(recording, &options.still);
        for (at, segment) in segments.iter().enumerate() {
            let label = if segments.len() > 1 {
                format!("{stem} part {}", at + 1)
            } else {
                stem.clone()
            };
            // A name with a sign speaks of one placement; with two stretches
            // in the file it can speak of neither.
            let one_face = matches!(claimed, Some(Claim::Face(_))) && segments.len() == 1;
            let mut spans = match options.rows {
                Some(n) => first_rows(vec![segment.clone()], Some(n)),
                None => longest_per_face(recording, &stills, segment, one_face, options),
            };
            if spans.is_empty() {
                let shaky = find_stills(recording, &StillOptions::unsteady());
                spans = longest_per_face(recording, &shaky, segment, true, options);
                tell_unsteady(recording, &label, &spans, &shaky, findings);
            }
            let selection = if options.rows.is_some() {
                Selection::Given
            } else {
                Selection::Found
            };
            if spans.is_empty() {
                add_without_still(
                    recording,
                    segment,
                    &label,
                    index,
                    claimed,
                    &mut drafts,
                    findings,
                );
                continue;
            }
            tell_motion(recording, segment, &spans, options, findings);
            for span in spans {
                drafts.push(Draft {
                    label: label.clone(),
                    recording: index,
                    rows: vec![span],
                    selection,
                    claim: claimed.filter(|c| one_face || matches!(c, Claim::Axis(_))),
                });
            }
        }
    }
    if drafts.is_empty() {
        return Err(never_still(&recordings[0].name, recordings.len()));
    }
    Ok(drafts)
}

/// All holds of one recording and the turns between them.
pub(super) fn in_one(
    recording: &Recording,
    options: &SegmentOptions,
    gyro_scale: &mut Option<GyroScale>,
    findings: &mut Vec<Finding>,
) -> Result<(Vec<Draft>, Vec<Turn>)> {
    let stills = find_stills(recording, &options.still);
    let mut spans = longest_per_hold(recording, stills.spans);
    let mut selection = Selection::Found;
    if let Some(n) = options.rows {
        let segments = recording.segments();
        let parts = if segments.len() > 1 { segments } else { spans };
        spans = parts
            .into_iter()
            .flat_map(|p| first_rows(vec![p], Some(n)))
            .collect();
        selection = Selection::Given;
    }
    if recording.rows() < 40 && spans.is_empty() {
        // Too short to look for stills in: a handful of rows of one placement.
        spans = recording.segments();
        selection = Selection::Given;
    }
    let held: usize = spans.iter().map(|s| s.len()).sum();
    if spans.is_empty() || (held * 50 < recording.rows() && spans.len() < 6) {
        return Err(never_still(&recording.name, 1));
    }
    if recording.working_rate_hz().1 {
        findings.push(
            Finding::note(
                "rate-unknown",
                format!(
                    "no time stamps and no --rate: stills were looked for as at {} Hz",
                    Recording::ASSUMED_RATE_HZ
                ),
            )
            .in_file(&recording.name),
        );
    }
    let moves = motions(recording, &spans);
    *gyro_scale = decide_gyro_unit(recording, &moves, findings);
    let mut turns = full_turns(0, &moves, *gyro_scale, options.turn_angle_deg.to_radians());
    for turn in &mut turns {
        // Found by the board's channel, meant about an axis of the case.
        turn.axis = options.axes.case_axis(turn.axis);
    }
    let drafts = spans
        .into_iter()
        .enumerate()
        .map(|(i, rows)| Draft {
            label: format!("still {}", i + 1),
            recording: 0,
            rows: vec![rows],
            selection,
            claim: None,
        })
        .collect();
    Ok((drafts, turns))
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
            span.start - end < near
                && !recording
                    .breaks
                    .iter()
                    .any(|b| (end..=span.start).contains(b))
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

fn never_still(name: &str, files: usize) -> Error {
    let what = if files > 1 {
        "the recordings are"
    } else {
        "the recording is"
    };
    Error::input(
        "never-still",
        format!("{what} never still long enough for a hold"),
    )
    .at(Path::new(name), None)
    .with_hint(
        "lay the sensor down for 3 s or more in each position; `gravical inspect` shows the stills",
    )
}

/// Name of a file without folder and endings (`.csv.gz` is two).
pub(crate) fn stem(name: &str) -> String {
    let file = Path::new(name)
        .file_name()
        .map_or_else(|| name.into(), |f| f.to_string_lossy());
    let mut stem = file.as_ref();
    for ending in [".gz", ".csv", ".txt", ".tsv", ".log", ".dat"] {
        stem = stem.strip_suffix(ending).unwrap_or(stem);
    }
    stem.to_owned()
}

fn longest_per_face(
    recording: &Recording,
    stills: &Stills,
    segment: &Range<usize>,
    one_face: bool,
    options: &SegmentOptions,
) -> Vec<Range<usize>> {
    let mut best: Vec<(Option<Face>, Range<usize>)> = Vec::new();
    for span in stills
        .spans
        .iter()
        .filter(|s| s.start >= segment.start && s.end <= segment.end)
    {
        let (mean, _) = moments(&recording.accel, span.clone());
        let (face, angle) = Face::nearest(options.axes.to_case(mean));
        let face = (angle <= MOST_FACE_ANGLE_DEG).then_some(face);
        let group = if one_face { None } else { face };
        match best.iter_mut().find(|(f, _)| *f == group) {
            Some((_, kept)) if kept.len() < span.len() => *kept = span.clone(),
            Some(_) => {}
            None => best.push((group, span.clone())),
        }
    }
    best.sort_by_key(|(_, s)| s.start);
    best.into_iter().map(|(_, s)| s).collect()
}

/// A stretch without a still: taken whole when it is too short to judge, else
/// left out with a warning.
fn add_without_still(
    recording: &Recording,
    segment: &Range<usize>,
    label: &str,
    index: usize,
    claimed: Option<Claim>,
    drafts: &mut Vec<Draft>,
    findings: &mut Vec<Finding>,
) {
    let (rate, _) = recording.working_rate_hz();
    if segment.len() < (rate as usize).max(40) {
        findings.push(
            Finding::warning(
                "short-hold",
                format!(
                    "{label}: {} rows only; all are taken, moving or not",
                    segment.len()
                ),
            )
            .in_file(&recording.name),
        );
        drafts.push(Draft {
            label: label.to_owned(),
            recording: index,
            rows: vec![segment.clone()],
            selection: Selection::Given,
            claim: claimed,
        });
        return;
    }
    findings.push(
        Finding::warning(
            "no-still",
            format!(
                "{label}: never still in lines {} to {}; left out",
                recording.line(segment.start),
                recording.line(segment.end - 1)
            ),
        )
        .in_file(&recording.name),
    );
}

/// Says that a hold was taken from a rest that was none.
fn tell_unsteady(
    recording: &Recording,
    label: &str,
    spans: &[Range<usize>],
    stills: &Stills,
    findings: &mut Vec<Finding>,
) {
    for span in spans {
        let (mean, variance) = moments(&recording.accel, span.clone());
        let gravity = mean.iter().map(|m| m * m).sum::<f64>().sqrt();
        findings.push(
            Finding::warning(
                "unsteady-hold",
                format!(
                    "{label}: never quite still; the calmest part, lines {} to {}, shakes by {:.0} mg rms (its quietest blocks by {:.0}) and is taken",
                    recording.line(span.start),
                    recording.line(span.end - 1),
                    1000.0 * variance.sqrt() / gravity,
                    1000.0 * stills.noise / gravity
                ),
            )
            .in_file(&recording.name),
        );
    }
}

/// Says how much of a file is motion or a shorter still, and thus not in the
/// mean.
fn tell_motion(
    recording: &Recording,
    segment: &Range<usize>,
    spans: &[Range<usize>],
    options: &SegmentOptions,
    findings: &mut Vec<Finding>,
) {
    if options.rows.is_some() {
        return;
    }
    let used: usize = spans.iter().map(|s| s.len()).sum();
    if used * 10 < segment.len() * 9 {
        let parts: Vec<String> = spans
            .iter()
            .map(|s| format!("{}-{}", recording.line(s.start), recording.line(s.end - 1)))
            .collect();
        findings.push(
            Finding::note(
                "motion-left-out",
                format!(
                    "still in lines {} ({used} of {} rows); the rest moves and is left out",
                    parts.join(", "),
                    segment.len()
                ),
            )
            .in_file(&recording.name),
        );
    }
}
