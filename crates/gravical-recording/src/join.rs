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

use gravical_judge::finding::Case;
use gravical_judge::{Finding, GAP_PERIODS, LineSpans, ReadOptions, Result};

use crate::bytes::Input;
use crate::problem::Problem;
use crate::read::{open_head, read_gyroscope};
use crate::recording::{JoinedFile, Recording};
use crate::source::{Named, open, stem};

/// Stamps that differ by less than this share of the gyroscope's period are equal: within it the
/// change of the rate is far below its noise.
const SAME_STAMP: f64 = 0.02;

/// Reads the recording at `path` by `read`, with the gyroscope of a second file, if there is one.
///
/// # Errors
///
/// Those of `read` and of [`join_gyroscope`].
pub fn read_joined(
    path: &Path,
    gyro: Option<&Path>,
    options: &ReadOptions,
    read: impl Fn(&Path, &ReadOptions) -> Result<Recording>,
) -> Result<Recording> {
    let Some(gyro) = gyro else {
        return read(path, options);
    };
    let mut recording = read(path, &options.beside_gyroscope_file())?;
    join_gyroscope(&mut recording, gyro, options)?;
    Ok(recording)
}

/// Reads the gyroscope from `file` and joins it to `recording`. Rows that it does not cover get
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
pub fn join_gyroscope<'a>(
    recording: &mut Recording,
    file: impl Into<Named<'a>>,
    options: &ReadOptions,
) -> Result<()> {
    let file = file.into();
    join_input(recording, open(file, options)?, &file.name(), options)
}

/// True for a file that contains a gyroscope and no accelerometer, by its column names, or, if
/// these are bare `x`, `y`, `z` or missing, by its file name (`Gyroscope.csv`).
pub fn holds_gyroscope_alone(file: Named<'_>, options: &ReadOptions) -> bool {
    let head = open_head(file, options);
    let read = head.and_then(|input| read_gyroscope(input, &file.name(), options));
    let bare = |name: &String| name.trim().trim_matches('"').eq_ignore_ascii_case("x");
    read.is_ok_and(|read| {
        let names = read.format.names;
        let is_told = !names.is_empty() && !names.iter().any(bare);
        is_told || is_named_gyroscope(file.path())
    })
}

/// True for a file named after a gyroscope and not also after an accelerometer.
pub fn is_named_gyroscope(path: &Path) -> bool {
    let stem = stem(&path.to_string_lossy()).to_lowercase();
    stem.contains("gyr") && !stem.contains("acc")
}

fn join_input(
    recording: &mut Recording,
    input: Input,
    name: &str,
    options: &ReadOptions,
) -> Result<()> {
    if recording.gyro.is_some() {
        let error = Problem::GyroTwice.error();
        let error = error.at(recording.name.as_ref(), None);
        return Err(error.advise("gyro", "").advise("columns", "gx=-,gy=-,gz=-"));
    }
    recording.refuse_averaged("cut the recording, and join its parts")?;
    let options = ReadOptions {
        likely_time_unit: recording.clock.unit,
        ..options.clone()
    };
    let mut gyro = read_gyroscope(input, name, &options)?;
    refuse_restart(&gyro)?;
    let channels = gyro.gyro.take().unwrap_or_default();
    let (channels, finding) = match (stamps_s(recording), stamps_s(&gyro)) {
        (Some(times_s), Some(stamps_s)) if times_s == stamps_s => (channels, None),
        (Some(times_s), Some(stamps_s)) => {
            refuse_restart(recording)?;
            by_stamps(recording, &times_s, &gyro, &channels, &stamps_s)?
        }
        _ => {
            check_rows(recording, &gyro)?;
            let finding = Case::GyroRowByRow.finding().in_file(name);
            (channels, Some(finding))
        }
    };
    // Of the measured values, before interpolation.
    recording.units.resolution[1] = gyro.units.resolution[1];
    recording.units.gyro = gyro.units.gyro;
    recording.gyro = Some(channels);
    recording.gyro_file = Some(JoinedFile {
        name: name.to_owned(),
        sha256: gyro.sha256,
    });
    recording.findings.append(&mut gyro.findings);
    recording.findings.extend(finding);
    Ok(())
}

/// Times of the rows on the recorder's clock.
fn stamps_s(recording: &Recording) -> Option<Vec<f64>> {
    let (time_s, origin_s) = (recording.time_s.as_ref()?, recording.clock.start_s?);
    Some(time_s.iter().map(|t| t + origin_s).collect())
}

