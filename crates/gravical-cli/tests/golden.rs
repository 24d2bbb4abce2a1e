//! The golden table: what some eighty runs of the program find, reduced to the numbers that
//! matter. A change that replaces how something is computed is judged by it: whatever moves beyond
//! the tolerance of its column is printed, and explained by whoever writes the table anew.
//!
//!     cargo test -p gravical-cli --test golden                     compare
//!     GRAVICAL_BLESS=1 cargo test -p gravical-cli --test golden    write `table.json` anew
//!
//! Runs on real recordings need `GRAVICAL_DATA` (and the folder `cases` beside it); they stand
//! under keys of their own and are skipped without. `GRAVICAL_BIN` compares another build.
#![allow(clippy::unwrap_used, clippy::panic)] // helpers of a test may panic as it does

#[path = "../../../tests/golden/columns.rs"]
mod columns;
#[path = "../../../tests/support/each.rs"]
mod each;
#[path = "../../../tests/golden/runs.rs"]
mod runs;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Map, Value, json};

use Tolerance::{Equal, Seconds, Share, Sigma};
use columns::{COLUMNS, Column, Tolerance};
use each::each;

/// Sums over a column of a table that was written.
const SUMS: Tolerance = Share(1e-9);

#[test]
fn nothing_moves_unseen() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden");
    let (path, folder) = (golden.join("table.json"), tempfile::tempdir().unwrap());
    let text = std::fs::read_to_string(&path).unwrap_or_else(|_| "{}".into());
    let mut table: BTreeMap<String, BTreeMap<String, Value>> = serde_json::from_str(&text).unwrap();
    let mut places = vec![
        ("{golden}", golden.clone()),
        ("{examples}", golden.join("../../examples")),
    ];
    if let Some(data) = std::env::var_os("GRAVICAL_DATA").map(PathBuf::from) {
        assert!(data.join("README.md").is_file(), "{}", data.display());
        places.extend([("{cases}", data.join("../cases")), ("{data}", data)]);
    }
    for line in runs::SIMULATED {
        let run = run(folder.path(), line, &places);
        assert!(run.0 == 0, "{line}");
    }
    let mut moved = Vec::new();
    for (section, needs, lines) in [
        ("simulated", "{examples}", runs::COMMANDS),
        ("recordings", "{data}", runs::RECORDINGS),
        ("cases", "{cases}", runs::CASES),
    ] {
        if !places.iter().any(|(name, _)| *name == needs) {
            println!("skipped: {section}, GRAVICAL_DATA is not set");
            continue;
        }
        let rows = rows(folder.path(), lines, &places);
        let old = table.insert(section.into(), rows.clone());
        let old = old.unwrap_or_default();
        for name in old.keys().chain(rows.keys()).collect::<BTreeSet<_>>() {
            moved.extend(differences(name, old.get(name), rows.get(name)));
        }
    }
    let blessed = std::env::var_os("GRAVICAL_BLESS").is_some();
    if blessed {
        std::fs::write(&path, one_line_each(&table)).unwrap();
    }
    for line in &moved {
        println!("{line}");
    }
    assert!(moved.is_empty() || blessed, "{} values moved", moved.len());
}

/// The table with a line for each row, so that a change shows as the lines that moved.
fn one_line_each(table: &BTreeMap<String, BTreeMap<String, Value>>) -> String {
    let section = |(name, rows): (&String, &BTreeMap<String, Value>)| {
        let row = |(k, v): (&String, &Value)| format!("  {}: {v}", Value::from(k.as_str()));
        let rows: Vec<String> = rows.iter().map(row).collect();
        let name = Value::from(name.as_str());
        format!("{name}: {{\n{}\n}}", rows.join(",\n"))
    };
    let sections: Vec<String> = table.iter().map(section).collect();
    format!("{{\n{}\n}}\n", sections.join(",\n"))
}

/// The rows of these command lines, run side by side.
fn rows(folder: &Path, lines: &[&str], places: &[(&str, PathBuf)]) -> BTreeMap<String, Value> {
    let run = |i: usize| (lines[i].to_owned(), row(folder, lines[i], places));
    each(lines.len(), run).into_iter().collect()
}

