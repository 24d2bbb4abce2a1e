//! The file of the recording, and the rejected lines beside it.

use std::io;
use std::path::{Path, PathBuf};

use gravical::escape::path_text;
use gravical::targets::check_targets;
use gravical::{Error, Result};

use crate::device::board::{Settings, Wanted};
use crate::device::disk::LineFile;
use crate::device::item::Kind;
use crate::device::lines::Lines;

/// The header of a file that is continued is within this many bytes.
const HEAD: u64 = 1 << 16;
/// A longer last line without an end is not a row of a board, bytes.
const MOST_TORN: usize = 1 << 12;

/// What to do with a file that exists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// Refuse it.
    Refuse,
    /// Continue it.
    Append,
    /// Replace it.
    Replace,
}

/// The files of rows and of rejected lines.
pub struct Files {
    main: LineFile,
    rejected: Option<LineFile>,
}

impl Files {
    /// Checks whether the file can be created, before a board is searched for.
    ///
    /// # Errors
    ///
    /// `exists`, `is-folder`, `is-pipe`, `in-use`, `no-folder`, `stdout-target` (usage).
    pub fn check(path: &Path, existing: Existing) -> Result<()> {
        if is_pipe(path) {
            return Err(Error::usage(
                "is-pipe",
                "rows are appended to a file; this is a pipe, whose reader could block them",
            )
            .at(path, None)
            .with_hint("record into a file, and follow it with tail -f"));
        }
        let any = existing != Existing::Refuse;
        check_targets(&[path.to_owned()], &[], any).map_err(with_append_hint)?;
        if any && LineFile::is_busy(path) {
            return Err(in_use(path));
        }
        Ok(())
    }

    /// Creates a file, or opens the end of one.
    ///
    /// A last line without an end may be a part of a row, and its last number wrong: it is
    /// moved to the rejected lines, and a warning is returned.
    ///
    /// # Errors
    ///
    /// As [`check`](Self::check); the system's errors.
    pub fn open(path: &Path, existing: Existing) -> Result<(Self, Option<String>)> {
        Self::check(path, existing)?;
        let main = match existing {
            Existing::Append => LineFile::continued(path),
            Existing::Replace => LineFile::replaced(path),
            Existing::Refuse => LineFile::create(path),
        };
        let main = main.map_err(|e| match e.kind() {
            io::ErrorKind::ResourceBusy => in_use(path),
            _ => Error::io(path, e),
        })?;
        let mut files = Files {
            main,
            rejected: None,
        };
        let torn = match existing {
            Existing::Append => files.end_last_line()?,
            _ => None,
        };
        Ok((files, torn))
    }

    /// Ends the last line, or moves it to the rejected lines.
    fn end_last_line(&mut self) -> Result<Option<String>> {
        let path = self.path().to_owned();
        let io = |e| Error::io(&path, e);
        let torn = self.main.torn().map_err(io)?;
        if torn.is_empty() {
            return Ok(None);
        }
        // A comment, a header, or a longer line than a board sends.
        let text = torn
            .first()
            .is_some_and(|b| *b == b'#' || b.is_ascii_alphabetic());
        if text || torn.len() > MOST_TORN {
            self.main.append(b"\n").map_err(io)?;
            return Ok(None);
        }
        let mut line = torn.clone();
        line.push(b'\n');
        // It is removed here only once it is safe there.
        let rejected = rejected_path(&path);
        let kept = self.rejects(&line).and_then(|()| self.sync());
        kept.map_err(|e| Error::io(&rejected, e))?;
        self.main.cut(torn.len() as u64).map_err(io)?;
        let text = String::from_utf8_lossy(&torn);
        let shown: String = text.chars().filter(|c| !c.is_control()).take(80).collect();
        Ok(Some(format!(
            "the last line of {} has no line end and may be incomplete: it was moved to {}: \"{shown}\"",
            path.display(),
            rejected.display()
        )))
    }

    /// Passes rows to the system.
    pub fn rows(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.main.append(bytes)
    }

    /// Continues a file that another program removed, replaced or cut in a new one beside it, with
    /// all that is left of it; then a warning is returned.
    ///
    /// # Errors
    ///
    /// The system's error; then nothing is changed.
    pub fn mend(&mut self) -> io::Result<Option<String>> {
        for file in self.rejected.iter_mut().chain([&mut self.main]) {
            if let Some(was) = file.mend()? {
                let (was, now) = (path_text(&was), path_text(file.path()));
                return Ok(Some(format!(
                    "{was} was deleted, moved, replaced or cut by another program: what is left of it is in {now}, where it continues"
                )));
            }
        }
        Ok(None)
    }

    /// Passes rejected lines to the system; their file is created with the first.
    pub fn rejects(&mut self, bytes: &[u8]) -> io::Result<()> {
        let file = match &mut self.rejected {
            Some(file) => file,
            none => none.insert(LineFile::continued(&rejected_path(self.main.path()))?),
        };
        file.append(bytes)
    }

