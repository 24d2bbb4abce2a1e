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

use serde::{Deserialize, Serialize};

use crate::{Error, Result};

use super::ledger::Aside;
use super::monitor::{Defects, GyroCounts, gyro_by_claim};
use super::names::Quantity;
use super::names::Role;
use super::open::{self, Input};
use super::row::{GYRO, SLOTS, TIME};
use super::text::open_rows;
use super::timing::{self, BreakKind, Claims, TimeUnit, Treatment};
use super::{ReadOptions, Recording, RowMap, metadata};
use crate::finding::{Finding, FindingKind, LineSpans};
use crate::resolution::resolution;

/// File that was joined to a recording.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct JoinedFile {
    /// Path of the file as given.
    pub name: String,
    /// SHA-256 of the file, if requested.
    pub sha256: Option<String>,
}

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
    refuse_second(recording)?;
    let input = open::open(path, options)?;
    join_input(recording, input, &path.display().to_string(), options)
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
    refuse_second(recording)?;
    let reader = Box::new(std::io::Cursor::new(bytes.to_vec()));
    let input =
        open::from_reader(reader, options.hash).map_err(|e| Error::io(Path::new(name), e))?;
    join_input(recording, input, name, options)
}

/// True for a file that contains a gyroscope and no accelerometer, by its column names, or, if
/// these are bare `x`, `y`, `z` or missing, by its file name (`Gyroscope.csv`).
#[must_use]
pub fn holds_gyroscope_alone(path: &Path, options: &ReadOptions) -> bool {
    let name = path.display().to_string();
    let opened = open::open(path, &ReadOptions::default())
        .and_then(|input| open_rows(input, &name, Role::Gyroscope, options, None));
    let Ok(mut file) = opened else { return false };
    let header = file.format.dialect.header.clone();
    let readable = loop {
        match file.rows.next_row() {
            Ok(Some(_)) => {}
            Ok(None) => break file.finish(Treatment::Repaired).is_ok(),
            Err(_) => break false,
        }
    };
    let bare = |name: &String| name.trim().trim_matches('"').eq_ignore_ascii_case("x");
    let named = header.is_some_and(|h| !h.names.iter().any(bare));
    readable && (named || is_named_gyroscope(path))
}

