//! Many inputs in one run: `--each`, and `apply` with several recordings.
//!
//! Each input is what the command alone would do with it. One that fails is a row of the summary
//! and does not stop the others.

use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::File;
use std::io::{self, IsTerminal as _, Read as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use gravical::escape::{one_line, path_text};
use gravical::live::folder::is_session;
use gravical::numfmt::count;
use gravical::output::{make_folder, write_atomic};
use gravical::recording::max_bytes;
use gravical::recording::source::{ENDINGS, entries};
use gravical::session::{may_be_recording, session_name};
use gravical::targets::{SUMMARY_COLUMNS, check_targets, is_summary, place, same_target};
use gravical::{Error, Result};
use gravical_report::figure;
use gravical_report::figure::sessions::Session;
use gravical_report::report;

use crate::failure::{RenderedError, quality};
use crate::report::{with_origin, write_report};
use crate::{crash, progress, text};

#[derive(Debug, Default, clap::Args)]
#[command(next_help_heading = "Many sessions")]
pub struct EachArgs {
    /// Take each path, entry of a folder or line of @LIST as a session
    #[arg(long)]
    pub each: bool,
    /// Table (CSV), one row for each session
    #[arg(long, hide_short_help = true, value_name = "FILE")]
    pub summary: Option<PathBuf>,
    /// Skip sessions whose result is newer than the session
    #[arg(long, hide_short_help = true)]
    pub resume: bool,
    /// Every N-th session from the I-th: 1/8 to 8/8
    #[arg(long, hide_short_help = true, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<(usize, usize)>,
    /// Sessions at a time [default: one for each core]
    #[arg(
        long,
        hide_short_help = true,
        value_name = "N",
        value_parser = clap::value_parser!(u16).range(1..)
    )]
    pub threads: Option<u16>,
}

/// One of several runs over the same inputs, from 1, and how many they are.
fn parse_shard(text: &str) -> Result<(usize, usize), String> {
    let parts = text.split_once('/');
    let parts: Option<(usize, usize)> =
        parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    parts
        .filter(|(index, count)| (1..=*count).contains(index))
        .ok_or_else(|| "1/8 to 8/8 are the eight parts of a run".to_owned())
}

impl EachArgs {
    fn threads(&self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.map_or_else(cores, usize::from)
    }

    /// Memory that each of the recordings that are read at once may take, bytes.
    pub fn max_bytes(&self) -> u64 {
        max_bytes() / self.threads().max(1) as u64
    }

    /// Refuses options of `--each` without it.
    ///
    /// # Errors
    ///
    /// `each-option` (usage).
    pub fn refuse_alone(&self) -> Result<()> {
        let given = [
            ("--summary", self.summary.is_some()),
            ("--resume", self.resume),
            ("--shard", self.shard.is_some()),
            ("--threads", self.threads.is_some()),
        ];
        let hint = "add --each: then each path is a session of its own";
        refuse(&given, "this belongs to a run over many sessions", hint)
    }

    /// Refuses options that have no meaning for many sessions.
    ///
    /// # Errors
    ///
    /// `each-option` (usage).
    pub fn refuse_beside(options: &[(&str, bool)]) -> Result<()> {
        let hint = "leave it out, or run the command for one session without --each";
        refuse(options, "this belongs to one session, not to many", hint)
    }
}

/// Refuses the first of these options that is given.
///
/// # Errors
///
/// `each-option` (usage).
fn refuse(options: &[(&str, bool)], why: &str, hint: &str) -> Result<()> {
    let given = options.iter().find(|(_, given)| *given);
    given.map_or(Ok(()), |(option, _)| {
        let error = Error::usage("each-option", format!("{option}: {why}"));
        Err(error.with_hint(hint))
    })
}

/// A run over many inputs.
pub struct Plan<'a> {
    pub each: &'a EachArgs,
    pub inputs: &'a [PathBuf],
    /// Files that every input is read with: a calibration, noise, sections.
    pub shared: Vec<PathBuf>,
    /// A folder inside of a folder is an input, too.
    pub folders: bool,
    /// Folder of the results.
    pub output: Option<&'a Path>,
    /// Ending of a result, with the dot.
    pub ending: &'static str,
    /// The page of all; those of the sessions are in a folder of its name beside it.
    pub report: Option<&'a Path>,
    /// Columns of the summary behind the common ones.
    pub numbers: &'a [&'static str],
    pub force: bool,
    pub quiet: bool,
}

/// What the command found of one input: a row of the summary.
#[derive(Default)]
pub struct Outcome {
    /// Its verdict.
    pub grade: String,
    /// The verdict fails the quality gate.
    pub is_poor: bool,
    /// Reasons of the verdict, the main one first.
    pub reasons: Vec<String>,
    /// Values of [`Plan::numbers`].
    pub numbers: Vec<String>,
    /// What the page of all says besides.
    pub session: Session,
    /// Code and hint of the error, if it failed.
    pub error_code: String,
    pub hint: String,
}

