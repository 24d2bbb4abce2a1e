//! The loop between port, clock and disk and the recorder.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

use gravical::Result;

use super::Args;
use super::event::Event;
use super::file::LogFile;
use super::recorder::{Options, Recorder};
use super::status::Monitor;
use crate::device::ports::{Target, list, the_board};
use crate::device::serial::Serial;
use crate::device::trouble::holders;

/// Longest wait for bytes of the port.
const WAIT: Duration = Duration::from_millis(20);
/// Time between two searches for a port, s.
const LOOK_FOR_S: f64 = 0.3;
/// Time between two writes of rows, s.
const WRITE_S: f64 = 0.2;
/// Time between two synchronisations with the disk, s.
const SYNC_S: f64 = 10.0;
/// Time between two statuses, s.
const STATUS_S: f64 = 1.0;

/// A recording of a port in a file.
pub struct Session {
    started: Instant,
    pub recorder: Recorder,
    pub file: LogFile,
    /// None where others judge the rows.
    monitor: Option<Monitor>,
    source: Option<Serial>,
    target: Target,
    baud: u32,
    last_write_s: f64,
    last_sync_s: f64,
    last_search_s: f64,
    last_status_s: f64,
    /// Code of the error with which the port could not be opened.
    open_error: Option<&'static str>,
    /// Events that were not returned yet.
    events: Vec<Event>,
    /// What was written and not returned yet, for those who read along.
    written: Option<Vec<u8>>,
}

impl Session {
    /// Opens port and file, and tells what is waited for; none when the user ended the waiting.
    ///
    /// # Errors
    ///
    /// Those of the file, of the port and of the options.
    pub fn open(
        args: &Args,
        tell: &mut dyn FnMut(Event),
        interrupted: &AtomicBool,
    ) -> Result<Option<Self>> {
        args.validate()?;
        let (path, existing) = (args.file(), args.existing());
        LogFile::check(&path, existing)?;
        let Some(target) = find_target(args, tell, interrupted)? else {
            return Ok(None);
        };
        let is_there = target.find(&list().unwrap_or_default()).is_some();
        let source = if args.board.wait && !is_there {
            None
        } else {
            Some(Serial::open(&target.name, args.board.baud)?)
        };
        // After the port: without a board no empty file remains.
        let mut file = LogFile::open(&path, existing)?;
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let recorder = Recorder::new(Options {
            name: path.display().to_string(),
            wanted: args.board.wanted,
            columns: args.board.columns.clone(),
            rows: args.rows,
            duration_s: args.duration,
            wait: args.board.wait,
            preamble: format!(
                "# gravical {} log, {}, {}\n",
                env!("CARGO_PKG_VERSION"),
                gravical::calibration_file::creation_time(),
                target.name
            ),
            before: file.before().to_vec(),
            day_s: now.map_or(0.0, |now| now.as_secs_f64() % 86_400.0),
        })?;
        file.end_last_line()?;
        let mut session = Session {
            started: Instant::now(),
            recorder,
            file,
            monitor: (!args.is_read_along).then(Monitor::default),
            source,
            target,
            baud: args.board.baud,
            last_write_s: 0.0,
            last_sync_s: 0.0,
            last_search_s: 0.0,
            last_status_s: 0.0,
            open_error: None,
            events: Vec::new(),
            written: args.is_read_along.then(Vec::new),
        };
        match session.source {
            Some(_) => session.opened(),
            None => tell(Event::Waiting {
                text: format!("{} to be plugged in", session.target.name),
            }),
        }
        Ok(Some(session))
    }

    /// Seconds since it was opened.
    pub fn now_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// The port.
    pub fn port(&self) -> &str {
        &self.target.name
    }

    /// Whether the port is open.
    pub fn is_plugged_in(&self) -> bool {
        self.source.is_some()
    }

    /// Events since the last call.
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// What was written since the last call, for those who read along.
    pub fn take_written(&mut self) -> Vec<u8> {
        let written = self.written.as_mut();
        written.map(std::mem::take).unwrap_or_default()
    }

