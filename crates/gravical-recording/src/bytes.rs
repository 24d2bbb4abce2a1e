//! The bytes of a recording, plain or gzip.

use std::io::{self, BufRead, BufReader, Read};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use flate2::bufread::GzDecoder;
use gravical_judge::tap;
use sha2::{Digest, Sha256};

use crate::hash::hex;
use crate::problem::Problem;

/// With these bytes each member of a gzip file begins.
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];
/// Bytes of a packed file that are read at once.
const PACKED_BYTES: usize = 1 << 16;

/// Bytes of a recording, unpacked.
pub struct Input {
    /// The bytes to read.
    pub reader: Box<dyn Read + Send>,
    /// They were packed.
    pub is_gzip: bool,
    digest: Option<Arc<Mutex<Sha256>>>,
    cut_off: Arc<AtomicBool>,
}

impl Input {
    /// The bytes to read, once.
    pub fn take_reader(&mut self) -> Box<dyn Read + Send> {
        std::mem::replace(&mut self.reader, Box::new(io::empty()))
    }

    /// True if the file is packed and ends in the middle; the part that could be unpacked was
    /// read.
    pub fn is_cut_off(&self) -> bool {
        self.cut_off.load(Ordering::Relaxed)
    }

    /// SHA-256 of the file on disk, in hexadecimal; to be called after everything was read.
    /// `None` if not requested.
    pub fn sha256(&self) -> Option<String> {
        let digest = self.digest.as_ref()?.lock().ok()?.clone().finalize();
        Some(hex(&digest))
    }
}

/// Opens any reader.
///
/// # Errors
///
/// Errors of the reader while the first bytes are examined; `is-an-archive` within one.
pub fn from_reader(raw: Box<dyn Read + Send>, hash: bool) -> io::Result<Input> {
    let digest = hash.then(|| Arc::new(Mutex::new(Sha256::new())));
    let raw = match digest.clone() {
        Some(digest) => tap(raw, move |bytes| {
            if let Ok(mut digest) = digest.lock() {
                digest.update(bytes);
            }
            Ok(())
        }),
        None => raw,
    };
    let (magic, raw) = peek(raw, 4)?;
    if magic == b"PK\x03\x04" {
        return Err(io::Error::other(Problem::IsArchive.error()));
    }
    let is_gzip = magic.starts_with(&GZIP_MAGIC);
    let cut_off = Arc::new(AtomicBool::new(false));
    let plain: Box<dyn Read + Send> = if is_gzip {
        let packed = BufReader::with_capacity(PACKED_BYTES, raw);
        Box::new(Members {
            member: Some(GzDecoder::new(packed)),
            cut_off: Arc::clone(&cut_off),
        })
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
pub(crate) fn peek(
    mut reader: Box<dyn Read + Send>,
    n: usize,
) -> io::Result<(Vec<u8>, Box<dyn Read + Send>)> {
    let head = read_head(&mut reader, n)?;
    let again = io::Cursor::new(head.clone()).chain(reader);
    Ok((head, Box::new(again)))
}

/// The members of a packed file, one after the other: a log that was packed piece by piece. Zeros
/// behind them fill the last block of a medium. Where the file ends in the middle of a member, or goes
/// on with anything else, reading ends without an error.
struct Members<R> {
    /// `None` after the last.
    member: Option<GzDecoder<R>>,
    cut_off: Arc<AtomicBool>,
}

impl<R: BufRead> Members<R> {
    /// The member behind one that ended, if there is one.
    fn next_member(&self, mut packed: R) -> io::Result<Option<GzDecoder<R>>> {
        loop {
            let bytes = packed.fill_buf()?;
            let zeros = bytes.iter().take_while(|b| **b == 0).count();
            let next = bytes.get(zeros).copied();
            let is_end = bytes.is_empty();
            packed.consume(zeros);
            match next {
                None if !is_end => {}
                Some(byte) if byte == GZIP_MAGIC[0] => return Ok(Some(GzDecoder::new(packed))),
                next => {
                    self.cut_off.fetch_or(next.is_some(), Ordering::Relaxed);
                    return Ok(None);
                }
            }
        }
    }
}

impl<R: BufRead> Read for Members<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while let Some(member) = &mut self.member {
            match member.read(buffer) {
                Ok(0) if !buffer.is_empty() => {
                    let ended = self.member.take().map(GzDecoder::into_inner);
                    let next = ended.map(|packed| self.next_member(packed)).transpose()?;
                    self.member = next.flatten();
                }
                Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
                    self.cut_off.store(true, Ordering::Relaxed);
                    self.member = None;
                }
                result => return result,
            }
        }
        Ok(0)
    }
}

/// The first bytes of a stream.
///
/// # Errors
///
/// What reading returns.
pub fn read_head(reader: &mut impl Read, bytes: usize) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    reader.take(bytes as u64).read_to_end(&mut head)?;
    Ok(head)
}
