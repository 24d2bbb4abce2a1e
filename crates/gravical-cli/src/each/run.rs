//! The run over all items.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use gravical::cohort::{
    Beginning, Columns, Content, Ending, Item, Journal, List, Origin, Outcome, Row, SEPARATOR,
    Status, journal_name, sha256_of,
};
use gravical::escape::{one_line, path_text, shown_json};
use gravical::numfmt::count;
use gravical::output::{check_target, check_targets, make_folder};
use gravical::session::files_in;
use gravical::{Error, Result};

use super::args::EachArgs;
use super::items::{Items, Kind};
use super::summary::{Counts, Form, Writer};
use super::words::Words;
use super::workers::in_order;
use crate::failure;
use crate::table::write_file;
use crate::{crash, progress, text};

/// Widest column of names on the screen.
const WIDEST: usize = 40;
/// Codes of errors that may be gone at the next attempt: of the file system, of memory, of a file that
/// was being written.
const TRANSIENT: [&str; 3] = ["io", "no-memory", "changed"];
/// Pause before the second attempt; each one after it is twice as long.
const FIRST_PAUSE: Duration = Duration::from_secs(1);
const LONGEST_PAUSE: Duration = Duration::from_secs(60);
/// Most codes in the sentence about errors.
const MOST_CODES: usize = 4;

/// What a command does with one item.
pub trait Job: Sync {
    /// What it measures.
    type Values: Columns;

    /// Does what the command alone does, and writes the result if one is wanted.
    ///
    /// # Errors
    ///
    /// Those of the command.
    fn run(&self, work: &Work<'_>) -> anyhow::Result<Outcome<Self::Values>>;
}

/// An item to work on.
pub struct Work<'a> {
    /// Its file or folder.
    pub path: &'a Path,
    /// File of the result, if one is to be written.
    pub result: Option<&'a Path>,
    /// Whether the result may replace a file: one of an earlier run, or any with `--force`.
    pub force: bool,
    content: &'a Content,
}

impl Work<'_> {
    /// To be called when the result is known, before it is published.
    ///
    /// # Errors
    ///
    /// `changed` if the files of the item changed meanwhile.
    pub fn check_unchanged(&self) -> Result<()> {
        self.content.check_unchanged()
    }
}

/// What is to be done.
pub struct Plan<'a> {
    pub each: &'a EachArgs,
    /// The options.
    pub words: Words,
    /// The arguments.
    pub inputs: &'a [PathBuf],
    pub kind: Kind,
    /// Folder of the results.
    pub output: Option<&'a Path>,
    /// Ending of a result, with the dot, from the path of its item; none for no result.
    pub ending: Option<Ending>,
    /// Files that belong to the options.
    pub files: Vec<&'a Path>,
    pub force: bool,
    pub json: bool,
    pub quiet: bool,
    pub verbose: bool,
}

/// Does `job` with all items, and prints a line for each.
///
/// # Errors
///
/// Only what concerns all of them: options, targets, the journal, the summary. The exit code is 4
/// if any item failed, and 130 if the run was interrupted.
pub fn run<J: Job>(plan: &Plan<'_>, job: &J) -> anyhow::Result<ExitCode> {
    let run = Run::prepare(plan, job)?;
    let interrupted = interrupted()?;
    for note in &run.items.notes {
        text::note(&format!("note: {}", one_line(note)));
    }
    progress::count(run.items.all.len() as u64);
    let tally = match &plan.each.summary {
        Some(path) => {
            let own = run.journal.as_ref().is_some_and(|j| j.is_own_summary(path));
            run.say_summary(path, false)?;
            let form = Form::of(path)?;
            let tally = write_file(path, plan.force || own, |out| {
                let mut writer = Writer::new(path, form, &plan.words, J::Values::NAMES, out)?;
                let tally = run.all(&interrupted, Some(&mut writer))?;
                writer.finish(&tally.counts)?;
                Ok(tally)
            })?;
            run.say_summary(path, true)?;
            tally
        }
        None => run.all(&interrupted, None)?,
    };
    progress::end();
    run.say(&tally);
    Ok(match tally.counts {
        _ if tally.taken < run.items.all.len() && !tally.is_unread => {
            ExitCode::from(failure::INTERRUPTED)
        }
        Counts {
            poor: 0, error: 0, ..
        } => ExitCode::SUCCESS,
        _ => ExitCode::from(failure::QUALITY),
    })
}

