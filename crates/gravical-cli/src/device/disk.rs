//! The file of a recording: complete batches only, even if the disk fails.

use std::fs::{File, OpenOptions};
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::Path;

/// A last line without an end is looked for in this many bytes; lines of a board are far
/// shorter.
const TAIL: u64 = 1 << 16;

/// Bytes that are copied at once.
const COPIED_AT_ONCE: usize = 1 << 20;

/// What happened to a file while it was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loss {
    /// It was deleted or moved.
    Gone,
    /// Another file has its name.
    Replaced,
    /// Its end is missing.
    Cut,
}

#[cfg(unix)]
fn is_same(a: &std::fs::Metadata, b: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// On such systems a file that is open for writing cannot be replaced.
#[cfg(not(unix))]
fn is_same(_: &std::fs::Metadata, _: &std::fs::Metadata) -> bool {
    true
}

/// A file to which lines are appended, locked against other instances of this program.
#[derive(Debug)]
pub struct Growing {
    file: File,
    /// End of the last complete batch.
    length: u64,
}

/// Every write goes to the end of the file.
fn options() -> OpenOptions {
    let mut options = File::options();
    options.write(true).read(true);
    // On Windows a file opened for appending cannot be cut.
    #[cfg(not(windows))]
    options.append(true);
    // On Windows a lock would exclude readers; this shares reading and deleting only.
    #[cfg(windows)]
    std::os::windows::fs::OpenOptionsExt::share_mode(&mut options, 1 | 4);
    options
}

/// Locks `file` against other writers.
///
/// # Errors
///
/// `ResourceBusy` if there is one.
fn lock(file: File) -> io::Result<File> {
    #[cfg(not(windows))]
    if file.metadata()?.is_file()
        && let Err(std::fs::TryLockError::WouldBlock) = file.try_lock()
    {
        return Err(io::ErrorKind::ResourceBusy.into());
    }
    // A file system without locks is accepted.
    Ok(file)
}

/// The error of a file that another program has open, as `ResourceBusy`.
fn busy(error: io::Error) -> io::Error {
    const SHARING_VIOLATION: i32 = 32;
    if cfg!(windows) && error.raw_os_error() == Some(SHARING_VIOLATION) {
        return io::ErrorKind::ResourceBusy.into();
    }
    error
}

impl Growing {
    /// Creates a file; a device is written to.
    ///
    /// # Errors
    ///
    /// `AlreadyExists`, and the system's errors.
    pub fn create(path: &Path) -> io::Result<Self> {
        let device = std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir());
        let file = if device {
            File::options().write(true).open(path)?
        } else {
            lock(options().create_new(true).open(path).map_err(busy)?)?
        };
        Ok(Growing { file, length: 0 })
    }

    /// Creates a file, or empties the one that exists.
    ///
    /// # Errors
    ///
    /// As [`continued`](Self::continued).
    pub fn replaced(path: &Path) -> io::Result<Self> {
        let mut growing = Self::continued(path)?;
        if growing.file.metadata()?.is_file() {
            growing.file.set_len(0)?;
            growing.length = 0;
        }
        Ok(growing)
    }

    /// Opens the end of a file, which is created if it does not exist.
    ///
    /// # Errors
    ///
    /// `ResourceBusy` if another instance writes to it, and the system's errors.
    pub fn continued(path: &Path) -> io::Result<Self> {
        let file = lock(options().create(true).open(path).map_err(busy)?)?;
        let length = file.metadata()?.len();
        let mut growing = Growing { file, length };
        // A device may have no end.
        if length > 0 {
            growing.file.seek(SeekFrom::End(0))?;
        }
        growing.sync()?;
        Ok(growing)
    }

    /// Whether another instance writes to `path`.
    pub fn is_busy(path: &Path) -> bool {
        let opened = options().open(path).map_err(busy).and_then(lock);
        opened.is_err_and(|e| e.kind() == io::ErrorKind::ResourceBusy)
    }

    /// What happened to the file `path` since it was opened; none if it is as it was
    /// written, or a device.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn loss(&self, path: &Path) -> io::Result<Option<Loss>> {
        let own = self.file.metadata()?;
        if !own.is_file() {
            return Ok(None);
        }
        if own.len() < self.length {
            return Ok(Some(Loss::Cut));
        }
        match std::fs::metadata(path) {
            Ok(there) if is_same(&own, &there) => Ok(None),
            Ok(_) => Ok(Some(Loss::Replaced)),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(Some(Loss::Gone)),
            Err(e) => Err(e),
        }
    }

    /// Appends all complete lines that are left in the file to `to`.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn copy_to(&mut self, to: &mut Growing) -> io::Result<()> {
        use std::io::Read as _;
        let mut left = self.file.metadata()?.len().min(self.length);
        let mut block = vec![0; COPIED_AT_ONCE];
        self.file.seek(SeekFrom::Start(0))?;
        while left > 0 {
            let n = (&self.file).take(left).read(&mut block)?;
            if n == 0 {
                break;
            }
            to.append(block.get(..n).unwrap_or_default())?;
            left -= n as u64;
        }
        let torn = to.torn()?.len();
        to.cut(torn)
    }

    /// Bytes that were written.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// The last line, if it has no line end.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn torn(&mut self) -> io::Result<Vec<u8>> {
        use std::io::Read as _;
        let mut tail = Vec::new();
        if self.length == 0 {
            return Ok(tail);
        }
        let from = self.length.saturating_sub(TAIL);
        self.file.seek(SeekFrom::Start(from))?;
        (&self.file).take(TAIL).read_to_end(&mut tail)?;
        self.file.seek(SeekFrom::End(0))?;
        let begin = tail
            .iter()
            .rposition(|b| *b == b'\n')
            .map_or(0, |at| at + 1);
        Ok(tail.split_off(begin))
    }

    /// Cuts `bytes` off the end.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn cut(&mut self, bytes: usize) -> io::Result<()> {
        self.length = self.length.saturating_sub(bytes as u64);
        self.file.set_len(self.length)?;
        self.file.seek(SeekFrom::End(0))?;
        self.sync()
    }

    /// Appends all of `bytes`, or nothing: a part that was written is removed again.
    ///
    /// # Errors
    ///
    /// The system's error, a full disk for instance.
    pub fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self.file.write_all(bytes) {
            Ok(()) => {
                self.length += bytes.len() as u64;
                Ok(())
            }
            Err(e) => {
                // A device has no length.
                let _ = self.file.set_len(self.length);
                let _ = self.file.seek(SeekFrom::Start(self.length));
                Err(e)
            }
        }
    }

    /// Makes what was appended safe against a power failure.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn sync(&mut self) -> io::Result<()> {
        match self.file.sync_data() {
            // A pipe or a device that cannot.
            Err(e) if e.kind() == io::ErrorKind::InvalidInput => Ok(()),
            done => done,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_overwritten_and_only_one_instance_writes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mut disk = Growing::create(&path).unwrap();
        disk.append(b"1,2\n3,").unwrap();
        disk.sync().unwrap();
        let kind = |file: io::Result<Growing>| file.unwrap_err().kind();
        assert_eq!(kind(Growing::create(&path)), io::ErrorKind::AlreadyExists);
        assert_eq!(kind(Growing::continued(&path)), io::ErrorKind::ResourceBusy);
        drop(disk);
        let mut disk = Growing::continued(&path).unwrap();
        assert_eq!(disk.torn().unwrap(), b"3,");
        disk.cut(2).unwrap();
        assert_eq!(disk.torn().unwrap(), b"");
        disk.append(b"4\n").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "1,2\n4\n");
        let other = folder.path().join("b.csv");
        assert_eq!(Growing::continued(&other).unwrap().torn().unwrap(), b"");
        assert_eq!(std::fs::read_to_string(&other).unwrap(), "");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_an_error_each_time() {
        let mut full = Growing::create(Path::new("/dev/full")).unwrap();
        for _ in 0..2 {
            let error = full.append(b"1,2\n").unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        }
        full.sync().unwrap();
    }
}
