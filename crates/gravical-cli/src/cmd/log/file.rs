//! The file of a recording: locked, appended to in whole lines, and rescued if it is deleted.

use std::fs::{File, TryLockError};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use gravical::escape::path_text;
use gravical::live::folder::JOURNAL;
use gravical::numfmt::count;
use gravical::output::is_special;
use gravical::targets::check_targets;
use gravical::{Error, Result};

/// The format of a file that is continued is recognised by so many bytes; its last line is shorter.
const HEAD: u64 = 1 << 18;
/// The error of Windows for a file that another program writes to.
const SHARING_VIOLATION: i32 = 32;

/// What to do with a file that exists; it is refused by default.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct Existing {
    /// Append to an existing file
    #[arg(long)]
    append: bool,
    /// Overwrite an existing file
    #[arg(long, conflicts_with = "append")]
    force: bool,
}

impl Existing {
    /// Of a session that begins, or goes on.
    pub fn of_session(resumes: bool) -> Self {
        Existing {
            append: resumes,
            force: false,
        }
    }
}

/// A file to which whole lines are appended, locked against other instances of this program.
pub struct LogFile {
    pub path: PathBuf,
    file: File,
    /// What to do with its content before the first lines.
    existing: Existing,
    /// End of the last lines that were written whole.
    pub length: u64,
    /// Lines of the file that is continued, from its beginning; empty for a new one.
    pub before: Vec<u8>,
    /// It cannot be written: it ends with the last whole line.
    has_failed: bool,
    /// Rows that could not be written.
    pub lost_rows: u64,
}

impl LogFile {
    /// Creates a file, or opens one; what it holds stays until the first lines are written.
    ///
    /// # Errors
    ///
    /// `exists`, `is-folder`, `is-pipe`, `in-use`, `no-folder`, `stdout-target` (usage); the system's.
    pub fn open(path: &Path, existing: Existing) -> Result<Self> {
        let is_in_dev = || path.canonicalize().is_ok_and(|p| p.starts_with("/dev"));
        let is_device = is_special(path) && is_in_dev();
        if is_special(path) && !is_device {
            let text = "rows are appended to a file; this is a pipe, whose reader could block them";
            let hint = "record into a file, and follow it with tail -f";
            return Err(Error::usage("is-pipe", text).at(path, None).with_hint(hint));
        }
        let is_new = !existing.append && !existing.force;
        check_targets(&[path.to_owned()], &[], !is_new).map_err(|error| match error.code() {
            "exists" => error.with_hint(
                "continue it with --append, replace it with --force, or name another file with -o",
            ),
            _ => error,
        })?;
        let mut options = File::options();
        // On Windows a file opened for appending cannot be cut.
        options.read(true).write(true).append(cfg!(not(windows)));
        options.create(true).create_new(is_new && !is_device);
        // On Windows a lock would exclude readers; this shares reading and deleting only.
        #[cfg(windows)]
        std::os::windows::fs::OpenOptionsExt::share_mode(&mut options, 1 | 4);
        let file = options.open(path).map_err(|e| match e.raw_os_error() {
            Some(SHARING_VIOLATION) if cfg!(windows) => in_use(path),
            _ => Error::io(path, e),
        })?;
        // A file system without locks is accepted.
        let is_locked = || matches!(file.try_lock(), Err(TryLockError::WouldBlock));
        if cfg!(not(windows)) && !is_device && is_locked() {
            return Err(in_use(path));
        }
        let mut file = LogFile {
            path: path.to_owned(),
            file,
            existing: Existing::default(),
            length: 0,
            before: Vec::new(),
            has_failed: false,
            lost_rows: 0,
        };
        // A device holds nothing.
        if !is_device {
            file.existing = existing;
        }
        if file.existing.append {
            file.read_before().map_err(|e| Error::io(path, e))?;
        }
        Ok(file)
    }

    /// Reads the beginning of a file that is continued.
    fn read_before(&mut self) -> io::Result<()> {
        self.length = self.file.metadata()?.len();
        (&self.file).take(HEAD).read_to_end(&mut self.before)?;
        // Of a single line without an end the reader says what it is.
        if self.before.contains(&b'\n') {
            self.before.truncate(end_of_lines(&self.before));
        }
        self.file.seek(SeekFrom::End(0)).map(drop)
    }

    /// Makes it ready for lines, which the first write does otherwise: a file that is replaced is
    /// emptied, and the last line of one that is continued is ended.
    ///
    /// # Errors
    ///
    /// The system's.
    pub fn start(&mut self) -> Result<()> {
        self.make_ready().map_err(|e| Error::io(&self.path, e))
    }

    fn make_ready(&mut self) -> io::Result<()> {
        match std::mem::take(&mut self.existing) {
            Existing { append: true, .. } => self.mend_end(),
            Existing { force: true, .. } => self.file.set_len(0),
            _ => Ok(()),
        }
    }

    /// A last line without an end is marked as rejected; half an event of a session is removed.
    fn mend_end(&mut self) -> io::Result<()> {
        let from = self.length.saturating_sub(HEAD);
        let mut tail = Vec::new();
        self.file.seek(SeekFrom::Start(from))?;
        (&self.file).take(HEAD).read_to_end(&mut tail)?;
        let torn = tail.split_off(end_of_lines(&tail));
        self.length -= torn.len() as u64;
        self.file.set_len(self.length)?;
        self.file.seek(SeekFrom::End(0))?;
        if torn.is_empty() || self.path.ends_with(JOURNAL) {
            return Ok(());
        }
        self.append(&[b"# rejected: ", torn.trim_ascii_end(), b"\n"].concat())
    }

