//! Joins a gyroscope from a separate file to the accelerometer's recording.
//!
//! Both files are read by the same reader. If both have time stamps, these are assumed to come
//! from one clock: the stamps themselves are compared, not the times since the first row, so that
//! an offset between the files is preserved. Rows with the same stamp are joined; between two
//! stamps of the gyroscope its rate is interpolated linearly. If one of the files has no time
//! stamps, rows are joined one by one, and their numbers must be equal.
//!
//! Files stamped by different clocks cannot be joined correctly: the directions of gravity then
//! do not match the turns, which the fit of the gyroscope reports.

use std::path::Path;

use crate::error::{Error, Result};
use crate::finding::{Finding, FindingKind};
use crate::options::ReadOptions;
use crate::read::read_gyroscope;
use crate::recording::{JoinedFile, Recording};
use crate::source::{Source, stem};
use crate::spans::LineSpans;

/// Stamps that differ by less than this share of the gyroscope's period are equal: within it the
/// change of the rate is far below its noise.
const SAME_STAMP: f64 = 0.02;

/// Largest number of periods between stamps for interpolation; more is a gap for the reader too.
const GAP_PERIODS: f64 = 4.5;

/// Reads the gyroscope from `path` and joins it to `recording`. Rows that it does not cover get
/// NaN and a finding.
///
/// `options` are those of the recording; of its columns, those of the gyroscope and the time
/// apply to this file. Otherwise the columns are named by the header; without a header they are
/// t, gx, gy, gz or gx, gy, gz.
///
/// # Errors
///
/// `gyro-twice` if the recording has a gyroscope, `no-gyroscope` if the file has none,
/// `gyro-overlap` if the time ranges do not overlap, `gyro-length` if rows must be joined one by
/// one and their numbers differ, `gyro-restart` if a clock restarted; and the errors of reading.
pub fn join_gyroscope(recording: &mut Recording, path: &Path, options: &ReadOptions) -> Result<()> {
    join_source(recording, &Source::Path(path), options)
}

/// As [`join_gyroscope`], from bytes; `name` is used in messages.
///
/// # Errors
///
/// As [`join_gyroscope`].
pub fn join_gyroscope_bytes(
    recording: &mut Recording,
    bytes: &[u8],
    name: &str,
    options: &ReadOptions,
) -> Result<()> {
    join_source(recording, &Source::Bytes(name, bytes), options)
}

/// True for a file that contains a gyroscope and no accelerometer, by its column names, or, if
/// these are bare `x`, `y`, `z` or missing, by its file name (`Gyroscope.csv`).
#[must_use]
pub fn holds_gyroscope_alone(path: &Path, options: &ReadOptions) -> bool {
    let options = ReadOptions {
        hash: false,
        meter: None,
        ..options.clone()
    };
    let read = read_gyroscope(&Source::Path(path), &options);
    let bare = |name: &String| name.trim().trim_matches('"').eq_ignore_ascii_case("x");
    read.is_ok_and(|read| {
        let names = read.column_names;
        let named = !names.is_empty() && !names.iter().any(bare);
        named || is_named_gyroscope(path)
    })
}

/// True for a file named after a gyroscope and not also after an accelerometer.
#[must_use]
pub fn is_named_gyroscope(path: &Path) -> bool {
    let stem = stem(&path.display().to_string()).to_lowercase();
    stem.contains("gyr") && !stem.contains("acc")
}

fn refuse_second(recording: &Recording) -> Result<()> {
    if recording.gyro.is_none() {
        return Ok(());
    }
    Err(Error::usage(
        "gyro-twice",
        "this recording has a gyroscope of its own, and --gyro gives a second one",
    )
    .at(recording.name.as_ref(), None)
    .with_hint(
        "omit --gyro, or ignore the recording's own gyroscope with --columns gx=-,gy=-,gz=-",
    ))
}

