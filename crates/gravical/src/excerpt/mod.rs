//! Reading of long recordings in memory that does not grow: only the rows of the static intervals
//! and of the motions between them are stored.
//!
//! `calibrate`, `inspect` and `check` need only these rows and statistics of all rows. [`read`]
//! stores a recording of up to 262 144 rows completely. A longer one is read several times: the
//! first pass stores only statistics of short blocks, from which the static intervals are
//! determined; the last pass stores the rows of the static intervals and of the motions between
//! them, up to a number that does not depend on the length of the recording. What exceeds it is
//! reported as a [`Finding`].
//!
//! The static intervals are found in short blocks ([`crate::stills`]), to a block. Beyond 131 072 blocks (7 h at 100 Hz) the noise
//! level is computed from every second, fourth … group of 64 blocks, and a static interval is
//! split after 16 384 blocks (an hour).
//!
//! A recording with a label column is stored completely, and so is a pipe whose copy in a
//! temporary file could not be written.

mod plan;
mod survey;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::path::Path;

use crate::Result;
use crate::finding::{Finding, FindingKind, LineSpans};
use crate::poses::rests::{TURNING_RAD_S, without_turns};
use crate::recording::collect::{Columns, Known, Rereader, Sink, collect, collect_from};
use crate::recording::excerpt::Excerpt;
use crate::recording::format::Format;
use crate::recording::layout::Layout;
use crate::recording::monitor::Facts;
use crate::recording::names::Role;
use crate::recording::open::Reopenable;
use crate::recording::row::TEMPERATURE;
use crate::recording::rows::{Mark, Rows, Source};
use crate::recording::timing::Timing;
use crate::recording::{self, ReadOptions, Recording, RowMap, between, wearable};
use crate::stats::moments;
use crate::stills::{Levels, TemperatureCutter, block_rows};
use crate::temperature::MIN_SPAN_C;

use plan::{Plan, find_quiet};
use survey::{Long, QuietRows, Survey};

/// Limits of what is stored.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    /// Largest number of rows of a recording that is stored completely.
    whole: usize,
    /// Number of blocks from which the levels are computed.
    blocks: usize,
    /// Number of blocks that are searched for quiet runs at once.
    at_once: usize,
    /// Number of rows of static intervals.
    still_rows: usize,
    /// Smallest number of rows of a static interval.
    least: usize,
    /// Number of motions between static intervals, of their rows, and the longest motion, s.
    motions: usize,
    motion_rows: usize,
    motion_s: f64,
}

const BOUNDS: Bounds = Bounds {
    whole: 1 << 18,
    blocks: 1 << 17,
    at_once: 1 << 14,
    still_rows: 250_000,
    least: 250,
    motions: 500,
    motion_rows: 100_000,
    motion_s: 60.0,
};

/// Reads the recording at `path` (`-` is standard input): completely, or, if it is long, only its
/// static intervals and the motions between them.
///
/// # Errors
///
/// As [`recording::read`](crate::recording::read); `changed` for a file that has fewer rows when
/// it is read again.
///
/// # Example
///
/// ```
/// use gravical::recording::ReadOptions;
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("desk.csv");
/// # std::fs::write(&path, "t_ms,ax,ay,az\n0,0.1,0.0,9.8\n10,0.1,0.1,9.8\n20,0.1,0.0,9.7\n")?;
/// let recording = gravical::excerpt::read(&path, &ReadOptions::default())?;
/// assert!(!recording.is_excerpt() && recording.rows_in_file() == 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    options.validate()?;
    if !path.is_file() || !wearable::is_file(path)? {
        return recording::read(path, options);
    }
    let name = path.display().to_string();
    read_from(&mut Reopenable::of(path), &name, options, BOUNDS)
}

