//! Errors of a result against a reference, point by point and move by move.

use super::line::Line;
use super::offset;
use super::read::Reference;
use crate::motion::{Comparison, MotionResult, MoveComparison, ReferenceTrack, Track};
use crate::recording::{Finding, FindingKind};
use crate::{Error, Result};

/// The reference's path is summed over means of this length, s: over single
/// points the noise of a camera walks further than the sensor.
const PATH_BIN_S: f64 = 0.1;

/// Steps that the two tracks are aligned by, s.
const STEP_S: f64 = 0.5;

/// Correlation of the speeds below which an offset is doubtful. Two different
/// motions of stops and goes reach 0.5 by chance.
const ALIKE: f64 = 0.8;

/// Path below which a share of it says nothing, m.
const NO_PATH_M: f64 = 1e-3;

/// Points at which both are known, counted from the first of them.
struct Points {
    t_s: Vec<f64>,
    /// Where the result is at the first.
    origin: [f64; 3],
    result: Vec<[f64; 3]>,
    reference: Vec<[f64; 3]>,
}

pub(super) fn compare(
    result: &MotionResult,
    track: &Track,
    reference: &Reference,
    findings: &mut Vec<Finding>,
) -> Result<(Comparison, ReferenceTrack)> {
    let offset_s = offset_of(track, reference, findings);
    let t_s: Vec<f64> = reference.t_s.iter().map(|t| t + offset_s).collect();
    let mut points =
        common(track, &t_s, &reference.position_m).ok_or_else(|| overlap(track, &t_s))?;
    let yaw_rad = yaw_rad(&points);
    let (sine, cosine) = yaw_rad.sin_cos();
    for [x, y, _] in &mut points.reference {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
    let path_m = path(&points);
    let squares: f64 = points
        .result
        .iter()
        .zip(&points.reference)
        .map(|(a, b)| squared(a, b))
        .sum();
    let end = points.result.last().zip(points.reference.last());
    let end_error_m = end.map_or(f64::NAN, |(a, b)| squared(a, b).sqrt());
    let (moves, left_out) = by_move(result, &points);
    if left_out > 0 {
        findings.push(Finding::new(
            FindingKind::TruthMoves,
            format!("{left_out} of {} moves are not compared: they are not usable, or the reference does not see their start and end", result.moves.len()),
        ));
    }
    let comparison = Comparison {
        source: reference.source.clone(),
        end_error_m,
        rmse_m: (squares / points.t_s.len() as f64).sqrt(),
        percent_of_path: (path_m > NO_PATH_M).then(|| 100.0 * end_error_m / path_m),
        path_m,
        from_s: points.t_s.first().copied().unwrap_or(f64::NAN),
        to_s: points.t_s.last().copied().unwrap_or(f64::NAN),
        time_offset_s: offset_s + reference.base_s,
        yaw_deg: yaw_rad.to_degrees(),
        moves,
        points: points.t_s.len() as u64,
    };
    let from = points.origin;
    for p in &mut points.reference {
        *p = std::array::from_fn(|k| p[k] + from[k]);
    }
    let track = ReferenceTrack {
        t_s: points.t_s,
        position_m: points.reference,
    };
    Ok((comparison, track))
}

fn squared(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum()
}

fn overlap(track: &Track, t_s: &[f64]) -> Error {
    let span = |t: &[f64]| match (t.first(), t.last()) {
        (Some(a), Some(b)) => format!("{a:.1} to {b:.1} s"),
        _ => "nothing".to_owned(),
    };
    Error::input(
        "truth-overlap",
        format!(
            "reference and recording have no time in common in which both positions are known: {} and {}",
            span(t_s),
            span(&track.t_s)
        ),
    )
    .with_hint("record both from one motion to the next, or shift the reference's stamps")
}

/// What is added to the reference's time, its [`base_s`](Reference::base_s)
/// aside.
fn offset_of(track: &Track, reference: &Reference, findings: &mut Vec<Finding>) -> f64 {
    if reference.same_file {
        return 0.0;
    }
    let own = Line::new(&track.t_s, &track.position_m);
    let other = Line::new(&reference.t_s, &reference.position_m);
    let found = offset::find(&own, &other);
    match found {
        Some(f) if f.correlation >= ALIKE => f.offset_s,
        Some(f) => {
            // Where the stamps themselves have nothing in common, the best lag is
            // all there is.
            let as_stamped = overlap_at(&own, &other, 0.0);
            let (taken, offset_s) = if as_stamped {
                ("none is assumed", 0.0)
            } else {
                ("it is taken all the same", f.offset_s)
            };
            findings.push(Finding::new(
                FindingKind::TruthOffset,
                format!(
                    "the speeds are little alike (correlation {:.2} at best, with an offset of {:+.3} s): {taken}",
                    f.correlation,
                    f.offset_s + reference.base_s
                ),
            ));
            offset_s
        }
        None => {
            findings.push(Finding::new(
                FindingKind::TruthOffset,
                "too little moves to find the offset of the clocks: none is assumed",
            ));
            0.0
        }
    }
}

/// Whether the two have time in common when `offset_s` is added to the second.
fn overlap_at(own: &Line<'_>, other: &Line<'_>, offset_s: f64) -> bool {
    match (own.range(), other.range()) {
        (Some((from, to)), Some((start, end))) => start + offset_s < to && end + offset_s > from,
        _ => false,
    }
}

/// The points at which both are known, both counted from the first; none with
/// fewer than two.
fn common(track: &Track, t_s: &[f64], reference: &[[f64; 3]]) -> Option<Points> {
    let mut walk = Line::new(&track.t_s, &track.position_m).walk(0.0);
    let mut points = Points {
        t_s: Vec::new(),
        origin: [0.0; 3],
        result: Vec::new(),
        reference: Vec::new(),
    };
    for (&t, r) in t_s.iter().zip(reference) {
        if let Some(p) = walk.at(t) {
            points.t_s.push(t);
            points.result.push(p);
            points.reference.push(*r);
        }
    }
    points.origin = *points.result.first()?;
    for column in [&mut points.result, &mut points.reference] {
        let origin = *column.first()?;
        for p in column.iter_mut() {
            *p = std::array::from_fn(|k| p[k] - origin[k]);
        }
    }
    (points.t_s.len() > 1).then_some(points)
}

/// The turn about z, rad, that brings the steps of the reference closest to those of the result:
/// ψ = atan2(Σ rₓpᵧ − rᵧpₓ, Σ rₓpₓ + rᵧpᵧ).
fn yaw_rad(points: &Points) -> f64 {
    let (mut sine, mut cosine) = (0.0, 0.0);
    let (reference, result) = steps(points);
    for (r, p) in reference.iter().zip(&result) {
        sine += r[0] * p[1] - r[1] * p[0];
        cosine += r[0] * p[0] + r[1] * p[1];
    }
    let yaw_rad = f64::atan2(sine, cosine);
    if yaw_rad.is_finite() { yaw_rad } else { 0.0 }
}

/// Steps of [`STEP_S`] of reference and result: between them a result's drift,
/// which grows slowly, counts for little, and the motion for all.
fn steps(points: &Points) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let (mut reference, mut result) = (Vec::new(), Vec::new());
    let mut from = 0;
    for (i, t) in points.t_s.iter().enumerate().skip(1) {
        if t - points.t_s[from] < STEP_S {
            continue;
        }
        let moved = |p: &[[f64; 3]]| std::array::from_fn(|k| p[i][k] - p[from][k]);
        reference.push(moved(&points.reference));
        result.push(moved(&points.result));
        from = i;
    }
    (reference, result)
}