/// One input: its path, and where its result and its page go.
pub struct Item {
    pub path: PathBuf,
    pub result: Option<PathBuf>,
    pub page: Option<PathBuf>,
}

/// Calls `work` for every input on several threads. For `--resume`, `read` gives the outcome in a result of an earlier run,
/// if it is that of the input.
///
/// # Errors
///
/// What concerns all inputs: none at all, targets, the summary.
pub fn run(
    plan: &Plan<'_>,
    work: impl Fn(&Item) -> anyhow::Result<Outcome> + Sync,
    read: impl Fn(&Path, &Path) -> Option<Outcome> + Sync,
) -> anyhow::Result<ExitCode> {
    let (given, lists) = given(plan.inputs)?;
    let (paths, repeated) = paths(plan, &given)?;
    let force = plan.force || plan.each.resume;
    let mut items = named(paths.clone(), plan)?;
    if let Some((index, count)) = plan.each.shard {
        items = items.into_iter().skip(index - 1).step_by(count).collect();
    }
    for folder in plan.output.into_iter().chain(plan.pages().as_deref()) {
        make_folder(folder)?;
    }
    let targets = items.iter().flat_map(|item| [&item.result, &item.page]);
    let targets = targets.flatten().chain(&plan.each.summary).cloned();
    let targets: Vec<PathBuf> = targets.chain(plan.report.map(Path::to_owned)).collect();
    let inputs = [&plan.shared, &lists, &given, &paths].map(Vec::as_slice);
    check_targets(&targets, &inputs.concat(), force)?;
    for (path, same) in repeated {
        text::say(&format!("note: {path} is {same}, which is read once"));
    }
    let widths = items.iter().map(|i| path_text(&i.path).chars().count());
    let width = widths.max().unwrap_or(0).min(40);
    let bar = progress::of_sessions(items.len());
    let threads = plan.each.threads();
    let next = AtomicUsize::new(0);
    let mut rows = BTreeMap::new();
    let one = |item: &Item| {
        let (path, result) = (&item.path, item.result.as_deref());
        let has_page = || item.page.as_deref().is_none_or(Path::exists);
        let is_done =
            |result: &&Path| plan.each.resume && has_page() && is_newer(result, path, &plan.shared);
        let done = crash::guarded(|| {
            let before = result.filter(is_done).and_then(|result| read(result, path));
            before.map_or_else(|| work(item), Ok)
        });
        done.unwrap_or_else(|panic| Err(anyhow::anyhow!("a defect of the program: {panic}")))
            .unwrap_or_else(|error| Outcome::failed(&error))
    };
    let (send, done) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..threads.min(items.len()) {
            let (send, next, items, one) = (send.clone(), &next, &items, &one);
            scope.spawn(move || {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(at) else { return };
                    // It is received until every thread has ended.
                    let _ = send.send((at, one(item)));
                }
            });
        }
        drop(send);
        let mut printed = 0;
        for (at, row) in done {
            bar.inc(1);
            rows.insert(at, row);
            // In the order of the names.
            while let Some(row) = rows.get(&printed) {
                if !plan.quiet || row.is_poor {
                    let line = row.line(&items[printed].path, width);
                    // A reader who has gone does not end the work.
                    let _ = bar.suspend(|| text::print(&line));
                }
                printed += 1;
            }
        }
    });
    bar.finish_and_clear();
    if let Some(path) = &plan.each.summary {
        write_summary(path, plan, &items, &rows)?;
    }
    if let Some(path) = plan.report {
        let all: Vec<Session> = items.iter().zip(rows.values()).map(session).collect();
        let figures = figure::sessions::sessions(&all);
        let document = with_origin(report::sessions(&all, &figures), &[]);
        write_report(path, force, &document)?;
        if !plan.quiet {
            text::say(&format!("Report: {}", path_text(path)));
        }
    }
    if !plan.quiet {
        text::say(&tally(&rows));
    }
    Ok(quality(rows.values().any(|row| row.is_poor)))
}

/// Bytes of a list of paths at most.
const MAX_LIST_BYTES: u64 = 1 << 24;