/// Exit code, standard output and the file written to `{out}`.
fn run(folder: &Path, line: &str, places: &[(&str, PathBuf)]) -> (i32, String, PathBuf) {
    let name = line.replace(|c: char| !c.is_alphanumeric(), "_");
    let name = &name[name.len().saturating_sub(150)..];
    let out = folder.join(name).with_extension("out");
    let words = line.split_whitespace().map(|word| {
        let word = word.replace("{out}", &out.display().to_string());
        let put =
            |w: String, (place, path): &(_, PathBuf)| w.replace(*place, path.to_str().unwrap());
        places.iter().fold(word, put)
    });
    let program = std::env::var_os("GRAVICAL_BIN");
    let program = program.unwrap_or_else(|| env!("CARGO_BIN_EXE_gravical").into());
    let mut run = Command::new(program);
    let run = run.args(words).current_dir(folder).output().unwrap();
    let code = run.status.code().unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(![1, 2, 101].contains(&code), "{line}\n{said}");
    (code, String::from_utf8(run.stdout).unwrap(), out)
}

fn row(folder: &Path, line: &str, places: &[(&str, PathBuf)]) -> Value {
    let (code, printed, out) = run(folder, line, places);
    let mut row = Map::new();
    row.insert("exit".into(), code.into());
    let verb = line.split(' ').next().unwrap();
    if line.contains(" --each ") {
        for column in ["grade", "bias", "scale"] {
            let each = files(&out).into_iter().filter_map(|file| {
                let result = serde_json::from_str(&std::fs::read_to_string(file).ok()?).ok()?;
                reduce("calibrate", &result).remove(column)
            });
            row.insert(column.into(), flatten(&each.collect::<Vec<_>>()).into());
        }
    } else if verb == "live" {
        let events = printed.lines().flat_map(serde_json::from_str::<Value>);
        let events: Vec<Value> = events.collect();
        let accepted = events.iter().filter(|e| e["type"] == "pose_accepted");
        row.insert("accepted".into(), accepted.count().into());
        let verdict = events.iter().rfind(|e| e["type"] == "verdict");
        let grade = verdict.map_or(Value::Null, |v| v["grade"].clone());
        row.insert("grade".into(), grade);
    } else if verb == "export" {
        row.insert("numbers".into(), exact_numbers(&printed).into());
    } else {
        let result = serde_json::from_str(&printed).unwrap_or_else(|e| panic!("{line}: {e}"));
        row.extend(reduce(verb, &result));
    }
    if out.is_file() {
        row.extend(sums(&out));
    }
    row.into()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let mut files: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    files.sort();
    files
}

/// The columns of a result.
fn reduce(verb: &str, result: &Value) -> Map<String, Value> {
    let mut row = Map::new();
    for Column(_, name, at, _) in COLUMNS.iter().filter(|c| c.0 == verb || c.0 == "*") {
        let mut values = Vec::new();
        collect(result, at.trim_start_matches('/').split('/'), &mut values);
        if *name == "faults" {
            values.sort_by_key(ToString::to_string);
            values.dedup();
        }
        if !values.is_empty() {
            row.insert((*name).into(), flatten(&values).into());
        }
    }
    if let Some(variances) = result.pointer("/accelerometer/covariance/values") {
        let sd = (0..9).filter_map(|i| Some(variances[i][i].as_f64()?.sqrt()));
        row.insert("matrix_sd".into(), sd.collect());
    }
    row
}

fn collect<'a>(
    value: &Value,
    mut path: impl Iterator<Item = &'a str> + Clone,
    into: &mut Vec<Value>,
) {
    match (path.next(), value) {
        (None, Value::Null) => {}
        (None, value) => into.push(value.clone()),
        (Some("#"), Value::Array(list)) => into.push(list.len().into()),
        (Some("*"), Value::Array(list)) => {
            list.iter().for_each(|v| collect(v, path.clone(), into));
        }
        (Some(key), Value::Array(list)) => {
            let entry = key.parse().ok().and_then(|i: usize| list.get(i));
            collect(entry.unwrap_or(&Value::Null), path, into);
        }
        (Some(key), value) => collect(value.get(key).unwrap_or(&Value::Null), path, into),
    }
}