/// Reads the recording at `path`: completely, or, if it is long, only the rows `wanted` of the
/// file. Properties of the recording are those of all rows.
///
/// # Errors
///
/// As [`recording::read`](crate::recording::read). Rows beyond the end are no error: they are not
/// in memory.
pub(crate) fn read_rows(
    path: &Path,
    options: &ReadOptions,
    wanted: &[Range<usize>],
) -> Result<Recording> {
    read_rows_from(Reopenable::of(path), path, options, wanted, BOUNDS.whole)
}

fn read_rows_from(
    mut source: Reopenable,
    path: &Path,
    options: &ReadOptions,
    wanted: &[Range<usize>],
    whole: usize,
) -> Result<Recording> {
    options.validate()?;
    let name = path.display().to_string();
    let wanted = plan::merged(wanted.to_vec());
    let sink = |format: &Format, facts: &Facts| StoredRows {
        to_end: true,
        ..StoredRows::new(&format.layout, facts, wanted.clone())
    };
    let (stored, read) = collect(&mut source, &name, Role::Recording, options, sink)?.with(());
    if stored.row <= whole {
        return Ok(collect(
            &mut source,
            &name,
            Role::Recording,
            options,
            Columns::of_format,
        )?
        .into_recording());
    }
    let even_hz = read
        .finished
        .summary
        .facts
        .stamp_reading
        .and_then(|s| s.even_hz);
    let mut recording = read.with(stored.columns).1.into_recording();
    recording.excerpt = Some(Excerpt {
        rows: stored.rows,
        temperature_c: recording.temperature_range_c(),
        thermal: Vec::new(),
        still_rows_left_out: 0,
        rests: Vec::new(),
        is_worn: false,
    });
    time_by_rows_of_the_file(&mut recording, even_hz);
    Ok(recording)
}

/// With an even rate, the time of a row is its number in the file over the rate.
fn time_by_rows_of_the_file(recording: &mut Recording, even_hz: Option<f64>) {
    if let (Some(rate_hz), Some(_)) = (even_hz, &recording.time_s) {
        let rows = (0..recording.rows()).map(|row| recording.row_in_file(row));
        recording.time_s = Some(rows.map(|row| row as f64 / rate_hz).collect());
    }
}

