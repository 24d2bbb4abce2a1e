//! The file of the recording, and the rejected lines beside it.

use std::io;
use std::path::{Path, PathBuf};

use gravical::escape::path_text;
use gravical::{Error, Result};

use crate::device::board::{Settings, Wanted};
use crate::device::disk::{Growing, Loss};
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
    path: PathBuf,
    main: Growing,
    /// Its first lines up to the header.
    head: Vec<u8>,
    rejected: Option<(Growing, PathBuf)>,
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
        gravical::output::check_target(path, any).map_err(with_append_hint)?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
        if let Some(folder) = folder
            && !folder.is_dir()
        {
            return Err(Error::usage(
                "no-folder",
                format!("there is no folder \"{}\"", folder.display()),
            )
            .at(path, None)
            .with_hint("create it first, or name another file with -o"));
        }
        if any && Growing::is_busy(path) {
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
        let append = existing == Existing::Append;
        let main = match existing {
            Existing::Append => Growing::continued(path),
            Existing::Replace => Growing::replaced(path),
            Existing::Refuse => Growing::create(path),
        };
        let main = main.map_err(|e| match e.kind() {
            io::ErrorKind::ResourceBusy => in_use(path),
            _ => Error::io(path, e),
        })?;
        let mut files = Files {
            path: path.to_path_buf(),
            main,
            head: Vec::new(),
            rejected: None,
        };
        if append {
            let mut head = Vec::new();
            let file = std::fs::File::open(path).map_err(|e| Error::io(path, e))?;
            if file.metadata().is_ok_and(|m| m.is_file()) {
                io::Read::read_to_end(&mut io::Read::take(file, HEAD), &mut head)
                    .map_err(|e| Error::io(path, e))?;
            }
            files.note_head(&head);
        }
        let torn = if append { files.mend()? } else { None };
        Ok((files, torn))
    }

    /// Ends the last line, or moves it to the rejected lines.
    fn mend(&mut self) -> Result<Option<String>> {
        let path = self.path.clone();
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
        self.main.cut(torn.len()).map_err(io)?;
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
        self.main.append(bytes)?;
        self.note_head(bytes);
        Ok(())
    }

    /// Keeps the first lines up to the header.
    fn note_head(&mut self, bytes: &[u8]) {
        let comment = |line: &[u8]| line.starts_with(b"#") || line.trim_ascii().is_empty();
        let ends = |head: &[u8]| {
            let last = head.trim_ascii_end().rsplit(|b| *b == b'\n').next();
            !last.is_none_or(comment)
        };
        for line in bytes.split_inclusive(|b| *b == b'\n') {
            if ends(&self.head) || self.head.len() as u64 > HEAD {
                return;
            }
            self.head.extend_from_slice(line);
        }
    }

    /// Checks that the files are as they were written. If one was deleted, replaced or cut
    /// meanwhile, the recording continues in a new file beside it, with all rows that are
    /// left, and a warning is returned.
    ///
    /// # Errors
    ///
    /// The system's error; then nothing is changed.
    pub fn mend_loss(&mut self) -> io::Result<Option<String>> {
        if let Some((rejected, path)) = &mut self.rejected
            && let Some(loss) = rejected.loss(path)?
        {
            let was = path.clone();
            continue_beside(rejected, path, loss, b"")?;
            return Ok(Some(loss_text(&was, loss, path)));
        }
        let Some(loss) = self.main.loss(&self.path)? else {
            return Ok(None);
        };
        let was = self.path.clone();
        continue_beside(&mut self.main, &mut self.path, loss, &self.head)?;
        Ok(Some(loss_text(&was, loss, &self.path)))
    }

    /// Passes rejected lines to the system; their file is created with the first.
    pub fn rejects(&mut self, bytes: &[u8]) -> io::Result<()> {
        let (disk, _) = match &mut self.rejected {
            Some(disk) => disk,
            none => {
                let path = rejected_path(&self.path);
                none.insert((Growing::continued(&path)?, path))
            }
        };
        disk.append(bytes)
    }

    /// The file of the rows.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file of the rejected lines, once it exists.
    pub fn rejected_file(&self) -> Option<PathBuf> {
        self.rejected.as_ref().map(|(_, path)| path.clone())
    }

    /// The path for rejected lines.
    pub fn rejected_target(&self) -> PathBuf {
        self.rejected_file()
            .unwrap_or_else(|| rejected_path(&self.path))
    }

    /// Removes the file if nothing was recorded.
    pub fn discard(&self) {
        let empty = std::fs::metadata(&self.path).is_ok_and(|m| m.is_file() && m.len() == 0);
        if empty {
            let _ = std::fs::remove_file(&self.path);
        }
    }

    /// Makes what was written safe on the disk.
    pub fn sync(&mut self) -> io::Result<()> {
        if let Some((disk, _)) = &mut self.rejected {
            disk.sync()?;
        }
        self.main.sync()
    }
}