/// Set by Ctrl-C, by which no further item is begun; the second time the program ends at once,
/// which loses no more than what was being worked on.
fn interrupted() -> anyhow::Result<Arc<AtomicBool>> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(failure::INTERRUPTED));
        }
        text::note("ending with what is being worked on; Ctrl-C again ends at once");
    })?;
    Ok(interrupted)
}

/// A run that can begin.
struct Run<'a, J> {
    plan: &'a Plan<'a>,
    job: &'a J,
    items: Items,
    journal: Option<Journal>,
    /// Items that were done before.
    skipped: AtomicU64,
}

/// What became of an item.
struct Attempt<V> {
    row: Row<V>,
    /// Its result, if this or an earlier run wrote it.
    own: Option<PathBuf>,
    /// It was done before.
    is_of_earlier_run: bool,
}

impl<V> Attempt<V> {
    fn new(row: Row<V>) -> Self {
        Attempt {
            row,
            own: None,
            is_of_earlier_run: false,
        }
    }
}

/// What became of all items.
#[derive(Default)]
struct Tally {
    counts: Counts,
    /// Items whose rows were taken.
    taken: usize,
    codes: BTreeMap<String, u64>,
    /// Items with the content of another one.
    doubles: Vec<String>,
    /// Nobody reads what is printed.
    is_unread: bool,
}

impl<'a, J: Job> Run<'a, J> {
    /// Checks everything before the work.
    ///
    /// # Errors
    ///
    /// `each-option`, `each-input`, `summary-target`, `exists`, `in-use` and others of files.
    fn prepare(plan: &'a Plan<'a>, job: &'a J) -> Result<Self> {
        let each = plan.each;
        if let Some(path) = &each.summary {
            Form::of(path)?;
        }
        let journal = journal_path(plan);
        if each.resume && journal.is_none() {
            return Err(Error::usage(
                "each-option",
                "--resume: without results there is nothing to continue",
            )
            .with_hint("give -o DIR or --summary FILE, as the run before"));
        }
        if let Some(folder) = plan.output {
            if folder == Path::new("-") {
                return Err(Error::usage(
                    "each-option",
                    "-o: the results of many sessions need a folder",
                )
                .with_hint("name a folder; --json prints a line for each session"));
            }
            make_folder(folder)?;
        }
        let mut outputs: Vec<&Path> = plan.output.into_iter().collect();
        outputs.extend(each.summary.as_deref());
        outputs.extend(journal.as_deref());
        let ending = plan.ending.filter(|_| plan.output.is_some());
        let mut items = Items::of(plan.inputs, plan.kind, &outputs, ending)?;
        let list = List::of(&items.all);
        if let Some(shard) = each.shard {
            let mut index = 0..;
            let own = |_: &Item| index.next().is_some_and(|i| shard.takes(i));
            items.all.retain(own);
        }
        let hashes = plan.files.iter().map(|path| {
            let sha256 = sha256_of(path)?;
            Ok((path.display().to_string(), sha256))
        });
        let (verb, options) = (&plan.words.verb, &plan.words.options);
        let origin = Origin::new(verb, options, hashes.collect::<Result<_>>()?);
        let run = Run {
            plan,
            job,
            items,
            journal: None,
            skipped: AtomicU64::new(0),
        };
        // What stands in the way is said before anything is written.
        let may_exist = plan.force || each.resume;
        let results = run.items.all.iter().filter_map(|item| run.result(item));
        let targets: Vec<PathBuf> = results.chain(each.summary.clone()).collect();
        let mut read: Vec<PathBuf> = plan.files.iter().map(|p| p.to_path_buf()).collect();
        for item in &run.items.all {
            match item.path.is_dir() {
                // A folder without recordings is an error of its item.
                true => read.extend(files_in(&item.path).unwrap_or_default()),
                false => read.push(item.path.clone()),
            }
        }
        check_targets(&targets, &read, may_exist).map_err(with_resume_hint)?;
        let beginning = Beginning {
            origin,
            shard: each.shard,
            list,
            items: &run.items.all,
        };
        let journal = journal.map(|path| Journal::open(&path, &beginning, each.resume, plan.force));
        let journal = journal.transpose()?;
        if let Some(path) = &each.summary {
            let own = journal.as_ref().is_some_and(|j| j.is_own_summary(path));
            check_target(path, plan.force || own)?;
        }
        Ok(Run { journal, ..run })
    }

    fn result(&self, item: &Item) -> Option<PathBuf> {
        Some(self.plan.output?.join(item.file.as_ref()?))
    }

    fn say_summary(&self, path: &Path, is_written: bool) -> Result<()> {
        match &self.journal {
            Some(journal) => journal.summary(path, is_written),
            None => Ok(()),
        }
    }