/// Length of the reference's path, over means of [`PATH_BIN_S`], in m. A gap is
/// crossed in a straight line.
fn path(points: &Points) -> f64 {
    let mut length = 0.0;
    let mut before: Option<[f64; 3]> = None;
    let mut from = 0;
    while let Some(start) = points.t_s.get(from) {
        let rest = points.t_s.iter().skip(from);
        let n = rest.take_while(|t| **t < start + PATH_BIN_S).count().max(1);
        let bin = points.reference.iter().skip(from).take(n);
        let sum = bin.fold([0.0; 3], |s, p| [s[0] + p[0], s[1] + p[1], s[2] + p[2]]);
        let mean = sum.map(|v| v / n as f64);
        if let Some(b) = &before {
            length += squared(b, &mean).sqrt();
        }
        before = Some(mean);
        from += n;
    }
    length
}

/// Every usable move whose ends the reference sees, and how many are left out.
fn by_move(motion: &MotionResult, points: &Points) -> (Vec<MoveComparison>, usize) {
    // The moves come in order.
    let mut reference = Line::new(&points.t_s, &points.reference).walk(0.0);
    let mut result = Line::new(&points.t_s, &points.result).walk(0.0);
    let all = &motion.moves;
    let compared: Vec<MoveComparison> = all
        .iter()
        .filter_map(|m| {
            let displacement = m.displacement_m?;
            let (start, own_start) = (reference.at(m.start_s), result.at(m.start_s));
            let (start, end, own_start) = (start?, reference.at(m.end_s)?, own_start?);
            let from = points.t_s.partition_point(|t| *t < m.start_s);
            let to = points.t_s.partition_point(|t| *t <= m.end_s);
            let (mut squares, mut n) = (0.0, 0.0);
            let pairs = points.result.iter().zip(&points.reference);
            for (p, r) in pairs.take(to).skip(from) {
                let moved: [f64; 3] = std::array::from_fn(|k| p[k] - own_start[k]);
                let truly: [f64; 3] = std::array::from_fn(|k| r[k] - start[k]);
                squares += squared(&moved, &truly);
                n += 1.0;
            }
            Some(MoveComparison {
                start_s: m.start_s,
                end_s: m.end_s,
                end_error_m: std::array::from_fn(|k| displacement[k] - (end[k] - start[k])),
                sigma_m: m.sigma_m,
                rmse_m: if n > 0.0 {
                    f64::sqrt(squares / n)
                } else {
                    f64::NAN
                },
            })
        })
        .collect();
    let left_out = all.len() - compared.len();
    (compared, left_out)
}
