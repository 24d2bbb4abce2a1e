//! From a file to a recording.

use std::io::{Cursor, Read};
use std::path::Path;

use gravical_recording as new;
use gravical_recording::{bytes, cwa};

use super::foreign::in_file;
use super::ledger::Ledger;
use super::open::{HEAD, Input, Source, open, peek, truncated};
use super::text_options::text_options;
use super::{ReadOptions, Recording, TableColumn, foreign, metadata};
use crate::finding::Finding;
use crate::{Error, Result};

/// Reads the recording at `path`; `-` is standard input.
///
/// A `.cwa` file of more than 2²⁰ samples is read as means of neighbouring samples, at 2.5 Hz or
/// faster: see [`Recording::is_averaged`].
///
/// # Errors
///
/// Errors that prevent reading: `not-found`, `empty-file`, `no-rows`, `no-accelerometer`,
/// `columns-unknown`, `all-zero` …, each with the file and a hint. Lesser faults are
/// [`Finding`](super::Finding)s of the recording.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let name = path.display().to_string();
    read_by(&Source::Path(path), &name, options, cwa::read)
}

/// The same with all samples of a `.cwa` file.
///
/// # Errors
///
/// As [`read`]; `too-large` if they take more than a gigabyte.
pub fn read_samples(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let name = path.display().to_string();
    read_by(&Source::Path(path), &name, options, cwa::read_samples)
}

/// Reads the first 256 KiB of the recording at `path`: unit, range, first time stamp, serial number
/// and the temperature in it, before all rows are read.
///
/// # Errors
///
/// As [`read`].
pub fn read_head(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let options = ReadOptions {
        hash: false,
        meter: None,
        ..options.clone()
    };
    let mut bytes = Vec::new();
    let reader = open(path, &options)?.reader;
    let read = reader.take(HEAD as u64).read_to_end(&mut bytes);
    read.map_err(|e| Error::io(path, e))?;
    if bytes.len() == HEAD {
        let line_end = || bytes.iter().rposition(|b| matches!(b, b'\n' | b'\r'));
        let whole = match cwa::is_one(&bytes) {
            true => cwa::whole_blocks(&bytes),
            false => line_end().map_or(HEAD, |at| at + 1),
        };
        bytes.truncate(whole);
    }
    read_bytes(&bytes, &path.display().to_string(), &options)
}

/// Reads a recording from bytes in memory; `name` is used in messages.
///
/// # Errors
///
/// As [`read`].
pub fn read_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Recording> {
    read_by(&Source::Bytes(bytes), name, options, cwa::read)
}

/// Bytes that tell what a file is that is no recording.
const HEAD_BYTES: u64 = 65_536;

/// Reads a file of any kind, one of a worn device by `read_device`.
fn read_by(
    source: &Source<'_>,
    name: &str,
    options: &ReadOptions,
    read_device: fn(Box<dyn Read>, &new::ReadOptions) -> Result<new::Recording>,
) -> Result<Recording> {
    options.validate()?;
    let mut input = source.open(options)?;
    let here = Path::new(name);
    let reader = std::mem::replace(&mut input.reader, Box::new(std::io::empty()));
    let (magic, reader) = peek(reader, cwa::MAGIC_BYTES).map_err(|e| Error::io(here, e))?;
    foreign::refuse_container(&magic, here)?;
    let options = text_options(options, false);
    if !cwa::is_one(&magic) {
        return read_text(reader, &input, name, &options);
    }
    let judged = read_device(reader, &options).map_err(|e| in_file(e, here))?;
    Ok(of_input(judged, &input, name))
}

/// Reads the gyroscope of a recording from a file of its own; its accelerometer, if there is one,
/// is not read.
///
/// # Errors
///
/// As [`read`]; `no-gyroscope`.
pub(super) fn read_gyroscope(
    source: &Source<'_>,
    name: &str,
    options: &ReadOptions,
) -> Result<Recording> {
    options.validate()?;
    let mut input = source.open(options)?;
    let reader = std::mem::replace(&mut input.reader, Box::new(std::io::empty()));
    let mut read = read_text(reader, &input, name, &text_options(options, true))?;
    read.gyro = Some(std::mem::take(&mut read.accel));
    read.resolution.rotate_right(3);
    Ok(read)
}

