//! The file of a recording: only whole batches, whatever the disk does.

use std::fs::{File, OpenOptions};
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::Path;

/// The most that is looked at for the beginning of a last line without an end; what a
/// board sends in a line is far shorter.
const TAIL: u64 = 1 << 16;

/// Bytes that are copied at once.
const COPIED_AT_ONCE: usize = 1 << 20;

/// What became of a file while it was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loss {
    /// There is none of its name.
    Gone,
    /// There is another one of its name.
    Replaced,
    /// Something is missing at its end.
    Cut,
}

#[cfg(unix)]
fn is_same(a: &std::fs::Metadata, b: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// There, a file that is open for writing is not replaced.
#[cfg(not(unix))]
fn is_same(_: &std::fs::Metadata, _: &std::fs::Metadata) -> bool {
    true
}

/// A file that grows, and that no other program of ours writes to meanwhile.
#[derive(Debug)]
pub struct Growing {
    file: File,
    /// Whole batches end here.
    length: u64,
}

/// Where every write goes to the end, a cut behind what another one wrote included.
fn options() -> OpenOptions {
    let mut options = File::options();
    options.write(true).read(true);
    // There, a file that is only appended to cannot be cut.
    #[cfg(not(windows))]
    options.append(true);
    // There, a lock would keep readers out; this shares reading and deleting only.
    #[cfg(windows)]
    std::os::windows::fs::OpenOptionsExt::share_mode(&mut options, 1 | 4);
    options
}

/// Nobody else may write to `file`.
///
/// # Errors
///
/// `ResourceBusy`: somebody does.
fn lock(file: File) -> io::Result<File> {
    #[cfg(not(windows))]
    if file.metadata()?.is_file()
        && let Err(std::fs::TryLockError::WouldBlock) = file.try_lock()
    {
        return Err(io::ErrorKind::ResourceBusy.into());
    }
    // Where a file system knows no locks, there is none.
    Ok(file)
}

/// What another program holds is busy under whatever name.
fn busy(error: io::Error) -> io::Error {
    const SHARING_VIOLATION: i32 = 32;
    if cfg!(windows) && error.raw_os_error() == Some(SHARING_VIOLATION) {
        return io::ErrorKind::ResourceBusy.into();
    }
    error
}

impl Growing {
    /// A new file; one that is there stays as it is. A device is written to.
    ///
    /// # Errors
    ///
    /// `AlreadyExists`, and what the system says.
    pub fn create(path: &Path) -> io::Result<Self> {
        let device = std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir());
        let file = if device {
            File::options().write(true).open(path)?
        } else {
            lock(options().create_new(true).open(path).map_err(busy)?)?
        };
        Ok(Growing { file, length: 0 })
    }

    /// The end of a file, which is made when it is not there.
    ///
    /// # Errors
    ///
    /// `ResourceBusy` where another one writes to it, and what the system says.
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

    /// Whether another one writes to `path` now.
    pub fn is_busy(path: &Path) -> bool {
        let opened = options().open(path).map_err(busy).and_then(lock);
        opened.is_err_and(|e| e.kind() == io::ErrorKind::ResourceBusy)
    }

    /// What became of the file under `path` since it was opened; none where it is as it was
    /// written. What is no file has nothing to lose.
    ///
    /// # Errors
    ///
    /// What the system says.
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

    /// Appends all whole lines that are left in the file to `to`.
    ///
    /// # Errors
    ///
    /// What the system says.
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

    /// The last line, where it has no end.
    ///
    /// # Errors
    ///
    /// What the system says.
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
    /// What the system says.
    pub fn cut(&mut self, bytes: usize) -> io::Result<()> {
        self.length = self.length.saturating_sub(bytes as u64);
        self.file.set_len(self.length)?;
        self.file.seek(SeekFrom::End(0))?;
        self.sync()
    }

    /// Appends all of `bytes`, or nothing: a part that was taken is taken back.
    ///
    /// # Errors
    ///
    /// What the system says, a full disk for instance.
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

    /// What was appended is safe when the power fails.
    ///
    /// # Errors
    ///
    /// What the system says.
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
    fn nothing_is_overwritten_and_one_writes_at_a_time() {
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