/// Continues `disk` in a new file, which begins with `head` where that was lost.
fn continue_beside(
    disk: &mut Growing,
    path: &mut PathBuf,
    loss: Loss,
    head: &[u8],
) -> io::Result<()> {
    let (mut new, at) = beside(path)?;
    let moved = disk.copy_to(&mut new).and_then(|()| {
        if new.length() < head.len() as u64 {
            new.cut(usize::try_from(new.length()).unwrap_or(usize::MAX))?;
            new.append(head)?;
        }
        match loss {
            Loss::Cut if !head.is_empty() => new.append(CUT),
            _ => Ok(()),
        }?;
        new.sync()
    });
    if let Err(e) = moved {
        let _ = std::fs::remove_file(&at);
        return Err(e);
    }
    (*disk, *path) = (new, at);
    Ok(())
}

/// The line in place of rows that were cut off.
const CUT: &[u8] = b"# gap: another program cut the file: rows are missing\n";

/// A new file beside `path`: NAME.kept.csv, NAME.kept-2.csv ….
fn beside(path: &Path) -> io::Result<(Growing, PathBuf)> {
    let stem = path.file_stem().unwrap_or_default();
    let base = match stem.to_str().and_then(|text| text.rsplit_once(".kept")) {
        Some((base, _)) => base.into(),
        None => stem.to_owned(),
    };
    let mut n = 1;
    loop {
        let mut name = base.clone();
        name.push(".kept");
        if n > 1 {
            name.push(format!("-{n}"));
        }
        if let Some(ending) = path.extension() {
            name.push(".");
            name.push(ending);
        }
        let at = path.with_file_name(name);
        match Growing::create(&at) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists && n < MOST_KEPT => n += 1,
            made => return Ok((made?, at)),
        }
    }
}

/// New files beside one that is removed again and again.
const MOST_KEPT: u32 = 100;