    /// The file of the rows.
    pub fn path(&self) -> &Path {
        self.main.path()
    }

    /// The first lines of the file.
    pub fn head(&self) -> &[u8] {
        self.main.head()
    }

    /// The file of the rejected lines, once it exists.
    pub fn rejected_file(&self) -> Option<&Path> {
        self.rejected.as_ref().map(LineFile::path)
    }

    /// The path for rejected lines.
    pub fn rejected_target(&self) -> PathBuf {
        let own = || rejected_path(self.path());
        self.rejected_file().map_or_else(own, Path::to_owned)
    }

    /// Removes the file if nothing was recorded.
    pub fn discard(&self) {
        let empty = std::fs::metadata(self.path()).is_ok_and(|m| m.is_file() && m.len() == 0);
        if empty {
            let _ = std::fs::remove_file(self.path());
        }
    }

    /// Makes what was written safe on the disk.
    pub fn sync(&mut self) -> io::Result<()> {
        if let Some(file) = &mut self.rejected {
            file.sync()?;
        }
        self.main.sync()
    }
}

/// The error `exists` with the options of this command.
fn with_append_hint(error: Error) -> Error {
    if error.code() == "exists" {
        return error.with_hint(
            "continue it with --append, replace it with --force, or name another file with -o",
        );
    }
    error
}

fn in_use(path: &Path) -> Error {
    Error::usage("in-use", "another gravical log is writing to this file")
        .at(path, None)
        .with_hint("end that one first, or name another file with -o")
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    std::fs::metadata(path).is_ok_and(|m| m.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}

/// The file for the rejected lines of `path`.
pub fn rejected_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".rejected.txt");
    name.into()
}

/// The head of a file that is continued.
#[derive(Debug, Default, PartialEq)]
pub struct Continued {
    /// Its header.
    pub header: Option<Vec<u8>>,
    /// The settings of the board.
    pub settings: Option<Settings>,
}

/// Reads the head of `path`; empty where the file does not exist or is empty.
///
/// # Errors
///
/// The system's error; `no-header` (input) for a file without a header.
pub fn continued(path: &Path) -> Result<Continued> {
    use std::io::Read as _;
    let mut head = Vec::new();
    match std::fs::File::open(path) {
        Ok(file) => file
            .take(HEAD)
            .read_to_end(&mut head)
            .map_err(|e| Error::io(path, e))?,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Continued::default()),
        Err(e) => return Err(Error::io(path, e)),
    };
    let mut found = Continued::default();
    for line in Lines::of_file().push(&head, None) {
        match line.kind {
            Kind::Comment => {
                let settings = Settings::parse(&String::from_utf8_lossy(&line.bytes));
                found.settings = settings.or(found.settings);
            }
            Kind::Header { .. } => {
                found.header = Some(line.bytes);
                return Ok(found);
            }
            _ => {}
        }
    }
    if head.trim_ascii().is_empty() {
        return Ok(Continued::default());
    }
    Err(Error::input(
        "no-header",
        "the file to be continued has no header of three or more columns: it is not a recording of gravical log",
    )
    .at(path, None)
    .with_hint("name another file with -o"))
}

impl Continued {
    /// The wanted settings, completed by those of the file.
    ///
    /// # Errors
    ///
    /// `option-range` (usage), and `settings-differ` (usage) for another range where the
    /// file has counts: the file could not show which range belongs to which row.
    pub fn wanted(&self, wanted: Wanted) -> Result<Wanted> {
        let Some(settings) = &self.settings else {
            wanted.validate()?;
            return Ok(wanted);
        };
        let was = Wanted::exactly(settings);
        let all = Wanted {
            accel_range_g: wanted.accel_range_g.or(was.accel_range_g),
            gyro_range_deg_s: wanted.gyro_range_deg_s.or(was.gyro_range_deg_s),
            low_pass_hz: wanted.low_pass_hz.or(was.low_pass_hz),
            rate_hz: wanted.rate_hz.or(was.rate_hz),
            format: wanted.format.or(was.format),
        };
        // Settings that were not asked for are not checked.
        let asked = Wanted {
            format: all.format,
            ..wanted
        };
        asked.validate()?;
        let ranges = |w: &Wanted| (w.accel_range_g, w.gyro_range_deg_s);
        if settings.format > 0 && ranges(&all) != ranges(&was) {
            return Err(Error::usage(
                "settings-differ",
                format!(
                    "the file that is continued has counts of ±{} g and ±{} °/s, not of the ranges asked for",
                    settings.accel_range_g, settings.gyro_range_deg_s
                ),
            )
            .with_hint("leave --range and --gyro-range out, or name another file with -o"));
        }
        Ok(all)
    }
}
