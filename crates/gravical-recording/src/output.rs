//! Safe writing of files: never over an existing file without permission, and never partially.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{MAIN_SEPARATOR, Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use flate2::Compression;
use flate2::write::GzEncoder;
use gravical_judge::{Error, Result};
use tempfile::NamedTempFile;

use crate::problem::Problem;

/// Name and version of the program, as results state it.
pub const TOOL: &str = concat!("gravical ", env!("CARGO_PKG_VERSION"));

/// Prefix of temporary files.
const PREFIX: &str = ".gravical-";

/// Refuses a `path` that exists unless `force` is given, and a folder in any case.
///
/// # Errors
///
/// `exists` (usage) if the file exists and `force` is false; `is-folder`.
pub fn check_target(path: &Path, force: bool) -> Result<()> {
    if path == Path::new("-") {
        return Err(Problem::FileToStdout.error().advise("json", "true"));
    }
    let name = path.as_os_str().to_string_lossy();
    if path.is_dir() || name.ends_with(['/', MAIN_SEPARATOR]) {
        return Err(Problem::IsFolder.error().at(path, None));
    }
    // A dangling link exists, too.
    if !force && !is_special(path) && path.symlink_metadata().is_ok() {
        return Err(exists(path));
    }
    Ok(())
}

fn exists(path: &Path) -> Error {
    let error = Problem::Exists.error().at(path, None);
    error.advise("force", "true")
}

/// Whether the name of a file has this ending, in small letters or capitals.
pub fn ends_in(path: &Path, ending: &str) -> bool {
    let extension = path.extension();
    extension.is_some_and(|e| e.eq_ignore_ascii_case(ending))
}

/// The folder of a file.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

/// The error of a file whose folder is missing.
pub fn no_folder(folder: &Path, path: &Path) -> Error {
    let folder = folder.display().to_string();
    Problem::NoFolder { folder }.error().at(path, None)
}

/// True for a device or a pipe such as /dev/null, which is written to and never replaced by a
/// file, and for a name of the system such as /dev/stdout, even if it refers to a file.
pub fn is_special(path: &Path) -> bool {
    let is_below = |folder: &str| path.starts_with(folder);
    let of_system = is_below("/proc") || is_below("/dev") && !is_below("/dev/shm");
    std::fs::metadata(path).is_ok_and(|m| !m.is_dir() && (of_system || !m.is_file()))
}

/// Creates a folder and its parents if necessary.
///
/// # Errors
///
/// `no-folder` (usage), with the error of the file system; `stdout-target` (usage) for `-`.
pub fn make_folder(path: &Path) -> Result<()> {
    if path == Path::new("-") {
        return Err(Problem::FolderToStdout.error());
    }
    std::fs::create_dir_all(path).map_err(|e| {
        let why = e.to_string();
        Problem::FolderNotMade { why }.error().at(path, None)
    })
}

/// Writes `path` atomically, so that a reader sees the old file or the complete new one, and returns
/// what `fill` returns. A device or a pipe is written to directly.
///
/// A path that ends in `.gz` is compressed.
///
/// Until it is complete it is a hidden temporary file in the same folder (`.gravical-…`), which is deleted with an
/// error; a program that a signal ends calls [`discard_unfinished`]. A replaced file keeps its permissions.
///
/// # Errors
///
/// `exists` and `is-folder` as [`check_target`], also if another program created the file
/// meanwhile; otherwise errors of the file system, with the path.
pub fn write_atomic<T>(
    path: &Path,
    force: bool,
    fill: impl FnOnce(&mut dyn Write) -> Result<T>,
) -> Result<T> {
    check_target(path, force)?;
    let folder = folder_of(path);
    let io = |e| Error::io(path, e);
    let packed = ends_in(path, "gz");
    let fill = |out: &mut dyn Write| {
        if !packed {
            return fill(out);
        }
        let mut packer = GzEncoder::new(out, Compression::fast());
        let filled = fill(&mut packer)?;
        packer.finish().map_err(io)?;
        Ok(filled)
    };
    if is_special(path) {
        let mut writer = BufWriter::with_capacity(1 << 18, open_special(path).map_err(io)?);
        let filled = fill(&mut writer)?;
        writer.flush().map_err(io)?;
        return Ok(filled);
    }
    if !folder.is_dir() {
        return Err(no_folder(folder, path));
    }
    let (_listed, file) = temporary_file(folder).map_err(io)?;
    let mut writer = BufWriter::with_capacity(1 << 18, file.as_file());
    let filled = fill(&mut writer)?;
    writer.flush().map_err(io)?;
    drop(writer);
    persist(file, path, force).map_err(|e| match e.kind() {
        // Another program created it after the check above.
        io::ErrorKind::AlreadyExists if !force => exists(path),
        _ if path.is_dir() => Problem::IsFolder.error().at(path, None),
        _ => io(e),
    })?;
    Ok(filled)
}

