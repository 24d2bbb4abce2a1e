//! Writing files so that nothing is lost: never over an existing file without
//! being told, never half a file.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{MAIN_SEPARATOR, Path, PathBuf};

use crate::{Error, Result};

/// Text that is made row by row and handed on in blocks.
pub(crate) struct BlockWriter<'a> {
    out: &'a mut dyn Write,
    /// What is not handed on yet.
    pub bytes: Vec<u8>,
}

impl<'a> BlockWriter<'a> {
    /// Output is handed on in blocks of this many bytes.
    const SIZE: usize = 256 << 10;

    pub fn new(out: &'a mut dyn Write) -> Self {
        BlockWriter {
            out,
            bytes: Vec::with_capacity(Self::SIZE + (Self::SIZE >> 2)),
        }
    }

    /// # Errors
    ///
    /// What writing reports.
    #[inline]
    pub fn hand_on_if_full(&mut self) -> Result<()> {
        if self.bytes.len() < Self::SIZE {
            return Ok(());
        }
        self.hand_on()
    }

    fn hand_on(&mut self) -> Result<()> {
        let written = self.out.write_all(&self.bytes);
        self.bytes.clear();
        written.map_err(|e| Error::io(Path::new("output"), e))
    }

    /// Hands on what is left.
    ///
    /// # Errors
    ///
    /// What writing reports.
    pub fn finish(mut self) -> Result<()> {
        self.hand_on()?;
        let flushed = self.out.flush();
        flushed.map_err(|e| Error::io(Path::new("output"), e))
    }
}

/// Refuses a `path` that exists unless `force`, and a folder in any case.
///
/// # Errors
///
/// `exists` (usage) when the file is there and `force` is false; `is-folder`.
pub fn check_target(path: &Path, force: bool) -> Result<()> {
    if path == Path::new("-") {
        return Err(Error::usage(
            "stdout-target",
            "-o names a file; standard output is where it goes without -o",
        ));
    }
    let ends_open = path
        .as_os_str()
        .to_string_lossy()
        .ends_with(['/', MAIN_SEPARATOR]);
    if path.is_dir() || ends_open {
        return Err(is_folder(path));
    }
    // A link that leads nowhere is there, too.
    if !force && !is_special(path) && path.symlink_metadata().is_ok() {
        return Err(exists(path));
    }
    Ok(())
}

fn is_folder(path: &Path) -> Error {
    Error::usage("is-folder", "a file goes there; this is a folder")
        .at(path, None)
        .with_hint("name a file in it")
}

fn exists(path: &Path) -> Error {
    Error::usage("exists", "the file exists already; nothing was written")
        .at(path, None)
        .with_hint("name another file, or add --force to replace it")
}

/// Everything that one command writes, looked at together and before its work: a
/// result must replace neither another one nor what it was made from.
///
/// # Errors
///
/// Those of [`check_target`]; `no-folder`, `same-target`, and `target-is-input`, the
/// last two whatever `force` says (all usage).
pub fn check_targets(targets: &[PathBuf], inputs: &[PathBuf], force: bool) -> Result<()> {
    let mut taken: Vec<PathBuf> = Vec::new();
    let read: Vec<PathBuf> = inputs.iter().map(|p| place(p)).collect();
    for path in targets {
        check_target(path, force)?;
        let folder = folder_of(path);
        if !folder.is_dir() {
            return Err(no_folder(folder, path));
        }
        if is_special(path) {
            continue;
        }
        let own = place(path);
        if read.contains(&own) {
            return Err(Error::usage(
                "target-is-input",
                "this is read, and would be replaced by what is made of it",
            )
            .at(path, None)
            .with_hint("name another file for the result"));
        }
        if taken.contains(&own) {
            return Err(
                Error::usage("same-target", "two results would go into this one file")
                    .at(path, None)
                    .with_hint("give each a file of its own"),
            );
        }
        taken.push(own);
    }
    Ok(())
}

/// A path that is the same however it was written. One that is not there yet is named
/// by its folder.
fn place(path: &Path) -> PathBuf {
    if let Ok(whole) = path.canonicalize() {
        return whole;
    }
    match (folder_of(path).canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_owned(),
    }
}

