//! Long recordings in flat memory: the rows of their stills, and of the motions between
//! them.
//!
//! What `calibrate`, `inspect` and `check` need of a recording are its stills, the motions
//! between them, and figures over all rows. [`read`] keeps a recording of up to
//! 262 144 rows whole. A longer one is read again: the first reading keeps statistics of
//! short blocks alone, by which the stills are found; the last one keeps the rows of the
//! stills and of the motions between them, up to a number that does not grow with the
//! recording. What of them had no room is a [`Finding`].
//!
//! The stills are those that [`find_stills`](crate::segment::still::find_stills) finds in
//! the whole recording, with the same rows. Beyond 131 072 blocks (7 h at 100 Hz) the level
//! of the noise is that of every second, fourth … stretch of 64 blocks, and a still ends
//! where 16 384 blocks (an hour) end.
//!
//! A recording with a label column is kept whole, and so is a pipe that cannot be read
//! again: where its copy in a temporary file had no room.

mod plan;
mod survey;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::path::Path;

use crate::finding::{Finding, FindingKind, LineSpans};
use crate::recording::collect::{Columns, Known, Sink, collect_again, collect_from};
use crate::recording::excerpt::Excerpt;
use crate::recording::layout::Layout;
use crate::recording::monitor::Facts;
use crate::recording::open::Reopenable;
use crate::recording::row::TEMPERATURE;
use crate::recording::rows::{Mark, Rows, Source};
use crate::recording::timing::Timing;
use crate::recording::{ReadOptions, Recording, RowMap, between};
use crate::still::{Levels, StillOptions, Stills, TemperatureCutter, block_rows};
use crate::temperature::LEAST_SPAN_C;
use crate::{Error, Result};

use plan::{Plan, find_quiet};
use survey::{Long, QuietRows, Survey};

/// How much is kept.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    /// A recording of so many rows is kept whole.
    whole: usize,
    /// Blocks by which the levels are found.
    blocks: usize,
    /// Blocks in which runs are looked for at once.
    at_once: usize,
    /// Rows of stills.
    still_rows: usize,
    /// Rows that a still keeps at the least.
    least: usize,
    /// Motions between stills, their rows, and the length of each, s.
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

/// Reads the recording at `path` (`-` is standard input): whole, or of a long one what its
/// stills, found by `still`, and the motions between them need.
///
/// # Errors
///
/// As [`recording::read`](crate::recording::read); `changed` for a file that has fewer rows
/// when it is read again, and for a pipe of which no copy could be kept.
///
/// # Example
///
/// ```
/// use gravical::recording::ReadOptions;
/// use gravical::segment::still::StillOptions;
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("desk.csv");
/// # std::fs::write(&path, "t_ms,ax,ay,az\n0,0.1,0.0,9.8\n10,0.1,0.1,9.8\n20,0.1,0.0,9.7\n")?;
/// let recording =
///     gravical::excerpt::read(&path, &ReadOptions::default(), &StillOptions::default())?;
/// assert!(!recording.is_excerpt() && recording.rows_in_file() == 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(path: &Path, options: &ReadOptions, still: &StillOptions) -> Result<Recording> {
    options.validate()?;
    let name = path.display().to_string();
    read_from(Reopenable::of(path), &name, options, still, BOUNDS)
}

