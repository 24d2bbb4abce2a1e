//! The journal of a run: what was begun and what is done, one JSON object a line.
//!
//! A result is known by three things: the content of the item, the options and the version; the
//! last two are in the line with which a run begins. A line is written before a result and one
//! after it, so that whenever a run ends, a file of its own is distinguished from that of somebody else.

use std::collections::{BTreeMap, HashMap};
use std::fs::{File, TryLockError};
use std::io::{BufRead as _, BufReader, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use gravical::report::TOOL;
use gravical::{Error, Result};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use super::content::{Stamp, sha256_of_text};
use super::items::Item;
use super::row::{Columns, Row, Status};
use super::words::Words;

/// Name of the format, of the journal and of a summary.
pub const FORMAT: &str = "gravical-each/1";

#[derive(Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
enum Line<R> {
    /// A run begins; the lines after it are of its options.
    Run(Origin),
    /// The result of an item is about to be written.
    Begin { name: String, file: String },
    /// An item is done.
    Done {
        name: String,
        file: Option<String>,
        /// Of the result, if there is one.
        stamp: Option<Stamp>,
        sha256: Option<String>,
        status: Status,
        row: R,
    },
    /// The summary is about to be written, or was.
    Summary { file: PathBuf, stamp: Option<Stamp> },
}

/// What decides about results beside the content of their items.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    format: String,
    tool: String,
    command: String,
    options: Vec<String>,
    /// SHA-256 of the files that belong to the options.
    files: BTreeMap<String, String>,
}

impl Origin {
    /// Of a run with these options, and with `files` and their SHA-256.
    pub fn new(words: &Words, files: BTreeMap<String, String>) -> Self {
        Origin {
            format: FORMAT.to_owned(),
            tool: TOOL.to_owned(),
            command: words.verb.clone(),
            options: words.options.clone(),
            files,
        }
    }

    /// Equal for runs whose results are the same.
    fn key(&self) -> String {
        let files: Vec<&String> = self.files.values().collect();
        sha256_of_text(&format!(
            "{:?}",
            (&self.tool, &self.command, &self.options, files)
        ))
    }
}

/// What is known of an item of earlier runs.
struct Known {
    /// File of the result.
    file: Option<String>,
    /// As it was written; none while it was being written.
    stamp: Option<Stamp>,
    being_written: bool,
    done: Option<Done>,
}

struct Done {
    key: String,
    sha256: Option<String>,
    status: Status,
    /// The line in the journal.
    at: u64,
    length: usize,
}

/// The journal, open for one run alone.
pub struct Journal {
    path: PathBuf,
    file: Mutex<File>,
    key: String,
    known: HashMap<String, Known>,
    summaries: HashMap<PathBuf, Option<Stamp>>,
}

