//! `gravical log`: record from a serial board to a file.

mod board;
mod file;
mod host;
mod keys;
mod reporter;

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;

use gravical::escape::shell_word;
use gravical::inspect::{Inspection, inspect};
use gravical::live::recorder::{Counts, End, Event, Output, Status};
use gravical::numfmt::count;
use gravical::poses::face::AxisMap;
use gravical::recording::{Follow, ReadOptions, read};
use gravical_report::document::Detail;
use gravical_report::report;
use serde::Serialize;

pub use board::BoardArgs;
pub use file::{Existing, LogFile, free_path};
pub use host::Recording;

use host::Ended;
use keys::Keys;
use reporter::Reporter;

use crate::options::number;
use crate::{failure, interrupt};

/// At the end a file up to this length is inspected, bytes.
const MAX_INSPECTED: u64 = 100_000_000;
/// The last rows are judged for the status: so many, up to twice as many, from so many bytes at once.
const JUDGED_ROWS: usize = 10_000;
const JUDGED_BYTES: usize = 1 << 20;

/// Record from a serial board; losses are marked; Space pauses
#[derive(Clone, Default, clap::Args)]
#[command(after_help = "\
Example: gravical log x     records x_axis.csv; Space pauses, q ends

Exit codes: 0 recorded, 1 rows lost on disk, 2 usage, 3 the file cannot be used,
5 board or port, 130 interrupted, or rows are missing.")]
pub struct Args {
    /// x, y or z: the file is AXIS_axis.csv
    #[arg(value_parser = ["x", "y", "z"], hide_possible_values = true)]
    axis: Option<String>,
    /// File [default: AXIS_axis.csv, or recording.csv]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    existing: Existing,
    /// Stop S seconds after the first row, without pauses
    #[arg(long, value_name = "S", value_parser = number(1e-3, 1e9))]
    duration: Option<f64>,
    /// Stop after N rows
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    rows: Option<u64>,
    /// Print events as JSON, one object per line
    #[arg(long)]
    pub json: bool,
    /// Print warnings and errors only
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    board: BoardArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let mut reporter = Reporter::new(args.json, args.quiet);
    let interrupted = interrupt::flag();
    args.board.wanted.validate()?;
    // Before the port, whose opening resets the board.
    let axis = args.axis.as_ref().map(|axis| format!("{axis}_axis.csv"));
    let default = axis.unwrap_or_else(|| "recording.csv".to_owned());
    let path = args.output.clone().unwrap_or_else(|| default.into());
    let file = LogFile::open(&path, args.existing)?;
    let mut judge = Judge::new(&file.before);
    let mut recording = Recording::start(&args.board, file, args.rows, args.duration)?;
    let keys = Keys::new();
    reporter.screen.is_raw = keys.is_some();
    while let Some(output) = recording.next() {
        judge.report(output, &mut reporter);
        match keys.as_ref().and_then(Keys::pressed) {
            Some(b' ') => recording.toggle_pause(),
            // Ctrl-C and Ctrl-D, too.
            Some(b'q' | 3 | 4) => break,
            _ if interrupted.load(Ordering::SeqCst) => break,
            _ => {}
        }
    }
    reporter.screen.close();
    drop(keys);
    let Some(ended) = recording.end(false) else {
        return Ok(ExitCode::SUCCESS);
    };
    for output in recording.outputs.try_iter() {
        judge.report(output, &mut reporter);
    }
    end(args, ended, &mut reporter)
}

/// Reads what was written, for the status: behind the recording, and some of it only where it falls back.
struct Judge {
    reader: Follow,
    unread: Vec<u8>,
    /// Kinds of what was found.
    found: BTreeSet<String>,
}

impl Judge {
    fn new(before: &[u8]) -> Self {
        Judge {
            reader: Follow::new("recording.csv", ReadOptions::default(), JUDGED_ROWS),
            unread: before.to_vec(),
            found: BTreeSet::new(),
        }
    }