    /// Works on all items, until `stop`.
    ///
    /// # Errors
    ///
    /// Those of the journal and of the summary.
    fn all(&self, stop: &AtomicBool, mut summary: Option<&mut Writer<'_>>) -> Result<Tally> {
        let all = &self.items.all;
        let width = all.iter().map(|i| i.name.chars().count()).max();
        let width = width.unwrap_or(0).min(WIDEST);
        let mut tally = Tally::default();
        let mut contents: HashMap<String, usize> = HashMap::new();
        let results_are_kept = self.journal.is_some();
        let work = |i: usize| self.row(&all[i], stop);
        let taken = in_order(all.len(), self.plan.each.workers(), stop, work, |i, row| {
            let mut row = row?;
            if let Some(sha256) = &row.sha256 {
                let first = *contents.entry(sha256.clone()).or_insert(i);
                if first != i {
                    row.same_content_as = Some(all[first].name.clone());
                    tally.doubles.push(row.name.clone());
                }
            }
            tally.add(&row);
            progress::counted(row.status != Status::Done);
            if let Some(summary) = &mut summary {
                summary.row(&row)?;
            }
            if !tally.is_unread {
                match self.print(&row, width) {
                    Err(error) if error.is_broken_pipe() => {
                        tally.is_unread = true;
                        // Without results nobody gets anything any more.
                        stop.fetch_or(!results_are_kept, Ordering::SeqCst);
                    }
                    printed => printed?,
                }
            }
            Ok::<(), Error>(())
        })?;
        tally.taken = taken;
        Ok(tally)
    }

    /// Works on one item, as often as `--retries` allows. After `stop` nothing is tried again.
    ///
    /// # Errors
    ///
    /// Those of the journal.
    fn row(&self, item: &Item, stop: &AtomicBool) -> Result<Row<J::Values>> {
        let mut pause = FIRST_PAUSE;
        for _ in 0..self.plan.each.retries {
            let attempt = self.attempt(item)?;
            let code = attempt.row.error_code.as_deref().unwrap_or_default();
            if !TRANSIENT.contains(&code) || stop.load(Ordering::SeqCst) {
                return self.end(item, attempt);
            }
            thread::sleep(pause);
            pause = (2 * pause).min(LONGEST_PAUSE);
        }
        let attempt = self.attempt(item)?;
        self.end(item, attempt)
    }

    /// Works on one item once.
    ///
    /// # Errors
    ///
    /// Those of the journal.
    fn attempt(&self, item: &Item) -> Result<Attempt<J::Values>> {
        let mut row = Row {
            path: item.path.display().to_string(),
            ..Row::of(&item.name, Status::Done)
        };
        let result = self.result(item);
        let content = match Content::of(&item.path) {
            Ok(content) => content,
            Err(error) => {
                set_error(&mut row, &error.into());
                return Ok(Attempt::new(row));
            }
        };
        row.sha256 = Some(content.sha256.clone());
        let before = self.journal.as_ref().filter(|_| self.plan.each.resume);
        let before = before.and_then(|j| j.done(item, &content.sha256, result.as_deref()));
        if let Some(mut before) = before {
            before.path = row.path;
            before.result = result.as_deref().map(path_text);
            return Ok(Attempt {
                is_of_earlier_run: true,
                ..Attempt::new(before)
            });
        }
        let sha256 = Some(content.sha256.as_str());
        let is_own = |result: &PathBuf| {
            let journal = self.journal.as_ref();
            journal.is_some_and(|j| j.is_own(item, sha256, result))
        };
        let own = result.clone().filter(is_own);
        match self.outcome(item, result.as_deref(), own.is_some(), &content)? {
            Ok(outcome) => {
                row.measured(outcome, result.as_deref());
                Ok(Attempt {
                    own: result,
                    ..Attempt::new(row)
                })
            }
            Err(error) => {
                set_error(&mut row, &error);
                if let (Some(reason), Some(own)) = (&mut row.reason, own.as_ref())
                    && own.exists()
                {
                    let own = path_text(own);
                    reason.push_str(&format!("{SEPARATOR}{own} is still that of an earlier run"));
                }
                Ok(Attempt {
                    own,
                    ..Attempt::new(row)
                })
            }
        }
    }