/// The paths of the arguments, `@LIST` replaced by its lines; and the lists.
///
/// # Errors
///
/// `each-input` (usage) for standard input; `too-large` (input); errors of reading a list.
fn given(arguments: &[PathBuf]) -> Result<(Vec<PathBuf>, Vec<PathBuf>)> {
    let (mut found, mut lists) = (Vec::new(), Vec::new());
    for argument in arguments {
        if argument == Path::new("-") {
            let text = "standard input is one recording, and many are read here";
            let hint = "give files or folders, or @LIST for the paths in a file";
            return Err(Error::usage("each-input", text).with_hint(hint));
        }
        let text = argument.to_string_lossy();
        match text.strip_prefix('@').filter(|_| !argument.exists()) {
            Some(list) => {
                let list = PathBuf::from(list);
                let text = read_list(&list)?;
                let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim);
                let lines = lines.filter(|l| !l.is_empty() && !l.starts_with('#'));
                found.extend(lines.map(PathBuf::from));
                lists.push(list);
            }
            None => found.push(argument.clone()),
        }
    }
    Ok((found, lists))
}

fn read_list(list: &Path) -> Result<String> {
    let file = File::open(list).map_err(|e| Error::io(list, e))?;
    let mut text = String::new();
    let read = file.take(MAX_LIST_BYTES + 1).read_to_string(&mut text);
    if read.map_err(|e| Error::io(list, e))? as u64 > MAX_LIST_BYTES {
        let error = Error::input("too-large", "more than 16 MiB: not a list of paths");
        return Err(error.at(list, None));
    }
    Ok(text)
}

/// A path, and that of the same session before it.
type Repeated = Vec<(String, String)>;

/// The sessions: files, and entries of folders, each once; and other names of them. What is written is no input.
///
/// # Errors
///
/// `no-recordings` (input); errors of reading a folder.
fn paths(plan: &Plan<'_>, given: &[PathBuf]) -> Result<(Vec<PathBuf>, Repeated)> {
    let pages = plan.pages();
    let outputs = [plan.output, plan.each.summary.as_deref(), pages.as_deref()];
    let outputs = outputs.map(|path| path.map(place));
    let mut paths = Vec::new();
    for path in given {
        if !path.is_dir() || plan.folders && is_session(path) {
            paths.push(path.clone());
            continue;
        }
        let is_input = |p: &PathBuf| {
            let is_session = if p.is_dir() {
                plan.folders
            } else {
                may_be_recording(p) && !is_summary(p)
            };
            is_session && !outputs.contains(&Some(place(p)))
        };
        paths.extend(entries(path)?.into_iter().filter(is_input));
    }
    let mut seen: HashMap<PathBuf, PathBuf> = HashMap::new();
    let mut repeated = Vec::new();
    paths.retain(|path| match seen.entry(place(path)) {
        Entry::Vacant(new) => {
            new.insert(path.clone());
            true
        }
        Entry::Occupied(first) => {
            if first.get() != path {
                repeated.push((path_text(path), path_text(first.get())));
            }
            false
        }
    });
    if paths.is_empty() {
        let error = Error::input("no-recordings", "there is no session among these paths");
        let hint = "give files, or a folder that holds them; recordings end in .";
        return Err(error.with_hint(hint.to_owned() + &ENDINGS.join(", .")));
    }
    Ok((paths, repeated))
}

impl Plan<'_> {
    /// The folder of the sessions' pages.
    fn pages(&self) -> Option<PathBuf> {
        self.report.map(|page| page.with_extension(""))
    }
}

/// Each path with its result and its page: its name without endings; where several would share one, that of its
/// folder in front. Names do not depend on the order of the paths, so that `--resume` finds them.
///
/// # Errors
///
/// `same-target` (usage) where that does not tell them apart.
fn named(paths: Vec<PathBuf>, plan: &Plan<'_>) -> Result<Vec<Item>> {
    let pages = plan.pages();
    // File systems that ignore case take `A.json` and `a.json` for one file.
    let mut uses: BTreeMap<String, usize> = BTreeMap::new();
    for path in &paths {
        *uses.entry(session_name(path).to_lowercase()).or_default() += 1;
    }
    let (mut taken, mut items) = (HashSet::new(), Vec::new());
    for path in paths {
        let mut name = session_name(&path);
        if uses[&name.to_lowercase()] > 1
            && let Some(folder) = path.parent().and_then(Path::file_name)
        {
            name = format!("{}-{name}", folder.to_string_lossy());
        }
        let at = |folder: &Path, ending: &str| folder.join(format!("{name}{ending}"));
        let result = plan.output.map(|folder| at(folder, plan.ending));
        let page = pages.as_deref().map(|folder| at(folder, ".html"));
        let is_new = taken.insert(name.to_lowercase());
        if let Some(target) = result.as_ref().or(page.as_ref()).filter(|_| !is_new) {
            let hint = "several sessions have this name; give them in runs with an -o of their own";
            return Err(same_target(target).with_hint(hint));
        }
        items.push(Item { path, result, page });
    }
    Ok(items)
}