    fn report(&mut self, output: Output, reporter: &mut Reporter) {
        self.unread.extend(output.lines);
        if self.reader.form().is_some() && self.unread.len() > JUDGED_BYTES {
            let old = self.unread.len() - JUDGED_BYTES;
            let end = self.unread[old..].iter().position(|b| *b == b'\n');
            self.unread.drain(..end.map_or(old, |at| old + at + 1));
        }
        for mut event in output.events {
            if let Event::Status(status) = &mut event {
                self.observe(status, reporter);
            }
            reporter.event(&event);
        }
    }

    /// Adds what the last rows say. Without new rows nothing is known of this second.
    fn observe(&mut self, status: &mut Status, reporter: &mut Reporter) {
        if self.unread.is_empty() {
            return;
        }
        let text = std::mem::take(&mut self.unread);
        let _ = self.reader.classify(&text, true);
        if let Some(Ok(recording)) = self.reader.recording(u32::MAX) {
            status.observe(&recording);
            for finding in recording.findings {
                if finding.is_of_samples() && self.found.insert(finding.kind.clone()) {
                    reporter.finding(&finding);
                }
            }
        }
    }
}

/// What was recorded.
#[derive(Serialize)]
struct Summary {
    file: String,
    /// Why it ended; none after an error.
    reason: Option<End>,
    /// Since the first row, without pauses, s.
    elapsed_s: f64,
    #[serde(flatten)]
    counts: Counts,
    /// What `inspect` says of the file; none of a long file, and of one that cannot be read as a
    /// recording.
    inspection: Option<Inspection>,
}

impl Summary {
    /// The counts, and what `gravical inspect` says of the file; none without a row.
    fn words(&self) -> Option<String> {
        let (file, counts) = (&self.file, &self.counts);
        let mut text = format!("{file}: {} rows in {:.1} s", counts.rows, self.elapsed_s);
        for (n, what) in [
            (counts.rejected, "rejected line"),
            (counts.gaps, "gap"),
            (counts.missing, "missing row"),
        ] {
            if n > 0 {
                text += &format!(", {}", count(n, what));
            }
        }
        text += &match &self.inspection {
            Some(inspection) => {
                let document = report::inspection(inspection, &[]);
                format!("\n\n{}", document.to_text(Detail::Full))
            }
            None => format!("\nNext: gravical inspect {}", shell_word(file)),
        };
        (counts.rows > 0).then_some(text)
    }
}

/// Reports the summary.
fn end(args: &Args, ended: Ended, reporter: &mut Reporter) -> anyhow::Result<ExitCode> {
    let (recorder, path) = (&ended.recorder, &ended.file.path);
    let counts = recorder.counts;
    let mut inspection = None;
    if counts.rows == 0 {
        ended.file.discard_empty();
    } else if std::fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() <= MAX_INSPECTED) {
        match read(path, &ReadOptions::default()) {
            Ok(recording) => inspection = Some(inspect(&recording, &AxisMap::default())),
            Err(error) => {
                reporter.warn(format!("gravical inspect cannot read the file: {error}"));
            }
        }
    }
    let reason = recorder.end.filter(|_| ended.done.is_ok());
    let elapsed_s = recorder.elapsed_s(ended.now_s);
    reporter.ended(&Summary {
        file: path.display().to_string(),
        reason,
        elapsed_s: elapsed_s.min(args.duration.unwrap_or(f64::INFINITY)),
        counts,
        inspection,
    });
    ended.done?;
    let is_silent = recorder.is_silent();
    let is_early = args.rows.is_some() || args.duration.is_some() || counts.rows == 0;
    Ok(ExitCode::from(match reason {
        Some(End::User) if is_early || is_silent || recorder.is_incomplete => failure::INTERRUPTED,
        Some(End::Duration) if ended.is_unplugged => failure::DEVICE,
        Some(End::Duration) if is_silent || recorder.has_dropped => failure::INTERRUPTED,
        Some(End::Rows) if recorder.has_dropped => failure::INTERRUPTED,
        _ => 0,
    }))
}