fn refuse_restart(recording: &Recording) -> Result<()> {
    let Some((line, _)) = recording.clock.restarts.first() else {
        return Ok(());
    };
    let (error, line) = (Problem::GyroRestart.error(), u64::from(*line));
    Err(error.at(recording.name.as_ref(), Some(line)))
}

/// Refuses files whose rows do not follow each other alike: without stamps they are joined by them.
fn check_rows(recording: &Recording, gyro: &Recording) -> Result<()> {
    let (rows, of_gyro) = (recording.lines.len(), gyro.lines.len());
    let apart =
        |row: &usize| recording.line(*row) - recording.line(0) != gyro.line(*row) - gyro.line(0);
    let problem = if rows != of_gyro {
        let (gyro, accel) = (of_gyro, rows);
        Problem::GyroRows { gyro, accel }
    } else if let Some(row) = (0..rows).find(apart) {
        let line = recording.line(row);
        Problem::GyroLines { line }
    } else {
        return Ok(());
    };
    Err(problem.error().at(gyro.name.as_ref(), None))
}

/// The rates at the times of the accelerometer's rows, and a finding about rows without any.
fn by_stamps(
    recording: &Recording,
    times_s: &[f64],
    gyro: &Recording,
    channels: &[Vec<f64>; 3],
    stamps_s: &[f64],
) -> Result<([Vec<f64>; 3], Option<Finding>)> {
    // Interpolation needs increasing times: repeated stamps and steps back, reported by the
    // reader, are skipped.
    let mut latest_s = f64::NEG_INFINITY;
    let mut rising: Vec<usize> = (0..stamps_s.len()).collect();
    rising.retain(|row| {
        let rises = stamps_s[*row] > latest_s;
        latest_s = latest_s.max(stamps_s[*row]);
        rises
    });
    let period_s = gyro.clock.rate_hz().map_or(f64::NAN, f64::recip);
    let near_s = SAME_STAMP * period_s;
    // Rows of the gyroscope around a time, and where between them it is.
    let around = |t: &f64| -> Option<(usize, usize, f64)> {
        let at = rising.partition_point(|row| stamps_s[*row] < *t);
        let below = at.checked_sub(1).map(|before| rising[before]);
        match (below, rising.get(at).copied()) {
            (_, Some(b)) if stamps_s[b] - t <= near_s => Some((b, b, 0.0)),
            (Some(a), _) if t - stamps_s[a] <= near_s => Some((a, a, 0.0)),
            (Some(a), Some(b)) => {
                let step_s = stamps_s[b] - stamps_s[a];
                let is_near = step_s < GAP_PERIODS * period_s && !gyro.is_broken(&(a..b + 1));
                is_near.then(|| (a, b, (t - stamps_s[a]) / step_s))
            }
            _ => None,
        }
    };
    let places: Vec<Option<(usize, usize, f64)>> = times_s.iter().map(around).collect();
    let joined = channels.each_ref().map(|channel| {
        let rate =
            |(a, b, share): (usize, usize, f64)| channel[a] + share * (channel[b] - channel[a]);
        let rates = places.iter().map(|place| place.map_or(f64::NAN, rate));
        rates.collect()
    });
    let uncovered = (0..places.len()).filter(|row| places[*row].is_none());
    let uncovered: LineSpans = uncovered.map(|row| recording.line(row)).collect();
    let rows = times_s.len() as u64;
    if uncovered.count() == rows {
        let spans_s = [recording, gyro].map(|r| {
            let start_s = r.clock.start_s.unwrap_or(f64::NAN);
            [start_s, start_s + r.clock.duration_s.unwrap_or(f64::NAN)]
        });
        let name = recording.name.clone();
        let error = Problem::GyroOverlap { name, spans_s }.error();
        let error = error.at(gyro.name.as_ref(), None);
        return Err(error.advise("time_unit", ""));
    }
    let finding = (!uncovered.is_empty()).then(|| {
        let case = Case::GyroUncovered {
            uncovered: uncovered.count(),
            rows,
            percent: 100.0 * uncovered.count() as f64 / rows as f64,
            within_ms: 1e3 * GAP_PERIODS * period_s,
        };
        let finding = case.finding().at_lines(&uncovered);
        finding.in_file(&recording.name)
    });
    Ok((joined, finding))
}
