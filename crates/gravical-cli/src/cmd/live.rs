//! `gravical live`: guided calibration.

mod connect;
mod console;
mod driver;
mod source;
mod web;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::sync_channel;

use gravical::escape::path_word;
use gravical::gravity::Gravity;
use gravical::live::event::{EndReason, Event, SourceKind};
use gravical::live::folder::{Journal, RECORDING};
use gravical::live::{LiveOptions, SimulatedBoard};
use gravical::output::make_folder;
use gravical::recording::{self, ReadOptions};
use gravical::targets::check_targets;
use gravical::{Error, Result};

use crate::cmd::log::{BoardArgs, Existing, LogFile, Recording, free_path};
use crate::device::ports::{is_present, list};
use crate::options::{GravityArgs, number};
use crate::{failure, interrupt};

use connect::{Connection, OpenSource};
use console::{Console, EventLines, Plain};
use source::{Incoming, Port, Replay, Simulated, Source};
use web::Page;

/// What is typed or clicked waits in a queue of this length.
const ENTRIES: usize = 64;

/// Guide a calibration from the first row to the result
#[derive(Clone, clap::Args)]
#[command(after_help = "\
Example: gravical live --simulate    a simulated sensor on a page in the browser

The page is served to this computer only; its address is the first line printed.

Commands, typed here or clicked there: port NAME; simulate; undo; redo +x; take
(accept this pose as it is); latitude 48.1; gravity 9.81; stop (calculate and
save); cancel. Of a simulated sensor also +x … -z, free, shake, 0.6 0.6 0.5.

Exit codes: 0 saved, 2 usage, 3 no calibration or unreadable rows, 4 the verdict
is poor, 5 board or port, 130 interrupted or cancelled; --resume goes on.")]
pub struct Args {
    /// Guide with a recording in place of a board
    #[arg(long, value_name = "FILE", conflicts_with_all = ["simulate", "resume", "port", "wait", "baud", "range", "gyro_range", "low_pass", "format"])]
    replay: Option<PathBuf>,
    /// A simulated sensor, moved by commands
    #[arg(long, conflicts_with_all = ["port", "wait", "baud", "columns", "range", "gyro_range", "rate", "low_pass", "format"])]
    simulate: bool,
    /// Seed of the simulated sensor [default: drawn]
    #[arg(long, value_name = "N", requires = "simulate")]
    seed: Option<u64>,
    /// Go on with the session in this folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["folder", "simulate"])]
    resume: Option<PathBuf>,
    /// Folder of the session [default: session-DATE-TIME]
    #[arg(long, value_name = "DIR", conflicts_with = "replay")]
    folder: Option<PathBuf>,
    /// Calibration file [default: in the folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Events to a file or - (stdout), one JSON object a line
    #[arg(long, value_name = "FILE")]
    events: Option<PathBuf>,
    /// In the terminal only, one line an event
    #[arg(long)]
    plain: bool,
    /// Do not open the page in the browser
    #[arg(long, conflicts_with = "plain")]
    no_open: bool,
    /// Port of the page [default: a free one]
    #[arg(long, value_name = "PORT", conflicts_with = "plain", value_parser = clap::value_parser!(u16).range(1024..))]
    http_port: Option<u16>,
    /// Accept every steady hold at any time
    #[arg(long)]
    any_pose: bool,
    /// Length of a capture, s
    #[arg(long, value_name = "S", default_value = "2.5", value_parser = number(0.5, 60.0))]
    capture: f64,
    /// Times real time [default: 1; a replay 0, no waiting]
    #[arg(long, value_name = "X", value_parser = number(0.0, 1e6))]
    speed: Option<f64>,
    #[command(flatten)]
    gravity: GravityArgs,
    #[command(flatten)]
    board: BoardArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> anyhow::Result<ExitCode> {
    if args.speed.is_some() && args.replay.is_none() && !args.simulate && args.resume.is_none() {
        let error = Error::usage("usage", "--speed is for a replay or a simulated sensor");
        return Err(error.with_hint("a board sets its own pace: --rate").into());
    }
    args.check_targets()?;
    let interrupted = interrupt::flag();
    let mut args = args.clone();
    let journal = args.journal()?;
    args.folder = args.session_folder()?;
    let is_real_time = args.speed() > 0.0;
    let (typing, typed) = sync_channel(ENTRIES);
    let (clicking, clicked) = sync_channel(ENTRIES);
    let open_lines = |path: &PathBuf| EventLines::open(path, is_real_time);
    let mut console = Console {
        plain: Plain::new(is_real_time),
        lines: args.events.as_ref().map(open_lines).transpose()?,
        page: None,
        typed,
        clicked,
        interrupted,
    };
    // A session as fast as possible is over before a page is loaded.
    if !args.plain && is_real_time {
        console.page = Some(Page::serve(args.http_port, !args.no_open, clicking)?);
    }
    if args.replay.is_none() {
        console::send_typed(typing);
    }
    let mut done = args.guide(journal.as_ref(), &mut console);
    while done.is_ok() && console.goes_on() {
        // What was said in the session counts, not what was given before.
        args.resume.clone_from(&args.folder);
        (args.simulate, args.board.port) = (false, None);
        args.gravity = GravityArgs::default();
        done = match args.journal() {
            Ok(journal) => args.guide(journal.as_ref(), &mut console),
            Err(error) => Err(error.into()),
        };
    }
    if let (Err(error), Some(page)) = (&done, &console.page) {
        page.fail(&error.to_string());
    }
    done
}

impl Args {
    /// From the source to the end of the session; `before` is the journal of one that goes on.
    fn guide(&self, before: Option<&Journal>, console: &mut Console) -> anyhow::Result<ExitCode> {
        let connection = Connection {
            args: self.clone(),
            console: &mut *console,
        };
        if let Some(opened) = connection.open()? {
            return driver::run(self, before, console, opened);
        }
        let event = Event::End {
            reason: EndReason::Interrupted,
            poses: 0,
            resume: None,
        };
        console.note(event, "Ended before the first row.")?;
        Ok(ExitCode::from(failure::INTERRUPTED))
    }

