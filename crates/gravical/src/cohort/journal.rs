//! The journal of a run: what is to be done, what was begun and what is done, one JSON object a line.
//!
//! A result is known by three things: the content of the item, the options and the version; the
//! last two are in the line with which a run begins. A line is written before a result and one
//! after it, so that whenever a run ends, a file of its own is distinguished from that of somebody else.
//!
//! Each run has a journal of its own, also if several machines write to one folder: what they are
//! called ends in `.journal.ndjson`. A run that continues reads those of the others, too.

use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io::{BufRead as _, BufReader, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};

use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Serialize};

use super::content::Stamp;
use super::row::{Row, Status};
use crate::escape::one_line;
use crate::hash::sha256;
use crate::output::{check_target, write_atomic};
use crate::{Error, Result, TOOL};

/// Name of the format, of the journal and of a summary.
pub const FORMAT: &str = "gravical-each/1";

/// What the name of a journal ends in.
const ENDING: &str = ".journal.ndjson";

/// One of many recordings or sessions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Item {
    /// What it is called: unique among all, whatever the case of its letters.
    pub name: String,
    /// Where it is.
    pub path: PathBuf,
    /// File of its result, in the folder of the results.
    pub file: Option<String>,
}

impl Item {
    /// Its absolute path, by which it is known whose a result is.
    fn place(&self) -> String {
        place(&self.path).display().to_string()
    }
}

/// All items of a run, or of the runs that share them.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct List {
    /// How many there are.
    pub items: u64,
    /// SHA-256 of their names.
    sha256: String,
}

impl List {
    /// Of these items.
    #[must_use]
    pub fn of(items: &[Item]) -> Self {
        let names: Vec<&str> = items.iter().map(|item| item.name.as_str()).collect();
        List {
            items: items.len() as u64,
            sha256: sha256(format!("{names:?}").as_bytes()),
        }
    }
}

/// Part of the items that one of several runs takes: `2/8`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Shard {
    /// Which one, from 1.
    pub number: u32,
    /// Of how many.
    pub of: u32,
}

impl Shard {
    /// Whether the item with this index belongs to it: each one takes every `of`th item.
    #[must_use]
    pub fn takes(self, index: usize) -> bool {
        index % self.of as usize == self.number as usize - 1
    }

    /// How many of `all` items belong to it.
    #[must_use]
    pub fn count(self, all: u64) -> u64 {
        (all + u64::from(self.of - self.number)) / u64::from(self.of)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> std::result::Result<Self, String> {
        text.parse()
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parsed = text
            .split_once('/')
            .and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        match parsed {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Shard { number, of }),
            _ => Err("a shard is its number and how many there are, 1/8 to 8/8".to_owned()),
        }
    }
}

/// What decides about results beside the content of their items.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    format: String,
    /// Name and version of the program.
    pub tool: String,
    /// The command.
    pub command: String,
    /// Its options, `--name=value`.
    pub options: Vec<String>,
    /// SHA-256 of the files that belong to the options.
    files: BTreeMap<String, String>,
}

impl Origin {
    /// Of a run of `command` with these options, and with `files` and their SHA-256.
    #[must_use]
    pub fn new(command: &str, options: &[String], files: BTreeMap<String, String>) -> Self {
        Origin {
            format: FORMAT.to_owned(),
            tool: TOOL.to_owned(),
            command: command.to_owned(),
            options: options.to_vec(),
            files,
        }
    }

    /// Equal for runs whose results are the same.
    #[must_use]
    pub fn key(&self) -> String {
        let files: Vec<&String> = self.files.values().collect();
        // Those of one name keep their order; the others have none in Python.
        let mut options: Vec<&str> = self.options.iter().map(String::as_str).collect();
        options.sort_by_key(|option| option.split('=').next());
        sha256(format!("{:?}", (&self.tool, &self.command, options, files)).as_bytes())
    }
}

