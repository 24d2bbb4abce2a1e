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
    task: Task,
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
        let Task { item, folder, .. } = self;
        let journal = self.journal(self.anew)?;
        let mut work = Work {
            task: self.clone(),
            journal,
            content: None,
            result: item.file.as_ref().map(|file| folder.join(file)),
            is_own: self.replaces,
            may_replace: self.anew || self.replaces,
        };
        let content = match Content::of(&item.path) {
            Ok(content) => content,
            Err(error) => {
                work.own_if(None);
                return Ok(work.refused(&error));
            }
        };
        work.own_if(Some(&content.sha256));
        work.content = Some(content);
        if let Some(row) = work.row_of(&work.journal) {
            return Ok(TaskWork::Over(Box::new(row)));
        }
        let check = |result| work.journal.check_target(item, result, work.may_replace);
        match work.result().map(check) {
            Some(Err(error)) => Ok(work.refused(&error)),
            _ => {
                work.journal.begin(item)?;
                Ok(TaskWork::Open(Box::new(work)))
            }
        }
    }

    fn journal(&self, anew: bool) -> Result<Journal> {
        let name = item_journal_name(&self.origin.command, &self.item.name);
        Journal::of_one(&self.folder.join(name), &self.origin, anew)
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
        match self.journal.end(&self.task.item, self.result(), &row) {
            Ok(()) => row,
            Err(error) => self.unnoted(&error),
        }
    }

    /// To be called if there is no result, with the code of the error, its message and hint. If another
    /// worker has done the same task meanwhile, the row and the journal are those of the other one.
    pub fn failed<V: Serialize + DeserializeOwned>(
        &self,
        code: &str,
        message: &str,
        hint: Option<&str>,
    ) -> Row<V> {
        let done = || self.row_of(&self.task.journal(false).ok()?);
        if !self.task.anew
            && let Some(row) = done()
        {
            return row;
        }
        let mut row = self.row();
        row.failed(code, message, hint);
        let own = self.result().filter(|_| self.is_own);
        // The row is an error anyway, and whoever collects the rows has it.
        let _ = self.journal.end(&self.task.item, own, &row);
        row
    }

    /// The row of the item, if it is done according to `journal`.
    fn row_of<V: Serialize + DeserializeOwned>(&self, journal: &Journal) -> Option<Row<V>> {
        let sha256 = &self.content.as_ref()?.sha256;
        let mut row = journal.done::<V>(&self.task.item, sha256, self.result())?;
        row.path = self.task.item.path.display().to_string();
        row.result = self.result().map(path_text);
        Some(row)
    }

    /// It may replace its result if that is of this item.
    fn own_if(&mut self, sha256: Option<&str>) {
        let journal = &self.journal;
        let own = |result: &PathBuf| journal.is_own(&self.task.item, sha256, result);
        self.is_own |= self.result.as_ref().is_some_and(own);
        self.may_replace |= self.is_own;
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
            path: self.task.item.path.display().to_string(),
            sha256: self.content.as_ref().map(|c| c.sha256.clone()),
            ..Row::of(&self.task.item.name, Status::Done)
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use super::super::row::tests::Length;
    use super::*;

    fn task(folder: &Path, recording: &str) -> Task {
        let path = folder.join(recording);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, format!("t,ax,ay,az of {recording}\n")).unwrap();
        Task {
            folder: folder.to_owned(),
            origin: Origin::new("calibrate", &[], BTreeMap::new()),
            item: Item {
                name: "a".to_owned(),
                path,
                file: Some("a.json".to_owned()),
            },
            replaces: false,
            anew: false,
        }
    }

    fn open(task: &Task) -> Box<Work> {
        match task.begin::<Length>().unwrap() {
            TaskWork::Open(work) => work,
            TaskWork::Over(row) => panic!("{row:?}"),
        }
    }

    fn write(work: &Work) -> Row<Length> {
        fs::write(work.result().unwrap(), "a result").unwrap();
        work.done(Outcome {
            verdict: "good".to_owned(),
            is_poor: false,
            reasons: Vec::new(),
            values: Length { length_m: 2.0 },
        })
    }

    #[test]
    fn a_task_that_is_done_is_not_done_again() {
        let folder = tempfile::tempdir().unwrap();
        let task = task(folder.path(), "in/a.csv");
        let row = write(&open(&task));
        match task.begin::<Length>().unwrap() {
            TaskWork::Over(again) => assert_eq!(*again, row),
            TaskWork::Open(_) => panic!("it is done"),
        }
    }

    /// An engine that lost sight of a worker gives its task to another one.
    #[test]
    fn the_slower_of_two_workers_has_the_row_of_the_other() {
        let folder = tempfile::tempdir().unwrap();
        let task = task(folder.path(), "in/a.csv");
        let (fast, slow) = (open(&task), open(&task));
        let row = write(&fast);
        assert_eq!(slow.failed::<Length>("exists", "it is there", None), row);
        assert_eq!(slow.failed::<Length>("io", "no space", None), row);
        assert!(matches!(task.begin::<Length>().unwrap(), TaskWork::Over(again) if *again == row));
    }

    #[test]
    fn another_recording_of_the_same_name_replaces_nothing() {
        let folder = tempfile::tempdir().unwrap();
        write(&open(&task(folder.path(), "in/a.csv")));
        match task(folder.path(), "other/a.csv")
            .begin::<Length>()
            .unwrap()
        {
            TaskWork::Over(row) => assert_eq!(row.error_code.as_deref(), Some("exists")),
            TaskWork::Open(_) => panic!("the result is of in/a.csv"),
        }
        let result = fs::read_to_string(folder.path().join("a.json")).unwrap();
        assert_eq!(result, "a result");
    }
}