    /// How the session is guided.
    fn session_options(&self, kind: SourceKind, before: Option<&Journal>) -> Result<LiveOptions> {
        let default = match kind {
            SourceKind::Simulate => SimulatedBoard::gravity()?,
            _ => Gravity::default(),
        };
        let gravity = self.gravity.given()?.or(before.map(|j| j.gravity));
        Ok(LiveOptions {
            read: self.read_options(),
            gravity: gravity.unwrap_or(default),
            capture_s: self.capture,
            any_pose: self.any_pose,
            ..LiveOptions::default()
        })
    }

    /// The calibration file.
    fn output(&self) -> Option<PathBuf> {
        let default = || Some(self.folder.as_ref()?.join("calibration.json"));
        let output = self.output.clone().or_else(default)?;
        // A session that goes on has saved one.
        let resumes = self.resume.is_some();
        Some(if resumes { free_path(&output) } else { output })
    }

    /// Checks what will be written, before the poses are.
    fn check_targets(&self) -> Result<()> {
        let events = self.events.iter().filter(|p| p.as_path() != Path::new("-"));
        let targets: Vec<PathBuf> = self.output.iter().chain(events).cloned().collect();
        let inputs: Vec<PathBuf> = self.replay.iter().chain(&self.resume).cloned().collect();
        check_targets(&targets, &inputs, false).map_err(|error| match error.code() {
            "exists" => error.with_hint("name another file"),
            _ => error,
        })
    }

    /// Times real time; 0 is as fast as possible.
    fn speed(&self) -> f64 {
        let default = if self.replay.is_some() { 0.0 } else { 1.0 };
        self.speed.unwrap_or(default)
    }

    /// The journal of a session that goes on, whose rows come from where they came before.
    fn journal(&mut self) -> Result<Option<Journal>> {
        let journal = self.resume.as_deref().map(Journal::read).transpose()?;
        if let Some(journal) = &journal {
            journal.verify(&self.read_options())?;
            match journal.source.clone() {
                Some((SourceKind::Simulate, name)) => {
                    self.simulate = true;
                    self.seed = name.rsplit(' ').next().and_then(|seed| seed.parse().ok());
                }
                // A browser gives a port another name than the system.
                Some((_, name)) if self.board.port.is_none() => {
                    let ports = list().unwrap_or_default();
                    self.board.port = Some(name).filter(|name| is_present(name, &ports));
                }
                _ => {}
            }
        }
        Ok(journal)
    }

    /// The folder of the session; none for a replay.
    fn session_folder(&self) -> Result<Option<PathBuf>> {
        if self.replay.is_some() || self.resume.is_some() {
            return Ok(self.resume.clone());
        }
        let folder = self.folder.clone().unwrap_or_else(|| {
            let now = gravical::calibration_file::creation_time();
            PathBuf::from(format!("session-{}", now.replace(['-', ':', 'Z'], "")))
        });
        if !folder.exists() {
            return Ok(Some(folder));
        }
        let hint = format!(
            "gravical live --resume {} goes on with it; --folder names another",
            path_word(&folder)
        );
        let error = Error::usage("exists", "the folder of the session exists already");
        Err(error.at(&folder, None).with_hint(hint))
    }

    fn read_options(&self) -> ReadOptions {
        // In the file of a board the columns have names.
        let rows = self.replay.as_ref().map(|_| &self.board);
        ReadOptions {
            columns: rows.and_then(|board| board.columns.clone()),
            rate_hz: rows.and_then(|board| board.wanted.rate_hz.map(f64::from)),
            hash: true,
            ..ReadOptions::default()
        }
    }

    /// Opens the source.
    fn open(&self) -> Result<OpenSource> {
        let resumes = self.resume.is_some();
        let folder = self.folder.as_deref().unwrap_or(Path::new(""));
        let mut restored_bytes = 0;
        let (kind, name, source): (_, _, Box<dyn Source>) = if let Some(file) = &self.replay {
            let replay = Replay {
                input: recording::source::open(file, &self.read_options())?,
                path: file.clone(),
            };
            let name = file.display().to_string();
            (SourceKind::Replay, name, Box::new(replay))
        } else if self.simulate {
            make_folder(folder)?;
            let seed = self.seed.unwrap_or_else(Simulated::draw_seed);
            let name = format!("simulated MPU6050, seed {seed}");
            let path = folder.join(RECORDING);
            let simulated = Simulated::open(&path, resumes, seed, self.speed())?;
            restored_bytes = simulated.file.length;
            (SourceKind::Simulate, name, Box::new(simulated))
        } else {
            make_folder(folder)?;
            self.board.wanted.validate()?;
            let existing = Existing::of_session(resumes);
            let mut recording = LogFile::open(&folder.join(RECORDING), existing)?;
            // What a session goes on with are whole lines.
            recording.start()?;
            let file = recording.second()?;
            restored_bytes = recording.length;
            let recording = Recording::start(&self.board, recording, None, None)?;
            // The port gives its name when it is open.
            let name = self.board.port.clone().unwrap_or("the board".to_owned());
            (SourceKind::Port, name, Box::new(Port { recording, file }))
        };
        Ok(OpenSource {
            kind,
            name,
            source,
            restored_bytes,
            first: Incoming::default(),
        })
    }
}
