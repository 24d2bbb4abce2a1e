//! The serial port of the virtual board: a pseudo-terminal, opened like
//! `/dev/ttyACM0`.
//!
//! What a port of a board does: opening it resets the board, what is sent while
//! nobody has it open is lost, and so is what a slow reader does not fetch. What it
//! does not do: it has no modem lines (setting DTR fails with `ENOTTY`), and any
//! baud rate can be set.

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::mem::MaybeUninit;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};

use gravical::{Error, Result};
use rustix::fs::inotify::{self, CreateFlags, ReadFlags, WatchFlags};
use rustix::fs::{Mode, OFlags, fcntl_getfl, fcntl_setfl, open};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, tcflush, tcgetattr, tcsetattr};

/// A pseudo-terminal.
#[derive(Debug)]
pub struct Port {
    ours: File,
    /// Kept open: without it the first close by a reader would end the terminal.
    theirs: OwnedFd,
    watch: OwnedFd,
    path: PathBuf,
    link: Option<PathBuf>,
    readers: u32,
}

impl Port {
    /// A new one, with a symbolic link to it where wanted. A link that leads to
    /// another pseudo-terminal or nowhere is replaced, nothing else is.
    ///
    /// # Errors
    ///
    /// `io` where `link` is something else, or where the system has no pseudo-terminals.
    pub fn new(link: Option<&Path>) -> Result<Self> {
        let ours_error = |e: Errno| Error::io(Path::new("/dev/ptmx"), e.into());
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).map_err(ours_error)?;
        grantpt(&ours).map_err(ours_error)?;
        unlockpt(&ours).map_err(ours_error)?;
        let name = ptsname(&ours, Vec::new()).map_err(ours_error)?;
        let path = PathBuf::from(name.to_string_lossy().into_owned());
        let theirs_error = |e: Errno| Error::io(&path, e.into());
        let theirs =
            open(&path, OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).map_err(theirs_error)?;
        let mut raw = tcgetattr(&theirs).map_err(theirs_error)?;
        raw.make_raw();
        tcsetattr(&theirs, OptionalActions::Now, &raw).map_err(theirs_error)?;
        let flags = fcntl_getfl(&ours).map_err(ours_error)?;
        fcntl_setfl(&ours, flags | OFlags::NONBLOCK).map_err(ours_error)?;
        let watch = inotify::init(CreateFlags::NONBLOCK).map_err(theirs_error)?;
        inotify::add_watch(&watch, &path, WatchFlags::OPEN | WatchFlags::CLOSE)
            .map_err(theirs_error)?;
        if let Some(link) = link {
            place(link, &path)?;
        }
        Ok(Self {
            ours: File::from(ours),
            theirs,
            watch,
            path,
            link: link.map(Path::to_path_buf),
            readers: 0,
        })
    }

    /// What to open: the link, else the terminal itself.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.link.as_deref().unwrap_or(&self.path)
    }

    /// Whether anybody has it open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.readers > 0
    }

    /// Looks who came and went; true when somebody opened it since the last call.
    /// What was sent before is thrown away then, as the driver of a board does.
    pub fn opened(&mut self) -> bool {
        let mut buffer = [MaybeUninit::uninit(); 4096];
        let mut events = inotify::Reader::new(&self.watch, &mut buffer);
        let mut opened = false;
        while let Ok(event) = events.next() {
            if event.events().contains(ReadFlags::OPEN) {
                self.readers += 1;
                opened = true;
            } else if event
                .events()
                .intersects(ReadFlags::CLOSE_WRITE | ReadFlags::CLOSE_NOWRITE)
            {
                self.readers = self.readers.saturating_sub(1);
            }
        }
        if opened {
            // What is lost when this fails is what was lost anyway.
            let _ = tcflush(&self.ours, QueueSelector::OFlush);
            let _ = tcflush(&self.theirs, QueueSelector::IFlush);
        }
        opened
    }

    /// What the other side sent since the last call.
    pub fn receive(&mut self) -> Vec<u8> {
        let mut bytes = [0; 256];
        match self.ours.read(&mut bytes) {
            Ok(count) => bytes.iter().take(count).copied().collect(),
            Err(_) => Vec::new(),
        }
    }

    /// Bytes to the other side. What finds no room, or nobody, is lost.
    pub fn send(&mut self, bytes: &[u8]) {
        if self.is_open() {
            let _ = self.ours.write_all(bytes);
        }
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        if let Some(link) = &self.link
            && std::fs::read_link(link).is_ok_and(|to| to == self.path)
        {
            let _ = std::fs::remove_file(link);
        }
    }
}

fn place(link: &Path, path: &Path) -> Result<()> {
    if let Ok(to) = std::fs::read_link(link)
        && (to.starts_with("/dev/pts") || !to.exists())
    {
        std::fs::remove_file(link).map_err(|e| Error::io(link, e))?;
    }
    std::os::unix::fs::symlink(path, link).map_err(|e| Error::io(link, e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_replaces_a_dead_one_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("virtual-board-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let link = folder.join("ttyACM0");
        std::os::unix::fs::symlink("/dev/pts/no-such", &link).unwrap();
        let port = Port::new(Some(&link)).unwrap();
        assert_eq!(port.path(), link);
        assert!(File::open(&link).is_ok());
        drop(port);
        assert!(!link.exists());
        std::fs::write(&link, "mine").unwrap();
        assert!(Port::new(Some(&link)).is_err());
        assert_eq!(std::fs::read_to_string(&link).unwrap(), "mine");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