/// A line of a journal.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Line<R> {
    /// A run begins; the lines after it are of its options.
    Run {
        /// Its options.
        #[serde(flatten)]
        origin: Origin,
        /// Its part of the items; all of them if null.
        #[serde(default)]
        shard: Option<Shard>,
        /// The items of all shards together.
        #[serde(default)]
        list: Option<List>,
    },
    /// An item that belongs to the run.
    Planned {
        /// Name of the item.
        name: String,
        /// Its path as given.
        path: String,
    },
    /// The result of an item is about to be written.
    Begin {
        /// Name of the item.
        name: String,
        /// Its absolute path.
        path: String,
        /// File of the result.
        file: String,
    },
    /// An item is done.
    Done {
        /// Name of the item.
        name: String,
        /// Its absolute path.
        path: String,
        /// File of the result, in the folder of the journal.
        file: Option<String>,
        /// Of the result, if there is one.
        stamp: Option<Stamp>,
        /// Of the content.
        sha256: Option<String>,
        /// What became of it.
        status: Status,
        /// All that is said of it.
        row: R,
    },
    /// The summary is about to be written, or was.
    Summary {
        /// Its path.
        file: PathBuf,
        /// Of the file, once it was written.
        stamp: Option<Stamp>,
    },
}

/// Calls `take` with each line of the journal in `file`, with its place and length, and returns the
/// length of those that are whole.
///
/// # Errors
///
/// `journal-syntax` for a line that is none; errors of reading and those of `take`.
pub(super) fn read_lines<R: DeserializeOwned>(
    path: &Path,
    file: File,
    mut take: impl FnMut(Line<R>, u64, usize) -> Result<()>,
) -> Result<u64> {
    let mut reader = BufReader::new(file);
    let (mut at, mut number, mut line) = (0, 0, Vec::new());
    loop {
        line.clear();
        let length = reader.read_until(b'\n', &mut line);
        let length = length.map_err(|e| Error::io(path, e))?;
        // The end, or a line that was not written to its end.
        if line.last() != Some(&b'\n') {
            return Ok(at);
        }
        number += 1;
        take(parse_line(path, number, &line)?, at, length)?;
        at += length as u64;
    }
}

/// True if the result `file` in `folder` is the one that had this `stamp`.
pub(super) fn is_there(folder: &Path, file: Option<&str>, stamp: Option<Stamp>) -> bool {
    let there = file.and_then(|file| Stamp::of(&folder.join(file)));
    there.is_some() && there == stamp
}

/// Parses line `number` of the journal at `path`.
///
/// # Errors
///
/// `journal-syntax`.
pub(super) fn parse_line<R: DeserializeOwned>(
    path: &Path,
    number: u64,
    line: &[u8],
) -> Result<Line<R>> {
    serde_json::from_slice(line).map_err(|e| {
        Error::input("journal-syntax", format!("no line of this journal: {e}"))
            .at(path, Some(number))
            .with_hint("--force begins anew, and replaces the results")
    })
}

/// Name of the journal of a run of `command`.
#[must_use]
pub fn journal_name(command: &str, shard: Option<Shard>) -> String {
    match shard {
        Some(Shard { number, of }) => format!("{command}.{number}-of-{of}{ENDING}"),
        None => format!("{command}{ENDING}"),
    }
}

/// Name of the journal of one item, which an engine distributes. A hash: names of items have any length,
/// and could be those of shards.
pub(super) fn item_journal_name(command: &str, item: &str) -> String {
    format!("{command}.{}{ENDING}", &sha256(item.as_bytes())[..32])
}

