//! Filtering of a file of any size: its rows are read again while they are filtered and written.

use std::array::from_fn;
use std::collections::VecDeque;
use std::io::Write;
use std::path::Path;

use crate::Result;
use crate::apply::plan::{Plan, channel_field, input_name};
use crate::calibration_file::InputFile;
use crate::excerpt::read_ahead;
use crate::output::BlockWriter;
use crate::recording::collect::{Known, Rereader, Sink};
use crate::recording::dialect::Dialect;
use crate::recording::layout::Layout;
use crate::recording::open::Reopenable;
use crate::recording::row::Span;
use crate::recording::rows::{self, Rows, Source};
use crate::recording::sample::Sample;
use crate::recording::{ReadOptions, Recording};

use super::clock::{Clock, FIRST_STAMPS, StampFiller};
use super::lane::Setup;
use super::off_grid::GridScout;
use super::run::Run;
use super::{Begun, DenoiseOptions, DenoiseSummary, begin};

/// A recording that was filtered from file to file.
#[derive(Debug, Clone)]
pub struct DenoisedFile {
    /// Results, with all findings.
    pub summary: DenoiseSummary,
    /// The file that was read.
    pub inputs: Vec<InputFile>,
}

/// Writes the recording at `path` (`-` is standard input) with filtered channels in place of the
/// recorded ones, as [`denoise`](super::denoise) filters them.
///
/// Filtered channels keep the name and the unit of their column, so that a calibration for the
/// recording also applies to the output; for a derivative `_per_s` is appended. Every other
/// column is copied byte for byte, breaks become blank lines. Values have six decimals.
///
/// Memory does not grow with the recording, only with the memory of the filters: the windows, and
/// the number of samples over which a two-pass Butterworth filter fades. What comes from a pipe is
/// copied to a temporary file.
///
/// # Errors
///
/// As [`denoise`](super::denoise) and [`crate::recording::read`]; `changed` (input) if the file
/// does not have the same rows when it is read again, and for a pipe that could not be copied;
/// errors of writing.
pub fn denoise_file(
    path: &Path,
    read: &ReadOptions,
    options: &DenoiseOptions,
    out: &mut dyn Write,
) -> Result<DenoisedFile> {
    options.validate()?;
    let name = path.display().to_string();
    let mut source = Reopenable::of(path);
    let mut recording = read_ahead(&mut source, &name, read, &options.still)?;
    let inputs = InputFile::of(std::slice::from_ref(&recording));
    let mut file = File {
        again: Rereader::new(&mut source, &name, read, recording.known),
        rows: recording.rows_in_file(),
    };
    let begun = begin(&mut recording, options)?;
    let begun = match recording.is_excerpt() {
        true => file.set_up(&recording, begun, options)?,
        false => begun.set_up(&recording, options),
    };
    let (setup, mut rest) = begun;
    drop(recording);
    let run = Run::new(&setup, std::mem::take(&mut rest.noise));
    let (done, columns) = file.write(&setup, run, out)?;
    let mut summary = rest.finish(&setup, done);
    summary.columns = columns;
    Ok(DenoisedFile { summary, inputs })
}

/// The file, to be read again.
struct File<'a> {
    again: Rereader<'a>,
    rows: usize,
}

