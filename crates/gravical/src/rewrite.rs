//! A recording as another table: `apply`, `convert` and `denoise` read it alike and write it alike.

use std::io::Write;
use std::path::Path;

use gravical_recording::write::{Table, Writer};
use gravical_recording::{BatchReader, Rows};

use crate::recording::{Finding, Recording};
use crate::{Error, Result};

/// Writes the rows of `reader` as `table`, whose columns of values `columns` makes of each batch.
/// Returns the recording, the number of rows that were written, and findings about later rows.
///
/// # Errors
///
/// Those of reading and of writing.
pub(crate) fn write_rows(
    mut reader: BatchReader,
    out: &mut dyn Write,
    table: Table,
    only_measured: bool,
    mut columns: impl FnMut(&mut Rows) -> Vec<Vec<f64>>,
) -> Result<(Recording, usize, Vec<Finding>)> {
    let output = |e| Error::io(Path::new("output"), e);
    let mut writer = Writer::new(out, table);
    let mut written = 0;
    while let Some(mut rows) = reader.next_rows()? {
        let values = columns(&mut rows);
        let values: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
        let is_measured = &rows.readings.is_measured;
        let kept = (0..is_measured.len()).filter(|row| !only_measured || is_measured[*row]);
        written += kept.clone().count();
        writer
            .write_rows(kept, &rows.text, &values, &rows.readings.breaks)
            .map_err(output)?;
    }
    writer.finish().map_err(output)?;
    let (recording, findings) = reader.finish(only_measured);
    Ok((recording, written, findings))
}
