//! The file of the recording, and the rejected lines beside it.

use std::io;
use std::path::{Path, PathBuf};

use gravical::{Error, Result};

use crate::device::board::{Settings, Wanted};
use crate::device::disk::Growing;
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
    rejected: Option<Growing>,
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
            rejected: None,
        };
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
        self.main.append(bytes)
    }

    /// Hands rejected lines to the system; their file is made with the first.
    pub fn rejects(&mut self, bytes: &[u8]) -> io::Result<()> {
        let disk = match &mut self.rejected {
            Some(disk) => disk,
            none => none.insert(Growing::continued(&rejected_path(&self.path))?),
        };
        disk.append(bytes)
    }

    /// The file of the rows.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file of the rejected lines, once there is one.
    pub fn rejected_file(&self) -> Option<PathBuf> {
        self.rejected.as_ref().map(|_| rejected_path(&self.path))
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
        if let Some(disk) = &mut self.rejected {
            disk.sync()?;
        }
        self.main.sync()
    }
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