/// Reads text; of `input` the other properties are used.
fn read_text(
    reader: Box<dyn Read>,
    input: &Input,
    name: &str,
    options: &new::ReadOptions,
) -> Result<Recording> {
    let here = Path::new(name);
    let mut text = bytes::utf8(reader).map_err(|e| Error::io(here, e))?;
    let mut head = Vec::new();
    let read = text.by_ref().take(HEAD_BYTES).read_to_end(&mut head);
    read.map_err(|e| Error::io(here, e))?;
    foreign::refuse_calibration(&head, here)?;
    let file = here.file_name().unwrap_or_default().to_string_lossy();
    let text = Cursor::new(head).chain(text);
    let judged = new::Recording::read(text, &file, options).map_err(|e| in_file(e, here))?;
    Ok(of_input(judged, input, name))
}

/// A judged recording with what is known of its file.
pub(super) fn of_input(judged: new::Recording, input: &Input, name: &str) -> Recording {
    let mut recording = of_judged(judged, name);
    if input.is_gzip {
        recording.description.insert_str(0, "gzip, ");
    }
    recording.sha256 = input.sha256();
    if input.is_cut_off() {
        let finding = truncated(recording.rows());
        recording.findings.push(finding.in_file(name));
    }
    recording
}

/// A recording from a table in memory.
pub(super) fn of_table(
    name: &str,
    names: &[String],
    columns: &[TableColumn<'_>],
    options: &ReadOptions,
) -> Result<Recording> {
    let options = text_options(options, false);
    let judged = new::Recording::from_table(names, columns, &options)
        .map_err(|e| e.in_file(Path::new(name)))?;
    Ok(of_judged(judged, name))
}

/// The channels of a table in memory, each with its column from 0.
pub(super) fn table_fields(
    name: &str,
    names: &[String],
    columns: &[TableColumn<'_>],
    options: &ReadOptions,
) -> Result<Vec<(&'static str, usize)>> {
    new::table_channels(names, columns, &text_options(options, false))
        .map_err(|e| e.in_file(Path::new(name)))
}

/// A judged recording with the name of its file, and its notes as findings.
pub(super) fn of_judged(judged: new::Recording, name: &str) -> Recording {
    // Of means, the rows of the file are the samples.
    let ledger = Ledger::of(&judged.aside, judged.aside.lines - judged.aside.total());
    let in_file = |note| Finding::from(note).in_file(name);
    let is_calibrated_by_board = judged.board.is_some_and(|b| b.is_calibrated());
    let reads = |own: &[&str; 3]| {
        let mut pairs = judged.accel_columns.iter().zip(own);
        pairs.all(|(column, own)| judged.column_names.get(*column).is_some_and(|n| n == own))
    };
    Recording {
        name: name.to_owned(),
        sha256: None,
        serial: metadata::serial(&judged.metadata),
        stated_start_s: metadata::start_s(&judged.metadata),
        is_calibrated: is_calibrated_by_board || new::CALIBRATED.iter().any(reads),
        is_calibrated_by_board,
        description: judged.description,
        column_names: judged.column_names,
        accel: judged.accel,
        gyro: judged.gyro,
        gyro_file: None,
        temperature_c: judged.temperature_c,
        time_s: judged.time_s,
        time_origin_s: judged.start_s,
        restarted: judged.restarted,
        labels: judged.labels,
        breaks: judged.breaks,
        zero_offset: judged.zero_offset,
        accel_scale: judged.accel_scale,
        unit_doubt: judged.unit_doubt,
        header_unit: judged.header_unit,
        gyro_scale: judged.gyro_scale,
        resolution: judged.resolution,
        timing: judged.timing,
        ledger,
        findings: judged.notes.into_iter().map(in_file).collect(),
        lines: judged.lines,
    }
}
