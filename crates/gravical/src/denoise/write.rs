//! Writing of a filtered recording with its own columns, names and units.

use std::array::from_fn;
use std::io::Write;
use std::path::Path;

use crate::apply::plan::{Plan, channel_field, input_name};
use crate::output::BlockWriter;
use crate::recording::dialect::Dialect;
use crate::recording::layout::Layout;
use crate::recording::names::Role;
use crate::recording::open::Input;
use crate::recording::text::open_rows;
use crate::recording::timing::Treatment;
use crate::recording::{ReadOptions, Recording};
use crate::{Error, Result};

use super::{Channels, Denoised};

/// Writes the filtered channels in place of the recorded ones. `input` is the recording, opened
/// again; `read`: the options it was read with. Returns the names of the columns.
///
/// Filtered channels keep the name and the unit of their column, so that a calibration for the
/// recording also applies to the output; for a derivative `_per_s` is appended. Every other
/// column is copied byte for byte, breaks become blank lines. Values have six decimals.
///
/// # Errors
///
/// `changed` (input) if `input` does not have the rows that were filtered; errors of reading and
/// writing.
pub fn write(
    denoised: &Denoised,
    input: Input,
    read: &ReadOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>> {
    let recording = &denoised.recording;
    let here = Path::new(&recording.name);
    let facts = Some(recording.facts);
    let mut file = open_rows(input, &recording.name, Role::Recording, read, facts)?
        .without_hold_limit()
        .with_spans();
    let (dialect, layout) = (&file.format.dialect, &file.format.layout);
    let plan = Plan::with_names(dialect, layout, &names(denoised, dialect, layout), false);
    let columns = columns(denoised);
    let mut out = BlockWriter::new(out);
    out.bytes.extend_from_slice(&plan.header());
    let mut rows = 0;
    while let Some(row) = file.rows.next_row()? {
        if rows < recording.rows() {
            // Breaks are written as blank lines.
            row.before.iter().for_each(|_| out.bytes.push(b'\n'));
            let values = from_fn(|i| columns[i].map_or(f64::NAN, |c| c.0[rows] + c.1));
            plan.write_row(row.text.bytes, row.text.spans, &values, &mut out.bytes);
            out.write_if_full()?;
        }
        rows += 1;
    }
    if rows != recording.rows() {
        return Err(Error::input(
            "changed",
            format!(
                "{} rows were read the first time and {rows} the second time: the file changed",
                recording.rows()
            ),
        )
        .at(here, None)
        .with_hint("wait until no program writes to it"));
    }
    let trailing = file.finish(Treatment::Kept)?.finished.trailing;
    trailing.iter().for_each(|_| out.bytes.push(b'\n'));
    out.finish()?;
    Ok(plan.names)
}

/// The filtered channels, and the offset that was subtracted on reading.
fn columns(denoised: &Denoised) -> [Option<(&Vec<f64>, f64)>; 6] {
    let Recording {
        accel,
        gyro,
        zero_offset,
        ..
    } = &denoised.recording;
    // A filter that removes constants also removes the offset.
    let kept = denoised.summary.filters.iter().all(|f| f.keeps_constants);
    let offset = if kept { *zero_offset } else { 0.0 };
    from_fn(|i| match (i, denoised.channels) {
        (0..3, Channels::Accel | Channels::All) => Some((&accel[i], offset)),
        (3.., Channels::Gyro | Channels::All) => gyro.as_ref().map(|g| (&g[i - 3], 0.0)),
        _ => None,
    })
}

/// Names of the filtered channels.
fn names(denoised: &Denoised, dialect: &Dialect, layout: &Layout) -> [Option<String>; 6] {
    let order = denoised.summary.filters.last().map_or(0, |f| f.derivative);
    let suffix = match order {
        0 => String::new(),
        1 => "_per_s".to_owned(),
        n => format!("_per_s{n}"),
    };
    let filtered = columns(denoised);
    from_fn(|i| {
        filtered[i]?;
        let field = channel_field(layout, i)?;
        Some(input_name(dialect, layout, field) + &suffix)
    })
}
