//! Motion against a reference: positions that somebody else measured, with a camera or on a rail.
//!
//! The lag at which the speeds of both agree best brings the reference onto the recording's clock, a turn
//! about the vertical into the frame of the result; both start at 0 at their first common time. What is
//! fitted is not judged: the lag hides a delay, the turn the heading.

#[cfg(test)]
mod tests;

use std::io::{Cursor, Read as _};
use std::ops::RangeInclusive;
use std::path::Path;

use gravical_core::matrix3::{norm, sub};
use gravical_recording::judge::{ClockOptions, clock};
use gravical_recording::{
    HEAD_BYTES, Reason, Role, TimeUnit, bytes, sniff_table, source, whole_lines,
};

use super::{Comparison, Motion, Move, MoveComparison};
use crate::calibration_file::{InputFile, InputRole};
use crate::finding::Case;
use crate::recording::{Finding, ReadOptions, Recording};
use crate::{Error, Result};

/// Nothing is interpolated over more than this, s, and than so many median steps.
const MAX_GAP_S: f64 = 0.25;
const MAX_GAP_STEPS: f64 = 4.5;
/// Bins of one track in the coarse pass; of the fine one at most, and at least so long, s: below it the noise
/// of a camera (0.1 mm) makes more speed than a slow motion has.
const COARSE_BINS: f64 = 2048.0;
const MAX_BINS: f64 = 2e5;
const MIN_BIN_S: f64 = 0.02;
/// Fraction of the bins of the shorter track that has to overlap.
const MIN_OVERLAP: f64 = 0.3;
/// Correlation of the speeds below which an offset is doubtful: two different motions of stops and goes reach
/// 0.5 by chance.
const MIN_CORRELATION: f64 = 0.8;
/// Steps that the heading is fitted to, s: between them drift counts for little.
const STEP_S: f64 = 0.5;
/// The path is summed over means of this length, s: over points the noise of a camera walks further.
const PATH_BIN_S: f64 = 0.1;
/// Path below which a share of it says nothing, m.
const MIN_PATH_M: f64 = 1e-3;
/// Units that names of columns end with, in m.
const UNITS: [(&str, f64); 3] = [("", 1.0), ("m", 1.0), ("mm", 1e-3)];

/// Positions that somebody else measured.
#[derive(Debug, Clone)]
pub struct Reference {
    /// The file as it was given, with its SHA-256 where the recording has one.
    pub input: InputFile,
    /// Time, s, by its own stamps; rising, without the rows that have no position.
    pub t_s: Vec<f64>,
    /// Position, m.
    pub position_m: Vec<[f64; 3]>,
    /// It stands in the recording itself: `t_s` is the recording's.
    pub same_file: bool,
    /// What is odd.
    pub findings: Vec<Finding>,
}

