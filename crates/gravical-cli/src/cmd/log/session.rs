//! The loop between port, clock and disk and the recorder.

use std::collections::BTreeSet;
use std::time::{Duration, Instant, SystemTime};

use gravical::live::event::PortInfo;
use gravical::{Error, Result};

use super::Args;
use super::event::{Event, Status};
use super::file::LogFile;
use super::recorder::Recorder;
use crate::device::ports::{find_again, list, named, the_board};
use crate::device::serial::Serial;

/// Longest wait for bytes of the port.
const WAIT: Duration = Duration::from_millis(20);
/// Time between two synchronisations with the disk, s.
const SYNC_S: u64 = 10;

/// A recording of a port in a file.
pub struct Session {
    started: Instant,
    pub recorder: Recorder,
    pub file: LogFile,
    /// Rows that were looked at, and kinds of what was found in them.
    observed_rows: u64,
    found: BTreeSet<String>,
    /// The device that is open, or was.
    target: Option<PortInfo>,
    serial: Option<Serial>,
    /// The second in which a port was searched for, and the status reported.
    second: u64,
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
        args.board.wanted.validate()?;
        // Before the port, whose opening resets the board.
        let file = LogFile::open(&args.file(), args.existing)?;
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let day_s = now.map_or(0.0, |now| now.as_secs_f64() % 86_400.0);
        let mut session = Session {
            started: Instant::now(),
            recorder: Recorder::new(args.clone(), day_s, file.before())?,
            file,
            observed_rows: 0,
            found: BTreeSet::new(),
            target: None,
            serial: None,
            second: 0,
            open_error: None,
        };
        if let Err(error) = session.connect() {
            if !args.board.wait || !is_missing(&error) {
                session.file.discard_empty();
                return Err(error);
            }
            session.report_missing(&error);
        }
        Ok(session)
    }

    /// Seconds since it was opened.
    pub fn now_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// The port, as far as it is known.
    pub fn port(&self) -> Option<&str> {
        let target = self.target.as_ref().map(|target| target.name.as_str());
        target.or(self.recorder.args.board.port.as_deref())
    }

    /// Whether the port is open.
    pub fn is_plugged_in(&self) -> bool {
        self.serial.is_some()
    }

    /// Events since the last call.
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.recorder.events)
    }

    /// Waits shortly for bytes, and does what is due. Returns the lines that were written.
    ///
    /// # Errors
    ///
    /// Those that end the recording.
    pub fn step(&mut self) -> Result<Vec<u8>> {
        let read = match &mut self.serial {
            Some(serial) => serial.next(WAIT),
            None => {
                std::thread::sleep(WAIT);
                Ok(Vec::new())
            }
        };
        let now_s = self.now_s();
        let mut done = Ok(());
        match read {
            Ok(bytes) if bytes.is_empty() => {}
            Ok(bytes) => done = self.recorder.bytes(now_s, &bytes),
            Err(e) => self.lost(&e.to_string()),
        }
        let done = done.and_then(|()| self.recorder.tick(now_s));
        let second = now_s as u64;
        let last = std::mem::replace(&mut self.second, second);
        if last != second {
            if self.serial.is_none()
                && let Err(error) = self.connect()
            {
                self.report_missing(&error);
            }
            self.observe(now_s);
        }
        let lines = self.write()?;
        if last / SYNC_S != second / SYNC_S {
            self.file.sync()?;
        }
        done.map(|()| lines)
    }

    /// Pauses, or resumes.
    ///
    /// # Errors
    ///
    /// Those of the disk.
    pub fn toggle_pause(&mut self) -> Result<()> {
        let done = self.recorder.toggle_pause(self.now_s());
        self.write()?;
        self.file.sync()?;
        done
    }

    /// Ends the recording, and writes everything that has arrived, unless it failed.
    ///
    /// # Errors
    ///
    /// Those of the disk, and of the rows that are left.
    pub fn close(&mut self, has_failed: bool) -> Result<()> {
        // The reader thread ends first, otherwise a continuous stream would never end here.
        let rest = self.serial.take().map(Serial::rest).unwrap_or_default();
        let now_s = self.now_s();
        let mut done = Ok(());
        if !has_failed {
            let read = self.recorder.bytes(now_s, &rest);
            done = read.and_then(|()| self.recorder.finish(now_s));
        }
        self.write()?;
        self.file.sync()?;
        done
    }

    fn observe(&mut self, now_s: f64) {
        let recorder = &mut self.recorder;
        let counts = recorder.counts;
        if counts.rows == 0 || recorder.args.is_read_along {
            return;
        }
        let mut status = Status {
            rows: counts.rows,
            elapsed_s: recorder.elapsed_s(now_s),
            paused: recorder.is_paused(),
            rejected: counts.rejected,
            ..Status::default()
        };
        // Without new rows nothing is known of this second.
        if std::mem::replace(&mut self.observed_rows, counts.rows) != counts.rows
            && let Some(Ok(recording)) = recorder.reader.recording(u32::MAX)
        {
            status.observe(&recording);
            for finding in recording.findings {
                if finding.is_of_samples() && self.found.insert(finding.kind.clone()) {
                    recorder.say(Event::Finding(finding));
                }
            }
        }
        recorder.say(Event::Status(status));
    }

    /// Writes the lines that wait, and sends the commands.
    fn write(&mut self) -> Result<Vec<u8>> {
        let lines = std::mem::take(&mut self.recorder.text);
        self.file.write(&lines)?;
        let commands = std::mem::take(&mut self.recorder.commands);
        if let Some(serial) = self.serial.as_mut().filter(|_| !commands.is_empty())
            && let Err(e) = serial.send(commands.as_bytes())
        {
            self.lost(&e.to_string());
        }
        Ok(lines)
    }

    fn lost(&mut self, why: &str) {
        self.serial = None;
        self.recorder.lost(why);
    }

    /// Opens the port; nothing while the device that was lost is away.
    ///
    /// # Errors
    ///
    /// It is not clear which port it is, or it cannot be opened.
    fn connect(&mut self) -> Result<()> {
        let board = &self.recorder.args.board;
        let ports = list().unwrap_or_default();
        let name = match (&self.target, &board.port) {
            (Some(target), _) => match find_again(target, &ports) {
                Some(name) => name,
                None => return Ok(()),
            },
            (None, Some(given)) => given.clone(),
            (None, None) => the_board(&ports)?.name,
        };
        self.serial = Some(Serial::open(&name, board.baud)?);
        self.open_error = None;
        let target = named(&name, &ports);
        let preamble = format!(
            "# gravical {} log, {}, {name}\n",
            env!("CARGO_PKG_VERSION"),
            gravical::calibration_file::creation_time(),
        );
        let (now_s, device) = (self.now_s(), target.device.clone());
        self.recorder.opened(now_s, &name, device, preamble);
        self.target = Some(target);
        Ok(())
    }

    /// Just after plugging in, permissions are not set yet, and other programs probe the port: an error
    /// is reported once, and it is retried.
    fn report_missing(&mut self, error: &Error) {
        if self.open_error.replace(error.code()) != Some(error.code()) {
            let hint = error.hint().filter(|_| !is_missing(error));
            let hint = hint.map_or_else(String::new, |hint| format!(" ({hint})"));
            let text = format!("waiting for the port: {error}{hint}");
            self.recorder.say(Event::Waiting { text });
        }
    }
}

/// There is no port, yet.
fn is_missing(error: &Error) -> bool {
    matches!(error.code(), "no-port" | "no-such-port")
}
