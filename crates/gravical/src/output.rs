//! Writing files so that nothing is lost: never over an existing file without
//! being told, never half a file.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

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
    if path.is_dir() {
        return Err(
            Error::usage("is-folder", "a file goes there; this is a folder")
                .at(path, None)
                .with_hint("name a file in it"),
        );
    }
    if !force && path.exists() && !is_special(path) {
        return Err(
            Error::usage("exists", "the file exists already; nothing was written")
                .at(path, None)
                .with_hint("name another file, or add --force to replace it"),
        );
    }
    Ok(())
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

/// A device or a pipe, as /dev/null: it is written to, and never replaced by a file.
fn is_special(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir())
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
    let text = path.display().to_string();
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

/// Writes `path` through a temporary file in the same folder that replaces it
/// in one step, so that a reader sees the old file or the whole new one. A device or a
/// pipe is written to as it is.
///
/// # Errors
///
/// `exists` as [`check_target`]; otherwise what the file system says, with the
/// path.
pub fn write_atomic(
    path: &Path,
    force: bool,
    fill: impl FnOnce(&mut dyn Write) -> Result<()>,
) -> Result<()> {
    check_target(path, force)?;
    let folder = folder_of(path);
    let io = |e| Error::io(path, e);
    if is_special(path) {
        let file = std::fs::File::options()
            .write(true)
            .open(path)
            .map_err(io)?;
        let mut writer = BufWriter::with_capacity(1 << 18, file);
        fill(&mut writer)?;
        return writer.flush().map_err(io);
    }
    if !folder.is_dir() {
        return Err(no_folder(folder, path));
    }
    let mut temporary = tempfile::Builder::new();
    let temporary = temporary.prefix(".gravical-");
    #[cfg(unix)]
    let temporary = {
        use std::os::unix::fs::PermissionsExt;
        // What a plain create would give (the umask still applies); the
        // default of a temporary file is readable by its owner only.
        temporary.permissions(std::fs::Permissions::from_mode(0o666))
    };
    let file = temporary.tempfile_in(folder).map_err(io)?;
    let mut writer = BufWriter::with_capacity(1 << 18, file);
    fill(&mut writer)?;
    let file = writer.into_inner().map_err(|e| io(e.into_error()))?;
    file.as_file().sync_all().map_err(io)?;
    if force {
        file.persist(path).map_err(|e| io(e.error))?;
    } else {
        // Closes the gap between the check above and now.
        file.persist_noclobber(path).map_err(|e| io(e.error))?;
    }
    Ok(())
}

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
