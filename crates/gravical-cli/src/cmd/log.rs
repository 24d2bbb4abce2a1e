//! `gravical log`: record from a serial board to a file.

mod event;
mod file;
mod gap;
mod keys;
mod lines;
mod recorder;
mod reporter;
mod session;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use gravical::Result;
use gravical::inspect::inspect;
use gravical::poses::face::AxisMap;
use gravical::recording::{ColumnsSpec, ReadOptions, read};

pub use event::Event;
pub use file::{Existing, LogFile, free_path};
pub use session::Session;

use event::{End, Ended};
use keys::Keys;
use reporter::Reporter;

use crate::device::board::Wanted;
use crate::failure;
use crate::options::number;

/// At the end a file up to this length is inspected, bytes.
const MAX_INSPECTED: u64 = 100_000_000;

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
    /// Somebody reads the lines that are written, and judges them.
    #[arg(skip)]
    is_read_along: bool,
}

/// The board, and how it is set.
#[derive(Clone, Default, clap::Args)]
#[command(next_help_heading = "Board")]
pub struct BoardArgs {
    /// Serial port [default: the only board plugged in]
    #[arg(long, value_name = "PORT")]
    pub port: Option<String>,
    /// Wait until a board is plugged in and sends data
    #[arg(long)]
    pub wait: bool,
    /// Baud rate
    #[arg(long, value_name = "BAUD", default_value_t = 115_200, value_parser = clap::value_parser!(u32).range(300..=4_000_000))]
    baud: u32,
    /// t,ax,ay,az,-,gx,gy,gz in order, or t=ms,ax=… by name
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub columns: Option<ColumnsSpec>,
    #[command(flatten)]
    pub wanted: Wanted,
}

impl Args {
    /// For a session that reads along: into the file `output`, which is continued if it `resumes`.
    pub fn of_session(board: &BoardArgs, output: PathBuf, resumes: bool) -> Self {
        Args {
            output: Some(output),
            existing: Existing::of_session(resumes),
            board: board.clone(),
            is_read_along: true,
            ..Args::default()
        }
    }

    fn file(&self) -> PathBuf {
        let axis = self.axis.as_ref().map(|axis| format!("{axis}_axis.csv"));
        let default = axis.unwrap_or_else(|| "recording.csv".to_owned());
        self.output.clone().unwrap_or_else(|| default.into())
    }
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    let mut reporter = Reporter::new(args.json, args.quiet);
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    ctrlc::set_handler(move || flag.store(true, Ordering::SeqCst))?;
    let mut session = Session::open(args)?;
    let keys = Keys::new();
    reporter.screen.is_raw = keys.is_some();
    let mut done = Ok(());
    while done.is_ok() && session.recorder.end.is_none() && !interrupted.load(Ordering::SeqCst) {
        done = session.step().map(drop);
        match keys.as_ref().and_then(Keys::pressed) {
            Some(b' ') if done.is_ok() => done = session.toggle_pause(),
            // Ctrl-C and Ctrl-D, too.
            Some(b'q' | 3 | 4) => break,
            _ => {}
        }
        reporter.report(&session.take_events());
    }
    reporter.screen.close();
    drop(keys);
    end(args, session, done, &mut reporter)
}

/// Writes everything that waits, and reports the summary.
fn end(
    args: &Args,
    mut session: Session,
    mut done: Result<()>,
    reporter: &mut Reporter,
) -> anyhow::Result<ExitCode> {
    let is_unplugged = !session.is_plugged_in();
    let is_silent = session.recorder.is_silent();
    let now_s = session.now_s();
    let closed = session.close(done.is_err());
    done = done.and(closed);
    reporter.report(&session.take_events());
    let (recorder, path) = (&session.recorder, session.file.path());
    let counts = recorder.counts;
    let mut inspection = None;
    if counts.rows == 0 {
        session.file.discard_empty();
    } else if std::fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() <= MAX_INSPECTED) {
        match read(path, &ReadOptions::default()) {
            Ok(recording) => inspection = Some(inspect(&recording, &AxisMap::default())),
            Err(error) => {
                let text = format!("gravical inspect cannot read the file: {error}");
                reporter.report(&[Event::Warning { text }]);
            }
        }
    }
    let reason = recorder.end.filter(|_| done.is_ok());
    // Rows that were held are written by the end.
    let elapsed_s = recorder.elapsed_s(now_s);
    reporter.report(&[Event::Ended(Box::new(Ended {
        file: path.display().to_string(),
        reason,
        elapsed_s: elapsed_s.min(args.duration.unwrap_or(f64::INFINITY)),
        counts,
        inspection,
    }))]);
    done?;
    let is_early = args.rows.is_some() || args.duration.is_some() || counts.rows == 0;
    Ok(ExitCode::from(match reason {
        Some(End::User) if is_early || is_silent || recorder.is_incomplete => failure::INTERRUPTED,
        Some(End::Duration) if is_unplugged => failure::DEVICE,
        Some(End::Duration) if is_silent => failure::INTERRUPTED,
        _ => 0,
    }))
}