/// The folder that a file stands in.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

fn no_folder(folder: &Path, path: &Path) -> Error {
    let text = format!("there is no folder \"{}\"", folder.display());
    Error::usage("no-folder", text)
        .at(path, None)
        .with_hint("make it first, or name a file elsewhere")
}

/// A device or a pipe, as /dev/null: it is written to, and never replaced by a file; nor is
/// what a name of the system stands for, as /dev/stdout for a file.
#[must_use]
pub fn is_special(path: &Path) -> bool {
    let of_system = ["/dev", "/proc"]
        .iter()
        .any(|folder| path.starts_with(folder))
        && !path.starts_with("/dev/shm");
    std::fs::metadata(path).is_ok_and(|m| !m.is_dir() && (of_system || !m.is_file()))
}

/// A character that steers a terminal or turns the direction of text instead of being
/// seen: C0 but tab, DEL, C1, the bidirectional marks, and the ends of lines of Unicode.
fn steers(c: char) -> bool {
    (c.is_control() && c != '\t')
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

fn escaped(text: &str, stays: impl Fn(char) -> bool, write: fn(char) -> String) -> Cow<'_, str> {
    let odd = |c: char| steers(c) && !stays(c);
    if text.is_ascii() && !text.bytes().any(|b| odd(char::from(b))) || !text.contains(odd) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match odd(c) {
            true => out.push_str(&write(c)),
            false => out.push(c),
        }
    }
    Cow::Owned(out)
}

/// Text as a terminal may get it, whatever recordings, file names and calibrations put
/// into it: characters that would steer the terminal are written as `\u{1b}`. Line ends
/// stay. All text for people goes through this on its way out.
#[must_use]
pub fn shown(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c == '\n', |c| c.escape_unicode().to_string())
}

/// The same for a part of a line: a file name, a label, a sentence. Line ends do not stay.
#[must_use]
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, |_| false, |c| c.escape_unicode().to_string())
}

/// The path as [`one_line`].
#[must_use]
pub fn path_text(path: &Path) -> String {
    one_line(&path.to_string_lossy()).into_owned()
}

/// JSON that says the same with such characters escaped: they stand in strings only.
#[must_use]
pub fn shown_json(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c == '\n', |c| format!("\\u{:04x}", u32::from(c)))
}

/// A word of a command line as a shell takes it: in quotes where it needs them.
#[must_use]
pub fn shell_word(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "_./+-:=,@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        return text.to_owned();
    }
    // Double quotes do for every shell as long as nothing in them is special.
    if text.contains(['"', '$', '`', '\\', '!']) {
        return format!("'{}'", text.replace('\'', "'\\''"));
    }
    format!("\"{text}\"")
}

/// A path likewise; one that begins with a dash is no option behind `./`.
#[must_use]
pub fn path_word(path: &Path) -> String {
    let text = path_text(path);
    match text.strip_prefix('-') {
        Some(rest) if !rest.is_empty() => shell_word(&format!("./{text}")),
        _ => shell_word(&text),
    }
}

/// Makes a folder and those above it, where they are not there.
///
/// # Errors
///
/// `no-folder` (usage), with what the file system says.
pub fn make_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| {
        Error::usage("no-folder", format!("the folder cannot be made: {e}"))
            .at(path, None)
            .with_hint("name a folder that you may write to")
    })
}

/// Writes `path` in one step, so that a reader sees the old file or the whole new one. A
/// device or a pipe is written to as it is.
///
/// Until it is whole the new file has no name, where the file system knows such files:
/// whatever ends the program leaves nothing behind. Elsewhere it is a temporary file in the
/// same folder. A file that is replaced keeps its rights.
///
/// # Errors
///
/// `exists` and `is-folder` as [`check_target`], even where another program was faster;
/// otherwise what the file system says, with the path.
pub fn write_atomic(
    path: &Path,
    force: bool,
    fill: impl FnOnce(&mut dyn Write) -> Result<()>,
) -> Result<()> {
    check_target(path, force)?;
    let folder = folder_of(path);
    let io = |e| Error::io(path, e);
    if is_special(path) {
        let mut writer = BufWriter::with_capacity(1 << 18, open_special(path).map_err(io)?);
        fill(&mut writer)?;
        return writer.flush().map_err(io);
    }
    if !folder.is_dir() {
        return Err(no_folder(folder, path));
    }
    let new = NewFile::in_folder(folder).map_err(io)?;
    let mut writer = BufWriter::with_capacity(1 << 18, new.file());
    fill(&mut writer)?;
    writer.flush().map_err(io)?;
    drop(writer);
    new.put(path, force).map_err(|e| match e.kind() {
        // Somebody was faster than the check above.
        io::ErrorKind::AlreadyExists if !force => exists(path),
        _ if path.is_dir() => is_folder(path),
        _ => io(e),
    })
}

