//! What items and their results are called.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use super::journal::Item;
use crate::session::ENDINGS;

/// The ending of a result, with the dot, from the path of its item.
pub type Ending = fn(&Path) -> String;

/// The ending of the results of `command`; none if they are rows alone.
#[must_use]
pub fn ending_of(command: &str) -> Option<Ending> {
    match command {
        "calibrate" | "noise" => Some(|_| ".json".to_owned()),
        "apply" => Some(unpacked),
        _ => None,
    }
}

/// Endings of recordings that are no table.
const BINARY: [&str; 1] = ["cwa"];

/// The ending of the recording, unpacked.
fn unpacked(path: &Path) -> String {
    let plain = match path.extension() {
        Some(e) if e.eq_ignore_ascii_case("gz") => path.with_extension(""),
        _ => path.to_owned(),
    };
    match plain.extension() {
        // What is written is text, whatever is read.
        Some(e) if !BINARY.iter().any(|b| e.eq_ignore_ascii_case(b)) => {
            format!(".{}", e.to_string_lossy())
        }
        _ => ".csv".to_owned(),
    }
}

/// Name of a file without the endings of recordings; a folder keeps all of its name.
fn stem(path: &Path) -> String {
    let whole = match path.file_name() {
        Some(name) => name.to_string_lossy().into_owned(),
        // Such as `..`.
        None => path
            .canonicalize()
            .ok()
            .and_then(|p| Some(p.file_name()?.to_string_lossy().into_owned()))
            .unwrap_or_else(|| "session".to_owned()),
    };
    if path.is_dir() {
        return whole;
    }
    let without = |name: &str| {
        let (stem, ending) = name.rsplit_once('.')?;
        let known = ENDINGS.iter().any(|e| ending.eq_ignore_ascii_case(e));
        (known && !stem.is_empty()).then(|| stem.to_owned())
    };
    // `x.csv.gz`
    let once = without(&whole).unwrap_or(whole);
    without(&once).unwrap_or(once)
}

/// Gives each path a name of its own. Those that would share a name get that of their folder in
/// front, and a number where that does not help: they are returned, too. Results get the name of their
/// item and the ending that `ending` makes of its path; none without.
#[must_use]
pub fn named(paths: Vec<PathBuf>, ending: Option<Ending>) -> (Vec<Item>, Vec<Item>) {
    let ending = |path: &Path| ending.map(|ending| ending(path));
    // File systems that ignore case take `A.json` and `a.json` for one file.
    let key = |name: &str, path: &Path| {
        let ending = ending(path).unwrap_or_default();
        format!("{}{ending}", name.to_lowercase())
    };
    let mut stems: Vec<String> = paths.iter().map(|p| stem(p)).collect();
    let mut uses: HashMap<String, usize> = HashMap::new();
    for (stem, path) in stems.iter().zip(&paths) {
        *uses.entry(key(stem, path)).or_default() += 1;
    }
    let (mut taken, mut renamed) = (HashSet::new(), Vec::new());
    // The number that a name has reached: with thousands of one name, none is tried twice.
    let mut numbers: HashMap<String, usize> = HashMap::new();
    for (renamed_at, (stem, path)) in stems.iter_mut().zip(&paths).enumerate() {
        let shared = uses[&key(stem, path)] > 1;
        if shared && let Some(folder) = folder_name(path) {
            *stem = format!("{folder}-{stem}");
        }
        let plain = stem.clone();
        let number = numbers.entry(key(&plain, path)).or_insert(1);
        // A name that others have from the start stays theirs.
        while taken.contains(&key(stem, path))
            || (*stem != plain || shared) && uses.contains_key(&key(stem, path))
        {
            *number += 1;
            *stem = format!("{plain}-{number}");
        }
        taken.insert(key(stem, path));
        if shared {
            renamed.push(renamed_at);
        }
    }
    let items = paths.into_iter().zip(stems);
    let items: Vec<Item> = items
        .map(|(path, name)| Item {
            file: ending(&path).map(|ending| format!("{name}{ending}")),
            name,
            path,
        })
        .collect();
    let renamed = renamed.into_iter().map(|i: usize| items[i].clone());
    let renamed = renamed.collect();
    (items, renamed)
}

fn folder_name(path: &Path) -> Option<String> {
    let folder = path.canonicalize().ok()?;
    let name = folder.parent()?.file_name()?;
    Some(name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_not_packed() {
        for (path, own) in [
            ("a.csv", ".csv"),
            ("a.TXT", ".TXT"),
            ("a.csv.gz", ".csv"),
            ("a.cwa", ".csv"),
            ("a.CWA.gz", ".csv"),
            ("a.gz", ".csv"),
            ("a", ".csv"),
        ] {
            assert_eq!(unpacked(Path::new(path)), own, "{path}");
        }
    }
}