fn join_source(
    recording: &mut Recording,
    source: &Source<'_>,
    options: &ReadOptions,
) -> Result<()> {
    let name = &source.name();
    refuse_second(recording)?;
    recording.refuse_averaged("join a recording of at most three hours at 100 Hz")?;
    let mut gyro = read_beside(recording, source, options)?;
    if gyro.restarted {
        let restart = |f: &&Finding| f.kind == FindingKind::RestartedTime;
        let line = gyro.findings.iter().find(restart);
        return Err(restarted(
            name,
            line.and_then(|f| Some(f.lines.first()?[0])),
        ));
    }
    let channels = gyro.gyro.take().unwrap_or_default();
    let own = absolute(recording.time_s.clone(), recording.time_origin_s);
    let stamps_s = absolute(gyro.time_s.take(), gyro.time_origin_s);
    let mut findings = Vec::new();
    let joined = match (own, stamps_s) {
        (Some(own), Some(other)) if own == other => channels,
        (Some(own), Some(other)) => {
            if recording.restarted {
                return Err(restarted(&recording.name, None));
            }
            by_stamps(recording, &own, &gyro, &channels, &other, &mut findings)?
        }
        _ => row_by_row(recording, &gyro, channels, name, &mut findings)?,
    };
    // Of the measured values, before interpolation.
    recording.resolution[3..].copy_from_slice(&gyro.gyro_resolution());
    recording.gyro_scale = gyro.gyro_scale;
    recording.gyro = Some(joined);
    recording.gyro_file = Some(JoinedFile {
        name: name.clone(),
        sha256: gyro.sha256,
    });
    recording.findings.append(&mut gyro.findings);
    for mut finding in findings {
        finding.file.get_or_insert_with(|| name.clone());
        recording.findings.push(finding);
    }
    Ok(())
}

/// The gyroscope in `source`, read as any recording. Without a unit of its stamps from the header
/// or the user they are in the unit of those of `recording`, if that gives it a rate of similar
/// size.
fn read_beside(
    recording: &Recording,
    source: &Source<'_>,
    options: &ReadOptions,
) -> Result<Recording> {
    let by_header = read_gyroscope(source, options)?;
    let is_unit_assumed = by_header
        .findings
        .iter()
        .any(|f| f.kind == FindingKind::TimeUnitAssumed);
    let Some(unit) = recording.timing.unit.filter(|_| is_unit_assumed) else {
        return Ok(by_header);
    };
    let options = ReadOptions {
        time_unit: Some(unit),
        ..options.clone()
    };
    if !source.is_reopenable() {
        return Ok(by_header);
    }
    let by_unit = read_gyroscope(source, &options)?;
    let rates = recording.timing.rate_hz().zip(by_unit.timing.rate_hz());
    let similar = rates.is_some_and(|(accel, gyro)| (0.02..50.0).contains(&(accel / gyro)));
    Ok(if similar { by_unit } else { by_header })
}

fn absolute(time_s: Option<Vec<f64>>, origin_s: Option<f64>) -> Option<Vec<f64>> {
    let (mut time, origin) = (time_s?, origin_s?);
    for t in &mut time {
        *t += origin;
    }
    Some(time)
}

fn restarted(file: &str, line: Option<u64>) -> Error {
    Error::input(
        "gyro-restart",
        "the time stamps restart in the middle: the files cannot be joined by them",
    )
    .at(file.as_ref(), line)
    .with_hint("split both files where the board was reset, and read the parts separately")
}

fn row_by_row(
    recording: &Recording,
    gyro: &Recording,
    channels: [Vec<f64>; 3],
    name: &str,
    findings: &mut Vec<Finding>,
) -> Result<[Vec<f64>; 3]> {
    let (own, other) = (recording.rows(), channels[0].len());
    if own != other {
        return Err(Error::input(
            "gyro-length",
            format!("{other} rows of the gyroscope, {own} of the accelerometer, without time stamps in both files to join them by"),
        )
        .at(name.as_ref(), None)
        .with_hint("give files with time stamps, or with equal numbers of rows"));
    }
    let apart =
        |row: &usize| recording.line(*row) - recording.line(0) != gyro.line(*row) - gyro.line(0);
    if let Some(row) = (0..own).find(apart) {
        let line = recording.line(row);
        return Err(Error::input(
            "gyro-length",
            format!("rows were set aside before line {line} in one of the files, and there are no time stamps in both to join them by"),
        )
        .at(name.as_ref(), None)
        .with_hint("give files with time stamps, or without such rows"));
    }
    findings.push(Finding::new(
        FindingKind::GyroRowByRow,
        "one of the files has no time stamps: joined row by row",
    ));
    Ok(channels)
}

/// Source of the rate for one row of the accelerometer.
enum Cover {
    Same(usize),
    Between(usize, usize, f64),
    Nothing,
}