/// Opens what is no file. Standard output is written to where it stands, even where it is
/// a file: opened again it would be written over from its start.
fn open_special(path: &Path) -> io::Result<Box<dyn Write>> {
    let names = |n: u8| ["/dev/fd", "/proc/self/fd"].map(|folder| format!("{folder}/{n}"));
    let is = |name: &str, n: u8| {
        path == Path::new(name) || names(n).iter().any(|p| path == Path::new(p))
    };
    if is("/dev/stdout", 1) {
        return Ok(Box::new(io::stdout()));
    }
    if is("/dev/stderr", 2) {
        return Ok(Box::new(io::stderr()));
    }
    let file = File::options().write(true).open(path)?;
    Ok(Box::new(file))
}

/// A file that is not there yet.
enum NewFile {
    /// Without a name.
    #[cfg(target_os = "linux")]
    Unnamed(File, PathBuf),
    /// Under another name; it goes with this value.
    Named(tempfile::NamedTempFile),
}

impl NewFile {
    fn in_folder(folder: &Path) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        {
            use rustix::fs::{Mode, OFlags};
            let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
            // What a plain create would give; the umask still applies.
            let mode = Mode::from_raw_mode(0o666);
            if let Ok(file) = rustix::fs::open(folder, flags, mode)
                && Path::new("/proc/self/fd").is_dir()
            {
                return Ok(NewFile::Unnamed(file.into(), folder.to_owned()));
            }
        }
        let mut temporary = tempfile::Builder::new();
        let temporary = temporary.prefix(PREFIX);
        #[cfg(unix)]
        let temporary = {
            use std::os::unix::fs::PermissionsExt;
            // The default of a temporary file is readable by its owner only.
            temporary.permissions(std::fs::Permissions::from_mode(0o666))
        };
        temporary.tempfile_in(folder).map(NewFile::Named)
    }

    fn file(&self) -> &File {
        match self {
            #[cfg(target_os = "linux")]
            NewFile::Unnamed(file, _) => file,
            NewFile::Named(file) => file.as_file(),
        }
    }

    /// Gives it its name; with `force` in the place of a file that is there.
    fn put(self, path: &Path, force: bool) -> io::Result<()> {
        self.file().sync_all()?;
        let there = std::fs::symlink_metadata(path).ok();
        if let Some(old) = there.filter(|m| m.is_file() && force) {
            self.file().set_permissions(old.permissions())?;
        }
        match self {
            #[cfg(target_os = "linux")]
            NewFile::Unnamed(file, folder) => {
                let linked = link(&file, path);
                let taken = |e: &io::Error| e.kind() == io::ErrorKind::AlreadyExists;
                if !(force && linked.as_ref().is_err_and(taken)) {
                    return linked;
                }
                // A name can be given to a file, but not taken from another one in the same
                // step: it gets one of its own for a moment.
                let mut temporary = tempfile::Builder::new();
                let named = temporary
                    .prefix(PREFIX)
                    .make_in(folder, |name| link(&file, name))?;
                named.persist(path).map(drop).map_err(|e| e.error)
            }
            NewFile::Named(file) if force => file.persist(path).map(drop).map_err(|e| e.error),
            NewFile::Named(file) => file.persist_noclobber(path).map(drop).map_err(|e| e.error),
        }
    }
}

