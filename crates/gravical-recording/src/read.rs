//! From a file to a recording.

use std::io::{BufRead, Cursor, Read};
use std::path::Path;

use crate::bytes::{self, Input, peek, truncated};
use crate::cwa;
use crate::error::{Error, Result};
use crate::foreign::{self, in_file};
use crate::options::ReadOptions;
use crate::recording::{HEAD_BYTES, Recording, whole_lines};
use crate::source::{Source, open};
use crate::text::{Format, sniff};

/// Reads the recording at `path`; `-` is standard input.
///
/// A `.cwa` file of more than 2²⁰ samples is read as means of neighbouring samples, at 2.5 Hz or
/// faster: see [`Recording::is_averaged`].
///
/// # Errors
///
/// Errors that prevent reading: `not-found`, `empty-file`, `no-rows`, `no-accelerometer`,
/// `columns-unknown`, `all-zero` …, each with the file and a hint. Lesser faults are
/// [`Finding`](crate::Finding)s of the recording.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    read_source(&Source::Path(path), options, cwa::read)
}

/// The same with all samples of a `.cwa` file.
///
/// # Errors
///
/// As [`read`]; `too-large` if they take more than a gigabyte.
pub fn read_samples(path: &Path, options: &ReadOptions) -> Result<Recording> {
    read_source(&Source::Path(path), options, cwa::read_samples)
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
    let mut reader = open(path, &options)?.reader;
    let mut bytes = bytes::read_head(&mut reader, HEAD_BYTES).map_err(|e| Error::io(path, e))?;
    if bytes.len() == HEAD_BYTES {
        let line_end = || bytes.iter().rposition(|b| matches!(b, b'\n' | b'\r'));
        let whole = if cwa::is_one(&bytes) {
            cwa::whole_blocks(&bytes)
        } else {
            line_end().map_or(HEAD_BYTES, |at| at + 1)
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
    read_source(&Source::Bytes(name, bytes), options, cwa::read)
}

/// Reads a file of any kind, one of a worn device by `read_device`.
fn read_source(
    source: &Source<'_>,
    options: &ReadOptions,
    read_device: fn(Box<dyn Read>, &ReadOptions) -> Result<Recording>,
) -> Result<Recording> {
    options.validate()?;
    let mut input = source.open(options)?;
    let name = source.name();
    let here = Path::new(&name);
    let (magic, reader) =
        peek(input.take_reader(), cwa::MAGIC_BYTES).map_err(|e| Error::io(here, e))?;
    foreign::refuse_container(&magic, here)?;
    let recording = if cwa::is_one(&magic) {
        read_device(reader, options).map_err(|e| in_file(e, here))?
    } else {
        read_text(reader, here, options)?
    };
    Ok(recording.with_input(&input, &name))
}

/// Reads the gyroscope of a recording from a file of its own; its accelerometer, if there is one,
/// is not read.
///
/// # Errors
///
/// As [`read`]; `no-gyroscope`.
pub(crate) fn read_gyroscope(source: &Source<'_>, options: &ReadOptions) -> Result<Recording> {
    options.validate()?;
    let name = source.name();
    let mut input = source.open(options)?;
    let options = ReadOptions {
        is_gyroscope: true,
        ..options.clone()
    };
    let read = read_text(input.take_reader(), Path::new(&name), &options)?;
    let mut read = read.with_input(&input, &name);
    read.gyro = Some(std::mem::take(&mut read.accel));
    read.resolution.rotate_right(3);
    Ok(read)
}

fn read_text(reader: Box<dyn Read>, here: &Path, options: &ReadOptions) -> Result<Recording> {
    let (format, text) = open_text(reader, here, options)?;
    Recording::collect(&format, format.batches(text)).map_err(|e| in_file(e, here))
}

/// The format of a text by its head, and the text from its beginning on; a calibration is refused.
pub(crate) fn open_text(
    reader: Box<dyn Read>,
    here: &Path,
    options: &ReadOptions,
) -> Result<(Format, impl BufRead + use<>)> {
    let io = |e| Error::io(here, e);
    let mut text = bytes::utf8(reader).map_err(io)?;
    let head = bytes::read_head(&mut text, HEAD_BYTES).map_err(io)?;
    foreign::refuse_calibration(&head, here)?;
    let file = here.file_name().unwrap_or_default().to_string_lossy();
    let format = sniff(&whole_lines(&head), &file, options).map_err(|e| in_file(e, here))?;
    Ok((format, Cursor::new(head).chain(text)))
}

impl Recording {
    /// With what is known of the file, once it is read.
    fn with_input(self, input: &Input, name: &str) -> Self {
        let mut recording = self.with_name(name);
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
}
