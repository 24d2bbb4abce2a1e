//! The file of a recording: complete batches only, even if the disk fails.

use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// A last line without an end is looked for in this many bytes; lines of a board are far
/// shorter.
const TAIL: u64 = 1 << 16;

/// The beginning of a file is held up to this length, bytes: rows without their header are no
/// recording.
const HEAD: u64 = 1 << 16;

/// The line in place of what was cut off.
const CUT: &[u8] = b"# gap: another program cut the file: rows are missing\n";

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

/// A file to which lines are appended, locked against other instances of this program. If it is
/// deleted, moved, replaced or cut meanwhile, it continues in a new file beside it.
#[derive(Debug)]
pub struct LineFile {
    path: PathBuf,
    file: File,
    /// End of the last complete batch.
    length: u64,
    /// Its first lines.
    head: Vec<u8>,
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

impl LineFile {
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
        Ok(LineFile {
            path: path.to_owned(),
            file,
            length: 0,
            head: Vec::new(),
        })
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
            growing.head.clear();
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
        let mut growing = LineFile {
            path: path.to_owned(),
            file,
            length,
            head: Vec::new(),
        };
        // A device may have no end.
        if length > 0 {
            (&growing.file).take(HEAD).read_to_end(&mut growing.head)?;
            let whole = growing.head.iter().rposition(|b| *b == b'\n');
            growing.head.truncate(whole.map_or(0, |at| at + 1));
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

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its first lines.
    pub fn head(&self) -> &[u8] {
        &self.head
    }

    /// Checks that the file is as it was written. Otherwise all that is left of it is copied into
    /// a new file beside it, in which it continues; returns the path that it had.
    ///
    /// # Errors
    ///
    /// The system's error; then nothing is changed.
    pub fn mend(&mut self) -> io::Result<Option<PathBuf>> {
        let own = self.file.metadata()?;
        if !own.is_file() {
            return Ok(None);
        }
        let is_there = match std::fs::metadata(&self.path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => false,
            there => is_same(&own, &there?),
        };
        if is_there && own.len() >= self.length {
            return Ok(None);
        }
        let mut new = Self::beside(&self.path)?;
        if let Err(e) = self.copy_to(&mut new) {
            let _ = std::fs::remove_file(&new.path);
            return Err(e);
        }
        Ok(Some(std::mem::replace(self, new).path))
    }

    /// Creates a file beside `path`: NAME.kept.csv, NAME.kept.kept.csv ….
    fn beside(path: &Path) -> io::Result<Self> {
        let mut name = path.file_stem().unwrap_or_default().to_owned();
        name.push(".kept");
        if let Some(ending) = path.extension() {
            name.push(".");
            name.push(ending);
        }
        let path = path.with_file_name(name);
        match Self::create(&path) {
            // A name that is too long ends this.
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Self::beside(&path),
            made => made,
        }
    }

    /// Copies all complete lines that are left to the new file `to`, at least the first ones.
    fn copy_to(&mut self, to: &mut Self) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(0))?;
        let copied = io::copy(&mut (&self.file).take(self.length), &mut to.file);
        self.file.seek(SeekFrom::End(0))?;
        to.length = copied?;
        let torn = to.torn()?.len() as u64;
        to.cut(torn)?;
        to.head.clone_from(&self.head);
        if to.length < to.head.len() as u64 {
            to.cut(to.length)?;
            to.write(&self.head)?;
        }
        if to.length < self.length {
            to.write(CUT)?;
        }
        to.sync()
    }

    /// The last line, if it has no line end.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn torn(&mut self) -> io::Result<Vec<u8>> {
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
    pub fn cut(&mut self, bytes: u64) -> io::Result<()> {
        self.length = self.length.saturating_sub(bytes);
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
        self.write(bytes)?;
        if (self.head.len() as u64) < HEAD {
            self.head.extend_from_slice(bytes);
        }
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
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
        let mut disk = LineFile::create(&path).unwrap();
        disk.append(b"1,2\n3,").unwrap();
        disk.sync().unwrap();
        let kind = |file: io::Result<LineFile>| file.unwrap_err().kind();
        assert_eq!(kind(LineFile::create(&path)), io::ErrorKind::AlreadyExists);
        assert_eq!(
            kind(LineFile::continued(&path)),
            io::ErrorKind::ResourceBusy
        );
        drop(disk);
        let mut disk = LineFile::continued(&path).unwrap();
        assert_eq!(disk.torn().unwrap(), b"3,");
        disk.cut(2).unwrap();
        assert_eq!(disk.torn().unwrap(), b"");
        disk.append(b"4\n").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "1,2\n4\n");
        let other = folder.path().join("b.csv");
        assert_eq!(LineFile::continued(&other).unwrap().torn().unwrap(), b"");
        assert_eq!(std::fs::read_to_string(&other).unwrap(), "");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_an_error_each_time() {
        let mut full = LineFile::create(Path::new("/dev/full")).unwrap();
        for _ in 0..2 {
            let error = full.append(b"1,2\n").unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        }
        full.sync().unwrap();
    }
}
