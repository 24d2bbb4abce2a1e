//! From a file to a recording.

use std::io::{Cursor, Read};
use std::path::Path;

use gravical_judge::finding::Case;
use gravical_judge::{Error, ReadOptions, Result};

use crate::bytes::{self, Input, peek};
use crate::cwa::{self, Samples};
use crate::encoding;
use crate::foreign;
use crate::memory::Budget;
use crate::recording::{HEAD_BYTES, Recording, whole_lines, without_cut_line};
use crate::source::{Named, open};
use crate::text::{Format, sniff};

/// Reads the recording at `path`; `-` is standard input.
///
/// More than 2²⁰ samples of a `.cwa` file are read as means of neighbouring samples, at 2.5 Hz or
/// faster: see [`Recording::is_averaged`].
///
/// # Errors
///
/// Errors that prevent reading: `not-found`, `empty-file`, `no-rows`, `no-accelerometer`,
/// `columns-unknown`, `all-zero`, `too-large` …, each with the file and a hint. Lesser faults are
/// [`Finding`](crate::Finding)s of the recording.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Recording> {
    read_named(Named::Path(path.as_ref()), options)
}

/// The same of a file on the disk or in memory.
///
/// # Errors
///
/// As [`read`].
pub fn read_named(file: Named<'_>, options: &ReadOptions) -> Result<Recording> {
    read_input(open(file, options)?, &file.name(), options, true)
}

/// The same with all samples.
///
/// # Errors
///
/// As [`read`].
pub fn read_samples<'a>(file: impl Into<Named<'a>>, options: &ReadOptions) -> Result<Recording> {
    let file = file.into();
    read_input(open(file, options)?, &file.name(), options, false)
}

/// Reads the first 256 KiB of the recording at `path`: unit, range, first time stamp, serial number
/// and the temperature in it, before all rows are read.
///
/// # Errors
///
/// As [`read`].
pub fn read_head(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Recording> {
    let file = Named::Path(path.as_ref());
    read_input(open_head(file, options)?, &file.name(), options, true)
}

/// The whole lines in the first 256 KiB of a file, as a file of its own.
pub(crate) fn open_head(file: Named<'_>, options: &ReadOptions) -> Result<Input> {
    let options = ReadOptions {
        hash: false,
        meter: None,
        ..options.clone()
    };
    let mut reader = open(file, &options)?.reader;
    let head = bytes::read_head(&mut reader, HEAD_BYTES).map_err(|e| Error::io(file.path(), e))?;
    let whole = if cwa::is_one(&head) {
        &head[..cwa::whole_blocks(&head)]
    } else {
        without_cut_line(&head)
    };
    open(Named::Bytes(file.path(), whole), &options)
}

/// Reads a recording from bytes in memory; `name` is used in messages.
///
/// # Errors
///
/// As [`read`].
pub fn read_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Recording> {
    read_named(Named::Bytes(Path::new(name), bytes), options)
}

/// Reads the gyroscope of a recording from a file of its own; its accelerometer, if there is one,
/// is not read.
///
/// # Errors
///
/// As [`read`]; `no-gyroscope`.
pub(crate) fn read_gyroscope(input: Input, name: &str, options: &ReadOptions) -> Result<Recording> {
    let options = ReadOptions {
        is_gyroscope: true,
        // It is that of the accelerometer.
        zero_offset: None,
        ..options.clone()
    };
    let mut read = read_input(input, name, &options, false)?;
    read.gyro = Some(std::mem::take(&mut read.accel));
    read.units.resolution.reverse();
    Ok(read)
}

/// Reads a file of any kind; with `averages` a long one of a worn device as means.
fn read_input(
    mut input: Input,
    name: &str,
    options: &ReadOptions,
    averages: bool,
) -> Result<Recording> {
    let here = Path::new(name);
    let budget = Budget::new(options);
    let judged = match open_source(&mut input, name, options)? {
        (format, Source::Text(text)) => {
            let check = |rows| budget.check_rows(&format, rows);
            let rows = format.parse_with_text(text, &[], check);
            rows.and_then(|rows| Recording::judge(&format, rows))
        }
        (format, Source::Worn(samples)) => {
            let max_samples = if averages {
                cwa::MAX_SAMPLES
            } else {
                usize::MAX
            };
            cwa::read_means(&format, *samples, &budget, max_samples)
        }
    };
    let mut recording = judged.map_err(|e| e.in_file(here))?.with_name(name);
    attach_metadata(&mut recording, &input);
    Ok(recording)
}

/// Adds what is known of the file once it is read; a finding if it is packed and cut off.
pub(crate) fn attach_metadata(recording: &mut Recording, input: &Input) {
    recording.format.is_packed = input.is_gzip;
    recording.sha256 = input.sha256();
    if input.is_cut_off() {
        let rows = recording.ledger.rows();
        let cut_off = Case::TruncatedFile { rows }.finding();
        recording.findings.push(cut_off.in_file(&recording.name));
    }
}

/// Where the rows of a recording come from.
pub(crate) enum Source {
    /// A text in UTF-8, from its first line on
    Text(Box<dyn Read + Send>),
    /// Blocks of samples of a worn device
    Worn(Box<Samples<Box<dyn Read + Send>>>),
}

/// The format of a recording of any kind, and its rows.
///
/// # Errors
///
/// What is known to be no recording is refused.
pub(crate) fn open_source(
    input: &mut Input,
    name: &str,
    options: &ReadOptions,
) -> Result<(Format, Source)> {
    options.validate()?;
    let here = Path::new(name);
    let io = |e| Error::io(here, e);
    let (magic, reader) = peek(input.take_reader(), cwa::MAGIC_BYTES).map_err(io)?;
    foreign::refuse_container(&magic, here)?;
    if cwa::is_one(&magic) {
        let opened = cwa::open(reader, options).map_err(|e| e.in_file(here))?;
        return Ok((opened.0, Source::Worn(Box::new(opened.1))));
    }
    let mut text = encoding::utf8(reader).map_err(io)?;
    let head = bytes::read_head(&mut text, HEAD_BYTES).map_err(io)?;
    foreign::refuse_calibration(&head, here)?;
    let file = here.file_name().unwrap_or_default().to_string_lossy();
    let format = sniff(&whole_lines(&head), &file, options).map_err(|e| e.in_file(here))?;
    let text = Box::new(Cursor::new(head).chain(text));
    Ok((format, Source::Text(text)))
}