fn read_from(
    mut source: Reopenable,
    name: &str,
    options: &ReadOptions,
    still: &StillOptions,
    bounds: Bounds,
) -> Result<Recording> {
    let input = source.open(options)?;
    let whole = match source.is_reopenable() {
        true => bounds.whole,
        false => usize::MAX,
    };
    let survey = |rate: Option<f64>| {
        move |layout: &Layout, facts: &Facts| {
            let columns = Columns::new(layout, facts);
            Survey::new(columns, whole, bounds.blocks, still, rate)
        }
    };
    let mut read = collect_from(input, &mut source, name, options, survey(None))?;
    let rate_hz = |timing: &Timing| timing.rate_hz().unwrap_or(Recording::ASSUMED_RATE_HZ);
    let mut rate = rate_hz(&read.finished.timing);
    let width = read.rows.long.as_ref().map(|long| long.width);
    // The first rows may tell another rate than all of them.
    if width.is_some_and(|width| width != block_rows(rate, still))
        && let Some(input) = source.again(options)?
    {
        read = collect_from(input, &mut source, name, options, survey(Some(rate)))?;
        rate = rate_hz(&read.finished.timing);
    }
    let (survey, read) = read.with(());
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
    let mut again = Again {
        source: &mut source,
        name,
        options,
        known: Known {
            facts: read.facts,
            zeros_from: read.zeros_from,
        },
    };

    // Where it is still …
    let wanted = [still.clone(), StillOptions::unsteady()];
    let levels = wanted.each_ref().map(|options| {
        let options = StillOptions {
            block_s: still.block_s,
            ..options.clone()
        };
        let steps = &read.finished.facts.resolution;
        Levels::of(&blocks.groups, rate, steps, &options)
    });
    let mut quiet = Default::default();
    if blocks.is_thinned() {
        drop(blocks);
        let sink = |_: &Layout, facts: &Facts| {
            QuietRows::new(levels.clone(), width, gyro, facts, bounds.at_once)
        };
        quiet = again.collect(sink)?.found;
    } else {
        for group in &blocks.groups {
            find_quiet(&levels, group, &mut quiet);
        }
        drop(blocks);
    }
    let segments = between(&breaks, rows);
    let mut plan = Plan::new(&quiet, &segments, rate, width, gyro, &bounds);
    drop(quiet);

    // … and these rows.
    let wide = temperature_c.is_some_and(|[low, high]| high - low > LEAST_SPAN_C);
    let wanted_rows = std::mem::take(&mut plan.kept);
    let kept = again.collect(|layout: &Layout, facts: &Facts| Kept {
        columns: Columns::new(layout, facts),
        rows: RowMap::default(),
        thermal: wide.then(|| TemperatureCutter::new(rate, gyro)),
        zero_offset: facts.zero_offset,
        wanted: wanted_rows,
        marks,
        complete: 0,
        row: 0,
        parts: false,
    })?;
    if kept.complete < kept.wanted.len() {
        return Err(again.gone());
    }
    let even_hz = read.finished.facts.stamp_reading.and_then(|s| s.even_hz);
    let mut recording = read.with(kept.columns).1.into_recording();
    recording.restarted |= restarted;
    recording.excerpt = Some(Excerpt {
        rows: kept.rows,
        temperature_c,
        thermal: kept.thermal.map_or_else(Vec::new, |c| c.blocks()),
        still_rows_left_out: plan.left_out.1,
        stills: Vec::new(),
    });
    if let (Some(rate_hz), Some(_)) = (even_hz, &recording.time_s) {
        let rows = (0..recording.rows()).map(|row| recording.row_in_file(row));
        recording.time_s = Some(rows.map(|row| row as f64 / rate_hz).collect());
    }
    let mut stills = Vec::new();
    for ((options, levels), rows) in wanted.into_iter().zip(levels).zip(&plan.quiet) {
        let found = levels.map_or_else(Stills::default, |levels| grown(&recording, &levels, rows));
        stills.push((options, found));
    }
    if let Some(excerpt) = &mut recording.excerpt {
        excerpt.stills = stills;
    }
    let told = tell(&recording, &plan, &bounds, rate);
    recording.findings.extend(told);
    Ok(recording)
}

/// A recording that is read again.
struct Again<'a> {
    source: &'a mut Reopenable,
    name: &'a str,
    options: &'a ReadOptions,
    known: Known,
}

impl Again<'_> {
    fn collect<T: Sink>(&mut self, sink: impl FnOnce(&Layout, &Facts) -> T) -> Result<T> {
        let read = collect_again(self.source, self.name, self.options, self.known, sink)?;
        read.ok_or_else(|| self.gone())
    }

    fn gone(&self) -> Error {
        Error::input(
            "changed",
            "too long to be kept in memory, and when it was read again it had fewer rows",
        )
        .at(Path::new(self.name), None)
        .with_hint(
            "wait until nothing writes to it; put what comes through a pipe into a file first",
        )
    }
}

