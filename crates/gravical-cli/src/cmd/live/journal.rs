//! The journal of a session on the disk.

use std::fs::{File, OpenOptions};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use gravical::live::folder::JOURNAL;
use gravical::live::{Event, Message};
use gravical::{Error, Result};

/// The journal, which grows by an event a line.
pub struct JournalFile {
    file: File,
    path: PathBuf,
}

impl JournalFile {
    /// Creates it in `folder`, or continues it.
    ///
    /// # Errors
    ///
    /// Those of the file system; it exists already.
    pub fn open(folder: &Path, continues: bool) -> Result<Self> {
        let path = folder.join(JOURNAL);
        let io = |e| Error::io(&path, e);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(!continues)
            .open(&path)
            .map_err(io)?;
        // A line that was not written completely is removed.
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(io)?;
        let end = bytes
            .iter()
            .rposition(|b| *b == b'\n')
            .map_or(0, |at| at + 1);
        file.set_len(end as u64).map_err(io)?;
        file.seek(SeekFrom::Start(end as u64)).map_err(io)?;
        Ok(JournalFile { file, path })
    }

    /// Writes an event. When this returns, one that changes the poses is safe on the disk.
    ///
    /// # Errors
    ///
    /// Those of the file system.
    pub fn write(&mut self, message: &Message) -> Result<()> {
        let io = |e| Error::io(&self.path, e);
        let mut line = serde_json::to_vec(message).map_err(|e| io(e.into()))?;
        line.push(b'\n');
        self.file.write_all(&line).map_err(io)?;
        if is_vital(message) {
            self.file.sync_data().map_err(io)
        } else {
            Ok(())
        }
    }
}

/// An event without which a session could not be resumed as it was.
pub fn is_vital(message: &Message) -> bool {
    matches!(
        message.event,
        Event::Session { .. }
            | Event::PoseAccepted(_)
            | Event::PoseUndone { .. }
            | Event::Gravity { .. }
    )
}