fn loss_text(was: &Path, loss: Loss, now: &Path) -> String {
    let (what, rows) = match loss {
        Loss::Gone => ("deleted or moved", "all of it"),
        Loss::Replaced => ("replaced", "all of it"),
        Loss::Cut => ("cut by another program", "the rest of it"),
    };
    format!(
        "{} was {what} during the recording: {rows} is in {}, where the recording continues",
        path_text(was),
        path_text(now)
    )
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_of_a_file_that_is_continued() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.csv");
        assert_eq!(continued(&path).unwrap(), Continued::default());
        std::fs::write(&path, "").unwrap();
        assert_eq!(continued(&path).unwrap(), Continued::default());
        std::fs::write(&path, "t,ax,ay,az,T,gx,gy,gz\n1,2\n").unwrap();
        let found = continued(&path).unwrap();
        assert_eq!(found.header.unwrap(), b"t,ax,ay,az,T,gx,gy,gz");
        std::fs::write(&path, "my diary\n").unwrap();
        assert_eq!(continued(&path).unwrap_err().code(), "no-header");
        let (mut files, torn) = Files::open(&path, Existing::Append).unwrap();
        assert_eq!(torn, None);
        let taken = Files::open(&path, Existing::Append)
            .map(|_| ())
            .unwrap_err();
        assert_eq!((taken.code(), taken.is_usage()), ("in-use", true));
        files.rows(b"1\n").unwrap();
        assert!(files.rejected_file().is_none());
        files.rejects(b"x\n").unwrap();
        files.sync().unwrap();
        let rejected = folder.path().join("x.csv.rejected.txt");
        assert_eq!(files.rejected_file().as_deref(), Some(&*rejected));
        assert_eq!(std::fs::read_to_string(rejected).unwrap(), "x\n");
        let exists = Files::open(&path, Existing::Refuse)
            .map(|_| ())
            .unwrap_err();
        assert_eq!(exists.code(), "exists");
        let in_use = Files::open(&path, Existing::Replace).map(|_| ());
        assert_eq!(in_use.unwrap_err().code(), "in-use");
        drop(files);
        let (mut files, _) = Files::open(&path, Existing::Replace).unwrap();
        files.rows(b"new\n").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new\n");
        let nowhere = Files::open(&folder.path().join("no/x.csv"), Existing::Refuse);
        assert_eq!(nowhere.map(|_| ()).unwrap_err().code(), "no-folder");
    }

    #[test]
    #[cfg(unix)]
    fn a_file_that_is_removed_continues_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let read = |name: &str| std::fs::read_to_string(at(name)).unwrap();
        let head = "# board\nt,ax,ay,az,T,gx,gy,gz\n";
        let (mut files, _) = Files::open(&at("x.csv"), Existing::Refuse).unwrap();
        files.rows(head.as_bytes()).unwrap();
        files.rows(b"1\n2\n").unwrap();
        assert_eq!(files.mend_loss().unwrap(), None);
        std::fs::remove_file(at("x.csv")).unwrap();
        let text = files.mend_loss().unwrap().unwrap();
        assert!(
            text.contains("x.csv was deleted") && text.contains("x.kept.csv"),
            "{text}"
        );
        files.rows(b"3\n").unwrap();
        assert_eq!(read("x.kept.csv"), format!("{head}1\n2\n3\n"));
        // Replaced: the file there now belongs to somebody else.
        std::fs::write(at("y"), "other").unwrap();
        std::fs::rename(at("y"), at("x.kept.csv")).unwrap();
        assert!(files.mend_loss().unwrap().unwrap().contains("replaced"));
        assert_eq!(read("x.kept.csv"), "other");
        assert_eq!(read("x.kept-2.csv"), format!("{head}1\n2\n3\n"));
        // Cut: the rest is still a recording.
        std::fs::write(at("x.kept-2.csv"), "").unwrap();
        assert!(files.mend_loss().unwrap().unwrap().contains("cut by"));
        files.rows(b"4\n").unwrap();
        let gap = String::from_utf8(CUT.to_vec()).unwrap();
        assert_eq!(read("x.kept-3.csv"), format!("{head}{gap}4\n"));
        // Rejected lines likewise.
        files.rejects(b"bad\n").unwrap();
        let rejected = files.rejected_file().unwrap();
        std::fs::remove_file(&rejected).unwrap();
        assert!(files.mend_loss().unwrap().is_some());
        let kept = files.rejected_file().unwrap();
        assert_eq!(std::fs::read_to_string(kept).unwrap(), "bad\n");
        assert_eq!(files.mend_loss().unwrap(), None);
    }

    #[test]
    fn a_last_line_without_an_end_is_moved() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.csv");
        let rejected = folder.path().join("x.csv.rejected.txt");
        let head = "t,ax,ay,az,T,gx,gy,gz\n";
        for whole in ["# a comment", "t,ax,ay,az"] {
            std::fs::write(&path, format!("{head}{whole}")).unwrap();
            let (_, torn) = Files::open(&path, Existing::Append).unwrap();
            assert_eq!(torn, None);
            let text = std::fs::read_to_string(&path).unwrap();
            assert_eq!(text, format!("{head}{whole}\n"));
        }
        assert!(!rejected.exists());
        // The beginning of 12.5 looks like a row.
        std::fs::write(&path, format!("{head}1,2,3,4,5,6,7,12")).unwrap();
        let (files, torn) = Files::open(&path, Existing::Append).unwrap();
        assert!(torn.unwrap().ends_with("\"1,2,3,4,5,6,7,12\""));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), head);
        let kept = std::fs::read_to_string(&rejected).unwrap();
        assert_eq!(kept, "1,2,3,4,5,6,7,12\n");
        drop(files);
        // A line that cannot be moved stays.
        std::fs::remove_file(&rejected).unwrap();
        std::fs::create_dir(&rejected).unwrap();
        std::fs::write(&path, format!("{head}1,2")).unwrap();
        assert!(Files::open(&path, Existing::Append).is_err());
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, format!("{head}1,2"));
    }
}