/// Reads the reference at `path` for `recording`, which was read from `recorded_at`. When both are one file,
/// the rows keep the recording's time.
///
/// # Errors
///
/// `truth-columns-missing` (usage) when no columns are positions; `truth-time` (input) without usable stamps;
/// `truth-empty` (input) without two positions; and what keeps a file from being read.
pub fn read_reference(path: &Path, recording: &Recording, recorded_at: &Path) -> Result<Reference> {
    let same_file =
        matches!((path.canonicalize(), recorded_at.canonicalize()), (Ok(a), Ok(b)) if a == b);
    let options = ReadOptions {
        hash: recording.sha256.is_some(),
        ..ReadOptions::default()
    };
    let mut input = source::open(path, &options)?;
    let io = |e| Error::io(path, e);
    let mut text = bytes::utf8(input.take_reader()).map_err(io)?;
    let head = bytes::read_head(&mut text, HEAD_BYTES).map_err(io)?;
    let format = sniff_table(&whole_lines(&head)).map_err(|_| {
        Error::input(
            "no-rows",
            "there are no rows of at least three numbers in this file",
        )
        .at(path, None)
        .with_hint("a reference is a table of text with the columns t_s,px_m,py_m,pz_m")
    })?;
    let (columns, metres) = position_columns(&format.names, same_file).ok_or_else(|| {
        let text = "no three columns of the reference are named as a position in one unit";
        Error::usage("truth-columns-missing", text)
            .with_hint("name them t_s,px_m,py_m,pz_m, in m or mm")
            .at(path, None)
    })?;
    let time = format.columns.iter().position(|c| c.role == Role::Time);
    let unit_s = time.and_then(|field| match &format.columns[field] {
        column if column.is_dated => Some(1.0),
        column => TimeUnit::parse(&column.unit).map(TimeUnit::seconds),
    });
    let text = Cursor::new(head).chain(text);
    let rows = format.parse(text).map_err(|e| e.in_file(path))?;
    let position = |row: usize| columns.map(|c| rows.columns[c][row] * metres);
    let positions: Vec<[f64; 3]> = (0..rows.rows()).map(position).collect();
    let stamps: Vec<f64> = time.map_or_else(Vec::new, |c| rows.columns[c].clone());
    let not_rows = [Reason::TornLine, Reason::TooManyFields, Reason::NotANumber];
    let torn: usize = not_rows.iter().map(|r| rows.ledger.count(*r)).sum();
    let time_s: Vec<f64> = if same_file {
        // NaN for a line that is no row of it.
        let time = |line: &u32| recording.time_at(recording.rows_at([*line; 2]).next()?);
        let times = rows.lines.iter().map(time);
        times.map(|t| t.unwrap_or(f64::NAN)).collect()
    } else {
        let options = ClockOptions {
            unit_s,
            ..ClockOptions::default()
        };
        let clock = clock(stamps, options).map_err(|_| {
            Error::input("truth-time", "the reference has no usable time stamps")
                .at(path, None)
                .with_hint("name the column of time t_s")
        })?;
        clock.time_s.iter().map(|t| t + clock.start_s).collect()
    };
    let all = positions.len() + torn;
    let (mut t_s, mut position_m) = (Vec::<f64>::new(), Vec::new());
    for (t, p) in time_s.into_iter().zip(positions) {
        let is_known = t.is_finite() && p.iter().all(|v| v.is_finite());
        if is_known && t_s.last().is_none_or(|last| *last <= t) {
            t_s.push(t);
            position_m.push(p);
        }
    }
    let (known, unknown) = (t_s.len(), all - t_s.len());
    if known < 2 {
        let text = format!("{known} of {all} rows of the reference have a position");
        return Err(Error::input("truth-empty", text)
            .at(path, None)
            .with_hint("name the columns of the positions px_m, py_m, pz_m"));
    }
    let gaps = Case::TruthGaps { unknown, rows: all }.finding();
    Ok(Reference {
        input: InputFile {
            path: path.display().to_string(),
            sha256: input.sha256(),
            role: InputRole::Reference,
        },
        t_s,
        position_m,
        same_file,
        findings: if unknown > 0 { vec![gaps] } else { vec![] },
    })
}

/// Columns called `px_m`, `pos_x`, `Position X (mm)` …, and metres of their unit; in a file of its own also
/// plain `x`, `y`, `z`, which in a recording would be acceleration.
fn position_columns(names: &[String], same_file: bool) -> Option<([usize; 3], f64)> {
    let plain = |name: &String| -> String {
        let characters = name.chars().filter(|c| c.is_alphanumeric());
        characters.flat_map(char::to_lowercase).collect()
    };
    let names: Vec<String> = names.iter().map(plain).collect();
    let prefixes = ["p", "pos", "position", ""].into_iter();
    let prefixes = prefixes.filter(|prefix| !(same_file && prefix.is_empty()));
    let mut kinds = prefixes.flat_map(|prefix| UNITS.map(|unit| (prefix, unit)));
    kinds.find_map(|(prefix, (unit, metres))| {
        let find = |axis: &str| {
            let name = format!("{prefix}{axis}{unit}");
            names.iter().position(|plain| *plain == name)
        };
        Some(([find("x")?, find("y")?, find("z")?], metres))
    })
}

