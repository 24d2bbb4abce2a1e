//! From a file to a recording.

use std::io::{self, Cursor, Read};
use std::path::Path;

use crate::bytes::{self, Input, peek};
use crate::cwa;
use crate::error::{Error, Result};
use crate::finding::{Finding, FindingKind};
use crate::foreign::{self, in_file};
use crate::means::collect;
use crate::options::ReadOptions;
use crate::recording::{HEAD_BYTES, Recording, whole_lines, without_cut_line};
use crate::source::{open, open_bytes};
use crate::text::{Batch, Format, sniff};

/// Reads the recording at `path`; `-` is standard input.
///
/// More than 2²⁰ samples of a `.cwa` file, and columns of more than a gigabyte, are read as means of
/// neighbouring samples, at 2.5 Hz or faster: see [`Recording::is_averaged`].
///
/// # Errors
///
/// Errors that prevent reading: `not-found`, `empty-file`, `no-rows`, `no-accelerometer`,
/// `columns-unknown`, `all-zero` …, each with the file and a hint. Lesser faults are
/// [`Finding`]s of the recording.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let name = path.display().to_string();
    read_input(open(path, options)?, &name, options, true)
}

/// The same with all samples.
///
/// # Errors
///
/// As [`read`]; `too-large` if they take more than a gigabyte.
pub fn read_samples(path: &Path, options: &ReadOptions) -> Result<Recording> {
    let name = path.display().to_string();
    read_input(open(path, options)?, &name, options, false)
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
    let head = bytes::read_head(&mut reader, HEAD_BYTES).map_err(|e| Error::io(path, e))?;
    let whole = if cwa::is_one(&head) {
        &head[..cwa::whole_blocks(&head)]
    } else {
        without_cut_line(&head)
    };
    read_bytes(whole, &path.display().to_string(), &options)
}

/// Reads a recording from bytes in memory; `name` is used in messages.
///
/// # Errors
///
/// As [`read`].
pub fn read_bytes(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Recording> {
    read_input(open_bytes(bytes, name, options)?, name, options, true)
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
        ..options.clone()
    };
    let mut read = read_input(input, name, &options, false)?;
    read.gyro = Some(std::mem::take(&mut read.accel));
    read.resolution.reverse();
    Ok(read)
}

/// Reads a file of any kind; with `averages` a long one as means.
fn read_input(
    mut input: Input,
    name: &str,
    options: &ReadOptions,
    averages: bool,
) -> Result<Recording> {
    let (format, batches) = open_batches(&mut input, name, options, |_| Vec::new())?;
    let judged = collect(&format, batches, averages);
    let recording = judged.map_err(|e| in_file(e, Path::new(name)))?;
    let mut recording = recording.with_name(name);
    let cut_off = note_input(&mut recording, &input);
    recording.findings.extend(cut_off.map(|f| f.in_file(name)));
    Ok(recording)
}

/// Adds what is known of the file once it is read; a finding if it is packed and cut off.
pub(crate) fn note_input(recording: &mut Recording, input: &Input) -> Option<Finding> {
    if input.is_gzip {
        recording.description.insert_str(0, "gzip, ");
    }
    recording.sha256 = input.sha256();
    input.is_cut_off().then(|| {
        let rows = recording.ledger.rows();
        let text = format!(
            "the packed file is damaged or ends in the middle; {rows} rows could be unpacked"
        );
        Finding::new(FindingKind::TruncatedFile, text)
    })
}

/// Rows of a recording.
pub(crate) type Batches = Box<dyn Iterator<Item = io::Result<Batch>>>;

/// The format of a recording of any kind, and its rows; `copied` says which columns keep their text.
/// What is known to be no recording is refused.
pub(crate) fn open_batches(
    input: &mut Input,
    name: &str,
    options: &ReadOptions,
    copied: impl FnOnce(&Format) -> Vec<(usize, usize)>,
) -> Result<(Format, Batches)> {
    options.validate()?;
    let here = Path::new(name);
    let io = |e| Error::io(here, e);
    let (magic, reader) = peek(input.take_reader(), cwa::MAGIC_BYTES).map_err(io)?;
    foreign::refuse_container(&magic, here)?;
    if cwa::is_one(&magic) {
        let (format, samples) = cwa::open(reader, options).map_err(|e| in_file(e, here))?;
        let batches = samples.with_text(&copied(&format));
        return Ok((format, Box::new(batches)));
    }
    let mut text = bytes::utf8(reader).map_err(io)?;
    let head = bytes::read_head(&mut text, HEAD_BYTES).map_err(io)?;
    foreign::refuse_calibration(&head, here)?;
    let file = here.file_name().unwrap_or_default().to_string_lossy();
    let format = sniff(&whole_lines(&head), &file, options).map_err(|e| in_file(e, here))?;
    let text = Cursor::new(head).chain(text);
    let batches = format.batches(text).with_text(&copied(&format));
    Ok((format, Box::new(batches)))
}
