//! Filtering from file to file: its text is written with the filtered values.

use std::io::Write;
use std::path::Path;

use gravical_recording::Format;
use gravical_recording::write::{NewColumn, Table, Writer, input_name};

use crate::calibration_file::InputFile;
use crate::recording::ReadOptions;
use crate::{Error, Result};
use gravical_recording::BatchReader;
use gravical_recording::source::open;

use super::{DenoiseOptions, DenoiseSummary, FilterSpec, begin, channels, filter_in_memory};

/// Decimals of a filtered value.
const DECIMALS: u32 = 6;

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
/// column is copied byte for byte, breaks become blank lines. Values have six decimals. A row that
/// is no measurement stays a row with empty channels.
///
/// Channels and the text of other columns are held in memory.
///
/// # Errors
///
/// As [`denoise`](super::denoise) and [`crate::recording::read_samples`]; errors of writing.
pub fn denoise_file(
    path: &Path,
    read: &ReadOptions,
    options: &DenoiseOptions,
    out: &mut dyn Write,
) -> Result<DenoisedFile> {
    options.validate()?;
    let name = path.display().to_string();
    let copied = |format: &Format| table(options, format).copied().to_vec();
    let mut reader = BatchReader::open_whole(open(path, read)?, &name, read, copied)?;
    let table = table(options, &reader.format);
    let (setup, mut begun) = begin(&mut reader.recording, options)?;
    let done = filter_in_memory(&setup, &mut reader.recording);
    begun
        .summary
        .finish(&setup, done, begun.scales, begun.duration_s);
    let mut summary = begun.summary;
    summary.columns.clone_from(&table.names);
    // A filter that removes constants also removes the offset.
    let keeps_offset = setup.filters.iter().all(|f| f.spec().keeps_constants());
    let offset = if keeps_offset {
        reader.recording.zero_offset
    } else {
        0.0
    };
    let output = |e| Error::io(Path::new("output"), e);
    let mut writer = Writer::new(out, table);
    let mut written = 0;
    while let Some(mut rows) = reader.next_rows()? {
        let readings = &mut rows.readings;
        let accel = readings.accel.iter_mut().flatten();
        accel.for_each(|v| *v += offset);
        let channels = readings.accel.iter().chain(readings.gyro.iter().flatten());
        let channels: Vec<&[f64]> = channels.map(Vec::as_slice).collect();
        let filtered: Vec<&[f64]> = setup.channels.iter().map(|c| channels[*c]).collect();
        let all = 0..rows.lines.len();
        written += all.len();
        writer
            .write_rows(all, &rows.text, &filtered, &readings.breaks)
            .map_err(output)?;
    }
    writer.finish().map_err(output)?;
    let (recording, _, found) = reader.finish(written);
    summary
        .findings
        .extend(found.into_iter().map(|f| f.in_file(&name)));
    summary.description.clone_from(&recording.description);
    Ok(DenoisedFile {
        summary,
        inputs: InputFile::of(std::slice::from_ref(&recording)),
    })
}

/// All columns, with the filtered channels in their places.
fn table(options: &DenoiseOptions, format: &Format) -> Table {
    let order: usize = options.filters.iter().map(FilterSpec::derivative).sum();
    let suffix = match order {
        0 => String::new(),
        1 => "_per_s".to_owned(),
        n => format!("_per_s{n}"),
    };
    let accel = format.accel.into_iter();
    let fields = accel
        .chain(format.gyro.into_iter().flatten())
        .collect::<Vec<usize>>();
    let columns = channels(format.gyro.is_some(), options)
        .into_iter()
        .map(|channel| NewColumn {
            name: input_name(format, fields[channel]) + &suffix,
            replaces: Some(fields[channel]),
        });
    Table::with_new(format, &columns.collect::<Vec<_>>(), DECIMALS, false)
}