/// What the page of all says of a session.
fn session((item, row): (&Item, &Outcome)) -> Session {
    let page = item.page.as_ref().filter(|page| page.exists());
    let page = page.filter(|_| row.error_code.is_empty());
    let parts = page.map(|page| page.iter().rev().take(2).collect::<Vec<_>>());
    let address = parts.map(|parts| {
        let parts = parts.iter().rev();
        parts
            .map(|part| encoded(&part.to_string_lossy()))
            .collect::<Vec<_>>()
            .join("/")
    });
    Session {
        name: item.path.display().to_string(),
        page: address,
        reason: row.main_reason(),
        ..row.session.clone()
    }
}

/// A name as a part of an address (RFC 3986, 2.3).
fn encoded(name: &str) -> String {
    let byte = |b: u8| match b {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => {
            char::from(b).to_string()
        }
        _ => format!("%{b:02X}"),
    };
    name.bytes().map(byte).collect()
}

/// True if the result was written after everything of the session, and after what it was read with.
fn is_newer(result: &Path, session: &Path, shared: &[PathBuf]) -> bool {
    let time = |path: &Path| path.metadata().and_then(|m| m.modified()).ok();
    let inside = std::fs::read_dir(session).into_iter().flatten().flatten();
    let inside = inside.map(|entry| entry.path());
    let read = shared.iter().cloned().chain([session.to_owned()]);
    let last = inside.chain(read).filter_map(|path| time(&path)).max();
    matches!((time(result), last), (Some(result), Some(last)) if result > last)
}

impl Outcome {
    fn failed(error: &anyhow::Error) -> Self {
        let error = RenderedError::new(error);
        Outcome {
            grade: "failed".to_owned(),
            is_poor: true,
            reasons: vec![error.message],
            error_code: error.code,
            hint: error.hint.unwrap_or_default(),
            ..Outcome::default()
        }
    }

    /// The first reason that the error of the calibration is not: it has a column of its own.
    fn main_reason(&self) -> String {
        let skipped = usize::from(self.session.error_mps2.is_some() && !self.is_poor);
        self.reasons.get(skipped).cloned().unwrap_or_default()
    }

    /// With the first reason; on a terminal in one line of it.
    fn line(&self, path: &Path, width: usize) -> String {
        let (grade, code) = (&self.grade, &self.error_code);
        let colon = if code.is_empty() { "" } else { ": " };
        let reason = self.reasons.first().map_or("", String::as_str);
        let (path, reason) = (path_text(path), one_line(reason));
        let line = format!("{grade:<14}  {path:<width$}  {code}{colon}{reason}");
        if io::stdout().is_terminal() {
            text::fit_terminal(&line) + "\n"
        } else {
            line + "\n"
        }
    }
}

fn write_summary(
    path: &Path,
    plan: &Plan<'_>,
    items: &[Item],
    rows: &BTreeMap<usize, Outcome>,
) -> Result<()> {
    write_atomic(path, plan.force || plan.each.resume, |out| {
        let failed = |e: csv::Error| Error::io(path, e.into());
        let mut table = csv::Writer::from_writer(out);
        let columns = SUMMARY_COLUMNS.iter().chain(plan.numbers);
        table.write_record(columns).map_err(failed)?;
        for (item, row) in items.iter().zip(rows.values()) {
            let result = item.result.as_deref().filter(|_| row.error_code.is_empty());
            let common = [
                item.path.display().to_string(),
                row.grade.clone(),
                row.main_reason(),
                row.error_code.clone(),
                row.hint.clone(),
                result.map_or_else(String::new, |r| r.display().to_string()),
            ];
            let cells = common.iter().chain(&row.numbers).map(|c| cell(c));
            let mut cells: Vec<String> = cells.collect();
            cells.resize(SUMMARY_COLUMNS.len() + plan.numbers.len(), String::new());
            table.write_record(cells).map_err(failed)?;
        }
        table.flush().map_err(|e| Error::io(path, e))
    })
}

/// One line; a text that a spreadsheet would take for a formula is quoted.
fn cell(text: &str) -> String {
    let text = one_line(text);
    let is_formula = text.starts_with(['=', '@', '+']);
    format!("{}{text}", if is_formula { "'" } else { "" })
}

/// `50 sessions: 19 good, 27 not-verifiable, 4 failed`.
fn tally(rows: &BTreeMap<usize, Outcome>) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for row in rows.values() {
        *counts.entry(&row.grade).or_default() += 1;
    }
    let mut counts: Vec<(&str, usize)> = counts.into_iter().collect();
    counts.sort_by_key(|(grade, n)| (*grade == "failed", std::cmp::Reverse(*n)));
    let counts = counts.iter().map(|(grade, n)| format!("{n} {grade}"));
    let counts = counts.collect::<Vec<_>>().join(", ");
    format!("{}: {counts}", count(rows.len(), "session"))
}