/// The last reading: the rows that are kept.
struct Kept {
    columns: Columns,
    rows: RowMap,
    thermal: Option<TemperatureCutter>,
    zero_offset: f64,
    /// Which rows are kept, and how many of these ranges are.
    wanted: Vec<Range<usize>>,
    complete: usize,
    /// What reading may go on by, and the row that comes next.
    marks: Vec<(usize, Mark)>,
    /// Number of the next row.
    row: usize,
    /// It does not follow the last one that was kept.
    parts: bool,
}

impl Sink for Kept {
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        rows.hold_few();
        let mut looked = 0;
        while self.complete < self.wanted.len() || self.thermal.is_some() {
            if self.thermal.is_none() && looked <= self.complete {
                looked = self.complete + 1;
                self.skip(rows)?;
            }
            let Some(row) = rows.next_row()? else {
                break;
            };
            let parts = row.parts();
            if let Some(thermal) = &mut self.thermal {
                let (accel, rate) = survey::sample(row.values, self.zero_offset);
                thermal.push(row.values[TEMPERATURE], accel, rate, parts);
            }
            self.parts |= parts;
            if let Some(range) = self.wanted.get(self.complete)
                && self.row >= range.start
            {
                self.columns.push(&row, std::mem::take(&mut self.parts))?;
                self.rows.push(self.row as u64);
                self.complete += usize::from(self.row + 1 == range.end);
            }
            self.row += 1;
        }
        Ok(())
    }
}

impl Kept {
    /// Passes over rows before those that are kept next.
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

/// Quiet runs of the file as stills in memory.
fn grown(recording: &Recording, levels: &Levels, quiet: &[Range<usize>]) -> Stills {
    let segments = recording.segments();
    let mut spans: Vec<Range<usize>> = Vec::new();
    for run in quiet {
        let row = |row: usize| recording.excerpt.as_ref()?.rows.row(row as u64);
        let (Some(first), Some(last)) = (row(run.start), row(run.end - 1)) else {
            continue;
        };
        let mut rows = first..last + 1;
        let at = segments.partition_point(|s| s.end <= first);
        if let Some(segment) = segments.get(at) {
            let from = spans.last().map_or(0, |s| s.end).max(segment.start);
            rows = levels.grow(&recording.accel, rows, from..segment.end);
        }
        if recording.length(&rows) >= levels.shortest {
            spans.push(rows);
        }
    }
    Stills {
        spans: levels.without_turning(recording.gyro.as_ref(), spans),
        noise: levels.noise(),
    }
}

/// What had no room.
fn tell(recording: &Recording, plan: &Plan, bounds: &Bounds, rate: f64) -> Vec<Finding> {
    let mut findings = Vec::new();
    let rows = recording.rows_in_file();
    if let Some((count, most)) = plan.shortened {
        let seconds = most as f64 / rate;
        findings.push(
            Finding::new(
                FindingKind::StillsShortened,
                format!(
                    "{rows} rows, too many to be kept in memory: of {count} stills longer than {seconds:.1} s the first and the last {:.1} s are used",
                    0.5 * seconds
                ),
            )
            .counting(count as u64),
        );
    }
    let (left_out, _) = plan.left_out;
    if left_out > 0 {
        let kept: usize = plan.quiet.iter().map(Vec::len).sum();
        findings.push(
            Finding::new(
                FindingKind::StillsLeftOut,
                format!(
                    "{} stills, too many to be kept in memory: the longest {kept} of all directions are used",
                    kept + left_out
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
                    "{rows} rows, too many to be kept in memory: {left_out} of {} motions between stills are not used: those beside a still that is left out or longer than {:.0} s, and beyond {} motions or {} rows the longer ones about each axis",
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