/// The numbers, texts and truths in nested lists and objects, in their order.
fn flatten(values: &[Value]) -> Vec<Value> {
    let inner = |value: &Value| match value {
        Value::Array(list) => flatten(list),
        Value::Object(map) => flatten(&map.values().cloned().collect::<Vec<_>>()),
        other => vec![other.clone()],
    };
    values.iter().flat_map(inner).collect()
}

/// Sums and sums of squares of the numeric columns of a table; its first line has the names.
fn sums(path: &Path) -> Map<String, Value> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut sums = vec![[0.0; 2]; names.len()];
    for line in lines {
        for (sum, cell) in sums.iter_mut().zip(line.split(',')) {
            let v: f64 = cell.parse().unwrap_or(0.0);
            *sum = [sum[0] + v, sum[1] + v * v];
        }
    }
    let columns = names.iter().zip(sums).filter(|(_, s)| s[1] > 0.0);
    let columns = columns.map(|(name, s)| (format!("sum {name}"), json!(s)));
    columns.collect()
}

/// The numbers of a text that have six digits or more, each once, in order of size.
fn exact_numbers(text: &str) -> Vec<f64> {
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
    let is_exact = |w: &&str| w.contains('.') && w.bytes().filter(u8::is_ascii_digit).count() > 6;
    let words = words.map(|w| w.trim_end_matches('f')).filter(is_exact);
    let mut numbers: Vec<f64> = words.filter_map(|w| w.parse().ok()).collect();
    numbers.sort_by(f64::total_cmp);
    numbers.dedup_by(|a, b| (*a - *b).abs() <= 1e-6 * b.abs());
    numbers
}

/// What moved, a line each.
fn differences(name: &str, old: Option<&Value>, new: Option<&Value>) -> Vec<String> {
    let (Some(old), Some(new)) = (old, new) else {
        let what = old.map_or("new", |_| "no longer run");
        return vec![format!("{name}: {what}")];
    };
    let (old, new) = (old.as_object().unwrap(), new.as_object().unwrap());
    let mut moved = Vec::new();
    for column in old.keys().chain(new.keys()).collect::<BTreeSet<_>>() {
        let entries =
            |row: &Map<String, Value>| flatten(row.get(column).map_or(&[], std::slice::from_ref));
        let (before, after) = (entries(old), entries(new));
        let allowed = |i: usize| allowed(name, column, old, &before, i);
        let is_same = |i: usize| match (before[i].as_f64(), after[i].as_f64()) {
            (Some(a), Some(b)) => (a - b).abs() <= allowed(i),
            _ => before[i] == after[i],
        };
        if before.len() != after.len() || !(0..before.len()).all(is_same) {
            let [before, after] = [before, after].map(|v| Value::from(v).to_string());
            let now = "now";
            moved.push(format!(
                "{name}\n    {column:<15} {before}\n    {now:<15} {after}"
            ));
        }
    }
    moved
}

/// By how much entry `i` of a column may differ.
fn allowed(name: &str, column: &str, row: &Map<String, Value>, values: &[Value], i: usize) -> f64 {
    let verb = name.split(' ').next().unwrap();
    let is_it = |c: &&Column| (c.0 == verb || c.0 == "*") && c.1 == column;
    let exact = Share(1e-6);
    let tolerance = match COLUMNS.iter().find(is_it) {
        Some(known) => &known.3,
        None if column.starts_with("sum ") => &SUMS,
        None => &exact,
    };
    // Of a vector: its largest entry, so that one near zero need not be exact.
    let numbers = values.iter().filter_map(Value::as_f64);
    let largest = numbers.map(f64::abs).fold(0.0, f64::max);
    match tolerance {
        Equal => 0.0,
        Seconds(s) => *s,
        Share(share) => share * largest,
        Sigma(of) => {
            let sigma = row.get(*of).and_then(|s| s.get(i)).and_then(Value::as_f64);
            sigma.map_or(1e-6 * largest, |s| 0.1 * s)
        }
    }
}
