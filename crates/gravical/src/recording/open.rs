//! Opening of files: plain, gzip or standard input.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use gravical_recording::axes;
use sha2::{Digest, Sha256};

use super::ReadOptions;
use crate::finding::{Finding, FindingKind};
use crate::hash::hex;
use crate::{Error, Result};

/// First bytes of a ZIP archive.
const ZIP: &[u8] = b"PK\x03\x04";

pub(crate) const HEAD: usize = 1 << 18;

/// Name of a file without folder and endings (`.csv.gz` is two).
pub(crate) fn stem(name: &str) -> String {
    let file = Path::new(name)
        .file_name()
        .map_or_else(|| name.into(), |f| f.to_string_lossy());
    let mut stem = file.as_ref();
    for ending in [".gz", ".csv", ".txt", ".tsv", ".log", ".dat", ".cwa"] {
        stem = stem.strip_suffix(ending).unwrap_or(stem);
    }
    stem.to_owned()
}

/// Bytes of a recording, unpacked.
pub struct Input {
    /// The bytes to read.
    pub reader: Box<dyn Read>,
    /// They were packed.
    pub is_gzip: bool,
    digest: Option<Arc<Mutex<Sha256>>>,
    cut_off: Arc<AtomicBool>,
}

impl Input {
    /// True if the file is packed and ends in the middle; the part that could be unpacked was
    /// read.
    #[must_use]
    pub fn is_cut_off(&self) -> bool {
        self.cut_off.load(Ordering::Relaxed)
    }

    /// SHA-256 of the file on disk, in hexadecimal; to be called after everything was read.
    /// `None` if not requested.
    #[must_use]
    pub fn sha256(&self) -> Option<String> {
        let digest = self.digest.as_ref()?.lock().ok()?.clone().finalize();
        Some(hex(&digest))
    }
}

/// A packed file that is damaged.
pub(super) fn truncated(rows: usize) -> Finding {
    let text =
        format!("the packed file is damaged or ends in the middle; {rows} rows could be unpacked");
    Finding::new(FindingKind::TruncatedFile, text)
}

/// Where a recording is read from.
pub(crate) enum Source<'a> {
    /// A file, a pipe or, as `-`, standard input.
    Path(&'a Path),
    /// Bytes in memory.
    Bytes(&'a [u8]),
}

impl Source<'_> {
    /// Opens it.
    ///
    /// # Errors
    ///
    /// As [`open`].
    pub fn open(&self, options: &ReadOptions) -> Result<Input> {
        match self {
            Source::Path(path) => open(path, options),
            Source::Bytes(bytes) => {
                let reader = Box::new(io::Cursor::new(bytes.to_vec()));
                from_file(Path::new("-"), reader, Some(bytes.len() as u64), options)
            }
        }
    }

    /// True if it can be opened again: it is no pipe.
    pub fn is_reopenable(&self) -> bool {
        match self {
            Source::Path(path) => *path != Path::new("-") && path.is_file(),
            Source::Bytes(_) => true,
        }
    }
}

/// Opens `path` (`-` is standard input); of the options only `hash` and `meter` are used.
///
/// # Errors
///
/// Errors of the file system; `is-a-directory` for a directory.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Input> {
    let (reader, total) = raw(path)?;
    from_file(path, reader, total, options)
}

/// The bytes at `path`, and their number if it is known.
fn raw(path: &Path) -> Result<(Box<dyn Read>, Option<u64>)> {
    if path == Path::new("-") {
        return Ok((Box::new(io::stdin().lock()), None));
    }
    if path.is_dir() {
        return Err(
            Error::input("is-a-directory", "this is a folder, not a recording")
                .at(path, None)
                .with_hint("give its files, or the folder to `gravical calibrate`"),
        );
    }
    if let Some(text) = axes::open(path) {
        let bytes = text.map_err(|e| e.in_file(path))?.into_bytes();
        let total = bytes.len() as u64;
        return Ok((Box::new(io::Cursor::new(bytes)), Some(total)));
    }
    let file = File::open(path).map_err(|e| Error::io(path, e))?;
    let total = file.metadata().ok().filter(std::fs::Metadata::is_file);
    Ok((Box::new(file), total.map(|m| m.len())))
}

fn from_file(
    path: &Path,
    reader: Box<dyn Read>,
    total: Option<u64>,
    options: &ReadOptions,
) -> Result<Input> {
    let reader = match &options.meter {
        Some(meter) => meter.over(&path.display().to_string(), total, reader),
        None => reader,
    };
    let mut input = from_reader(reader, options.hash).map_err(|e| Error::io(path, e))?;
    let (magic, reader) = peek(input.reader, ZIP.len()).map_err(|e| Error::io(path, e))?;
    input.reader = reader;
    if magic == ZIP {
        return Err(
            Error::input("is-an-archive", "this is a ZIP archive, not a recording")
                .at(path, None)
                .with_hint("unpack it and give the recording in it"),
        );
    }
    Ok(input)
}

/// Opens any reader.
///
/// # Errors
///
/// Errors of the reader while the first bytes are examined.
pub fn from_reader(raw: Box<dyn Read>, hash: bool) -> io::Result<Input> {
    let digest = hash.then(|| Arc::new(Mutex::new(Sha256::new())));
    let raw: Box<dyn Read> = match &digest {
        Some(digest) => Box::new(Hashing {
            inner: raw,
            digest: digest.clone(),
        }),
        None => raw,
    };
    let (magic, raw) = peek(raw, 2)?;
    let is_gzip = magic == [0x1f, 0x8b];
    let cut_off = Arc::new(AtomicBool::new(false));
    let plain: Box<dyn Read> = if is_gzip {
        // Several gzip members in one file are one recording (a log packed piece by piece).
        let decoder = flate2::read::MultiGzDecoder::new(raw);
        Box::new(UntilCut::new(decoder, &cut_off))
    } else {
        raw
    };
    Ok(Input {
        reader: plain,
        is_gzip,
        digest,
        cut_off,
    })
}

/// The first `n` bytes, and a reader that begins with them.
pub(super) fn peek(mut reader: Box<dyn Read>, n: usize) -> io::Result<(Vec<u8>, Box<dyn Read>)> {
    let mut head = Vec::with_capacity(n);
    reader.by_ref().take(n as u64).read_to_end(&mut head)?;
    let again = io::Cursor::new(head.clone()).chain(reader);
    Ok((head, Box::new(again)))
}

/// Passes bytes on and stops, without an error, where a packed file ends in the middle.
struct UntilCut<R> {
    inner: R,
    /// It is this one that ends; others may end as well.
    ended: bool,
    cut_off: Arc<AtomicBool>,
}

impl<R> UntilCut<R> {
    fn new(inner: R, cut_off: &Arc<AtomicBool>) -> Self {
        UntilCut {
            inner,
            ended: false,
            cut_off: Arc::clone(cut_off),
        }
    }
}

impl<R: Read> Read for UntilCut<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.ended {
            return Ok(0);
        }
        match self.inner.read(buffer) {
            Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
                self.ended = true;
                self.cut_off.store(true, Ordering::Relaxed);
                Ok(0)
            }
            result => result,
        }
    }
}

struct Hashing {
    inner: Box<dyn Read>,
    digest: Arc<Mutex<Sha256>>,
}

impl Read for Hashing {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        if let Ok(mut digest) = self.digest.lock() {
            digest.update(&buffer[..n]);
        }
        Ok(n)
    }
}
