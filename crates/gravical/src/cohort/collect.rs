//! What all runs over many recordings that wrote into one folder say together.
//!
//! Rows stay in the journals: of each item only where its row is is kept, and of each column its
//! numbers.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::content::Stamp;
use super::journal::{Line, List, Origin, Shard, is_there, journals, parse_line, read_lines};
use super::row::{Row, Status};
use super::values::{COMMANDS, CommandColumns};
use crate::calibration_file::CalibrationFile;
use crate::compare::{Stability, history};
use crate::escape::path_text;
use crate::numfmt::count;
use crate::stats::quantile;
use crate::store::time_of;
use crate::{Error, Result, TOOL};

/// Format of the JSON.
const COHORT_FORMAT: &str = "gravical-cohort/1";
/// Names listed with each code of an error.
const MOST_EXAMPLES: usize = 5;
/// Calibrations of one sensor that are tested at most.
const MOST_TESTED: usize = 1000;
/// Number of the worst items that are listed.
const MOST_WORST: usize = 10;
/// Number of shards without a journal that are listed.
const MOST_SHARDS: usize = 1000;
/// Code of an item without a row, and of one whose result is gone.
const MISSING: &str = "missing";

/// Values of a row of any command.
pub type AnyValues = Map<String, Value>;

/// Many recordings, as one result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cohort {
    /// `gravical-cohort/1`.
    pub format: String,
    /// Program and version that collected.
    pub tool: String,
    /// Folder of the results.
    pub folder: String,
    /// The command whose results these are.
    pub command: String,
    /// Number of journals.
    pub journals: usize,
    /// What became of the items.
    pub counts: CohortCounts,
    /// Shards of which there is no journal, while items are unknown.
    pub missing_shards: Vec<Shard>,
    /// The errors by their codes, the most frequent first.
    pub errors: Vec<ErrorCount>,
    /// Versions and options with which results were made, the most frequent first: more than one
    /// means that the results do not come from the same computation.
    pub origins: Vec<OriginCount>,
    /// Of each column of numbers.
    pub distributions: Vec<Distribution>,
    /// The column by which the worst are found, and its unit.
    pub worst_by: String,
    /// Its unit.
    pub worst_unit: String,
    /// The items with the largest values of that column.
    pub worst: Vec<WorstItem>,
    /// Number of sensors with several calibrations.
    pub repeated_sensors: u64,
    /// Those that changed.
    pub changed_sensors: Vec<ChangedSensor>,
    /// Calibrations of these sensors that could not be read, with the reason.
    pub unreadable: Vec<String>,
    /// The values of the distributions, sorted; not part of the JSON.
    #[serde(skip)]
    pub sorted: BTreeMap<String, Vec<f64>>,
}

/// How many items came to which end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CohortCounts {
    /// All that are known or announced.
    pub items: u64,
    /// Results that can be used.
    pub done: u64,
    /// Results that failed their quality gate.
    pub poor: u64,
    /// No result, with the reason.
    pub error: u64,
    /// Not begun, interrupted, or a result that is gone.
    pub missing: u64,
    /// Of the missing ones those that no journal names: of shards that were not begun.
    pub unnamed: u64,
}

/// An error with its number.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ErrorCount {
    /// Its code.
    pub code: String,
    /// Number of items.
    pub items: u64,
    /// Names of the first ones.
    pub examples: Vec<String>,
    /// Message of the first one.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
}

/// Version and options, with the number of their results.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct OriginCount {
    /// Program and version.
    pub tool: String,
    /// Options.
    pub options: Vec<String>,
    /// Number of results.
    pub items: u64,
}

/// Distribution of one column over all results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Distribution {
    /// Name of the column, as in a summary.
    pub name: String,
    /// Its unit; that of most results if they have different ones.
    pub unit: String,
    /// Number of values in that unit.
    pub values: u64,
    /// Number of values in other units, which do not count.
    pub in_other_units: u64,
    /// Smallest and largest value, and those below which 5, 25, 50, 75 and 95 % lie.
    pub min: f64,
    #[allow(missing_docs)]
    pub q05: f64,
    #[allow(missing_docs)]
    pub q25: f64,
    #[allow(missing_docs)]
    pub median: f64,
    #[allow(missing_docs)]
    pub q75: f64,
    #[allow(missing_docs)]
    pub q95: f64,
    #[allow(missing_docs)]
    pub max: f64,
}

