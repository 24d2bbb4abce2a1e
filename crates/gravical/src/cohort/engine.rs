//! One item of a run that an engine distributes: whoever works on it needs a [`Task`], the recording
//! and the folder of the results, and nothing else.
//!
//! ```text
//! Task::begin → it is done already: its row
//!             → Work: the command, then its result and Work::done, or Work::failed → a row
//! ```
//!
//! The row is in a journal of the item, and with whoever collects the rows of the engine: if one of them
//! is lost, the other one is there.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::content::Content;
use super::journal::{Item, Journal, Origin, item_journal_name};
use super::row::{Outcome, Row, Status};
use crate::escape::path_text;
use crate::output::check_target;
use crate::{Error, Result};

/// What is to be done with one item, for a worker on any machine that sees the paths.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Task {
    /// Folder of the results.
    pub folder: PathBuf,
    /// Command, options, version.
    pub origin: Origin,
    /// The item.
    pub item: Item,
    /// Whether its result may replace a file: an earlier run wrote it.
    pub replaces: bool,
    /// What is done is done again, and any file replaced.
    pub anew: bool,
}

/// A task that was begun.
pub enum TaskWork<V> {
    /// Nothing is left to be done: an earlier run had this row, or it fails.
    Over(Box<Row<V>>),
    /// The command is to be run.
    Open(Box<Work>),
}

/// An item that is being worked on.
pub struct Work {
    item: Item,
    journal: Journal,
    content: Option<Content>,
    result: Option<PathBuf>,
    /// An earlier run wrote the result that is there.
    is_own: bool,
    may_replace: bool,
}

impl Task {
    /// Begins it.
    ///
    /// # Errors
    ///
    /// Those of the journal of the item, without which nothing can be begun: `journal-syntax`, errors of
    /// the file system.
    pub fn begin<V: Serialize + DeserializeOwned>(&self) -> Result<TaskWork<V>> {
        let Task { item, origin, .. } = self;
        let name = item_journal_name(&origin.command, &item.name);
        let journal = Journal::of_one(&self.folder.join(name), origin, self.anew)?;
        let result = item.file.as_ref().map(|file| self.folder.join(file));
        let own = |path: &PathBuf| self.replaces || journal.is_own(item, path);
        let mut work = Work {
            is_own: result.as_ref().is_some_and(own),
            item: item.clone(),
            journal,
            content: None,
            result,
            may_replace: self.anew,
        };
        work.may_replace |= work.is_own;
        let content = match Content::of(&item.path) {
            Ok(content) => content,
            Err(error) => return Ok(work.refused(&error)),
        };
        let result = work.result.as_deref();
        if let Some(mut row) = work.journal.done::<V>(item, &content.sha256, result) {
            row.path = item.path.display().to_string();
            row.result = result.map(path_text);
            return Ok(TaskWork::Over(Box::new(row)));
        }
        let target = result.map(|result| check_target(result, work.may_replace));
        work.content = Some(content);
        match target {
            Some(Err(error)) => Ok(work.refused(&error)),
            _ => {
                work.journal.begin(item)?;
                Ok(TaskWork::Open(Box::new(work)))
            }
        }
    }
}

impl Work {
    /// File of the result, if one is to be written.
    #[must_use]
    pub fn result(&self) -> Option<&Path> {
        self.result.as_deref()
    }

    /// Whether the result may replace a file.
    #[must_use]
    pub fn may_replace(&self) -> bool {
        self.may_replace
    }

    /// To be called when the result is known, before it is published.
    ///
    /// # Errors
    ///
    /// `changed` if the files of the item changed meanwhile.
    pub fn check_unchanged(&self) -> Result<()> {
        self.content
            .as_ref()
            .map_or(Ok(()), Content::check_unchanged)
    }

    /// To be called once the result is written. If that cannot be noted, the row is an error.
    pub fn done<V: Serialize + DeserializeOwned>(&self, outcome: Outcome<V>) -> Row<V> {
        let mut row = self.row();
        row.measured(outcome, self.result());
        match self.journal.end(&self.item, self.result(), &row) {
            Ok(()) => row,
            Err(error) => self.unnoted(&error),
        }
    }

    /// To be called if there is no result, with the code of the error, its message and hint.
    pub fn failed<V: Serialize + DeserializeOwned>(
        &self,
        code: &str,
        message: &str,
        hint: Option<&str>,
    ) -> Row<V> {
        let mut row = self.row();
        row.failed(code, message, hint);
        let own = self.result().filter(|_| self.is_own);
        // The row is an error anyway, and whoever collects the rows has it.
        let _ = self.journal.end(&self.item, own, &row);
        row
    }

    fn refused<V: Serialize + DeserializeOwned>(&self, error: &Error) -> TaskWork<V> {
        let row = self.failed(error.code(), &error.in_flags(), error.hint());
        TaskWork::Over(Box::new(row))
    }

    fn unnoted<V>(&self, error: &Error) -> Row<V> {
        let mut row = self.row();
        row.failed(error.code(), &error.in_flags(), error.hint());
        row
    }

    fn row<V>(&self) -> Row<V> {
        Row {
            path: self.item.path.display().to_string(),
            sha256: self.content.as_ref().map(|c| c.sha256.clone()),
            ..Row::of(&self.item.name, Status::Done)
        }
    }
}
