//! Filtering from file to file: its text is written with the filtered values.

use std::array::from_fn;
use std::io::Write;
use std::path::Path;

use gravical_recording::Format;
use gravical_recording::write::{NewColumn, Table, Writer, input_name};

use crate::calibration_file::InputFile;
use crate::recording::batches::TextReader;
use crate::recording::open::open;
use crate::recording::{ReadOptions, Recording};
use crate::{Error, Result};

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
    let reader = TextReader::open(open(path, read)?, &name, read, copied)?;
    let table = table(options, &reader.format);
    let (mut recording, texts) = reader.collect(&name)?;
    let inputs = InputFile::of(std::slice::from_ref(&recording));
    let (setup, mut begun) = begin(&mut recording, options)?;
    let done = filter_in_memory(&setup, &mut recording);
    begun
        .summary
        .finish(&setup, done, begun.scales, begun.duration_s);
    begun.summary.columns.clone_from(&table.names);
    // A filter that removes constants also removes the offset.
    let keeps_offset = setup.filters.iter().all(|f| f.spec().keeps_constants());
    let offset = if keeps_offset {
        recording.zero_offset
    } else {
        0.0
    };
    let output = |e| Error::io(Path::new("output"), e);
    let mut writer = Writer::new(out, table);
    let mut next = 0;
    for (text, lines) in texts {
        let mut values: [Vec<f64>; 6] = from_fn(|_| Vec::with_capacity(lines.len()));
        let mut breaks = Vec::new();
        for (at, line) in lines.iter().enumerate() {
            let row = (next < recording.rows()).then_some(next);
            let row = row.filter(|row| recording.line(*row) == u64::from(*line));
            if row.is_some_and(|row| recording.breaks.binary_search(&row).is_ok()) {
                breaks.push(at);
            }
            next += usize::from(row.is_some());
            for (i, out) in values.iter_mut().enumerate() {
                out.push(row.map_or(f64::NAN, |row| value(&recording, i, row, offset)));
            }
        }
        let filtered: Vec<&[f64]> = setup.channels.iter().map(|c| &values[*c][..]).collect();
        writer
            .write_rows(0..lines.len(), &text, &filtered, &breaks)
            .map_err(output)?;
    }
    if next != recording.rows() {
        return Err(Error::input(
            "internal",
            "rows of the recording are not those of its text",
        ));
    }
    writer.finish().map_err(output)?;
    Ok(DenoisedFile {
        summary: begun.summary,
        inputs,
    })
}

/// A value of a channel as the file has it.
fn value(recording: &Recording, channel: usize, row: usize, offset: f64) -> f64 {
    match (channel, &recording.gyro) {
        (0..3, _) => recording.accel[channel][row] + offset,
        (_, Some(gyro)) => gyro[channel - 3][row],
        (_, None) => f64::NAN,
    }
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