fn by_stamps(
    recording: &Recording,
    own: &[f64],
    gyro: &Recording,
    channels: &[Vec<f64>; 3],
    stamps: &[f64],
    findings: &mut Vec<Finding>,
) -> Result<[Vec<f64>; 3]> {
    // Interpolation needs increasing times: repeated stamps and steps back, reported by the
    // reader, are skipped.
    let mut rising: Vec<usize> = Vec::with_capacity(stamps.len());
    let mut latest = f64::NEG_INFINITY;
    for (row, &t) in stamps.iter().enumerate() {
        if t > latest {
            latest = t;
            rising.push(row);
        }
    }
    let (first, last) = match (rising.first(), rising.last()) {
        (Some(&a), Some(&b)) => (stamps[a], stamps[b]),
        _ => (f64::NAN, f64::NAN),
    };
    let period_s = gyro.timing.rate_hz().map_or(f64::NAN, f64::recip);
    let near = SAME_STAMP * period_s;
    let mut joined: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(own.len()));
    let mut uncovered = LineSpans::default();
    let mut between = 0_u64;
    let mut at = 0;
    for (row, &t) in own.iter().enumerate() {
        // A step back of the stamps restarts the search.
        if at > 0 && rising.get(at - 1).is_some_and(|&r| stamps[r] > t) {
            at = rising.partition_point(|&r| stamps[r] < t);
        }
        while rising.get(at).is_some_and(|&r| stamps[r] < t) {
            at += 1;
        }
        let below = at.checked_sub(1).and_then(|i| rising.get(i)).copied();
        let above = rising.get(at).copied();
        let cover = match (below, above) {
            _ if !t.is_finite() => Cover::Nothing,
            (_, Some(r)) if stamps[r] - t <= near => Cover::Same(r),
            (Some(r), _) if t - stamps[r] <= near => Cover::Same(r),
            (Some(a), Some(b))
                if stamps[b] - stamps[a] < GAP_PERIODS * period_s
                    && !gyro.is_broken(&(a..b + 1)) =>
            {
                Cover::Between(a, b, (t - stamps[a]) / (stamps[b] - stamps[a]))
            }
            _ => Cover::Nothing,
        };
        let value = |axis: usize| match cover {
            Cover::Same(r) => channels[axis][r],
            Cover::Between(a, b, share) => {
                let (from, to) = (channels[axis][a], channels[axis][b]);
                from + share * (to - from)
            }
            Cover::Nothing => f64::NAN,
        };
        for (axis, channel) in joined.iter_mut().enumerate() {
            channel.push(value(axis));
        }
        match cover {
            Cover::Same(_) => {}
            Cover::Between(..) => between += 1,
            Cover::Nothing => uncovered.push(recording.line(row)),
        }
    }
    let rows = own.len() as u64;
    if uncovered.count() == rows {
        return Err(no_overlap(recording, own, [first, last], &gyro.name));
    }
    if !uncovered.is_empty() {
        findings.push(
            Finding::new(
                FindingKind::GyroUncovered,
                format!(
                    "{} of {rows} rows of the accelerometer ({:.1} %) have no reading of the gyroscope within {:.0} ms: before it starts, after it ends, or in its gaps; left empty there",
                    uncovered.count(),
                    100.0 * uncovered.count() as f64 / rows as f64,
                    1e3 * GAP_PERIODS * period_s
                ),
            )
            .at_lines(&uncovered)
            .in_file(&recording.name),
        );
    }
    if between > 0 {
        findings.push(
            Finding::new(
                FindingKind::GyroInterpolated,
                format!("{between} of {rows} rows of the accelerometer lie between two stamps of the gyroscope; its rate is interpolated there"),
            )
            .counting(between),
        );
    }
    Ok(joined)
}

fn no_overlap(recording: &Recording, own: &[f64], other: [f64; 2], name: &str) -> Error {
    let low = own.iter().copied().fold(f64::INFINITY, f64::min);
    let high = own.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Error::input(
        "gyro-overlap",
        format!(
            "the two files have no time in common: {} runs from {low:.3} to {high:.3} s, this one from {:.3} to {:.3} s",
            recording.name, other[0], other[1]
        ),
    )
    .at(name.as_ref(), None)
    .with_hint("give the two files of one recording, stamped by one clock; --time-unit sets the unit of both")
}