    /// Waits shortly for bytes, and does what is due.
    ///
    /// # Errors
    ///
    /// Those that end the recording.
    pub fn step(&mut self) -> Result<()> {
        let read = match &mut self.source {
            Some(source) => source.next(WAIT),
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
        if self.source.is_none() && is_due(&mut self.last_search_s, now_s, LOOK_FOR_S) {
            self.search();
        }
        self.recorder.tick(now_s);
        if is_due(&mut self.last_status_s, now_s, STATUS_S) {
            self.recorder.report_rejected();
            self.observe(now_s);
        }
        let is_read_along = self.written.is_some();
        if is_due(&mut self.last_write_s, now_s, WRITE_S) || is_read_along {
            self.write()?;
        }
        if is_due(&mut self.last_sync_s, now_s, SYNC_S) {
            self.file.sync()?;
        }
        self.recorder.run.fatal.take().map_or(Ok(()), Err)
    }

    /// Pauses, or resumes.
    ///
    /// # Errors
    ///
    /// Those of the disk.
    pub fn toggle_pause(&mut self) -> Result<()> {
        self.recorder.toggle_pause(self.now_s());
        self.make_safe()
    }

    /// Makes the lines so far safe on the disk.
    ///
    /// # Errors
    ///
    /// Those of the disk.
    pub fn make_safe(&mut self) -> Result<()> {
        self.write()?;
        self.file.sync()
    }

    /// Ends the recording, and writes everything that has arrived, unless it failed.
    ///
    /// # Errors
    ///
    /// Those of the disk.
    pub fn close(&mut self, has_failed: bool) -> Result<()> {
        // The reader thread ends first, otherwise a continuous stream would never end here.
        let rest = self.source.take().map(Serial::rest).unwrap_or_default();
        let now_s = self.now_s();
        if !has_failed {
            self.recorder.bytes(now_s, &rest);
        }
        self.recorder.finish(now_s);
        self.make_safe()
    }

    fn observe(&mut self, now_s: f64) {
        let is_begun = self.recorder.run.counts.rows > 0;
        if let Some(monitor) = self.monitor.as_mut().filter(|_| is_begun) {
            let (status, findings) = monitor.observe(&self.recorder, now_s);
            self.events.extend(findings.into_iter().map(Event::Finding));
            self.events.push(Event::Status(status));
        }
    }

    fn write(&mut self) -> Result<()> {
        let out = self.recorder.take();
        self.events.extend(out.events);
        self.file.write(&out.text)?;
        if let Some(written) = &mut self.written {
            written.extend_from_slice(&out.text);
        }
        if !out.commands.is_empty() {
            let commands = out.commands.as_bytes();
            let sent = self.source.as_mut().map(|source| source.send(commands));
            if let Some(Err(e)) = sent {
                self.lost(self.now_s(), &e.to_string());
            }
        }
        Ok(())
    }

    /// The port was opened. Other programs that read it take rows away.
    fn opened(&mut self) {
        let device = self.target.device(&list().unwrap_or_default());
        self.recorder
            .opened(self.now_s(), &self.target.name, device);
        let others = holders(&self.target.name);
        if !others.is_empty() {
            let programs = others.join(" and ");
            self.events.push(Event::Warning {
                text: format!(
                    "{programs} has the port open too: rows that it reads are missing here; close it"
                ),
            });
        }
    }

    fn lost(&mut self, now_s: f64, why: &str) {
        self.source = None;
        self.last_search_s = now_s;
        self.recorder.lost(now_s, why);
    }

    /// Searches for the device that was lost.
    fn search(&mut self) {
        let Some(name) = self.target.find(&list().unwrap_or_default()) else {
            return;
        };
        match Serial::open(&name, self.baud) {
            Ok(source) => {
                self.open_error = None;
                self.target.name = name;
                self.source = Some(source);
                self.opened();
            }
            // Just after plugging in, permissions are not set yet, and other programs probe the
            // port: it is retried. Each error is reported once.
            Err(e) if self.open_error != Some(e.code()) => {
                self.open_error = Some(e.code());
                let hint = e.hint().map_or_else(String::new, |h| format!(" ({h})"));
                let text = format!("{e}; it is retried{hint}");
                self.events.push(Event::Warning { text });
            }
            Err(_) => {}
        }
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

/// The port to record from; none when the user ended the waiting.
fn find_target(
    args: &Args,
    tell: &mut dyn FnMut(Event),
    interrupted: &AtomicBool,
) -> Result<Option<Target>> {
    let mut is_told = false;
    loop {
        let ports = list().unwrap_or_default();
        let name = args.board.port.clone();
        let found = name.map_or_else(|| the_board(&ports).map(|port| port.name), Ok);
        match found {
            Err(e) if args.board.wait && e.code() == "no-port" => {}
            found => return found.map(|name| Some(Target::new(&name, &ports))),
        }
        if !std::mem::replace(&mut is_told, true) {
            let text = "a board to be plugged in".to_owned();
            tell(Event::Waiting { text });
        }
        if interrupted.load(Ordering::SeqCst) {
            return Ok(None);
        }
        std::thread::sleep(Duration::from_secs_f64(LOOK_FOR_S));
    }
}