impl Distribution {
    /// Of sorted values in one unit; at least one.
    fn of(name: &str, unit: &str, sorted: &[f64], in_other_units: u64) -> Option<Self> {
        let q = |p| quantile(sorted, p);
        Some(Distribution {
            name: name.to_owned(),
            unit: unit.to_owned(),
            values: sorted.len() as u64,
            in_other_units,
            min: q(0.0)?,
            q05: q(0.05)?,
            q25: q(0.25)?,
            median: q(0.5)?,
            q75: q(0.75)?,
            q95: q(0.95)?,
            max: q(1.0)?,
        })
    }
}

/// One of the worst items.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WorstItem {
    /// Its name.
    pub name: String,
    /// Its path as given.
    pub path: String,
    /// File of its result.
    pub result: Option<String>,
    /// Verdict of the command.
    pub verdict: Option<String>,
    /// The value of the column.
    pub value: f64,
}

/// A sensor whose calibrations differ by more than their uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChangedSensor {
    /// The sensor.
    pub sensor_id: String,
    /// Names of the items, in order of time.
    pub items: Vec<String>,
    /// Why it is said to have changed.
    pub reasons: Vec<String>,
}

/// Where the row of an item is.
#[derive(Debug, Clone)]
struct Place {
    journal: usize,
    at: u64,
    length: usize,
    status: Status,
    /// Which of the origins.
    origin: usize,
    /// File of the result, and its stamp.
    file: Option<String>,
    stamp: Option<Stamp>,
}

/// What is known of an item.
#[derive(Debug, Clone)]
enum State {
    /// It has a row.
    Row(Place),
    /// It is planned or begun, under this path.
    Open(String),
}

/// The journals of a folder.
#[derive(Debug)]
pub struct Gathered {
    folder: PathBuf,
    table: CommandColumns,
    journals: Vec<PathBuf>,
    items: BTreeMap<String, State>,
    origins: Vec<Origin>,
    /// The shards of each list of recordings.
    lists: BTreeMap<List, Shards>,
}

/// The shards of a list that were begun, by how many there are; without shards it is the only one.
type Shards = BTreeMap<u32, BTreeSet<Shard>>;

impl Gathered {
    /// Reads the journals in `folder`, of `command` if they are of several.
    ///
    /// # Errors
    ///
    /// `no-journal` if there is none; `collect-command` (usage) if they are of several commands and none
    /// is given; `journal-syntax`; errors of the file system.
    pub fn read(folder: &Path, command: Option<&str>) -> Result<Self> {
        let mut paths = Vec::new();
        for path in journals(folder)? {
            let changed = fs::metadata(&path).and_then(|m| m.modified());
            paths.push((changed.ok(), path));
        }
        // What was written last counts.
        paths.sort();
        let paths: Vec<PathBuf> = paths.into_iter().map(|(_, path)| path).collect();
        let mut commands = BTreeSet::new();
        let mut of_command = Vec::new();
        for path in paths {
            let Some(own) = command_of(&path)? else {
                continue;
            };
            if command.is_none_or(|c| c == own) {
                of_command.push(path);
            }
            commands.insert(own);
        }
        let table = table_of(folder, command, &commands)?;
        let mut gathered = Gathered {
            folder: folder.to_owned(),
            table,
            journals: of_command,
            items: BTreeMap::new(),
            origins: Vec::new(),
            lists: BTreeMap::new(),
        };
        for journal in 0..gathered.journals.len() {
            gathered.journal(journal)?;
        }
        Ok(gathered)
    }

    fn journal(&mut self, journal: usize) -> Result<()> {
        let path = self.journals[journal].clone();
        let file = File::open(&path).map_err(|e| Error::io(&path, e))?;
        let mut origin = 0;
        read_lines::<IgnoredAny>(&path, file, |line, at, length| {
            match line {
                Line::Run {
                    origin: own,
                    shard,
                    list,
                } => {
                    origin = self.origin(own);
                    if let Some(list) = list {
                        let shard = shard.unwrap_or(Shard { number: 1, of: 1 });
                        let shards = self.lists.entry(list).or_default();
                        shards.entry(shard.of).or_default().insert(shard);
                    }
                }
                Line::Planned { name, path } => {
                    self.items.entry(name).or_insert(State::Open(path));
                }
                Line::Done {
                    name,
                    file,
                    stamp,
                    status,
                    ..
                } => {
                    // A failure elsewhere does not take a result away, and of two journals that one
                    // is right whose result is there.
                    let there = |file: Option<&str>, stamp| is_there(&self.folder, file, stamp);
                    let keeps = |known: &State| match known {
                        State::Row(place) if place.journal != journal => {
                            place.status != Status::Error && status == Status::Error
                                || there(place.file.as_deref(), place.stamp)
                                    && !there(file.as_deref(), stamp)
                        }
                        _ => false,
                    };
                    if !self.items.get(&name).is_some_and(keeps) {
                        let place = Place {
                            journal,
                            at,
                            length,
                            status,
                            origin,
                            file,
                            stamp,
                        };
                        self.items.insert(name, State::Row(place));
                    }
                }
                Line::Begin { .. } | Line::Summary { .. } => {}
            }
            Ok(())
        })?;
        Ok(())
    }