/// Compares `motion` with `reference`: its result gets the comparison and what is odd about it, and it the
/// reference.
///
/// # Errors
///
/// `truth-overlap` (input) when the two have no time in common.
pub fn add_comparison(motion: &mut Motion, reference: &Reference) -> Result<()> {
    let position_m: Vec<[f64; 3]> = motion.samples().map(|s| s.state.position_m).collect();
    let own = Line::new(&motion.own.samples.time_s, &position_m);
    let mut findings = reference.findings.clone();
    let (comparison, aligned) = compare(&own, &motion.result.moves, reference, &mut findings)?;
    motion.reference = Some(aligned);
    motion.result.truth = Some(comparison);
    let findings = findings.into_iter();
    let findings = findings.map(|finding| finding.in_file(&reference.input.path));
    motion.result.findings.extend(findings);
    Ok(())
}

fn compare(
    own: &Line<'_>,
    moves: &[Move],
    reference: &Reference,
    findings: &mut Vec<Finding>,
) -> Result<(Comparison, Reference)> {
    let mut offset_s = 0.0;
    if !reference.same_file {
        let other = Line::new(&reference.t_s, &reference.position_m);
        // None where one of the two hardly moves.
        let (lag_s, correlation) = best_lag(own, &other).unwrap_or_default();
        if correlation < MIN_CORRELATION {
            findings.push(Case::TruthOffset { correlation }.finding());
        } else {
            offset_s = lag_s;
        }
    }
    // Where both are known, counted from the first such point.
    let (mut t_s, mut result_m, mut reference_m) = (Vec::new(), Vec::new(), Vec::new());
    for (t, position) in reference.t_s.iter().zip(&reference.position_m) {
        if let Some(known) = own.at(t + offset_s, 0.0) {
            t_s.push(t + offset_s);
            result_m.push(known);
            reference_m.push(*position);
        }
    }
    let [from_s, .., to_s] = t_s[..] else {
        let span = |t: &[f64], offset_s: f64| match t {
            [a, .., b] => format!("{:.1} to {:.1} s", a + offset_s, b + offset_s),
            _ => "nothing".to_owned(),
        };
        let text = format!(
            "reference and recording have no time in common in which both positions are known: {} and {}",
            span(&reference.t_s, offset_s),
            span(own.t_s, 0.0)
        );
        return Err(Error::input("truth-overlap", text)
            .with_hint("record both from one motion to the next, or shift the reference's stamps")
            .at(Path::new(&reference.input.path), None));
    };
    let origin = result_m[0];
    for positions in [&mut result_m, &mut reference_m] {
        let first = positions[0];
        positions.iter_mut().for_each(|p| *p = sub(p, &first));
    }
    let yaw_rad = yaw_rad(&t_s, &result_m, &reference_m);
    let (sine, cosine) = yaw_rad.sin_cos();
    for [x, y, _] in &mut reference_m {
        (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
    }
    let pairs = result_m.iter().zip(&reference_m);
    let errors: Vec<[f64; 3]> = pairs.map(|(a, b)| sub(a, b)).collect();
    let lines = [&errors, &reference_m].map(|p| Line::new(&t_s, p));
    let compared = (1..)
        .zip(moves)
        .filter_map(|(number, m)| compare_move(number, m, &lines));
    let path_m = path_m(&t_s, &reference_m);
    let end_error_m = norm(&errors[errors.len() - 1]);
    let comparison = Comparison {
        source: reference.input.path.clone(),
        end_error_m,
        rmse_m: rms(&errors, [0.0; 3]),
        percent_of_path: (path_m > MIN_PATH_M).then(|| 100.0 * end_error_m / path_m),
        path_m,
        from_s,
        to_s,
        time_offset_s: offset_s,
        yaw_deg: yaw_rad.to_degrees(),
        moves: compared.collect(),
        points: t_s.len() as u64,
    };
    let in_place = |p: &[f64; 3]| std::array::from_fn(|k| p[k] + origin[k]);
    let aligned = Reference {
        position_m: reference_m.iter().map(in_place).collect(),
        t_s,
        ..reference.clone()
    };
    Ok((comparison, aligned))
}

/// The lag at which the speeds correlate most, s, and their correlation; none where one of the two does not
/// move, or both are too short.
fn best_lag(own: &Line<'_>, other: &Line<'_>) -> Option<(f64, f64)> {
    let base_s = own.t_s.first()? - other.t_s.first()?;
    let longest_s = own.duration_s().max(other.duration_s());
    let steps_s = own.step_s.max(other.step_s);
    let fine_s = steps_s.max(MIN_BIN_S).max(longest_s / MAX_BINS);
    let coarse_s = fine_s.max(longest_s / COARSE_BINS);
    let most_alike = |a: &[f64], b: &[f64], lags: RangeInclusive<i64>| {
        let known = lags.filter_map(|lag| Some((lag, alike(a, b, lag)?)));
        known.max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let (a, b) = (own.speeds(coarse_s), other.speeds(coarse_s));
    let (lag, _) = most_alike(&a, &b, -(b.len() as i64)..=a.len() as i64)?;
    let (a, b) = (own.speeds(fine_s), other.speeds(fine_s));
    let middle = (lag as f64 * coarse_s / fine_s).round() as i64;
    let reach = (1.5 * coarse_s / fine_s).ceil() as i64;
    let (lag, correlation) = most_alike(&a, &b, middle - reach..=middle + reach)?;
    // A parabola through the best three gives the fraction.
    let fraction = match (alike(&a, &b, lag - 1), alike(&a, &b, lag + 1)) {
        (Some(before), Some(after)) if before + after < 2.0 * correlation => {
            let curvature = before - 2.0 * correlation + after;
            (0.5 * (before - after) / curvature).clamp(-0.5, 0.5)
        }
        _ => 0.0,
    };
    Some((base_s + (lag as f64 + fraction) * fine_s, correlation))
}

/// Correlation coefficient of `own[i + lag]` and `other[i]`.
fn alike(own: &[f64], other: &[f64], lag: i64) -> Option<f64> {
    let skip = |lag: i64| usize::try_from(lag).unwrap_or(0);
    let pairs = own
        .iter()
        .skip(skip(lag))
        .zip(other.iter().skip(skip(-lag)));
    let (mut n, mut sa, mut sb, mut saa, mut sbb, mut sab) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (a, b) in pairs.filter(|(a, b)| a.is_finite() && b.is_finite()) {
        n += 1.0;
        sa += a;
        sb += b;
        saa += a * a;
        sbb += b * b;
        sab += a * b;
    }
    let (va, vb) = (saa - sa * sa / n, sbb - sb * sb / n);
    let shorter = own.len().min(other.len()) as f64;
    // What rounding leaves of a constant is no variance.
    let is_known = n >= (MIN_OVERLAP * shorter).max(8.0) && va > 1e-12 * saa && vb > 1e-12 * sbb;
    is_known.then(|| (sab - sa * sb / n) / (va * vb).sqrt())
}

/// Root mean square distance of `errors` from `origin`.
fn rms(errors: &[[f64; 3]], origin: [f64; 3]) -> f64 {
    let squares = errors.iter().map(|e| norm(&sub(e, &origin)).powi(2));
    (squares.sum::<f64>() / errors.len() as f64).sqrt()
}

/// The turn about z that brings the steps of the reference closest to those of the result:
/// ψ = atan2(Σ rₓpᵧ − rᵧpₓ, Σ rₓpₓ + rᵧpᵧ).
fn yaw_rad(t_s: &[f64], result: &[[f64; 3]], reference: &[[f64; 3]]) -> f64 {
    let (mut sine, mut cosine, mut from) = (0.0, 0.0, 0);
    for i in 1..t_s.len() {
        if t_s[i] - t_s[from] < STEP_S {
            continue;
        }
        let [r, p] = [reference, result].map(|x| sub(&x[i], &x[from]));
        sine += r[0] * p[1] - r[1] * p[0];
        cosine += r[0] * p[0] + r[1] * p[1];
        from = i;
    }
    let yaw_rad = f64::atan2(sine, cosine);
    if yaw_rad.is_finite() { yaw_rad } else { 0.0 }
}

/// Length of a path, m. A gap is crossed in a straight line.
fn path_m(t_s: &[f64], position: &[[f64; 3]]) -> f64 {
    let bin = |i: &usize| ((t_s[*i] - t_s[0]) / PATH_BIN_S).floor();
    let mean = |rows: &[usize]| -> [f64; 3] {
        let sum = |k: usize| rows.iter().map(|i| position[*i][k]).sum::<f64>();
        std::array::from_fn(|k| sum(k) / rows.len() as f64)
    };
    let rows: Vec<usize> = (0..t_s.len()).collect();
    let means: Vec<[f64; 3]> = rows.chunk_by(|a, b| bin(a) == bin(b)).map(mean).collect();
    means.windows(2).map(|w| norm(&sub(&w[1], &w[0]))).sum()
}

/// A usable move whose ends the reference sees.
fn compare_move(
    number: u64,
    m: &Move,
    [errors, reference]: &[Line<'_>; 2],
) -> Option<MoveComparison> {
    let displacement = m.displacement_m?;
    let truth = sub(&reference.at(m.end_s, 0.0)?, &reference.at(m.start_s, 0.0)?);
    let from = errors.t_s.partition_point(|t| *t < m.start_s);
    let to = errors.t_s.partition_point(|t| *t <= m.end_s);
    Some(MoveComparison {
        number,
        start_s: m.start_s,
        end_s: m.end_s,
        end_error_m: sub(&displacement, &truth),
        sigma_m: m.sigma_m,
        // Both start at 0.
        rmse_m: rms(&errors.position[from..to], errors.at(m.start_s, 0.0)?),
    })
}

/// Positions over time; stamps never fall.
struct Line<'a> {
    t_s: &'a [f64],
    position: &'a [[f64; 3]],
    /// Median step, s; 0 without any.
    step_s: f64,
}

impl<'a> Line<'a> {
    fn new(t_s: &'a [f64], position: &'a [[f64; 3]]) -> Self {
        let steps = t_s.windows(2).map(|w| w[1] - w[0]);
        let mut steps: Vec<f64> = steps.filter(|s| *s > 0.0).collect();
        Line {
            t_s,
            position,
            step_s: crate::stats::median(&mut steps).unwrap_or(0.0),
        }
    }

    fn duration_s(&self) -> f64 {
        match self.t_s {
            [from, .., to] => to - from,
            _ => 0.0,
        }
    }

    /// Position at `t_s`; none outside, over a gap (`max_s`, or what is one by its own rate), and where it is
    /// not known.
    fn at(&self, t_s: f64, max_s: f64) -> Option<[f64; 3]> {
        let next = self.t_s.partition_point(|t| *t < t_s);
        let (after, to) = (*self.t_s.get(next)?, self.position[next]);
        let mut found = to;
        if after > t_s {
            let (before, from) = (self.t_s[next.checked_sub(1)?], self.position[next - 1]);
            if after - before > max_s.max(MAX_GAP_S).max(MAX_GAP_STEPS * self.step_s) {
                return None;
            }
            let u = (t_s - before) / (after - before);
            found = std::array::from_fn(|k| from[k] + u * (to[k] - from[k]));
        }
        found.iter().all(|v| v.is_finite()).then_some(found)
    }

    /// Mean speed in bins from the first point on; NaN over a gap.
    fn speeds(&self, bin_s: f64) -> Vec<f64> {
        let from_s = self.t_s.first().copied().unwrap_or(0.0);
        let bins = (self.duration_s() / bin_s).floor().min(4.0 * MAX_BINS) as usize;
        let at = |i: usize| self.at(from_s + i as f64 * bin_s, bin_s);
        let places: Vec<Option<[f64; 3]>> = (0..=bins).map(at).collect();
        let speed = |w: &[Option<[f64; 3]>]| {
            let moved = w[0].zip(w[1]);
            moved.map_or(f64::NAN, |(a, b)| norm(&sub(&b, &a))) / bin_s
        };
        places.windows(2).map(speed).collect()
    }
}
