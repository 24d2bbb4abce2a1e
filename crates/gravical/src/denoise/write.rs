//! A filtered recording as a table: its own columns, names and units.

use std::array::from_fn;
use std::io::Write;
use std::path::Path;

use crate::apply::plan::{Plan, channel_field, input_name};
use crate::recording::dialect::Dialect;
use crate::recording::layout::Layout;
use crate::recording::open::Input;
use crate::recording::row::{SLOTS, Values};
use crate::recording::{LineReasons, Prepared, ReadOptions, Recording, prepare};
use crate::{Error, Result};

use super::{Channels, Denoised};

/// Output is handed on in blocks of this many bytes.
const BLOCK: usize = 256 << 10;

/// Writes the filtered channels in place of the recorded ones: `input` is the
/// recording once more, `read` what it was read with. Gives the names of the columns.
///
/// Filtered channels keep the name and the unit of their column, so that a
/// calibration for the recording fits what is written as well; behind a derivative
/// `_per_s` is put on. Every other column is kept byte for byte, blank lines and
/// repeated headers become a blank line. Values have six decimals.
///
/// # Errors
///
/// `changed` (input) when `input` has not the rows that were filtered; what reading
/// and writing report.
pub fn write(
    denoised: &Denoised,
    mut input: Input,
    read: &ReadOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>> {
    let recording = &denoised.recording;
    let here = Path::new(&recording.name);
    let reader = std::mem::replace(&mut input.reader, Box::new(std::io::empty()));
    let Prepared {
        mut lines,
        dialect,
        layout,
        ..
    } = prepare(reader, &recording.name, read)?;
    let plan = Plan::with_names(
        &dialect,
        &layout,
        &names(denoised, &dialect, &layout),
        false,
    );
    let columns = columns(denoised);
    let mut reasons = LineReasons::new(&dialect);
    let scanner = layout.scanner(&dialect);
    let mut values: Values = [f64::NAN; SLOTS];
    let mut spans = Vec::with_capacity(scanner.fields());
    let mut block = plan.header();
    let mut row = 0;
    while let Some(line) = lines.next_line().map_err(|e| Error::io(here, e))? {
        if line.number < dialect.first_data_line {
            continue;
        }
        match scanner.scan_spans(line.bytes, &mut values, &mut spans) {
            // Rows beyond are zeros that were never measured.
            Ok(()) if row < recording.rows() => {
                let values = from_fn(|i| columns[i].map_or(f64::NAN, |c| c.0[row] + c.1));
                plan.write_row(line.bytes, &spans, &values, &mut block);
                row += 1;
            }
            Ok(()) => {}
            // A line that is no row but parts the recording stays a blank one.
            Err(defect) => {
                if reasons.among(&line, defect).parts() {
                    block.push(b'\n');
                }
            }
        }
        if block.len() >= BLOCK {
            hand_on(&mut block, out)?;
        }
    }
    if row < recording.rows() {
        return Err(Error::input(
            "changed",
            format!(
                "{} rows were read at first, {row} later: the file changed",
                recording.rows()
            ),
        )
        .at(here, None)
        .with_hint("wait until nothing writes to it any more"));
    }
    hand_on(&mut block, out)?;
    out.flush().map_err(|e| Error::io(Path::new("output"), e))?;
    Ok(plan.names)
}

fn hand_on(block: &mut Vec<u8>, out: &mut dyn Write) -> Result<()> {
    out.write_all(block)
        .map_err(|e| Error::io(Path::new("output"), e))?;
    block.clear();
    Ok(())
}

/// The filtered channels, and what was subtracted from them on reading.
fn columns(denoised: &Denoised) -> [Option<(&Vec<f64>, f64)>; 6] {
    let Recording {
        accel,
        gyro,
        zero_offset,
        ..
    } = &denoised.recording;
    // A filter that takes constants away takes the offset with them.
    let kept = denoised.summary.filters.iter().all(|f| f.keeps_constants);
    let offset = if kept { *zero_offset } else { 0.0 };
    from_fn(|i| match (i, denoised.channels) {
        (0..3, Channels::Accel | Channels::All) => Some((&accel[i], offset)),
        (3.., Channels::Gyro | Channels::All) => gyro.as_ref().map(|g| (&g[i - 3], 0.0)),
        _ => None,
    })
}

/// The names of the filtered channels, their own.
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
