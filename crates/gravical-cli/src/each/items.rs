//! From the arguments to the items: what is a session, and what it is called.

use std::collections::HashSet;
use std::fs;
use std::io::{self, BufRead as _, BufReader, Read};
use std::path::{Path, PathBuf};

use gravical::cohort::{Ending, Item, named, not_twice};
use gravical::escape::path_text;
use gravical::live::folder::is_session;
use gravical::session::{ENDINGS, may_be_recording};
use gravical::{Error, Result};

/// What the items are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Sessions: files, or folders of them.
    Sessions,
    /// Recordings: files, also those of a folder.
    Recordings,
    /// Recordings: files, as they are named; a folder is none.
    Named,
}

/// The items of a run.
#[derive(Debug, Default)]
pub struct Items {
    pub all: Vec<Item>,
    /// What was left out or renamed, in sentences.
    pub notes: Vec<String>,
}

/// Most names in one note.
const MOST_NAMES: usize = 4;

/// Characters of a pattern.
const WILD: [char; 3] = ['*', '?', '['];

impl Items {
    /// The items of `arguments`: files and folders, patterns in quotes, `@LIST`. `outputs` are
    /// what the run writes, which is never read. Results get the name of their item and the
    /// ending that `ending` makes of a file name; none without.
    ///
    /// A path that does not exist is an item: it fails, and the others do not.
    ///
    /// # Errors
    ///
    /// `each-input` (usage) for standard input; `no-recordings` if there is no item; errors of
    /// reading a list.
    pub fn of(
        arguments: &[PathBuf],
        kind: Kind,
        outputs: &[&Path],
        ending: Option<Ending>,
    ) -> Result<Self> {
        let mut found = Found::new(kind, outputs);
        for argument in arguments {
            found.argument(argument)?;
        }
        let Found {
            paths, mut notes, ..
        } = found;
        if paths.is_empty() {
            let mut error = Error::input("no-recordings", "there is no session among these paths");
            if let [one] = arguments {
                error = error.at(one, None);
            }
            return Err(error.with_hint(format!(
                "give files, or a folder that holds them; recordings end in .{}",
                ENDINGS.join(", .")
            )));
        }
        let (all, renamed) = named(paths, ending);
        if !renamed.is_empty() {
            let renamed = renamed.iter().map(|item| {
                let path = path_text(&item.path);
                format!("{path} is {}", item.name)
            });
            let renamed: Vec<String> = renamed.collect();
            notes.push(format!(
                "names that several would share: {}",
                listed(&renamed)
            ));
        }
        Ok(Items { all, notes })
    }
}

/// Paths of items as they are found.
struct Found {
    kind: Kind,
    /// Canonical paths of what the run writes.
    outputs: Vec<PathBuf>,
    paths: Vec<PathBuf>,
    seen: HashSet<PathBuf>,
    notes: Vec<String>,
}

impl Found {
    fn new(kind: Kind, outputs: &[&Path]) -> Self {
        Found {
            kind,
            outputs: outputs
                .iter()
                .filter_map(|p| p.canonicalize().ok())
                .collect(),
            paths: Vec::new(),
            seen: HashSet::new(),
            notes: Vec::new(),
        }
    }

    fn argument(&mut self, argument: &Path) -> Result<()> {
        if argument == Path::new("-") {
            return Err(not_twice(argument));
        }
        let text = argument.to_string_lossy();
        if let Some(list) = text.strip_prefix('@')
            && !argument.exists()
        {
            return self.list(Path::new(list));
        }
        match matching(&text, argument) {
            Some(paths) => paths.iter().for_each(|path| self.path(path)),
            None => self.path(argument),
        }
        Ok(())
    }

    /// A path a line; empty lines and those that begin with # do not count.
    fn list(&mut self, list: &Path) -> Result<()> {
        let io = |e| Error::io(list, e);
        let reader: Box<dyn Read> = match list == Path::new("-") {
            true => Box::new(io::stdin().lock()),
            false => Box::new(fs::File::open(list).map_err(io)?),
        };
        for line in BufReader::new(reader).lines() {
            let line = line.map_err(io)?;
            let line = line.trim();
            if !(line.is_empty() || line.starts_with('#')) {
                self.path(Path::new(line));
            }
        }
        Ok(())
    }

    /// A file is an item, and so is a guided session; any other folder stands for its entries.
    fn path(&mut self, path: &Path) {
        if !path.is_dir() || self.is_one(path) {
            return self.add(path.to_owned());
        }
        match entries(path) {
            Ok(entries) => self.entries(path, entries),
            // Its error is that of an item.
            Err(_) => self.add(path.to_owned()),
        }
    }

    /// A folder that does not stand for its entries.
    fn is_one(&self, folder: &Path) -> bool {
        match self.kind {
            Kind::Sessions => is_session(folder),
            Kind::Recordings => false,
            Kind::Named => true,
        }
    }

