//! ZIP archives: that of an ActiGraph device is a recording.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use flate2::read::DeflateDecoder;
use rawzip::{CompressionMethod, ZipArchive};

use super::unpacking::{MOST_UNPACKED, Unpacking};
use super::wearable::gt3x::{MOST_INFO, start_of_stream};
use crate::{Error, Result};

/// First bytes of an archive.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

/// A member of an archive.
struct Member {
    packed: std::ops::Range<u64>,
    method: CompressionMethod,
    /// Its size, as the archive says, bytes.
    size: u64,
}

/// The stream of a `.gt3x` archive ([`start_of_stream`], then `log.bin`), and its length in bytes.
///
/// The list of an archive is at its end, so `archive` is copied to a temporary file. Where it is
/// damaged, the stream ends with `UnexpectedEof`.
///
/// # Errors
///
/// `is-an-archive`, `old-gt3x`, `unreadable` about the file `name`, and errors of reading and of
/// the temporary file.
pub(super) fn gt3x(archive: &mut dyn Read, name: &Path) -> Result<(Box<dyn Read>, u64)> {
    let io = |e| Error::io(name, e);
    let copy = |e| Error::io(Path::new("temporary file"), e);
    let mut file = tempfile::tempfile().map_err(copy)?;
    io::copy(archive, &mut file).map_err(copy)?;
    let damaged = |e: rawzip::Error| {
        Error::input("unreadable", format!("the archive is damaged: {e}"))
            .at(name, None)
            .with_hint("copy the file again; its list of contents is at its end")
    };
    let log = member(&file, "log.bin").map_err(damaged)?;
    let info = member(&file, "info.txt").map_err(damaged)?;
    let (Some(log), Some(info)) = (log, info) else {
        let old = member(&file, "activity.bin").map_err(damaged)?;
        return Err(refusal(old.is_some()).at(name, None));
    };
    let mut text = Vec::new();
    let info = info.open(&file).map_err(io)?;
    info.take(MOST_INFO as u64)
        .read_to_end(&mut text)
        .map_err(io)?;
    let start = start_of_stream(&text);
    // What the archive says of it may be anything.
    let most = log.packed_bytes().saturating_mul(MOST_UNPACKED);
    let size = log.size.min(most).saturating_add(start.len() as u64);
    let log = log.open(&file).map_err(io)?;
    Ok((Box::new(io::Cursor::new(start).chain(log)), size))
}

fn refusal(is_old: bool) -> Error {
    match is_old {
        true => Error::input(
            "old-gt3x",
            "a .gt3x file of a device with firmware before 3.0 (activity.bin) is not read",
        )
        .with_hint("export it as CSV with ActiLife, and read that"),
        false => Error::input("is-an-archive", "this is a ZIP archive, not a recording")
            .with_hint("unpack it and give the recording in it; a .gt3x file is read as it is"),
    }
}

/// The first member of that name, in any letters.
fn member(file: &File, name: &str) -> Result<Option<Member>, rawzip::Error> {
    let mut buffer = vec![0; rawzip::RECOMMENDED_BUFFER_SIZE];
    let archive = ZipArchive::from_file(file.try_clone()?, &mut buffer)?;
    let mut entries = archive.entries(&mut buffer);
    while let Some(entry) = entries.next_entry()? {
        let path = entry.file_path();
        let path: &[u8] = path.as_ref();
        let (last, within) = (path.len().saturating_sub(name.len()), path);
        let is_it = within[last..].eq_ignore_ascii_case(name.as_bytes())
            && (last == 0 || matches!(within[last - 1], b'/' | b'\\'));
        if is_it {
            let (from, to) = archive
                .get_entry(entry.wayfinder())?
                .compressed_data_range();
            return Ok(Some(Member {
                packed: from..to,
                method: entry.compression_method(),
                size: entry.uncompressed_size_hint(),
            }));
        }
    }
    Ok(None)
}

impl Member {
    fn packed_bytes(&self) -> u64 {
        self.packed.end.saturating_sub(self.packed.start)
    }

    fn open(&self, file: &File) -> io::Result<Box<dyn Read>> {
        let mut file = file.try_clone()?;
        file.seek(SeekFrom::Start(self.packed.start))?;
        let packed = Box::new(BufReader::new(file.take(self.packed_bytes())));
        match self.method {
            CompressionMethod::STORE => Ok(packed),
            CompressionMethod::DEFLATE => {
                let inflating = |packed| Inflating(DeflateDecoder::new(packed));
                Ok(Box::new(Unpacking::new(packed, inflating)))
            }
            other => Err(io::Error::new(
                io::ErrorKind::InvalidData,
                format!("a method of compression that .gt3x files do not have: {other}"),
            )),
        }
    }
}

/// Unpacks, and ends where the bytes are damaged.
struct Inflating<R>(DeflateDecoder<R>);

impl<R: Read> Read for Inflating<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.read(buffer).map_err(|e| match e.kind() {
            io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => {
                io::ErrorKind::UnexpectedEof.into()
            }
            _ => e,
        })
    }
}
