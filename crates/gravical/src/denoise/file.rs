//! Filtering from file to file: its text is read again and written with the filtered values.

use std::array::from_fn;
use std::io::Write;
use std::path::Path;

use crate::Result;
use crate::calibration_file::InputFile;
use crate::output::BlockWriter;
use crate::recording::collect::{self, Rereader};
use crate::recording::dialect::Dialect;
use crate::recording::layout::Layout;
use crate::recording::open::Reopenable;
use crate::recording::{ReadOptions, Recording};

use super::engine::Setup;
use super::plan::{Plan, channel_field, input_name};
use super::{DenoiseOptions, DenoiseSummary, begin, filter_in_memory};

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
/// The channels are held in memory. What comes from a pipe is copied to a temporary file.
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
    let mut recording = collect::read_from(&mut source, &name, read)?;
    let inputs = InputFile::of(std::slice::from_ref(&recording));
    let (setup, mut begun) = begin(&mut recording, options)?;
    let done = filter_in_memory(&setup, &mut recording);
    begun
        .summary
        .finish(&setup, done, begun.scales, begun.duration_s);
    let mut again = Rereader::new(&mut source, &name, read, recording.known);
    begun.summary.columns = write(&mut again, &setup, &recording, out)?;
    Ok(DenoisedFile {
        summary: begun.summary,
        inputs,
    })
}

/// Writes the rows of the file with the filtered values of `recording`; returns the names of the
/// columns.
fn write(
    again: &mut Rereader<'_>,
    setup: &Setup,
    recording: &Recording,
    out: &mut dyn Write,
) -> Result<Vec<String>> {
    let known = again.known;
    let file = again.open()?.with_spans();
    let mut rows = file.rows;
    let (dialect, layout) = (&file.format.dialect, &file.format.layout);
    let plan = Plan::with_names(dialect, layout, &names(setup, dialect, layout), false);
    let mut out = BlockWriter::new(out);
    out.bytes.extend_from_slice(&plan.header());
    // A filter that removes constants also removes the offset.
    let kept = setup.filters.iter().all(|f| f.spec().keeps_constants());
    let offset = if kept { known.facts.zero_offset } else { 0.0 };
    let columns: Vec<&Vec<f64>> = recording
        .accel
        .iter()
        .chain(recording.gyro.iter().flatten())
        .collect();
    let mut number = 0;
    while let Some(row) = rows.next_row()? {
        let values = from_fn(|c| {
            let value = columns.get(c).and_then(|column| column.get(number));
            value.map_or(f64::NAN, |v| if c < 3 { v + offset } else { *v })
        });
        // Breaks are written as blank lines.
        out.bytes.extend(row.before.iter().map(|_| b'\n'));
        plan.write_row(row.text.bytes, row.text.spans, &values, &mut out.bytes);
        out.write_if_full()?;
        number += 1;
    }
    if number != recording.rows() {
        return Err(again.changed());
    }
    rows.trailing().iter().for_each(|_| out.bytes.push(b'\n'));
    out.finish()?;
    Ok(plan.names)
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