    fn origin(&mut self, origin: Origin) -> usize {
        let key = origin.key();
        let known = self.origins.iter().position(|o| o.key() == key);
        known.unwrap_or_else(|| {
            self.origins.push(origin);
            self.origins.len() - 1
        })
    }

    /// The command, and its columns in a table.
    #[must_use]
    pub fn table(&self) -> &CommandColumns {
        &self.table
    }

    /// The options of the results; empty if they are of several runs with different ones.
    #[must_use]
    pub fn options(&self) -> &[String] {
        match &self.origins[..] {
            [one] => &one.options,
            _ => &[],
        }
    }

    /// Calls `take` with each row, in order of the names; a missing item has a row with the code
    /// `missing`. Returns what all of them say.
    ///
    /// # Errors
    ///
    /// Errors of reading and those of `take`.
    pub fn summarise(&self, mut take: impl FnMut(&Row<AnyValues>) -> Result<()>) -> Result<Cohort> {
        let mut sums = Sums::default();
        for (name, state) in &self.items {
            let row = match state {
                State::Row(place) => {
                    let mut row = self.row(place)?;
                    // As it is reached from here, which may be another machine.
                    let result = place.file.as_ref().map(|f| self.folder.join(f));
                    row.result = row.result.and(result.as_deref().map(path_text));
                    let gone = place.file.as_ref().filter(|file| {
                        place.status != Status::Error && !self.folder.join(file).exists()
                    });
                    match gone {
                        Some(file) => {
                            missing(name, &row.path, &format!("its result {file} is gone"))
                        }
                        None => {
                            *sums.origins.entry(place.origin).or_default() += 1;
                            row
                        }
                    }
                }
                State::Open(path) => {
                    missing(name, path, "it was not begun, or its run was interrupted")
                }
            };
            sums.add(&row, &self.table);
            take(&row)?;
        }
        self.cohort(sums)
    }

    fn row(&self, place: &Place) -> Result<Row<AnyValues>> {
        let path = &self.journals[place.journal];
        let mut line = vec![0; place.length];
        let read = |line: &mut [u8]| {
            let mut file = File::open(path)?;
            file.seek(SeekFrom::Start(place.at))?;
            file.read_exact(line)
        };
        read(&mut line).map_err(|e| Error::io(path, e))?;
        match serde_json::from_slice(&line) {
            Ok(Line::Done { row, .. }) => Ok(row),
            _ => Err(
                Error::input("changed", "the journal changed while it was read")
                    .at(path, None)
                    .with_hint("collect again"),
            ),
        }
    }

    /// Items that no journal names, and the shards to which they belong.
    fn not_begun(&self) -> (u64, Vec<Shard>) {
        let (mut items, mut missing) = (0, Vec::new());
        for (List { items: all, .. }, shards) in &self.lists {
            // A list may have been shared out several times: the time counts that is nearest to its end.
            let absent = shards.iter().map(|(of, begun)| {
                let every = (1..=*of).map(|number| Shard { number, of: *of });
                let absent: Vec<Shard> = every.filter(|s| !begun.contains(s)).collect();
                (absent.iter().map(|s| s.count(*all)).sum::<u64>(), absent)
            });
            if let Some((count, absent)) = absent.min_by_key(|(count, _)| *count) {
                items += count;
                missing.extend(absent.into_iter().filter(|s| s.count(*all) > 0));
            }
        }
        // A journal may end before its list does.
        let announced = self.lists.keys().map(|list| list.items).max().unwrap_or(0);
        let known = self.items.len() as u64;
        // A list that is done and has all that is known grew out of the others.
        let is_done =
            |shards: &Shards| shards.iter().any(|(of, begun)| begun.len() == *of as usize);
        let has_all = |(list, shards): (&List, &Shards)| list.items == known && is_done(shards);
        if self.lists.iter().any(has_all) {
            return (0, Vec::new());
        }
        (items.max(announced.saturating_sub(known)), missing)
    }