fn read_from(
    source: &mut Reopenable,
    name: &str,
    options: &ReadOptions,
    bounds: Bounds,
) -> Result<Recording> {
    let input = source.open(options)?;
    let whole = match source.is_reopenable() {
        true => bounds.whole,
        false => usize::MAX,
    };
    let survey = |rate: Option<f64>| {
        move |format: &Format, facts: &Facts| {
            let columns = Columns::of_format(format, facts);
            // Labels refer to all rows.
            let whole = match columns.has_labels() {
                true => usize::MAX,
                false => whole,
            };
            Survey::new(columns, whole, bounds.blocks, rate)
        }
    };
    let mut read = collect_from(input, source, name, Role::Recording, options, survey(None))?;
    let rate_hz = |timing: &Timing| timing.rate_hz().unwrap_or(Recording::ASSUMED_RATE_HZ);
    let mut rate = rate_hz(&read.finished.summary.timing);
    let width = read.rows.long.as_ref().map(|long| long.width);
    // The first rows may give another rate than all of them.
    if width.is_some_and(|width| width != block_rows(rate))
        && let Some(input) = source.reopen(options)?
    {
        read = collect_from(
            input,
            source,
            name,
            Role::Recording,
            options,
            survey(Some(rate)),
        )?;
        rate = rate_hz(&read.finished.summary.timing);
    }
    let (survey, read) = read.with(());
    let known = Known {
        facts: read.facts,
        zeros_from: read.zeros_from,
    };
    let Some(long) = survey.long else {
        return Ok(read.with(survey.columns).1.into_recording());
    };
    let temperature_c = long.temperature_c();
    let Long {
        width,
        blocks,
        rows,
        breaks,
        gyro,
        restarted,
        marks,
        ..
    } = long;
    let mut rereader = Rereader::new(source, name, options, known);

    // Find the quiet runs …
    let steps = &read.finished.summary.facts.resolution;
    let levels = Levels::of(&blocks.groups, rate, steps);
    let mut quiet = Vec::new();
    if blocks.is_thinned() {
        drop(blocks);
        let sink = |_: &Format, facts: &Facts| {
            QuietRows::new(levels.clone(), width, gyro, facts, bounds.at_once)
        };
        quiet = rereader.collect(sink)?.found;
    } else {
        for group in &blocks.groups {
            find_quiet(levels.as_ref(), group, &mut quiet);
        }
        drop(blocks);
    }
    let segments = between(&breaks, rows);
    let mut plan = Plan::new(&quiet, &segments, rate, width, gyro, &bounds);
    drop(quiet);

    // … and read their rows.
    let wide = temperature_c.is_some_and(|[low, high]| high - low > MIN_SPAN_C);
    let wanted_rows = std::mem::take(&mut plan.rows);
    let stored = rereader.collect(|format: &Format, facts: &Facts| StoredRows {
        thermal: wide.then(|| TemperatureCutter::new(rate, gyro)),
        marks,
        ..StoredRows::new(&format.layout, facts, wanted_rows)
    })?;
    if stored.complete < stored.wanted.len() {
        return Err(rereader.changed());
    }
    let even_hz = read
        .finished
        .summary
        .facts
        .stamp_reading
        .and_then(|s| s.even_hz);
    let mut recording = read.with(stored.columns).1.into_recording();
    recording.restarted |= restarted;
    recording.excerpt = Some(Excerpt {
        rows: stored.rows,
        temperature_c,
        thermal: stored.thermal.map_or_else(Vec::new, |c| c.blocks()),
        still_rows_left_out: plan.left_out.1,
        rests: Vec::new(),
        is_worn: false,
    });
    time_by_rows_of_the_file(&mut recording, even_hz);
    if let Some(levels) = levels {
        let rests = rests_in_memory(&recording, &levels, &plan.quiet);
        if let Some(excerpt) = &mut recording.excerpt {
            excerpt.rests = rests;
            excerpt.is_worn = levels.worn;
        }
    }
    let left_out = findings_about_rows_left_out(&recording, &plan, &bounds, rate);
    recording.findings.extend(left_out);
    Ok(recording)
}

/// The last pass: stores the planned rows.
struct StoredRows {
    columns: Columns,
    rows: RowMap,
    thermal: Option<TemperatureCutter>,
    zero_offset: f64,
    /// Rows after the last range are read, too, for the properties of all rows.
    to_end: bool,
    /// Ranges of rows to store, and the number of complete ones.
    wanted: Vec<Range<usize>>,
    complete: usize,
    /// Positions where reading can be continued, with the number of the next row.
    marks: Vec<(usize, Mark)>,
    /// Number of the next row.
    row: usize,
    /// The next stored row does not continue the last one.
    after_break: bool,
}

impl Sink for StoredRows {
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        rows.hold_default();
        let mut skipped_to = 0;
        let to_end = self.to_end || self.thermal.is_some();
        while self.complete < self.wanted.len() || to_end {
            if !to_end && skipped_to <= self.complete {
                skipped_to = self.complete + 1;
                self.skip(rows)?;
            }
            let Some(row) = rows.next_row()? else {
                break;
            };
            let is_break = row.is_break();
            if let Some(thermal) = &mut self.thermal {
                let (accel, rate) = survey::sample(row.values, self.zero_offset);
                thermal.push(row.values[TEMPERATURE], accel, rate, is_break);
            }
            self.after_break |= is_break;
            if let Some(range) = self.wanted.get(self.complete)
                && self.row >= range.start
            {
                self.columns
                    .push(&row, std::mem::take(&mut self.after_break))?;
                self.rows.push(self.row as u64);
                self.complete += usize::from(self.row + 1 == range.end);
            }
            self.row += 1;
        }
        Ok(())
    }
}

