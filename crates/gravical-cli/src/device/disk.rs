//! The file of a recording: only whole batches, whatever the disk does.

use std::fs::File;
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::Path;

/// Takes batches of whole lines.
pub trait Disk {
    /// Appends all of `bytes`, or nothing: a part that was taken is taken back.
    ///
    /// # Errors
    ///
    /// What the system says, a full disk for instance.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// What was appended is safe when the power fails.
    ///
    /// # Errors
    ///
    /// As [`append`](Self::append).
    fn sync(&mut self) -> io::Result<()>;
}

/// A file that grows.
#[derive(Debug)]
pub struct Growing {
    file: File,
    /// Whole batches end here.
    length: u64,
}

impl Growing {
    /// A new file; one that is there stays as it is. A device is written to.
    ///
    /// # Errors
    ///
    /// `AlreadyExists`, and what the system says.
    pub fn create(path: &Path) -> io::Result<Self> {
        let device = std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir());
        let file = File::options().write(true).create_new(!device).open(path)?;
        Ok(Growing { file, length: 0 })
    }

    /// The end of a file, which is made when it is not there. A last line without an
    /// end gets one.
    ///
    /// # Errors
    ///
    /// What the system says.
    pub fn continued(path: &Path) -> io::Result<Self> {
        use std::io::Read as _;
        let mut file = File::options()
            .write(true)
            .read(true)
            .create(true)
            .truncate(false)
            .open(path)?;
        let length = file.metadata()?.len();
        let mut growing = if length > 0 {
            let mut last = [0];
            file.seek(SeekFrom::Start(length - 1))?;
            file.read_exact(&mut last)?;
            let mut growing = Growing { file, length };
            if last != *b"\n" {
                growing.append(b"\n")?;
            }
            growing
        } else {
            Growing { file, length }
        };
        growing.sync()?;
        Ok(growing)
    }
}

impl Disk for Growing {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
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

    fn sync(&mut self) -> io::Result<()> {
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
    fn nothing_is_overwritten_and_torn_lines_get_an_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let mut disk = Growing::create(&path).unwrap();
        disk.append(b"1,2\n3,").unwrap();
        disk.sync().unwrap();
        assert_eq!(
            Growing::create(&path).unwrap_err().kind(),
            io::ErrorKind::AlreadyExists
        );
        for _ in 0..2 {
            Growing::continued(&path).unwrap();
        }
        Growing::continued(&path).unwrap().append(b"4\n").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "1,2\n3,\n4\n");
        let other = folder.path().join("b.csv");
        Growing::continued(&other).unwrap();
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