/// Gives an open file without a name this one.
#[cfg(target_os = "linux")]
fn link(file: &File, path: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let own = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(linkat(CWD, own, CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

/// How temporary files are called.
const PREFIX: &str = ".gravical-";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_existing_file_is_kept_unless_forced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let put = |text: &'static str, force| {
            write_atomic(&path, force, |w| {
                w.write_all(text.as_bytes())
                    .map_err(|e| Error::io(&path, e))
            })
        };
        put("one", false).unwrap();
        assert_eq!(put("two", false).unwrap_err().code(), "exists");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "one");
        put("two", true).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "two");
    }

    #[test]
    fn nothing_that_steers_a_terminal_is_shown() {
        let text = "a\tb\n\u{1b}[31m\r\u{9b}1m\u{202e}x\u{7f}é";
        let expected = "a\tb\n\\u{1b}[31m\\u{d}\\u{9b}1m\\u{202e}x\\u{7f}é";
        assert_eq!(shown(text), expected);
        assert_eq!(one_line(text), expected.replace('\n', "\\u{a}"));
        assert!(matches!(shown("plain\n"), Cow::Borrowed(_)));
        let json = serde_json::to_string(text).unwrap();
        let safe = shown_json(&json);
        assert_eq!(serde_json::from_str::<String>(&safe).unwrap(), text);
        assert!(!safe.contains(steers));
    }

    #[test]
    fn words_of_a_command_line() {
        for (text, word) in [
            ("cal.json", "cal.json"),
            ("my file.csv", "\"my file.csv\""),
            ("-x", "-x"),
            ("it's $5", "'it'\\''s $5'"),
            ("", "\"\""),
        ] {
            assert_eq!(shell_word(text), word);
        }
        assert_eq!(path_word(Path::new("-x.csv")), "./-x.csv");
        assert_eq!(path_word(Path::new("-")), "-");
    }

    #[test]
    #[cfg(unix)]
    fn a_device_is_written_to_and_stays_one() {
        // A link to one, so that nothing is lost when it is replaced after all.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("null");
        std::os::unix::fs::symlink("/dev/null", &path).unwrap();
        for force in [false, true] {
            let put = |w: &mut dyn Write| w.write_all(b"one").map_err(|e| Error::io(&path, e));
            write_atomic(&path, force, put).unwrap();
            assert!(path.is_symlink() && is_special(&path));
        }
    }

    #[test]
    #[cfg(unix)]
    fn what_is_replaced_keeps_its_rights_and_nothing_has_a_name_before() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let names = || std::fs::read_dir(folder.path()).unwrap().count();
        std::fs::write(&path, "old").unwrap();
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o640)).unwrap();
        write_atomic(&path, true, |w| {
            // Where the file system knows no files without a name there are two.
            assert!(names() == 1 || !cfg!(target_os = "linux"));
            w.write_all(b"new").map_err(|e| Error::io(&path, e))
        })
        .unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
        let mode = path.metadata().unwrap().permissions().mode();
        assert_eq!((mode & 0o777, names()), (0o640, 1));
    }

    #[test]
    #[cfg(unix)]
    fn who_was_faster_is_not_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let put = |path: &Path, force, before: &dyn Fn()| {
            write_atomic(path, force, |w| {
                before();
                w.write_all(b"own").map_err(|e| Error::io(path, e))
            })
        };
        let path = at("a.txt");
        let raced = put(&path, false, &|| std::fs::write(&path, "theirs").unwrap());
        assert_eq!(raced.unwrap_err().code(), "exists");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "theirs");
        let path = at("b.txt");
        for force in [false, true] {
            let raced = put(&path, force, &|| {
                let _ = std::fs::create_dir(&path);
            });
            let code = raced.unwrap_err().code();
            assert!(["exists", "is-folder"].contains(&code), "{code}");
        }
        let link = at("link");
        std::os::unix::fs::symlink(at("nowhere"), &link).unwrap();
        assert_eq!(put(&link, false, &|| ()).unwrap_err().code(), "exists");
        assert_eq!(
            put(&at("c/"), true, &|| ()).unwrap_err().code(),
            "is-folder"
        );
        put(&link, true, &|| ()).unwrap();
        assert!(!link.is_symlink() && !at("nowhere").exists());
    }

    #[test]
    fn a_failed_write_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let failed = write_atomic(&path, false, |w| {
            w.write_all(b"half").unwrap();
            Err(Error::input("test", "stop"))
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
