//! The file of the recording, and the rejected lines beside it.

use std::io;
use std::path::{Path, PathBuf};

use gravical::output::path_text;
use gravical::{Error, Result};

use crate::device::board::{Settings, Wanted};
use crate::device::disk::{Growing, Loss};
use crate::device::item::Kind;
use crate::device::lines::Lines;

/// How much of a file that is continued is looked at for its header.
const HEAD: u64 = 1 << 16;
/// A last line without an end is no row of a board when it is longer, bytes.
const MOST_TORN: usize = 1 << 12;

/// Where rows and rejected lines go.
pub struct Files {
    path: PathBuf,
    main: Growing,
    /// The lines that it begins with, its header the last of them.
    head: Vec<u8>,
    rejected: Option<(Growing, PathBuf)>,
}

impl Files {
    /// Whether the file can be made, before a board is looked for.
    ///
    /// # Errors
    ///
    /// `exists`, `is-folder`, `is-pipe`, `in-use`, `no-folder`, `stdout-target` (usage).
    pub fn check(path: &Path, append: bool) -> Result<()> {
        if is_pipe(path) {
            return Err(Error::usage(
                "is-pipe",
                "rows go into a file that grows; this is a pipe, which could stop them",
            )
            .at(path, None)
            .with_hint("write a file, and follow it with tail -f"));
        }
        // Whatever is there is continued; only a folder cannot be.
        gravical::output::check_target(path, append).map_err(name_append)?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
        if let Some(folder) = folder
            && !folder.is_dir()
        {
            return Err(Error::usage(
                "no-folder",
                format!("there is no folder \"{}\"", folder.display()),
            )
            .at(path, None)
            .with_hint("make it first, or write elsewhere with -o"));
        }
        if append && Growing::is_busy(path) {
            return Err(in_use(path));
        }
        Ok(())
    }

    /// A new file, or the end of one.
    ///
    /// A last line that has no end may be a piece of a row, which would read as another
    /// value. It goes to the rejected lines, and is given; so does nothing else.
    ///
    /// # Errors
    ///
    /// As [`check`](Self::check); what the system says.
    pub fn open(path: &Path, append: bool) -> Result<(Self, Option<String>)> {
        Self::check(path, append)?;
        let main = if append {
            Growing::continued(path)
        } else {
            Growing::create(path)
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
            files.see_head(&head);
        }
        let torn = if append { files.mend()? } else { None };
        Ok((files, torn))
    }

    /// Gives the last line an end, or moves it away.
    fn mend(&mut self) -> Result<Option<String>> {
        let path = self.path.clone();
        let io = |e| Error::io(&path, e);
        let torn = self.main.torn().map_err(io)?;
        if torn.is_empty() {
            return Ok(None);
        }
        // A comment, a header, or more than a board sends in a line.
        let text = torn
            .first()
            .is_some_and(|b| *b == b'#' || b.is_ascii_alphabetic());
        if text || torn.len() > MOST_TORN {
            self.main.append(b"\n").map_err(io)?;
            return Ok(None);
        }
        let mut line = torn.clone();
        line.push(b'\n');
        // First there, and safe, then not here any more.
        let rejected = rejected_path(&path);
        let kept = self.rejects(&line).and_then(|()| self.sync());
        kept.map_err(|e| Error::io(&rejected, e))?;
        self.main.cut(torn.len()).map_err(io)?;
        let text = String::from_utf8_lossy(&torn);
        let shown: String = text.chars().filter(|c| !c.is_control()).take(80).collect();
        Ok(Some(format!(
            "the last line of {} had no end, and may be a piece of a row: it is in {} now: \"{shown}\"",
            path.display(),
            rejected.display()
        )))
    }

    /// Hands rows to the system.
    pub fn rows(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.main.append(bytes)?;
        self.see_head(bytes);
        Ok(())
    }