impl File<'_> {
    /// The setup for a recording of which not all rows are in memory.
    fn set_up(
        &mut self,
        recording: &Recording,
        begun: Begun,
        options: &DenoiseOptions,
    ) -> Result<(Setup, Begun)> {
        let first_s = match recording.time_s {
            Some(_) => Some(self.again.collect(|_, _| FirstStamps(Vec::new()))?.0),
            None => None,
        };
        let clock = Clock::new(
            recording.timing.rate_hz(),
            first_s.as_deref(),
            options.gap_steps(),
        );
        let mut off_grid = Default::default();
        if begun.needs_grid() && first_s.is_some() {
            let scout = ScoutedRows {
                scout: GridScout::new(clock),
                filler: StampFiller::new(clock.step_s),
                known: self.again.known,
            };
            off_grid = self.again.collect(|_, _| scout)?.scout.finish();
        }
        Ok(begun.with(recording, clock, off_grid))
    }

    /// Filters and writes all rows; returns the names of the columns, too.
    fn write(
        &mut self,
        setup: &Setup,
        mut run: Run<'_>,
        out: &mut dyn Write,
    ) -> Result<(super::run::Done, Vec<String>)> {
        let known = self.again.known;
        let file = self.again.open()?.with_spans();
        let mut rows = file.rows;
        let (dialect, layout) = (&file.format.dialect, &file.format.layout);
        let plan = Plan::with_names(dialect, layout, &names(setup, dialect, layout), false);
        let mut out = BlockWriter::new(out);
        out.bytes.extend_from_slice(&plan.header());
        // A filter that removes constants also removes the offset.
        let kept = setup.filters.iter().all(|f| f.spec().keeps_constants());
        let offset = if kept { known.facts.zero_offset } else { 0.0 };
        let mut texts = Texts::default();
        let mut receive = |texts: &mut Texts, cells: &[Vec<f64>; 6], rows: usize| {
            texts.take(rows, |i, line, fields, breaks| {
                let values = from_fn(|c| {
                    let offset = if c < 3 { offset } else { 0.0 };
                    cells[c].get(i).map_or(f64::NAN, |value| value + offset)
                });
                // Breaks are written as blank lines.
                out.bytes.extend(std::iter::repeat_n(b'\n', breaks));
                plan.write_row(line, fields, &values, &mut out.bytes);
                out.write_if_full()
            })
        };
        let mut number = 0;
        while let Some(next) = rows.next_row()? {
            // Otherwise it is refused below.
            if number < self.rows {
                texts.push(&next);
                let sample = Sample::of_row(&next, number, &known);
                run.push(sample, &mut |cells, rows| receive(&mut texts, cells, rows))?;
            }
            number += 1;
        }
        if number != self.rows {
            return Err(self.again.changed());
        }
        let done = run.finish(&mut |cells, rows| receive(&mut texts, cells, rows))?;
        rows.trailing().iter().for_each(|_| out.bytes.push(b'\n'));
        out.finish()?;
        Ok((done, plan.names))
    }
}

/// The first time stamps of a recording.
struct FirstStamps(Vec<f64>);

impl Sink for FirstStamps {
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        while let Some(row) = rows.next_row()? {
            self.0.extend(Some(row.t_s).filter(|t| t.is_finite()));
            if self.0.len() == FIRST_STAMPS {
                break;
            }
        }
        Ok(())
    }
}

/// The pass over all time stamps.
struct ScoutedRows {
    scout: GridScout,
    filler: StampFiller,
    known: Known,
}

impl Sink for ScoutedRows {
    fn collect<S: Source>(&mut self, rows: &mut Rows<S>) -> Result<()> {
        let mut number = 0;
        while let Some(next) = rows.next_row()? {
            let sample = Sample::of_row(&next, number, &self.known);
            self.filler.push(sample).for_each(|s| self.scout.push(s));
            number += 1;
        }
        self.filler
            .finish()
            .into_iter()
            .for_each(|sample| self.scout.push(sample));
        Ok(())
    }
}

/// Text of the rows that are not written yet.
#[derive(Default)]
struct Texts {
    bytes: VecDeque<u8>,
    spans: VecDeque<Span>,
    /// Of each row the number of breaks before it, of bytes and of fields.
    rows: VecDeque<[u32; 3]>,
}

impl Texts {
    fn push(&mut self, row: &rows::Row<'_>) {
        self.bytes.extend(row.text.bytes);
        self.spans.extend(row.text.spans);
        let counts = [row.before.len(), row.text.bytes.len(), row.text.spans.len()];
        self.rows.push_back(counts.map(|n| n as u32));
    }

    /// Removes the first rows: passes the number, the line, its fields and the breaks before it to
    /// `write`.
    fn take(
        &mut self,
        rows: usize,
        mut write: impl FnMut(usize, &[u8], &[Span], usize) -> Result<()>,
    ) -> Result<()> {
        let (mut bytes, mut spans) = (0, 0);
        let (all_bytes, all_spans) = (self.bytes.make_contiguous(), self.spans.make_contiguous());
        for (i, counts) in self.rows.drain(..rows).enumerate() {
            let [breaks, line, fields] = counts.map(|n| n as usize);
            let (line, fields) = (bytes..bytes + line, spans..spans + fields);
            (bytes, spans) = (line.end, fields.end);
            write(i, &all_bytes[line], &all_spans[fields], breaks)?;
        }
        self.bytes.drain(..bytes);
        self.spans.drain(..spans);
        Ok(())
    }
}

/// Names of the filtered channels.
fn names(setup: &Setup, dialect: &Dialect, layout: &Layout) -> [Option<String>; 6] {
    let order: usize = setup.filters.iter().map(|f| f.spec().derivative()).sum();
    let suffix = match order {
        0 => String::new(),
        1 => "_per_s".to_owned(),
        n => format!("_per_s{n}"),
    };
    from_fn(|i| {
        setup.channels.contains(&i).then_some(())?;
        let field = channel_field(layout, i)?;
        Some(input_name(dialect, layout, field) + &suffix)
    })
}