impl StoredRows {
    fn new(layout: &Layout, facts: &Facts, wanted: Vec<Range<usize>>) -> Self {
        StoredRows {
            columns: Columns::new(layout, facts),
            rows: RowMap::default(),
            thermal: None,
            zero_offset: facts.zero_offset,
            to_end: false,
            wanted,
            complete: 0,
            marks: Vec::new(),
            row: 0,
            after_break: false,
        }
    }

    /// Skips rows before the next stored range.
    fn skip<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        let Some(next) = self.wanted.get(self.complete) else {
            return Ok(());
        };
        let at = self.marks.partition_point(|(row, _)| *row <= next.start);
        if let Some((row, mark)) = self.marks[..at].last()
            && *row > self.row
        {
            rows.skip_to(mark)?;
            self.row = *row;
        }
        Ok(())
    }
}

/// Quiet runs of the file as static intervals in memory.
fn rests_in_memory(
    recording: &Recording,
    levels: &Levels,
    quiet: &[Range<usize>],
) -> Vec<Range<usize>> {
    let row = |row: usize| recording.excerpt.as_ref()?.rows.row(row as u64);
    let spans: Vec<Range<usize>> = quiet
        .iter()
        .filter_map(|run| Some(row(run.start)?..row(run.end - 1)? + 1))
        .filter(|rows| recording.length(rows) >= levels.shortest)
        .collect();
    let per_rad_s = recording.gyro_scale.and_then(|s| s.nominal());
    match (&recording.gyro, per_rad_s) {
        (Some(gyro), Some(per_rad_s)) => {
            let rate = |rest: &Range<usize>| moments(gyro, rest.clone()).0;
            without_turns(spans, rate, TURNING_RAD_S * per_rad_s)
        }
        _ => spans,
    }
}

/// Findings about what was left out.
fn findings_about_rows_left_out(
    recording: &Recording,
    plan: &Plan,
    bounds: &Bounds,
    rate: f64,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let rows = recording.rows_in_file();
    if let Some((count, most)) = plan.shortened {
        let seconds = most as f64 / rate;
        findings.push(
            Finding::new(
                FindingKind::PosesShortened,
                format!(
                    "{rows} rows, too many for memory: of {count} static intervals longer than {seconds:.1} s the first and the last {:.1} s are used",
                    0.5 * seconds
                ),
            )
            .counting(count as u64),
        );
    }
    let (left_out, _) = plan.left_out;
    if left_out > 0 {
        let stored: usize = plan.quiet.len();
        findings.push(
            Finding::new(
                FindingKind::IntervalsLeftOut,
                format!(
                    "{} static intervals, too many for memory: of each direction the longest are used, {stored} in all",
                    stored + left_out
                ),
            )
            .counting(left_out as u64),
        );
    }
    if !plan.motions_left_out.is_empty() {
        let mut lines = LineSpans::default();
        let map = recording.excerpt.as_ref().map(|e| &e.rows);
        let line = |row: usize| Some(recording.line(map?.row(row as u64)?));
        for motion in &plan.motions_left_out {
            // From the last row at rest to the next one.
            if let (Some(from), Some(to)) = (line(motion.start - 1), line(motion.end)) {
                lines.push_range(from + 1, to - 1, 1);
            }
        }
        let left_out = plan.motions_left_out.len();
        findings.push(
            Finding::new(
                FindingKind::MotionsLeftOut,
                format!(
                    "{rows} rows, too many for memory: {left_out} of {} motions between static intervals are not used: those next to an interval that is left out, those longer than {:.0} s, and, beyond {} motions or {} rows, the longer ones about each axis",
                    plan.motions, bounds.motion_s, bounds.motions, bounds.motion_rows
                ),
            )
            .at_lines(&lines)
            .counting(left_out as u64),
        );
    }
    let name = |finding: Finding| finding.in_file(&recording.name);
    findings.into_iter().map(name).collect()
}
