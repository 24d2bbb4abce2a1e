//! The loop between port, clock and disk and the recorder.

use std::time::{Duration, Instant, SystemTime};

use gravical::{Error, Result};

use super::Args;
use super::event::Event;
use super::file::LogFile;
use super::recorder::Recorder;
use super::status::Monitor;
use super::writing::Options;
use crate::device::ports::{Target, list, the_board};
use crate::device::serial::Serial;
use crate::device::trouble::holders;

/// Longest wait for bytes of the port.
const WAIT: Duration = Duration::from_millis(20);
/// Time between two searches for a port, s.
const SEARCH_S: f64 = 0.3;
/// Time between two synchronisations with the disk, s.
const SYNC_S: f64 = 10.0;
/// Time between two statuses, s.
const STATUS_S: f64 = 1.0;

/// The port of the board, which may be unplugged.
struct Port {
    /// The name that the user gives.
    given: Option<String>,
    /// The device that was open before.
    target: Option<Target>,
    baud: u32,
    open: Option<Serial>,
}

impl Port {
    /// Opens it; false while the device that was lost is away.
    ///
    /// # Errors
    ///
    /// It is not clear which port it is, or it cannot be opened.
    fn open(&mut self) -> Result<bool> {
        let ports = list().unwrap_or_default();
        let name = match (&self.target, &self.given) {
            (Some(target), _) => match target.find(&ports) {
                Some(name) => name,
                None => return Ok(false),
            },
            (None, Some(given)) => given.clone(),
            (None, None) => the_board(&ports)?.name,
        };
        self.open = Some(Serial::open(&name, self.baud)?);
        self.target = Some(Target::new(&name, &ports));
        Ok(true)
    }

    fn name(&self) -> Option<&str> {
        let target = self.target.as_ref().map(|target| target.name.as_str());
        target.or(self.given.as_deref())
    }
}

/// A recording of a port in a file.
pub struct Session {
    started: Instant,
    pub recorder: Recorder,
    pub file: LogFile,
    /// None where others judge the rows.
    monitor: Option<Monitor>,
    port: Port,
    searched_s: f64,
    synced_s: f64,
    observed_s: f64,
    /// Code of the error with which the port could not be opened.
    open_error: Option<&'static str>,
}

impl Session {
    /// Opens port and file. With `--wait` a missing port is searched for by [`step`](Self::step).
    ///
    /// # Errors
    ///
    /// Those of the options, of the file and of the port.
    pub fn open(args: &Args) -> Result<Self> {
        let board = &args.board;
        board.wanted.validate()?;
        let path = args.file();
        // Before the port, whose opening resets the board.
        let file = LogFile::open(&path, args.existing())?;
        let mut port = Port {
            given: board.port.clone(),
            target: None,
            baud: board.baud,
            open: None,
        };
        let opened = match port.open() {
            Err(error) if !board.wait || !is_missing(&error) => {
                file.discard_empty();
                return Err(error);
            }
            opened => opened,
        };
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let options = Options {
            name: path.display().to_string(),
            wanted: board.wanted,
            columns: board.columns.clone(),
            rows: args.rows,
            duration_s: args.duration,
            wait: board.wait,
            day_s: now.map_or(0.0, |now| now.as_secs_f64() % 86_400.0),
        };
        let recorder = Recorder::new(options, file.before())?;
        let mut session = Session {
            started: Instant::now(),
            recorder,
            file,
            monitor: (!args.is_read_along).then(Monitor::default),
            port,
            searched_s: 0.0,
            synced_s: 0.0,
            observed_s: 0.0,
            open_error: None,
        };
        session.has_tried(opened);
        Ok(session)
    }

    /// Seconds since it was opened.
    pub fn now_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// The port, as far as it is known.
    pub fn port(&self) -> Option<&str> {
        self.port.name()
    }

    /// Whether the port is open.
    pub fn is_plugged_in(&self) -> bool {
        self.port.open.is_some()
    }