/// The journals in `folder`, in order of their names.
///
/// # Errors
///
/// Errors of the file system.
pub(super) fn journals(folder: &Path) -> Result<Vec<PathBuf>> {
    let io = |e| Error::io(folder, e);
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(io)? {
        let path = entry.map_err(io)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.ends_with(ENDING) && path.is_file() {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// What is known of an item of earlier runs.
struct Known {
    /// File of the result.
    file: Option<String>,
    /// As it was written; none while it was being written.
    stamp: Option<Stamp>,
    being_written: bool,
    /// Whose result it is.
    owner: Owner,
    done: Option<Done>,
}

/// The recording that a result is of: names may be those of others in another list.
#[derive(Clone)]
struct Owner {
    path: String,
    sha256: Option<String>,
}

impl Owner {
    /// It is the item, or one of the same content.
    fn is(&self, item: &Item, sha256: Option<&str>) -> bool {
        self.path == item.place() || sha256.is_some() && self.sha256.as_deref() == sha256
    }
}

struct Done {
    key: String,
    sha256: Option<String>,
    status: Status,
    /// The journal, and the line in it.
    journal: PathBuf,
    at: u64,
    length: usize,
}

/// Where lines go.
enum Sink {
    /// To the end of a file.
    Appended(File),
    /// Into a file that is written anew each time: these are its lines.
    Replaced(Vec<u8>),
}

/// The journal, open for one run alone.
pub struct Journal {
    path: PathBuf,
    sink: Mutex<Sink>,
    key: String,
    known: HashMap<String, Known>,
    summaries: HashMap<PathBuf, Option<Stamp>>,
}

/// What a journal begins with.
#[derive(Debug, Clone)]
pub struct Beginning<'a> {
    /// The options.
    pub origin: Origin,
    /// The part of the items.
    pub shard: Option<Shard>,
    /// The items of all shards together.
    pub list: List,
    /// The items of this run.
    pub items: &'a [Item],
}

impl Journal {
    /// Opens the journal at `path`: of a run that is continued, or a new one in place of it. One that
    /// is continued knows what others in the same folder did.
    ///
    /// # Errors
    ///
    /// `exists` (usage) if there is one and neither `resume` nor `force` is given; `in-use`
    /// (usage) while another run writes to it; `journal-syntax` if it is none; errors of the file
    /// system.
    pub fn open(path: &Path, run: &Beginning<'_>, resume: bool, force: bool) -> Result<Self> {
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
            // Through the handle with the lock: some systems let no other one read.
            sink: Mutex::new(Sink::Appended(file.try_clone().map_err(io)?)),
            key: run.origin.key(),
            known: HashMap::new(),
            summaries: HashMap::new(),
        };
        let mut whole = 0;
        if resume {
            journal.read_others(&run.origin.command)?;
            whole = journal.read(path, file.try_clone().map_err(io)?)?;
        }
        file.set_len(whole).map_err(io)?;
        journal.begin_run(run)?;
        Ok(journal)
    }

    /// The journal at `path` of one item alone, which is worked on wherever an engine puts it, and by
    /// two workers at a time if it lost sight of one. It is complete or absent, and the last writer
    /// wins: all of them have the same result. With `anew` what it says is not read.
    ///
    /// # Errors
    ///
    /// `journal-syntax` if it is none; errors of the file system.
    pub fn of_one(path: &Path, origin: &Origin, anew: bool) -> Result<Self> {
        let mut journal = Journal {
            path: path.to_owned(),
            sink: Mutex::new(Sink::Replaced(Vec::new())),
            key: origin.key(),
            known: HashMap::new(),
            summaries: HashMap::new(),
        };
        match File::open(path) {
            Ok(file) if !anew => {
                journal.read(path, file)?;
            }
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(Error::io(path, e)),
            _ => {}
        }
        let run = journal.text(&Line::<()>::Run {
            origin: origin.clone(),
            shard: None,
            list: None,
        })?;
        *journal.lock() = Sink::Replaced(run);
        Ok(journal)
    }

    /// Reads the journals that other runs of this command wrote into the same folder.
    fn read_others(&mut self, command: &str) -> Result<()> {
        let folder = match self.path.parent() {
            Some(folder) if folder != Path::new("") => folder.to_owned(),
            _ => PathBuf::from("."),
        };
        let own = self.path.file_name().map(std::ffi::OsStr::to_owned);
        let start = format!("{command}.");
        for path in journals(&folder)? {
            let name = path.file_name().unwrap_or_default();
            if Some(name) != own.as_deref() && name.to_string_lossy().starts_with(&start) {
                let file = File::open(&path).map_err(|e| Error::io(&path, e))?;
                self.read(&path, file)?;
            }
        }
        Ok(())
    }

    /// Reads the lines of earlier runs; returns the length of those that are whole.
    fn read(&mut self, path: &Path, file: File) -> Result<u64> {
        let mut key = String::new();
        let mut known: HashMap<String, Known> = HashMap::new();
        let is_own = path == self.path;
        let summaries = &mut self.summaries;
        // Of a result that was there before, until another one is written.
        let stamp_of = |known: &HashMap<String, Known>, name: &str| known.get(name)?.stamp;
        let owner_of = |known: &HashMap<String, Known>, name: &str| {
            let known = known.get(name)?;
            Some(known.owner.clone())
        };
        let whole = read_lines::<IgnoredAny>(path, file, |line, at, length| {
            match line {
                Line::Run { origin, .. } => key = origin.key(),
                Line::Planned { .. } => {}
                Line::Begin { name, path, file } => {
                    let begun = Known {
                        file: Some(file),
                        stamp: stamp_of(&known, &name),
                        being_written: true,
                        owner: Owner { path, sha256: None },
                        done: None,
                    };
                    known.insert(name, begun);
                }
                Line::Done {
                    name,
                    path: of,
                    file,
                    stamp,
                    sha256,
                    status,
                    ..
                } => {
                    let own = Owner {
                        path: of,
                        sha256: sha256.clone(),
                    };
                    let done = Done {
                        key: key.clone(),
                        sha256,
                        status,
                        journal: path.to_owned(),
                        at,
                        length,
                    };
                    // A failure leaves a result to the recording that it is of.
                    let failed = status == Status::Error;
                    let before = stamp_of(&known, &name).filter(|_| failed);
                    let owner = owner_of(&known, &name).filter(|_| before.is_some());
                    let done = Known {
                        file,
                        stamp: stamp.or(before),
                        being_written: false,
                        owner: owner.unwrap_or(own),
                        done: Some(done),
                    };
                    known.insert(name, done);
                }
                // That of another shard has other rows.
                Line::Summary { file, stamp } if is_own => {
                    summaries.insert(file, stamp);
                }
                Line::Summary { .. } => {}
            }
            Ok(())
        })?;
        // What several journals know, the one knows best whose result is there.
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        for (name, new) in known {
            let there = |known: &Known| is_there(folder, known.file.as_deref(), known.stamp);
            if !self
                .known
                .get(&name)
                .is_some_and(|old| there(old) && !there(&new))
            {
                self.known.insert(name, new);
            }
        }
        Ok(whole)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Sink> {
        self.sink.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The run, and those of its items that no journal knows.
    fn begin_run(&self, run: &Beginning<'_>) -> Result<()> {
        let mut text = self.text(&Line::<()>::Run {
            origin: run.origin.clone(),
            shard: run.shard,
            list: Some(run.list.clone()),
        })?;
        for item in run
            .items
            .iter()
            .filter(|i| self.known.get(&i.name).is_none_or(|k| !k.owner.is(i, None)))
        {
            text.extend(self.text(&Line::<()>::Planned {
                name: item.name.clone(),
                path: item.path.display().to_string(),
            })?);
        }
        self.append(&text)
    }

    fn text<R: Serialize>(&self, line: &Line<R>) -> Result<Vec<u8>> {
        let mut text = serde_json::to_vec(line).map_err(|e| Error::io(&self.path, e.into()))?;
        text.push(b'\n');
        Ok(text)
    }

    /// Writes at once: whenever the program is ended, a line is there or it is the torn last one.
    fn append(&self, text: &[u8]) -> Result<()> {
        let io = |e| Error::io(&self.path, e);
        match &mut *self.lock() {
            Sink::Appended(file) => {
                let end = file.seek(SeekFrom::End(0)).map_err(io)?;
                file.write_all(text).map_err(|e| {
                    // A torn line in the middle would make all of it unreadable.
                    let _ = file.set_len(end);
                    io(e)
                })
            }
            Sink::Replaced(lines) => {
                lines.extend(text);
                write_atomic(&self.path, true, |out| out.write_all(lines).map_err(io))
            }
        }
    }

    fn write<R: Serialize>(&self, line: &Line<R>) -> Result<()> {
        self.append(&self.text(line)?)
    }

    /// The row of an item that is done: with the same content, options and version, and with a
    /// result that is still there. Errors are no results: they are tried again.
    pub fn done<V: Serialize + DeserializeOwned>(
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
        let read = |mut file: &File, line: &mut [u8]| {
            file.seek(SeekFrom::Start(done.at))?;
            file.read_exact(line)
        };
        match &*self.lock() {
            Sink::Appended(file) if done.journal == self.path => read(file, &mut line).ok()?,
            _ => read(&File::open(&done.journal).ok()?, &mut line).ok()?,
        }
        match serde_json::from_slice(&line).ok()? {
            Line::Done { row, .. } => Some(row),
            _ => None,
        }
    }

    /// True if the file at `result` is what an earlier run wrote for this item, unchanged since.
    /// Items are the same if their path or their content is.
    pub fn is_own(&self, item: &Item, sha256: Option<&str>, result: &Path) -> bool {
        let written = self.written(item, result);
        written.is_some_and(|owner| owner.is(item, sha256))
    }

    /// Checks that the result of an item can be written; with `may_replace` it may be there.
    ///
    /// # Errors
    ///
    /// Those of [`check_target`]; `exists` says if it is the result of another item of this name.
    pub fn check_target(&self, item: &Item, result: &Path, may_replace: bool) -> Result<()> {
        let checked = check_target(result, may_replace);
        let other = self.written(item, result).map(|owner| &owner.path);
        match (checked, other) {
            (Err(error), Some(other)) if error.code() == "exists" && *other != item.place() => {
                Err(Error::usage(
                    "exists",
                    format!(
                        "it is the result of another recording of this name, {}",
                        one_line(other)
                    ),
                )
                .at(result, None)
                .with_hint("name another folder with -o; --force replaces it"))
            }
            (checked, _) => checked,
        }
    }

    /// Whose the file at `result` is, if an earlier run wrote it and it is unchanged since.
    fn written(&self, item: &Item, result: &Path) -> Option<&Owner> {
        let known = self.known.get(&item.name)?;
        let same = known.being_written || known.stamp.is_some() && known.stamp == Stamp::of(result);
        (known.file == item.file && same).then_some(&known.owner)
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
        let (name, path) = (item.name.clone(), item.place());
        self.write(&Line::<()>::Begin { name, path, file })
    }

    /// To be called once an item is done. `own` is its result, if this or an earlier run wrote it.
    ///
    /// # Errors
    ///
    /// Errors of writing.
    pub fn end<V: Serialize + DeserializeOwned>(
        &self,
        item: &Item,
        own: Option<&Path>,
        row: &Row<V>,
    ) -> Result<()> {
        self.write(&Line::Done {
            name: item.name.clone(),
            path: item.place(),
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
    use super::super::row::tests::{Length, row};
    use super::*;

    fn item(name: &str) -> Item {
        Item {
            name: name.to_owned(),
            path: format!("{name}.csv").into(),
            file: Some(format!("{name}.json")),
        }
    }

    fn origin(options: &[&str]) -> Beginning<'static> {
        let options: Vec<String> = options.iter().map(|o| (*o).to_owned()).collect();
        Beginning {
            origin: Origin::new("calibrate", &options, BTreeMap::new()),
            shard: None,
            list: List::of(&[]),
            items: &[],
        }
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
                path: String::new(),
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
        assert!(journal.is_own(&item("a"), None, &at("a.json")));
        assert!(journal.is_own(&item("b"), None, &at("b.json")));
        assert!(!journal.is_own(&item("c"), None, &at("c.json")));
        fs::write(at("a.json"), "of somebody else").unwrap();
        assert!(!journal.is_own(&item("a"), None, &at("a.json")));
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

    #[test]
    fn a_run_that_continues_knows_what_other_shards_did() {
        let folder = tempfile::tempdir().unwrap();
        let items = ["a", "b", "c"].map(item);
        let at = |shard: Option<Shard>| folder.path().join(journal_name("calibrate", shard));
        let run = |shard: Option<Shard>, resume: bool| {
            let run = Beginning {
                shard,
                list: List::of(&items),
                items: &items,
                ..origin(&[])
            };
            Journal::open(&at(shard), &run, resume, false).unwrap()
        };
        let second = Some("2/2".parse().unwrap());
        let journal = run(second, false);
        let result = folder.path().join("b.json");
        journal.begin(&items[1]).unwrap();
        fs::write(&result, "of b").unwrap();
        let done = row("b", Some(2.0));
        journal.end(&items[1], Some(&result), &done).unwrap();
        let known = |journal: &Journal| journal.done::<Length>(&items[1], "00", Some(&result));
        assert_eq!(known(&run(None, true)), Some(done));
        // While the other one is being written, too.
        drop(journal);
        assert!(
            fs::read_to_string(at(None))
                .unwrap()
                .matches("planned")
                .count()
                == 2
        );
        assert_eq!(
            at(second).file_name().unwrap(),
            "calibrate.2-of-2.journal.ndjson"
        );
    }

    #[test]
    fn shards_share_all_items() {
        for of in 1..=5 {
            for all in 0..12_u64 {
                let shards = (1..=of).map(|number| Shard { number, of });
                let counts: Vec<u64> = shards.clone().map(|s| s.count(all)).collect();
                assert_eq!(counts.iter().sum::<u64>(), all);
                for (shard, count) in shards.zip(counts) {
                    let own = (0..all as usize).filter(|i| shard.takes(*i)).count();
                    assert_eq!(own as u64, count, "{shard} of {all}");
                    assert_eq!(shard.to_string().parse(), Ok(shard));
                }
            }
        }
        for wrong in ["", "3", "0/2", "3/2", "a/b", "1/0"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_failure_leaves_a_result_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let path = begun(folder.path());
        let result = folder.path().join("a.json");
        let open = |options: &[&str]| Journal::open(&path, &origin(options), true, false).unwrap();
        let failed = row("a", None);
        let failed = Row {
            status: Status::Error,
            ..failed
        };
        // Before anything of it was read, and after the work was begun.
        let journal = open(&["--g"]);
        journal.end(&item("a"), None, &failed).unwrap();
        drop(journal);
        let journal = open(&["--g"]);
        assert!(journal.is_own(&item("a"), None, &result));
        journal.begin(&item("a")).unwrap();
        journal.end(&item("a"), None, &failed).unwrap();
        drop(journal);
        assert!(open(&["--g"]).is_own(&item("a"), None, &result));
    }

    #[test]
    fn a_result_belongs_to_a_recording_and_not_to_a_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = begun(folder.path());
        let result = folder.path().join("a.json");
        let other = Item {
            path: "other/a.csv".into(),
            ..item("a")
        };
        let items = [other.clone()];
        let open = || {
            let run = Beginning {
                items: &items,
                ..origin(&["--h"])
            };
            Journal::open(&path, &run, true, false).unwrap()
        };
        let journal = open();
        assert!(!journal.is_own(&other, Some("11"), &result));
        // Moved to another place, it is still the same.
        assert!(journal.is_own(&other, Some("00"), &result));
        let refused = journal.check_target(&other, &result, false).unwrap_err();
        assert!(refused.to_string().contains("a.csv"));
        // Its failure does not make the result its own.
        let failed = Row {
            status: Status::Error,
            sha256: Some("11".to_owned()),
            ..row("a", None)
        };
        journal.end(&other, None, &failed).unwrap();
        drop(journal);
        let journal = open();
        assert!(!journal.is_own(&other, Some("11"), &result));
        assert!(journal.is_own(&item("a"), None, &result));
        let planned = fs::read_to_string(&path).unwrap();
        assert!(planned.contains(r#"{"type":"planned","name":"a","path":"other/a.csv"}"#));
    }

    #[test]
    fn of_several_journals_that_one_counts_whose_result_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let items = ["a"].map(item);
        let result = folder.path().join("a.json");
        let run = |shard: Option<Shard>, options: &[&str]| {
            let run = Beginning {
                shard,
                list: List::of(&items),
                items: &items,
                ..origin(options)
            };
            let path = folder.path().join(journal_name("calibrate", shard));
            Journal::open(&path, &run, true, false).unwrap()
        };
        let write = |journal: &Journal, text: &str| {
            journal.begin(&items[0]).unwrap();
            fs::write(&result, text).unwrap();
            let done = row("a", Some(2.0));
            journal.end(&items[0], Some(&result), &done).unwrap();
        };
        let shard = Some("1/1".parse().unwrap());
        write(&run(shard, &["--old"]), "old");
        write(&run(None, &["--new"]), "newer");
        // The shard continues: its own journal is of the old options.
        let journal = run(shard, &["--new"]);
        assert!(journal.is_own(&items[0], None, &result));
        assert!(
            journal
                .done::<Length>(&items[0], "00", Some(&result))
                .is_some()
        );
    }
}