    fn see_head(&mut self, bytes: &[u8]) {
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

    /// Looks whether the files are still what was written. One that somebody has deleted,
    /// replaced or cut meanwhile goes on in a new file beside it, with all rows that are
    /// left, and that is said.
    ///
    /// # Errors
    ///
    /// What the system says; then all stays as it is.
    pub fn mend_loss(&mut self) -> io::Result<Option<String>> {
        if let Some((rejected, path)) = &mut self.rejected
            && let Some(loss) = rejected.loss(path)?
        {
            let was = path.clone();
            go_on_beside(rejected, path, loss, b"")?;
            return Ok(Some(told(&was, loss, path)));
        }
        let Some(loss) = self.main.loss(&self.path)? else {
            return Ok(None);
        };
        let was = self.path.clone();
        go_on_beside(&mut self.main, &mut self.path, loss, &self.head)?;
        Ok(Some(told(&was, loss, &self.path)))
    }

    /// Hands rejected lines to the system; their file is made with the first.
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

    /// The file of the rejected lines, once there is one.
    pub fn rejected_file(&self) -> Option<PathBuf> {
        self.rejected.as_ref().map(|(_, path)| path.clone())
    }

    /// Where rejected lines go.
    pub fn rejected_target(&self) -> PathBuf {
        self.rejected_file()
            .unwrap_or_else(|| rejected_path(&self.path))
    }

    /// Nothing was recorded: a file that was made for it goes again.
    pub fn discard(&self) {
        let empty = std::fs::metadata(&self.path).is_ok_and(|m| m.is_file() && m.len() == 0);
        if empty {
            let _ = std::fs::remove_file(&self.path);
        }
    }

    /// What was handed over is safe.
    pub fn sync(&mut self) -> io::Result<()> {
        if let Some((disk, _)) = &mut self.rejected {
            disk.sync()?;
        }
        self.main.sync()
    }
}

/// Has `disk` go on in a new file, which begins with `head` where that is lost.
fn go_on_beside(disk: &mut Growing, path: &mut PathBuf, loss: Loss, head: &[u8]) -> io::Result<()> {
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

/// What stands where rows were cut off.
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

/// New files beside one that is taken away again and again.
const MOST_KEPT: u32 = 100;

fn told(was: &Path, loss: Loss, now: &Path) -> String {
    let (what, rows) = match loss {
        Loss::Gone => ("deleted or moved", "all of it"),
        Loss::Replaced => ("replaced", "all of it"),
        Loss::Cut => ("cut by another program", "what was left of it"),
    };
    format!(
        "{} was {what} while it is written: {rows} is in {}, where it goes on",
        path_text(was),
        path_text(now)
    )
}

/// `exists` has another way out here.
fn name_append(error: Error) -> Error {
    if error.code() == "exists" {
        return error.with_hint("go on with it by --append, or write elsewhere with -o");
    }
    error
}

fn in_use(path: &Path) -> Error {
    Error::usage("in-use", "another gravical log is writing to this file")
        .at(path, None)
        .with_hint("end that one first, or write elsewhere with -o")
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

/// Where the rejected lines of `path` go.
pub fn rejected_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".rejected.txt");
    name.into()
}

/// What a file that is continued says of its rows.
#[derive(Debug, Default, PartialEq)]
pub struct Continued {
    /// Its header.
    pub header: Option<Vec<u8>>,
    /// How the board was set.
    pub settings: Option<Settings>,
}

/// Looks at the head of `path`; nothing where there is no such file, or an empty one.
///
/// # Errors
///
/// What the system says; `no-header` (input) for a file that no board's header is in.
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
    for line in Lines::of_file().push(&head) {
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
        "the file to be continued has no header of eight columns: it is no recording of a board",
    )
    .at(path, None)
    .with_hint("write elsewhere with -o"))
}