    /// What the job makes of an item: the inner error is the item's.
    fn outcome(
        &self,
        item: &Item,
        result: Option<&Path>,
        is_own: bool,
        content: &Content,
    ) -> Result<anyhow::Result<Outcome<J::Values>>> {
        let force = self.plan.force || is_own;
        if let Some(journal) = &self.journal {
            let check = |result| journal.check_target(item, result, force);
            if let Some(Err(error)) = result.map(check) {
                return Ok(Err(error.into()));
            }
            journal.begin(item)?;
        }
        let work = Work {
            path: &item.path,
            result,
            force,
            content,
        };
        let outcome = crash::guarded(|| self.job.run(&work));
        Ok(outcome.unwrap_or_else(|panic| {
            Err(anyhow::anyhow!(
                "a defect of the program, please report it: {panic}"
            ))
        }))
    }

    fn end(&self, item: &Item, attempt: Attempt<J::Values>) -> Result<Row<J::Values>> {
        let Attempt {
            row,
            own,
            is_of_earlier_run,
        } = attempt;
        if is_of_earlier_run {
            self.skipped.fetch_add(1, Ordering::Relaxed);
        } else if let Some(journal) = &self.journal {
            journal.end(item, own.as_deref(), &row)?;
        }
        Ok(row)
    }

    /// Prints the line of a row.
    ///
    /// # Errors
    ///
    /// Errors of printing.
    fn print(&self, row: &Row<J::Values>, width: usize) -> Result<()> {
        if self.plan.json {
            let text = serde_json::to_string(row)
                .map_err(|e| Error::io(Path::new("standard output"), e.into()))?;
            return text::print_line(&shown_json(&text));
        }
        if self.plan.quiet && row.status == Status::Done {
            return Ok(());
        }
        let word = row.verdict.as_deref().unwrap_or("error");
        let reason = row.reason.as_deref().unwrap_or_default();
        let mut line = format!("{word:<14}  {:<width$}  ", one_line(&row.name));
        if let Some(code) = &row.error_code {
            line.push_str(&format!("{code}: "));
        }
        // The main reason; the summary has all.
        let main = reason.split(SEPARATOR).next().unwrap_or_default();
        line.push_str(&one_line(if row.error_code.is_some() {
            reason
        } else {
            main
        }));
        text::print_line(line.trim_end())?;
        if self.plan.verbose
            && let Some(hint) = &row.hint
        {
            text::print_line(&format!("{:16}try: {}", "", one_line(hint)))?;
        }
        Ok(())
    }

    /// Says what became of all.
    fn say(&self, tally: &Tally) {
        let all = self.items.all.len();
        let is_interrupted = tally.taken < all;
        if self.plan.quiet && !is_interrupted {
            return;
        }
        let nouns = match self.plan.kind {
            Kind::Sessions => ["session", "sessions"],
            Kind::Recordings | Kind::Named => ["recording", "recordings"],
        };
        let noun = nouns[usize::from(all != 1)];
        let Counts { done, poor, error } = tally.counts;
        let mut text = format!("{all} {noun}: {done} done");
        if poor > 0 {
            text.push_str(&format!(", {poor} poor"));
        }
        if error > 0 {
            let errors = if error == 1 { "error" } else { "errors" };
            text.push_str(&format!(", {error} {errors} ({})", tally.codes()));
        }
        if is_interrupted {
            text.push_str(&format!(", {} not begun", all - tally.taken));
        }
        let skipped = self.skipped.load(Ordering::Relaxed);
        if skipped > 0 {
            text.push_str(&format!("; {skipped} of them by an earlier run"));
        }
        if let Some(folder) = self.plan.output {
            text.push_str(&format!(" → {}", path_text(folder)));
        }
        text::say(&text);
        if let Some(path) = &self.plan.each.summary {
            text::say(&format!("Summary: {}", path_text(path)));
        }
        if let [first, ..] = &tally.doubles[..] {
            let item = match self.plan.kind {
                Kind::Sessions => "session",
                Kind::Recordings | Kind::Named => "recording",
            };
            text::say(&format!(
                "note: {} with the content of an earlier one, the first is {} (same_content_as in --summary or --json)",
                count(tally.doubles.len(), item),
                one_line(first)
            ));
        }
        let folders = self.plan.inputs.iter().any(|path| path.is_dir());
        if error as usize == all && folders && self.plan.kind == Kind::Sessions {
            text::say(
                "note: each file of a folder was a session of its own; where the folder is the session, name the folder above it",
            );
        } else if error > 0 && !self.plan.verbose {
            text::say("What helps with each error: -v, or the column hint of --summary");
        }
        if is_interrupted && self.journal.is_some() {
            text::say("Interrupted; the same command with --resume continues");
        }
    }
}