    fn cohort(&self, mut sums: Sums) -> Result<Cohort> {
        let (unnamed, mut missing_shards) = self.not_begun();
        sums.counts.items = self.items.len() as u64 + unnamed;
        sums.counts.missing += unnamed;
        sums.counts.unnamed = unnamed;
        missing_shards.truncate(MOST_SHARDS);
        let mut origins: Vec<OriginCount> = sums
            .origins
            .iter()
            .map(|(origin, items)| OriginCount {
                tool: self.origins[*origin].tool.clone(),
                options: self.origins[*origin].options.clone(),
                items: *items,
            })
            .collect();
        origins.sort_by_key(|o| std::cmp::Reverse(o.items));
        let mut errors: Vec<ErrorCount> = sums.errors.into_values().collect();
        errors.sort_by(|a, b| b.items.cmp(&a.items).then_with(|| a.code.cmp(&b.code)));
        let (mut distributions, mut sorted) = (Vec::new(), BTreeMap::new());
        for name in self.table.names {
            let Some(mut units) = sums.columns.remove(name) else {
                continue;
            };
            let all: usize = units.values().map(Vec::len).sum();
            let most = units.iter().max_by_key(|(_, values)| values.len());
            let Some((unit, mut values)) = most
                .map(|(unit, _)| unit.clone())
                .and_then(|unit| units.remove_entry(&unit))
            else {
                continue;
            };
            values.sort_unstable_by(f64::total_cmp);
            let others = (all - values.len()) as u64;
            distributions.extend(Distribution::of(name, &unit, &values, others));
            sorted.insert((*name).to_owned(), values);
        }
        let repeated = sums.sensors.iter().filter(|(_, items)| items.len() > 1);
        let repeated_sensors = repeated.clone().count() as u64;
        let (mut changed_sensors, mut unreadable) = (Vec::new(), Vec::new());
        for (sensor_id, items) in repeated {
            changed_sensors.extend(self.changed(sensor_id, items, &mut unreadable));
        }
        Ok(Cohort {
            format: COHORT_FORMAT.to_owned(),
            tool: TOOL.to_owned(),
            folder: self.folder.display().to_string(),
            command: self.table.command.to_owned(),
            journals: self.journals.len(),
            counts: sums.counts,
            missing_shards,
            errors,
            origins,
            distributions,
            worst_by: self.table.worst.to_owned(),
            worst_unit: self.table.worst_unit.to_owned(),
            worst: sums.worst,
            repeated_sensors,
            changed_sensors,
            unreadable,
            sorted,
        })
    }

    /// Whether a sensor changed between its calibrations; of very many the last ones are tested.
    fn changed(
        &self,
        sensor_id: &str,
        items: &[String],
        unreadable: &mut Vec<String>,
    ) -> Option<ChangedSensor> {
        let mut files = Vec::new();
        for name in items.iter().rev().take(MOST_TESTED) {
            let Some(State::Row(Place {
                file: Some(file), ..
            })) = self.items.get(name)
            else {
                continue;
            };
            let read = CalibrationFile::read(&self.folder.join(file));
            match read.and_then(|file| Ok((time_of(&file)?.0, file))) {
                Ok((time, file)) => files.push((time, name.clone(), file)),
                Err(error) => unreadable.push(error.to_string()),
            }
        }
        files.sort_by(|a, b| (a.0, &a.1).cmp(&(b.0, &b.1)));
        let named: Vec<(&CalibrationFile, &str)> = files
            .iter()
            .map(|(_, name, file)| (file, name.as_str()))
            .collect();
        let verdict = history(&named).verdict;
        (verdict.judgement == Stability::Changed).then(|| ChangedSensor {
            sensor_id: sensor_id.to_owned(),
            items: named.iter().map(|(_, name)| (*name).to_owned()).collect(),
            reasons: verdict.reasons,
        })
    }
}

/// Sums over all rows.
#[derive(Debug, Default)]
struct Sums {
    counts: CohortCounts,
    errors: HashMap<String, ErrorCount>,
    origins: BTreeMap<usize, u64>,
    /// Values of each column, by their unit.
    columns: HashMap<&'static str, BTreeMap<String, Vec<f64>>>,
    worst: Vec<WorstItem>,
    /// The items of each sensor with a result.
    sensors: BTreeMap<String, Vec<String>>,
}