impl Continued {
    /// What is wanted, and for the rest as it was.
    ///
    /// # Errors
    ///
    /// `option-range` (usage), and `settings-differ` (usage) for another range where the
    /// file holds counts: nothing in it would say where which one begins.
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
        // What was not asked for is as the board's constants have it.
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
                    "the file that is continued has counts of ±{} g and ±{} °/s, not of what is asked for",
                    settings.accel_range_g, settings.gyro_range_deg_s
                ),
            )
            .with_hint("leave --range and --gyro-range out, or write elsewhere with -o"));
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_continued() {
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
        let (mut files, torn) = Files::open(&path, true).unwrap();
        assert_eq!(torn, None);
        let taken = Files::open(&path, true).map(|_| ()).unwrap_err();
        assert_eq!((taken.code(), taken.is_usage()), ("in-use", true));
        files.rows(b"1\n").unwrap();
        assert!(files.rejected_file().is_none());
        files.rejects(b"x\n").unwrap();
        files.sync().unwrap();
        let rejected = folder.path().join("x.csv.rejected.txt");
        assert_eq!(files.rejected_file().as_deref(), Some(&*rejected));
        assert_eq!(std::fs::read_to_string(rejected).unwrap(), "x\n");
        let exists = Files::open(&path, false).map(|_| ()).unwrap_err();
        assert_eq!(exists.code(), "exists");
        let nowhere = Files::open(&folder.path().join("no/x.csv"), false);
        assert_eq!(nowhere.map(|_| ()).unwrap_err().code(), "no-folder");
    }

    #[test]
    #[cfg(unix)]
    fn a_file_that_is_taken_away_goes_on_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let read = |name: &str| std::fs::read_to_string(at(name)).unwrap();
        let head = "# board\nt,ax,ay,az,T,gx,gy,gz\n";
        let (mut files, _) = Files::open(&at("x.csv"), false).unwrap();
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
        // Replaced: what is there now is not ours.
        std::fs::write(at("y"), "other").unwrap();
        std::fs::rename(at("y"), at("x.kept.csv")).unwrap();
        assert!(files.mend_loss().unwrap().unwrap().contains("replaced"));
        assert_eq!(read("x.kept.csv"), "other");
        assert_eq!(read("x.kept-2.csv"), format!("{head}1\n2\n3\n"));
        // Cut: what is left is a recording all the same.
        std::fs::write(at("x.kept-2.csv"), "").unwrap();
        assert!(files.mend_loss().unwrap().unwrap().contains("cut by"));
        files.rows(b"4\n").unwrap();
        let gap = String::from_utf8(CUT.to_vec()).unwrap();
        assert_eq!(read("x.kept-3.csv"), format!("{head}{gap}4\n"));
        // So are rejected lines kept.
        files.rejects(b"bad\n").unwrap();
        let rejected = files.rejected_file().unwrap();
        std::fs::remove_file(&rejected).unwrap();
        assert!(files.mend_loss().unwrap().is_some());
        let kept = files.rejected_file().unwrap();
        assert_eq!(std::fs::read_to_string(kept).unwrap(), "bad\n");
        assert_eq!(files.mend_loss().unwrap(), None);
    }

    #[test]
    fn a_last_line_without_an_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.csv");
        let rejected = folder.path().join("x.csv.rejected.txt");
        let head = "t,ax,ay,az,T,gx,gy,gz\n";
        for whole in ["# a comment", "t,ax,ay,az"] {
            std::fs::write(&path, format!("{head}{whole}")).unwrap();
            let (_, torn) = Files::open(&path, true).unwrap();
            assert_eq!(torn, None);
            let text = std::fs::read_to_string(&path).unwrap();
            assert_eq!(text, format!("{head}{whole}\n"));
        }
        assert!(!rejected.exists());
        // Of 12.5; it would be a row.
        std::fs::write(&path, format!("{head}1,2,3,4,5,6,7,12")).unwrap();
        let (files, torn) = Files::open(&path, true).unwrap();
        assert!(torn.unwrap().ends_with("\"1,2,3,4,5,6,7,12\""));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), head);
        let kept = std::fs::read_to_string(&rejected).unwrap();
        assert_eq!(kept, "1,2,3,4,5,6,7,12\n");
        drop(files);
        // What cannot be kept stays where it is.
        std::fs::remove_file(&rejected).unwrap();
        std::fs::create_dir(&rejected).unwrap();
        std::fs::write(&path, format!("{head}1,2")).unwrap();
        assert!(Files::open(&path, true).is_err());
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, format!("{head}1,2"));
    }
}