impl Tally {
    fn add<V>(&mut self, row: &Row<V>) {
        match row.status {
            Status::Done => self.counts.done += 1,
            Status::Poor => self.counts.poor += 1,
            Status::Error => self.counts.error += 1,
        }
        if let Some(code) = &row.error_code {
            *self.codes.entry(code.clone()).or_default() += 1;
        }
    }

    /// The codes of the errors, the most frequent first.
    fn codes(&self) -> String {
        let mut codes: Vec<(&String, &u64)> = self.codes.iter().collect();
        codes.sort_by_key(|(_, n)| std::cmp::Reverse(**n));
        let named = codes.iter().take(MOST_CODES).map(|(code, n)| match n {
            1 => (*code).clone(),
            n => format!("{n} {code}"),
        });
        let mut named: Vec<String> = named.collect();
        if codes.len() > MOST_CODES {
            named.push("others".to_owned());
        }
        named.join(", ")
    }
}

fn set_error<V>(row: &mut Row<V>, error: &anyhow::Error) {
    match error.downcast_ref::<Error>() {
        Some(error) => row.failed(error.code(), &error.in_flags(), error.hint()),
        None => row.failed("internal", &format!("{error:#}"), None),
    }
}

/// The journal is beside the results, or beside the summary where there are none.
fn journal_path(plan: &Plan<'_>) -> Option<PathBuf> {
    let verb = &plan.words.verb;
    if let Some(folder) = plan.output {
        return Some(folder.join(journal_name(verb, plan.each.shard)));
    }
    let summary = plan.each.summary.as_ref()?;
    let stem = summary.file_stem()?.to_string_lossy();
    Some(summary.with_file_name(journal_name(&stem, plan.each.shard)))
}

fn with_resume_hint(error: Error) -> Error {
    match error.code() {
        "exists" => error.with_hint(
            "--resume continues a run over many sessions, --force replaces the files, -o names another folder",
        ),
        _ => error,
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Length;
    use super::*;

    /// Fails in three ways.
    struct Lengths;

    impl Job for Lengths {
        type Values = Length;

        fn run(&self, work: &Work<'_>) -> anyhow::Result<Outcome<Length>> {
            let text = std::fs::read_to_string(work.path)?;
            match text.as_str() {
                "panic" => panic!("a defect"),
                "error" => return Err(Error::input("no-rows", "nothing").into()),
                "changed" => {
                    std::fs::write(work.path, "changed while it is read")?;
                    work.check_unchanged()?;
                }
                _ => {}
            }
            Ok(Outcome {
                verdict: "measured".to_owned(),
                is_poor: text == "poor",
                reasons: vec!["one".to_owned(), "two; and a half".to_owned()],
                values: Length {
                    length_m: text.len() as f64,
                },
            })
        }
    }

    #[test]
    fn whatever_happens_to_one_is_its_own_row() {
        let folder = tempfile::tempdir().unwrap();
        let texts = ["panic", "error", "poor", "changed", "fine"];
        for text in texts {
            std::fs::write(folder.path().join(format!("{text}.csv")), text).unwrap();
        }
        let summary = folder.path().join("all.json");
        let each = EachArgs {
            summary: Some(summary.clone()),
            ..EachArgs::default()
        };
        let inputs = texts.map(|text| folder.path().join(format!("{text}.csv")));
        let plan = Plan {
            each: &each,
            words: Words {
                verb: "measure".to_owned(),
                options: Vec::new(),
            },
            inputs: &inputs,
            kind: Kind::Sessions,
            output: None,
            ending: None,
            files: Vec::new(),
            force: false,
            json: false,
            quiet: true,
            verbose: false,
        };
        let code = run(&plan, &Lengths).unwrap();
        assert_eq!(code, ExitCode::from(failure::QUALITY));
        let text = std::fs::read_to_string(&summary).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let rows = value["rows"].as_array().unwrap();
        let column = |name: &str| -> Vec<&str> {
            rows.iter()
                .map(|row| row[name].as_str().unwrap_or("-"))
                .collect()
        };
        assert_eq!(
            column("status"),
            ["error", "error", "poor", "error", "done"]
        );
        assert_eq!(
            column("error_code"),
            ["internal", "no-rows", "-", "changed", "-"]
        );
        assert_eq!(rows[2]["reason"], "one / two; and a half");
        assert!(column("reason")[0].contains("a defect of the program"));
        assert_eq!(rows[4]["length_m"], 4.0);
        assert_eq!(value["counts"]["error"], 3);
    }
}