/// [`write_atomic`] of a text.
///
/// # Errors
///
/// Those of [`write_atomic`].
pub fn write_text(path: &Path, force: bool, text: &str) -> Result<()> {
    write_atomic(path, force, |out| {
        let written = out.write_all(text.as_bytes());
        written.map_err(|e| Error::io(path, e))
    })
}

/// Opens a device or pipe. Standard output is written at its current position even if it is a
/// file; opened again it would be overwritten from its start.
fn open_special(path: &Path) -> io::Result<Box<dyn Write>> {
    Ok(match path.to_str() {
        Some("/dev/stdout" | "/dev/fd/1" | "/proc/self/fd/1") => Box::new(io::stdout()),
        Some("/dev/stderr" | "/dev/fd/2" | "/proc/self/fd/2") => Box::new(io::stderr()),
        _ => Box::new(File::options().write(true).open(path)?),
    })
}

/// Temporary files that are not complete yet.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Deletes all files that are not complete, before a signal ends the program. Whoever begins or completes a file
/// afterwards waits for that end.
pub fn discard_unfinished() {
    let unfinished = unfinished();
    for path in &*unfinished {
        // It may have got its name just now.
        let _ = std::fs::remove_file(path);
    }
    std::mem::forget(unfinished);
}

/// A path in [`UNFINISHED`].
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().remove(&self.0);
    }
}

/// A new file of a hidden name in `folder`; deleted with this value.
fn temporary_file(folder: &Path) -> io::Result<(Listed, NamedTempFile)> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // By default a temporary file is readable by its owner only; the umask still applies.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut unfinished = unfinished();
    let file = builder.tempfile_in(folder)?;
    unfinished.insert(file.path().to_owned());
    Ok((Listed(file.path().to_owned()), file))
}

/// Gives a complete file its name; with `force` it replaces an existing file.
fn persist(file: NamedTempFile, path: &Path, force: bool) -> io::Result<()> {
    file.as_file().sync_all()?;
    let _unfinished = unfinished();
    if !force {
        file.persist_noclobber(path)?;
        return Ok(());
    }
    if let Some(old) = path.symlink_metadata().ok().filter(|m| m.is_file()) {
        file.as_file().set_permissions(old.permissions())?;
    }
    file.persist(path)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn permissions_are_the_usual_ones_and_stay() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let names = || std::fs::read_dir(folder.path()).unwrap().count();
        std::fs::write(&path, "old").unwrap();
        let mode = |path: &Path| path.metadata().unwrap().permissions().mode() & 0o777;
        let new = folder.path().join("b.txt");
        write_text(&new, false, "new").unwrap();
        assert_eq!(mode(&new), mode(&path), "by the umask");
        std::fs::remove_file(&new).unwrap();
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o640)).unwrap();
        write_atomic(&path, true, |w| {
            w.write_all(b"new").map_err(|e| Error::io(&path, e))
        })
        .unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
        assert_eq!((mode(&path), names()), (0o640, 1));
    }

    #[test]
    #[cfg(unix)]
    fn a_file_created_meanwhile_is_not_overwritten() {
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
            Err::<(), _>(Error::input("test", "stop"))
        });
        assert!(failed.is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