impl Sums {
    fn add(&mut self, row: &Row<AnyValues>, table: &CommandColumns) {
        match row.status {
            Status::Done => self.counts.done += 1,
            Status::Poor => self.counts.poor += 1,
            Status::Error if row.error_code.as_deref() == Some(MISSING) => {
                self.counts.missing += 1;
            }
            Status::Error => self.counts.error += 1,
        }
        if let Some(code) = &row.error_code {
            let error = self
                .errors
                .entry(code.clone())
                .or_insert_with(|| ErrorCount {
                    code: code.clone(),
                    items: 0,
                    examples: Vec::new(),
                    message: row.reason.clone().unwrap_or_default(),
                    hint: row.hint.clone(),
                });
            error.items += 1;
            if error.examples.len() < MOST_EXAMPLES {
                error.examples.push(row.name.clone());
            }
        }
        let Some(values) = row.values.as_ref().filter(|_| row.status != Status::Error) else {
            return;
        };
        let text = |name: &str| values.get(name).and_then(Value::as_str);
        if let Some(id) = text("sensor_id") {
            let items = self.sensors.entry(id.to_owned()).or_default();
            items.push(row.name.clone());
        }
        for &name in table.names {
            if let Some(value) = values.get(name).and_then(Value::as_f64) {
                let units = self.columns.entry(name).or_default();
                units.entry(table.unit(name, text)).or_default().push(value);
            }
        }
        if let Some(value) = values.get(table.worst).and_then(Value::as_f64) {
            let at = self.worst.partition_point(|w| w.value >= value);
            if at < MOST_WORST {
                let item = WorstItem {
                    name: row.name.clone(),
                    path: row.path.clone(),
                    result: row.result.clone(),
                    verdict: row.verdict.clone(),
                    value,
                };
                self.worst.insert(at, item);
                self.worst.truncate(MOST_WORST);
            }
        }
    }
}

/// The row of an item without one.
fn missing(name: &str, path: &str, why: &str) -> Row<AnyValues> {
    Row {
        path: path.to_owned(),
        reason: Some(why.to_owned()),
        error_code: Some(MISSING.to_owned()),
        hint: Some("run again with --resume: what is done is skipped".to_owned()),
        ..Row::of(name, Status::Error)
    }
}

/// The command of a journal; none while its first line is being written.
fn command_of(path: &Path) -> Result<Option<String>> {
    let mut first = Vec::new();
    let file = File::open(path).map_err(|e| Error::io(path, e))?;
    let read = BufReader::new(file).read_until(b'\n', &mut first);
    read.map_err(|e| Error::io(path, e))?;
    if first.last() != Some(&b'\n') {
        return Ok(None);
    }
    match parse_line::<IgnoredAny>(path, 1, &first)? {
        Line::Run { origin, .. } => Ok(Some(origin.command)),
        _ => Ok(None),
    }
}

fn table_of(
    folder: &Path,
    command: Option<&str>,
    found: &BTreeSet<String>,
) -> Result<CommandColumns> {
    let listed = || {
        found
            .iter()
            .map(String::as_str)
            .collect::<Vec<_>>()
            .join(", ")
    };
    let name = match (command, found.len()) {
        (Some(command), _) if found.contains(command) => command,
        (None, 1) => found.first().map_or("", |c| c.as_str()),
        (None, n) if n > 1 => {
            return Err(Error::usage(
                "collect-command",
                format!(
                    "this folder has results of {}: {}",
                    count(n, "command"),
                    listed()
                ),
            )
            .at(folder, None)
            .with_hint("choose one with --command"));
        }
        _ => {
            let of = command.map(|c| format!(" of {c}")).unwrap_or_default();
            let others = match found.is_empty() {
                true => String::new(),
                false => format!("; there are those of {}", listed()),
            };
            return Err(Error::input(
                "no-journal",
                format!("there is no journal{of} in this folder{others}"),
            )
            .at(folder, None)
            .with_hint("name the folder that a run with --each wrote into (its -o)"));
        }
    };
    COMMANDS
        .into_iter()
        .find(|t| t.command == name)
        .ok_or_else(|| {
            Error::input(
                "journal-syntax",
                format!("a journal of an unknown command: {name}"),
            )
            .at(folder, None)
            .with_hint("it is of a newer version: collect with that one")
        })
}