impl Journal {
    /// Opens the journal at `path`: of a run that is continued, or a new one in place of it.
    ///
    /// # Errors
    ///
    /// `exists` (usage) if there is one and neither `resume` nor `force` is given; `in-use`
    /// (usage) while another run writes to it; `journal-syntax` if it is none; errors of the file
    /// system.
    pub fn open(path: &Path, origin: &Origin, resume: bool, force: bool) -> Result<Self> {
        let io = |e| Error::io(path, e);
        if path.exists() && !(resume || force) {
            return Err(
                Error::usage("exists", "a run over many sessions was begun here before")
                    .at(path, None)
                    .with_hint("--resume continues it, --force begins anew"),
            );
        }
        let mut options = File::options();
        options.read(true).write(true).create(true).truncate(false);
        let file = options.open(path).map_err(io)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(
                    Error::usage("in-use", "another run is writing its results here")
                        .at(path, None)
                        .with_hint("wait for it, or end it, or name another -o or --summary"),
                );
            }
            // A file system without locks.
            Err(TryLockError::Error(_)) => {}
        }
        let mut journal = Journal {
            path: path.to_owned(),
            file: Mutex::new(file),
            key: origin.key(),
            known: HashMap::new(),
            summaries: HashMap::new(),
        };
        let whole = if resume { journal.read()? } else { 0 };
        journal.lock().set_len(whole).map_err(io)?;
        journal.write(&Line::<()>::Run(origin.clone()))?;
        Ok(journal)
    }

    /// Reads the lines of earlier runs; returns the length of those that are whole.
    fn read(&mut self) -> Result<u64> {
        let io = |e| Error::io(&self.path, e);
        // Through the handle with the lock: some systems let no other one read.
        let file = self.lock().try_clone().map_err(io)?;
        let mut reader = BufReader::new(file);
        let (mut at, mut number, mut key) = (0, 0, String::new());
        let mut line = Vec::new();
        loop {
            line.clear();
            let length = reader.read_until(b'\n', &mut line).map_err(io)?;
            // The end, or a line that was not written to its end.
            if line.last() != Some(&b'\n') {
                return Ok(at);
            }
            number += 1;
            let parsed = serde_json::from_slice::<Line<IgnoredAny>>(&line).map_err(|e| {
                Error::input("journal-syntax", format!("no line of this journal: {e}"))
                    .at(&self.path, Some(number))
                    .with_hint("--force begins anew, and replaces the results")
            })?;
            match parsed {
                Line::Run(origin) => key = origin.key(),
                Line::Begin { name, file } => {
                    let known = Known {
                        file: Some(file),
                        stamp: None,
                        being_written: true,
                        done: None,
                    };
                    self.known.insert(name, known);
                }
                Line::Done {
                    name,
                    file,
                    stamp,
                    sha256,
                    status,
                    ..
                } => {
                    let done = Done {
                        key: key.clone(),
                        sha256,
                        status,
                        at,
                        length,
                    };
                    let known = Known {
                        file,
                        stamp,
                        being_written: false,
                        done: Some(done),
                    };
                    self.known.insert(name, known);
                }
                Line::Summary { file, stamp } => {
                    self.summaries.insert(file, stamp);
                }
            }
            at += length as u64;
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, File> {
        self.file.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes a line at once: whenever the program is ended, it is there or it is the torn last one.
    fn write<R: Serialize>(&self, line: &Line<R>) -> Result<()> {
        let mut text = serde_json::to_vec(line).map_err(|e| Error::io(&self.path, e.into()))?;
        text.push(b'\n');
        let mut file = self.lock();
        let end = file.seek(SeekFrom::End(0));
        end.and_then(|_| file.write_all(&text))
            .map_err(|e| Error::io(&self.path, e))
    }

    /// The row of an item that is done: with the same content, options and version, and with a
    /// result that is still there. Errors are no results: they are tried again.
    pub fn done<V: Columns>(
        &self,
        item: &Item,
        sha256: &str,
        result: Option<&Path>,
    ) -> Option<Row<V>> {
        let known = self.known.get(&item.name)?;
        let done = known.done.as_ref()?;
        let same = done.key == self.key
            && done.sha256.as_deref() == Some(sha256)
            && done.status != Status::Error
            && known.file == item.file;
        let there = result.is_none_or(|path| {
            let bytes = |stamp: Option<Stamp>| stamp.map(|s| s.bytes);
            bytes(Stamp::of(path)) == bytes(known.stamp)
        });
        if !(same && there) {
            return None;
        }
        let mut line = vec![0; done.length];
        let mut file = self.lock();
        file.seek(SeekFrom::Start(done.at)).ok()?;
        file.read_exact(&mut line).ok()?;
        drop(file);
        match serde_json::from_slice(&line).ok()? {
            Line::Done { row, .. } => Some(row),
            _ => None,
        }
    }

    /// True if the file at `result` is what an earlier run wrote for this item, unchanged since.
    pub fn is_own(&self, item: &Item, result: &Path) -> bool {
        self.known.get(&item.name).is_some_and(|known| {
            known.file == item.file
                && (known.being_written
                    || known.stamp.is_some() && known.stamp == Stamp::of(result))
        })
    }

    /// The same of a summary.
    pub fn is_own_summary(&self, path: &Path) -> bool {
        self.summaries
            .get(&place(path))
            .is_some_and(|stamp| stamp.is_none() || *stamp == Stamp::of(path))
    }

    /// To be called before the result of an item is written.
    ///
    /// # Errors
    ///
    /// Errors of writing.
    pub fn begin(&self, item: &Item) -> Result<()> {
        let Some(file) = item.file.clone() else {
            return Ok(());
        };
        let name = item.name.clone();
        self.write(&Line::<()>::Begin { name, file })
    }

    /// To be called once an item is done. `own` is its result, if this or an earlier run wrote it.
    ///
    /// # Errors
    ///
    /// Errors of writing.
    pub fn end<V: Columns>(&self, item: &Item, own: Option<&Path>, row: &Row<V>) -> Result<()> {
        self.write(&Line::Done {
            name: item.name.clone(),
            file: item.file.clone(),
            stamp: own.and_then(Stamp::of),
            sha256: row.sha256.clone(),
            status: row.status,
            row,
        })
    }

    /// To be called before the summary is written, and after.
    ///
    /// # Errors
    ///
    /// Errors of writing.
    pub fn summary(&self, path: &Path, is_written: bool) -> Result<()> {
        let stamp = if is_written { Stamp::of(path) } else { None };
        let file = place(path);
        self.write(&Line::<()>::Summary { file, stamp })
    }
}

/// One name for a file, however it is given.
fn place(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::row::tests::{Length, row};
    use super::*;

    fn item(name: &str) -> Item {
        Item {
            name: name.to_owned(),
            path: format!("{name}.csv").into(),
            file: Some(format!("{name}.json")),
        }
    }

    fn origin(options: &[&str]) -> Origin {
        let options = options.iter().map(|o| (*o).to_owned()).collect();
        let verb = "calibrate".to_owned();
        Origin::new(&Words { verb, options }, BTreeMap::new())
    }

    /// A journal in which `a` is done, `b` was begun, and the last line is torn.
    fn begun(folder: &Path) -> PathBuf {
        let path = folder.join("journal");
        let journal = Journal::open(&path, &origin(&["--g"]), false, false).unwrap();
        let result = folder.join("a.json");
        journal.begin(&item("a")).unwrap();
        fs::write(&result, "of a").unwrap();
        journal
            .end(&item("a"), Some(&result), &row("a", Some(2.0)))
            .unwrap();
        journal.begin(&item("b")).unwrap();
        journal
            .write(&Line::<()>::Begin {
                name: "c".to_owned(),
                file: "c.json".to_owned(),
            })
            .unwrap();
        drop(journal);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() - 5]).unwrap();
        path
    }

    #[test]
    fn what_is_done_is_known_by_content_options_and_result() {
        let folder = tempfile::tempdir().unwrap();
        let (path, at) = (begun(folder.path()), |name: &str| folder.path().join(name));
        let open = |options: &[&str]| Journal::open(&path, &origin(options), true, false).unwrap();
        let journal = open(&["--g"]);
        let done = |journal: &Journal, name: &str, sha: &str| {
            let result = at(&format!("{name}.json"));
            journal.done::<Length>(&item(name), sha, Some(&result))
        };
        assert_eq!(done(&journal, "a", "00"), Some(row("a", Some(2.0))));
        assert_eq!(done(&journal, "a", "11"), None);
        assert_eq!(done(&journal, "b", "00"), None);
        drop(journal);
        // Other options: done again, over its own result and no other.
        let journal = open(&["--h"]);
        assert_eq!(done(&journal, "a", "00"), None);
        assert!(journal.is_own(&item("a"), &at("a.json")));
        assert!(journal.is_own(&item("b"), &at("b.json")));
        assert!(!journal.is_own(&item("c"), &at("c.json")));
        fs::write(at("a.json"), "of somebody else").unwrap();
        assert!(!journal.is_own(&item("a"), &at("a.json")));
        drop(journal);
        let journal = open(&["--g"]);
        assert_eq!(done(&journal, "a", "00"), None, "another result");
    }

    #[test]
    fn a_journal_is_of_one_run_at_a_time_and_never_replaced_unasked() {
        let folder = tempfile::tempdir().unwrap();
        let path = begun(folder.path());
        let code = |resume, force| {
            let opened = Journal::open(&path, &origin(&[]), resume, force);
            opened.map_or_else(|e| e.code(), |_| "opened")
        };
        assert_eq!(code(false, false), "exists");
        let journal = Journal::open(&path, &origin(&[]), true, false).unwrap();
        assert_eq!(code(true, false), "in-use");
        assert!(journal.known.len() == 2);
        let summary = folder.path().join("s.csv");
        assert!(!journal.is_own_summary(&summary));
        journal.summary(&summary, false).unwrap();
        drop(journal);
        let journal = Journal::open(&path, &origin(&[]), true, false).unwrap();
        assert!(journal.is_own_summary(&summary));
        drop(journal);
        let journal = Journal::open(&path, &origin(&[]), false, true).unwrap();
        assert!(journal.known.is_empty());
        drop(journal);
        fs::write(&path, "t,ax\n0,1\n").unwrap();
        assert_eq!(code(true, false), "journal-syntax");
    }
}