/// True for a file named after a gyroscope and not also after an accelerometer.
#[must_use]
pub fn is_named_gyroscope(path: &Path) -> bool {
    let stem = open::stem(&path.display().to_string()).to_lowercase();
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

/// Rows of a gyroscope with their times.
struct Gyro {
    channels: [Vec<f64>; 3],
    /// Seconds on the recorder's clock.
    stamps_s: Option<Vec<f64>>,
    period_s: f64,
    /// Rows before which samples are missing.
    breaks: Vec<usize>,
}

fn join_input(
    recording: &mut Recording,
    input: Input,
    name: &str,
    options: &ReadOptions,
) -> Result<()> {
    let mut file = open_rows(input, name, Role::Gyroscope, options, None)?;
    let layout = file.format.layout.clone();
    let stamped = layout.field(Quantity::Time).is_some();
    let mut channels: [Vec<f64>; 3] = Default::default();
    let mut stamps = Vec::new();
    let mut discontinuities: Vec<(usize, BreakKind)> = Vec::new();
    let mut lines = RowMap::default();
    let mut counted = GyroCounts::default();
    while let Some(row) = file.rows.next_row()? {
        let rate = [row.values[GYRO], row.values[GYRO + 1], row.values[GYRO + 2]];
        counted.observe(rate);
        let how = row
            .before
            .iter()
            .filter_map(|reason: &Aside| BreakKind::of(*reason));
        discontinuities.extend(how.max().map(|how| (channels[0].len(), how)));
        for (channel, value) in channels.iter_mut().zip(rate) {
            channel.push(value);
        }
        if stamped {
            stamps.push(row.values[TIME]);
        }
        lines.push(row.line);
    }
    let metadata_rate_hz = metadata::rate_hz(&file.format.dialect.metadata);
    let read = file.finish(Treatment::Repaired)?;
    let mut findings = read.findings;
    let claims = Claims {
        unit: options
            .time_unit
            .or(layout.time_claim)
            .or_else(|| unit_of(recording, &stamps)),
        nominal_rate_hz: options.rate_hz.or(metadata_rate_hz),
        temperature_span_c: 0.0,
    };
    let (rate_hz, stamps_s) = if stamped {
        let break_kind = |row: usize| {
            let at = discontinuities.binary_search_by_key(&row, |(at, _)| *at);
            at.ok().map(|i| discontinuities[i].1)
        };
        let timed = timing::judge(
            &stamps,
            &claims,
            |row| lines.number(row).unwrap_or_default(),
            break_kind,
        );
        if let Some(row) = timed.restarts.first() {
            return Err(restarted(name, lines.number(*row)));
        }
        findings.extend(timed.findings);
        (
            timed.timing.rate_hz(),
            absolute(timed.time_s, timed.origin_s),
        )
    } else {
        (claims.nominal_rate_hz, None)
    };
    let mut gyro = Gyro {
        channels,
        stamps_s,
        period_s: rate_hz.map_or(f64::NAN, |r| 1.0 / r),
        breaks: discontinuities.iter().map(|(row, _)| *row).collect(),
    };
    let own = absolute(recording.time_s.clone(), recording.time_origin_s);
    // From the measured values, before interpolation.
    let [.., x, y, z] = &mut recording.resolution;
    [*x, *y, *z] = resolution(&gyro.channels);
    let joined = match (own, gyro.stamps_s.take()) {
        (Some(own), Some(other)) if own == other => gyro.channels,
        (Some(own), Some(other)) => {
            if recording.restarted {
                return Err(restarted(&recording.name, None));
            }
            by_stamps(recording, &own, &gyro, &other, name, &mut findings)?
        }
        _ => row_by_row(recording, gyro, name, &mut findings)?,
    };
    recording.gyro_scale = Some(gyro_by_claim(counted, &layout, options));
    recording.gyro = Some(joined);
    recording.gyro_file = Some(JoinedFile {
        name: name.to_owned(),
        sha256: read.sha256,
    });
    findings.extend(defects(recording));
    for finding in &mut findings {
        finding.file.get_or_insert_with(|| name.to_owned());
    }
    recording.findings.extend(findings);
    Ok(())
}

/// Faults of the joined samples.
fn defects(recording: &Recording) -> Vec<Finding> {
    let [.., x, y, z] = recording.resolution;
    let resolution = [0.0, 0.0, 0.0, x, y, z];
    let mut defects = Defects::new(recording.accel_scale, 0.0, resolution, recording.gyro_scale);
    let mut values = [f64::NAN; SLOTS];
    for row in 0..recording.rows() {
        for (i, channel) in recording.gyro.iter().flatten().enumerate() {
            values[GYRO + i] = channel[row];
        }
        defects.observe(&values, recording.line(row));
    }
    defects.finish(false)
}

/// The unit of the accelerometer's stamps, if it gives the gyroscope a rate of similar size.
fn unit_of(recording: &Recording, time: &[f64]) -> Option<TimeUnit> {
    let unit = recording.timing.unit?;
    let rate = recording.timing.rate_hz()?;
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    steps.retain(|d| *d > 0.0);
    let period = crate::stats::median(&mut steps)? * unit.seconds();
    (0.02..50.0).contains(&(period * rate)).then_some(unit)
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
    gyro: Gyro,
    name: &str,
    findings: &mut Vec<Finding>,
) -> Result<[Vec<f64>; 3]> {
    let (own, other) = (recording.rows(), gyro.channels[0].len());
    if own != other {
        return Err(Error::input(
            "gyro-length",
            format!("{other} rows of the gyroscope, {own} of the accelerometer, without time stamps in both files to join them by"),
        )
        .at(name.as_ref(), None)
        .with_hint("give files with time stamps, or with equal numbers of rows"));
    }
    findings.push(Finding::new(
        FindingKind::GyroRowByRow,
        "one of the files has no time stamps: joined row by row",
    ));
    Ok(gyro.channels)
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
    gyro: &Gyro,
    stamps: &[f64],
    name: &str,
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
    let near = SAME_STAMP * gyro.period_s;
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
                if stamps[b] - stamps[a] < GAP_PERIODS * gyro.period_s
                    && !gyro.breaks.iter().any(|x| (a + 1..=b).contains(x)) =>
            {
                Cover::Between(a, b, (t - stamps[a]) / (stamps[b] - stamps[a]))
            }
            _ => Cover::Nothing,
        };
        let value = |axis: usize| match cover {
            Cover::Same(r) => gyro.channels[axis][r],
            Cover::Between(a, b, share) => {
                let (from, to) = (gyro.channels[axis][a], gyro.channels[axis][b]);
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
        return Err(no_overlap(recording, own, [first, last], name));
    }
    if !uncovered.is_empty() {
        findings.push(
            Finding::new(
                FindingKind::GyroUncovered,
                format!(
                    "{} of {rows} rows of the accelerometer ({:.1} %) have no reading of the gyroscope within {:.0} ms: before it starts, after it ends, or in its gaps; left empty there",
                    uncovered.count(),
                    100.0 * uncovered.count() as f64 / rows as f64,
                    1e3 * GAP_PERIODS * gyro.period_s
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