    fn entries(&mut self, folder: &Path, entries: Vec<PathBuf>) {
        let (mut others, mut folders) = (Vec::new(), Vec::new());
        for entry in entries {
            let name = entry.file_name().unwrap_or_default().to_string_lossy();
            let own = entry
                .canonicalize()
                .is_ok_and(|e| self.outputs.contains(&e));
            if own || name.starts_with('.') {
                continue;
            }
            match (entry.is_dir(), self.kind) {
                (true, Kind::Sessions) => self.add(entry),
                (true, _) => folders.push(name.into_owned()),
                (false, _) if may_be_recording(&entry) => self.add(entry),
                (false, _) => others.push(name.into_owned()),
            }
        }
        let folder = path_text(folder);
        if !others.is_empty() {
            self.notes.push(format!(
                "{folder}: no recordings by their names, left out: {}",
                listed(&others)
            ));
        }
        if !folders.is_empty() {
            self.notes.push(format!(
                "{folder}: folders inside are not read: {}; \"{folder}/*/*\" names their files",
                listed(&folders)
            ));
        }
    }

    fn add(&mut self, path: PathBuf) {
        let place = path.canonicalize().unwrap_or_else(|_| path.clone());
        if self.seen.insert(place) {
            self.paths.push(path);
        } else {
            let path = path_text(&path);
            self.notes
                .push(format!("{path} is given twice; it is taken once"));
        }
    }
}

/// What a pattern stands for, in order; none for a path and for a pattern that nothing matches.
fn matching(text: &str, path: &Path) -> Option<Vec<PathBuf>> {
    if !text.contains(WILD) || path.exists() {
        return None;
    }
    let paths: Vec<PathBuf> = glob::glob(text).ok()?.filter_map(Result::ok).collect();
    (!paths.is_empty()).then_some(paths)
}

fn entries(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let mut entries = entries.collect::<io::Result<Vec<PathBuf>>>()?;
    entries.sort();
    Ok(entries)
}

fn listed(names: &[String]) -> String {
    let shown = names.iter().take(MOST_NAMES).cloned();
    let mut shown: Vec<String> = shown.collect();
    if names.len() > MOST_NAMES {
        shown.push(format!("and {} more", names.len() - MOST_NAMES));
    }
    shown.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn json(_: &Path) -> String {
        ".json".to_owned()
    }

    /// Files with these names in a new folder.
    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        folder
    }

    fn names(items: &Items) -> Vec<&str> {
        items.all.iter().map(|i| i.name.as_str()).collect()
    }

    #[test]
    fn a_folder_stands_for_its_entries() {
        let folder = folder(&[
            "b.csv",
            "a.csv.gz",
            ".hidden.csv",
            "notes.md",
            "unit-1/x.csv",
            "out/old.csv",
            "guided/session.ndjson",
        ]);
        let (at, out) = (folder.path(), folder.path().join("out"));
        let of = |kind| Items::of(&[at.to_owned()], kind, &[&out], Some(json)).unwrap();
        let sessions = of(Kind::Sessions);
        assert_eq!(names(&sessions), ["a", "b", "guided", "unit-1"]);
        assert_eq!(sessions.all[0].file.as_deref(), Some("a.json"));
        assert!(sessions.notes.len() == 1 && sessions.notes[0].ends_with("notes.md"));
        let recordings = of(Kind::Recordings);
        assert_eq!(names(&recordings), ["a", "b"]);
        assert!(
            recordings.notes[1].contains("guided, unit-1"),
            "{:?}",
            recordings.notes
        );
        // A guided session is one, wherever it is named.
        let one = Items::of(&[at.join("guided")], Kind::Sessions, &[], None).unwrap();
        assert_eq!(names(&one), ["guided"]);
    }

    #[test]
    fn shared_names_are_told_apart() {
        let folder = folder(&["u1/s.csv", "u2/S.csv", "u1/s.txt", "u1-s.csv", "t.csv"]);
        let at = |name: &str| folder.path().join(name);
        let paths = ["u1/s.csv", "u2/S.csv", "u1/s.txt", "u1-s.csv", "t.csv"].map(at);
        let items = Items::of(&paths, Kind::Sessions, &[], Some(json)).unwrap();
        assert_eq!(names(&items), ["u1-s-2", "u2-S", "u1-s-3", "u1-s", "t"]);
        assert!(items.notes[0].contains("u2-S"), "{:?}", items.notes);
    }

    #[test]
    fn patterns_lists_and_what_is_given_twice() {
        let folder = folder(&["a1.csv", "a2.csv", "b.csv"]);
        let at = |name: &str| folder.path().join(name);
        let list = at("list");
        let text = format!("# those of today\n\n{}\n", at("b.csv").display());
        fs::write(&list, text).unwrap();
        let listed = PathBuf::from(format!("@{}", list.display()));
        let arguments = [at("a*.csv"), listed, at("./a1.csv"), at("none*.csv")];
        let items = Items::of(&arguments, Kind::Sessions, &[], None).unwrap();
        assert_eq!(names(&items), ["a1", "a2", "b", "none*"]);
        assert!(items.notes.len() == 1 && items.notes[0].contains("twice"));
        let stdin = Items::of(&["-".into()], Kind::Sessions, &[], None).unwrap_err();
        assert_eq!(stdin.code(), "each-input");
        let empty = tempfile::tempdir().unwrap();
        let none = Items::of(&[empty.path().into()], Kind::Sessions, &[], None).unwrap_err();
        assert_eq!(none.code(), "no-recordings");
    }
}