    /// Passes lines to the system, all or none; without lines only looks whether the file is still there.
    /// After an error nothing more is written.
    ///
    /// # Errors
    ///
    /// `io` when they cannot be written, or another program removed, replaced or cut the file.
    pub fn write(&mut self, lines: &[u8]) -> Result<()> {
        if self.has_failed {
            return Ok(());
        }
        self.check_place()?;
        if lines.is_empty() {
            return Ok(());
        }
        let written = self.make_ready().and_then(|()| self.append(lines));
        written.map_err(|e| self.failed(&e))
    }

    /// Makes what was written safe against a power failure.
    ///
    /// # Errors
    ///
    /// The system's.
    pub fn sync(&mut self) -> Result<()> {
        match self.file.sync_data() {
            // A device that cannot.
            Err(e) if e.kind() == io::ErrorKind::InvalidInput => Ok(()),
            Err(e) if !self.has_failed => Err(self.failed(&e)),
            _ => Ok(()),
        }
    }

    /// A second hold on the file, for [`File::sync_data`].
    ///
    /// # Errors
    ///
    /// The system's.
    pub fn second(&self) -> Result<File> {
        self.file.try_clone().map_err(|e| Error::io(&self.path, e))
    }

    fn failed(&mut self, why: &io::Error) -> Error {
        self.has_failed = true;
        let lost = count(self.lost_rows, "row");
        let text = format!(
            "{why}: the recording has ended; {lost} could not be written, those before are in the file"
        );
        Error::io(&self.path, io::Error::new(why.kind(), text)).with_hint(
            "make room on this disk and go on with --append, or record to another disk with -o",
        )
    }

    /// Removes the file if nothing was written.
    pub fn discard_empty(&self) {
        if std::fs::metadata(&self.path).is_ok_and(|m| m.is_file() && m.len() == 0) {
            let _ = std::fs::remove_file(&self.path);
        }
    }

    /// Writes as many whole lines as there is room for.
    fn append(&mut self, lines: &[u8]) -> io::Result<()> {
        let mut rest = lines;
        let done = loop {
            match self.file.write(rest) {
                _ if rest.is_empty() => break Ok(()),
                Ok(n) if n > 0 => rest = &rest[n..],
                Ok(_) => break Err(io::ErrorKind::WriteZero.into()),
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => break Err(e),
            }
        };
        let whole = end_of_lines(&lines[..lines.len() - rest.len()]);
        self.length += whole as u64;
        if done.is_err() {
            // A device has no length.
            let _ = self.file.set_len(self.length);
            let is_row = |line: &&[u8]| !line.is_empty() && !line.starts_with(b"#");
            let lost = lines[whole..].split(|b| *b == b'\n');
            self.lost_rows = lost.filter(is_row).count() as u64;
        }
        done
    }

    /// Looks whether the file is still there. One that is gone lives as long as it is open: it is copied.
    fn check_place(&mut self) -> Result<()> {
        let io_error = |e| Error::io(&self.path, e);
        let own = self.file.metadata().map_err(io_error)?;
        let is_cut = own.len() < self.length;
        let why = match std::fs::metadata(&self.path) {
            _ if !own.is_file() => return Ok(()),
            Err(_) => "another program deleted or moved the file",
            Ok(there) if !is_same(&own, &there) => "another program replaced the file",
            Ok(_) if is_cut => "another program cut the file, and what was recorded before is lost",
            Ok(_) => return Ok(()),
        };
        self.has_failed = true;
        let mut text = format!("{why}: the recording has ended");
        if !is_cut && self.length > 0 {
            text += &match self.rescue() {
                Ok(path) => format!("; what was received is in {}", path_text(&path)),
                Err(e) => format!("; what was received could not be copied ({e})"),
            };
        }
        Err(Error::io(&self.path, io::Error::other(text)))
    }

    /// Copies it to `walk.rescued.csv`, or `walk.rescued-2.csv` if there is one already.
    fn rescue(&mut self) -> io::Result<PathBuf> {
        let ending = self.path.extension().unwrap_or_default().to_string_lossy();
        let ending = format!("rescued.{ending}");
        let path = free_path(&self.path.with_extension(ending.trim_end_matches('.')));
        let mut copy = File::create_new(&path)?;
        self.file.rewind()?;
        io::copy(&mut self.file, &mut copy)?;
        copy.sync_data().map(|()| path)
    }
}

/// The end of the last whole line.
fn end_of_lines(text: &[u8]) -> usize {
    let end = text.iter().rposition(|b| *b == b'\n');
    end.map_or(0, |at| at + 1)
}

/// The path, or one with a number before its ending that does not exist.
pub fn free_path(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let name = |n: u32| format!("{stem}-{n}.{ending}");
    let numbered = (2..).map(|n| path.with_file_name(name(n).trim_end_matches('.')));
    let mut all = std::iter::once(path.to_owned()).chain(numbered);
    all.find(|p| !p.exists()).unwrap_or_else(|| path.to_owned())
}

fn in_use(path: &Path) -> Error {
    Error::usage("in-use", "another gravical log is writing to this file")
        .at(path, None)
        .with_hint("end that one first, or name another file with -o")
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