    /// Events since the last call.
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.recorder.out.events)
    }

    /// Waits shortly for bytes, and does what is due. Returns the lines that were written.
    ///
    /// # Errors
    ///
    /// Those that end the recording.
    pub fn step(&mut self) -> Result<Vec<u8>> {
        let read = match &mut self.port.open {
            Some(port) => port.next(WAIT),
            None => {
                std::thread::sleep(WAIT);
                Ok(Vec::new())
            }
        };
        let now_s = self.now_s();
        match read {
            Ok(bytes) if bytes.is_empty() => {}
            Ok(bytes) => self.recorder.bytes(now_s, &bytes),
            Err(e) => self.lost(now_s, &e.to_string()),
        }
        if self.port.open.is_none() && is_due(&mut self.searched_s, now_s, SEARCH_S) {
            let opened = self.port.open();
            self.has_tried(opened);
        }
        self.recorder.tick(now_s);
        if is_due(&mut self.observed_s, now_s, STATUS_S) {
            self.observe(now_s);
            self.recorder.report_rejected();
        }
        let lines = self.write()?;
        if is_due(&mut self.synced_s, now_s, SYNC_S) {
            self.file.sync()?;
        }
        self.recorder.take_error().map_or(Ok(lines), Err)
    }

    /// Pauses, or resumes.
    ///
    /// # Errors
    ///
    /// Those of the disk.
    pub fn toggle_pause(&mut self) -> Result<()> {
        self.recorder.toggle_pause(self.now_s());
        self.write()?;
        self.file.sync()
    }

    /// Ends the recording, and writes everything that has arrived, unless it failed. Returns the lines
    /// that were written.
    ///
    /// # Errors
    ///
    /// Those of the disk.
    pub fn close(&mut self, has_failed: bool) -> Result<Vec<u8>> {
        // The reader thread ends first, otherwise a continuous stream would never end here.
        let rest = self.port.open.take().map(Serial::rest).unwrap_or_default();
        let now_s = self.now_s();
        if !has_failed {
            self.recorder.bytes(now_s, &rest);
        }
        self.recorder.finish(now_s);
        let lines = self.write()?;
        self.file.sync()?;
        Ok(lines)
    }

    /// Closes port and file without writing what is held.
    pub fn discard(&mut self) {
        self.port.open = None;
        self.file.discard_empty();
    }

    fn observe(&mut self, now_s: f64) {
        let writing = self.recorder.writing().filter(|w| w.counts.rows > 0);
        if let (Some(monitor), Some(writing)) = (&mut self.monitor, writing) {
            let (status, findings) = monitor.observe(writing, now_s);
            let findings = findings.into_iter().map(Event::Finding);
            self.recorder.out.events.extend(findings);
            self.recorder.say(Event::Status(status));
        }
    }

    /// Writes the lines that wait, and sends the commands.
    fn write(&mut self) -> Result<Vec<u8>> {
        let lines = std::mem::take(&mut self.recorder.out.text);
        self.file.write(&lines)?;
        let commands = std::mem::take(&mut self.recorder.out.commands);
        if let Some(port) = self.port.open.as_mut().filter(|_| !commands.is_empty())
            && let Err(e) = port.send(commands.as_bytes())
        {
            self.lost(self.now_s(), &e.to_string());
        }
        Ok(lines)
    }

    /// Just after plugging in, permissions are not set yet, and other programs probe the port: an error
    /// is reported once, and it is retried.
    fn has_tried(&mut self, opened: Result<bool>) {
        let error = match opened {
            Ok(true) => return self.opened(),
            Ok(false) => return,
            Err(error) => error,
        };
        if self.open_error.replace(error.code()) == Some(error.code()) {
            return;
        }
        self.recorder.say(if is_missing(&error) {
            let name = self.port.name().unwrap_or("a board");
            let text = format!("{name} to be plugged in");
            Event::Waiting { text }
        } else {
            let hint = error.hint().map_or_else(String::new, |h| format!(" ({h})"));
            let text = format!("{error}; it is retried{hint}");
            Event::Warning { text }
        });
    }

    /// The port was opened. Other programs that read it take rows away.
    fn opened(&mut self) {
        self.open_error = None;
        let now_s = self.now_s();
        let Some(target) = &self.port.target else {
            return;
        };
        let preamble = format!(
            "# gravical {} log, {}, {}\n",
            env!("CARGO_PKG_VERSION"),
            gravical::calibration_file::creation_time(),
            target.name
        );
        let recorder = &mut self.recorder;
        recorder.opened(now_s, &target.name, target.device(), preamble);
        let others = holders(&target.name).join(" and ");
        if !others.is_empty() {
            let text = format!(
                "{others} has the port open too: rows that it reads are missing here; close it"
            );
            recorder.say(Event::Warning { text });
        }
    }

    fn lost(&mut self, now_s: f64, why: &str) {
        self.port.open = None;
        self.searched_s = now_s;
        self.recorder.lost(now_s, why);
    }
}

/// Whether `last_s` is so long ago; then it is now.
fn is_due(last_s: &mut f64, now_s: f64, period_s: f64) -> bool {
    let is_due = now_s - *last_s >= period_s;
    if is_due {
        *last_s = now_s;
    }
    is_due
}

/// There is no port, yet.
fn is_missing(error: &Error) -> bool {
    matches!(error.code(), "no-port" | "no-such-port")
}
