//! The threads around the recorder: one reads the port, and one writes the file. Whoever shows the
//! recording, or judges it, gets what was written afterwards.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

use gravical::live::event::PortInfo;
use gravical::live::recorder::{Event, NO_ROWS, Output, Recorder, RecorderOptions};
use gravical::{Error, Result};
use gravical_report::document::flag;

use super::board::BoardArgs;
use super::file::LogFile;
use crate::device::ports::{find_again, list, named, the_board};
use crate::device::serial::Serial;

/// Longest wait for bytes of the port, and for output of the recording.
const WAIT: Duration = Duration::from_millis(20);
/// At the end a port that says nothing for this time is not waited for.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two searches for a lost port, two looks at the file, and two synchronisations with the
/// disk, s.
const SEARCH_S: f64 = 0.2;
const LOOK_S: f64 = 1.0;
const SYNC_S: f64 = 10.0;
/// Bytes that wait for the disk at most: those of 20 minutes at 115200 baud.
const MAX_WAITING: u64 = 1 << 24;
/// Lines are passed to the disk at the latest when there are so many bytes of them.
const WRITE_BYTES: usize = 1 << 16;

/// What the thread that writes has to take.
enum Input {
    /// Bytes of the port and when they arrived; none when nothing arrived for a while.
    Bytes(Instant, Vec<u8>),
    /// So many bytes had no room.
    Dropped(u64),
    /// The port is lost, or was closed.
    Lost(io::Error),
    /// The user pauses, or resumes.
    Pause,
    /// The user ends it; what is held is written, unless it `discards` that.
    Stop { discards: bool },
}

/// The way from the port to the thread that writes. It has room for so many bytes, and never waits.
#[derive(Clone)]
struct Queue {
    inputs: Sender<Input>,
    waiting: Arc<AtomicU64>,
    /// Bytes that had no room. More are dropped until there is some, so that one gap is named, not many.
    dropped: u64,
}

impl Queue {
    /// Passes on what was read; false once nobody takes it.
    fn send(&mut self, read: io::Result<Vec<u8>>) -> bool {
        let length = read.as_ref().map_or(0, Vec::len) as u64;
        let share = if self.dropped > 0 { 2 } else { 1 };
        let has_room = self.waiting.load(Ordering::Acquire) + length <= MAX_WAITING / share;
        if read.is_ok() && !has_room {
            self.dropped += length;
            return true;
        }
        let dropped = std::mem::take(&mut self.dropped);
        if dropped > 0 && self.inputs.send(Input::Dropped(dropped)).is_err() {
            return false;
        }
        self.waiting.fetch_add(length, Ordering::AcqRel);
        let input = read.map_or_else(Input::Lost, |bytes| Input::Bytes(Instant::now(), bytes));
        self.inputs.send(input).is_ok()
    }
}

/// A recording of a port in a file.
pub struct Recording {
    inputs: Sender<Input>,
    pub outputs: Receiver<Output>,
    writer: Option<JoinHandle<Ended>>,
}

/// A recording that has ended.
pub struct Ended {
    pub recorder: Recorder,
    pub file: LogFile,
    pub done: Result<()>,
    /// Time of the last input, s.
    pub now_s: f64,
    pub is_unplugged: bool,
}

impl Recording {
    /// Opens the port, without one the only board, and records it. A missing port is searched for if that is
    /// wanted.
    ///
    /// # Errors
    ///
    /// Those of the options, of the file and of the port.
    pub fn start(
        board: &BoardArgs,
        file: LogFile,
        rows: Option<u64>,
        duration_s: Option<f64>,
    ) -> Result<Self> {
        let options = RecorderOptions {
            name: file.path.display().to_string(),
            columns: board.columns.clone(),
            wanted: board.wanted,
            rows,
            duration_s,
        };
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let day_s = now.map_or(0.0, |now| now.as_secs_f64() % 86_400.0);
        let (inputs, incoming) = channel();
        let (outgoing, outputs) = channel();
        let queue = Queue {
            inputs: inputs.clone(),
            waiting: Arc::default(),
            dropped: 0,
        };
        let mut writer = Writer {
            started: Instant::now(),
            heard: Instant::now(),
            now_s: 0.0,
            recorder: Recorder::new(options, day_s, &file.before)?,
            file,
            board: board.clone(),
            target: None,
            serial: None,
            reported: None,
            queue,
            outputs: outgoing,
        };
        if let Err(error) = writer.connect() {
            if !board.wait || !is_missing(&error) {
                writer.file.discard_empty();
                return Err(error);
            }
            writer.report_missing(&error);
        }
        let writer = std::thread::spawn(move || writer.run(&incoming));
        Ok(Recording {
            inputs,
            outputs,
            writer: Some(writer),
        })
    }

    /// Waits shortly for what was written; none once it has ended.
    pub fn next(&self) -> Option<Output> {
        match self.outputs.recv_timeout(WAIT) {
            Ok(output) => Some(output),
            Err(RecvTimeoutError::Timeout) => Some(Output::default()),
            Err(RecvTimeoutError::Disconnected) => None,
        }
    }

    /// Pauses, or resumes.
    pub fn toggle_pause(&self) {
        // A recording that has ended does not pause.
        let _ = self.inputs.send(Input::Pause);
    }

    /// Ends it, and waits until everything that has arrived is written, unless it `discards` what is held.
    /// None if it has been ended before.
    pub fn end(&mut self, discards: bool) -> Option<Ended> {
        let _ = self.inputs.send(Input::Stop { discards });
        // A panic of that thread has ended the program.
        self.writer.take()?.join().ok()
    }
}

/// The thread that writes.
struct Writer {
    started: Instant,
    /// When the last input came, and its time, s.
    heard: Instant,
    now_s: f64,
    recorder: Recorder,
    file: LogFile,
    board: BoardArgs,
    /// The device that is open, or was.
    target: Option<PortInfo>,
    serial: Option<Serial>,
    /// Code of the error with which the port cannot be opened, or sends no rows.
    reported: Option<&'static str>,
    queue: Queue,
    outputs: Sender<Output>,
}

impl Writer {
    fn run(mut self, inputs: &Receiver<Input>) -> Ended {
        let recorded = self.record(inputs);
        let is_unplugged = self.serial.take().is_none();
        // Also after an error, what the recorder passed on before is written.
        let written = self.write();
        let done = recorded.and(written).and(self.file.sync());
        let lost_rows = self.file.lost_rows;
        self.recorder.counts.rows = self.recorder.counts.rows.saturating_sub(lost_rows);
        Ended {
            recorder: self.recorder,
            file: self.file,
            done,
            now_s: self.now_s,
            is_unplugged,
        }
    }

    fn record(&mut self, inputs: &Receiver<Input>) -> Result<()> {
        let (mut searched_s, mut looked_s, mut synced_s) = (0.0, 0.0, 0.0);
        let mut stop = None;
        while self.recorder.end.is_none() {
            let taken = self.take(inputs, &mut stop);
            if stop.is_some() && self.heard.elapsed() > PATIENCE {
                // The driver of the port is stuck.
                self.serial = None;
            }
            // What the recorder passed on before an error is written, too.
            self.write().and(taken)?;
            match (stop, &self.serial) {
                (Some(true), None) => return Ok(()),
                (Some(false), None) => return self.recorder.finish(self.now_s),
                _ => {}
            }
            if self.serial.is_none()
                && self.is_due(&mut searched_s, SEARCH_S)
                && let Err(error) = self.connect()
            {
                self.report_missing(&error);
            }
            if self.is_due(&mut looked_s, LOOK_S) {
                if let Some(status) = self.recorder.status(self.now_s) {
                    self.recorder.report(Event::Status(status));
                }
                self.file.write(&[])?;
            }
            if self.is_due(&mut synced_s, SYNC_S) {
                self.file.sync()?;
            }
        }
        Ok(())
    }

    fn is_due(&self, last_s: &mut f64, period_s: f64) -> bool {
        let is_due = self.now_s - *last_s >= period_s;
        if is_due {
            *last_s = self.now_s;
        }
        is_due
    }

    /// Takes what waits.
    fn take(&mut self, inputs: &Receiver<Input>, stop: &mut Option<bool>) -> Result<()> {
        let mut bytes_left = WRITE_BYTES;
        let mut wait = WAIT;
        while bytes_left > 0
            && let Ok(input) = inputs.recv_timeout(wait)
        {
            wait = Duration::ZERO;
            self.heard = Instant::now();
            match input {
                Input::Bytes(at, bytes) => {
                    let waiting = &self.queue.waiting;
                    waiting.fetch_sub(bytes.len() as u64, Ordering::AcqRel);
                    bytes_left = bytes_left.saturating_sub(bytes.len());
                    self.now_s = (at - self.started).as_secs_f64();
                    let recorded = self.recorder.bytes(self.now_s, &bytes);
                    self.wait_for_rows(recorded)?;
                }
                Input::Dropped(bytes) => {
                    let recorded = self.recorder.overflow(bytes);
                    self.wait_for_rows(recorded)?;
                }
                Input::Lost(why) => {
                    self.serial = None;
                    if stop.is_none() {
                        self.recorder.lost(&why.to_string());
                    }
                }
                Input::Pause => {
                    self.recorder.toggle_pause(self.now_s)?;
                    self.write()?;
                    self.file.sync()?;
                }
                Input::Stop { discards } => {
                    *stop = Some(discards);
                    if let Some(serial) = &self.serial {
                        serial.close();
                    }
                }
            }
        }
        // Without a port nobody else tells the time.
        if self.serial.is_none() {
            self.now_s = self.started.elapsed().as_secs_f64();
            let recorded = self.recorder.bytes(self.now_s, b"");
            self.wait_for_rows(recorded)?;
        }
        Ok(())
    }

    /// What arrives in place of rows is an error, unless rows are waited for.
    fn wait_for_rows(&mut self, recorded: Result<()>) -> Result<()> {
        let error = match recorded {
            Err(error) if NO_ROWS.contains(&error.code()) => error,
            recorded => return recorded,
        };
        let hint = error.worded_hint(flag).unwrap_or_default();
        if !self.board.wait {
            let more = "gravical ports lists the ports, --wait waits without end";
            return Err(error.with_hint(format!("{hint}; {more}")));
        }
        let text = format!("{}; {hint}", error.message());
        self.report_once(&error, Event::Warning { text });
        Ok(())
    }

    /// Writes the lines that wait, sends the commands, and passes on what was written.
    fn write(&mut self) -> Result<()> {
        let output = self.recorder.take();
        if !output.lines.is_empty() {
            self.file.write(&output.lines)?;
        }
        if let Some(serial) = self.serial.as_mut().filter(|_| !output.commands.is_empty()) {
            // A port that is lost is noticed by its reader.
            let _ = serial.send(output.commands.as_bytes());
        }
        if !output.lines.is_empty() || !output.events.is_empty() {
            // Nobody may want it any more.
            let _ = self.outputs.send(output);
        }
        Ok(())
    }

    /// Opens the port; nothing while the device that was lost is away.
    ///
    /// # Errors
    ///
    /// It is not clear which port it is, or it cannot be opened.
    fn connect(&mut self) -> Result<()> {
        let ports = list().unwrap_or_default();
        let name = match (&self.target, &self.board.port) {
            (Some(target), _) => match find_again(target, &ports) {
                Some(name) => name,
                None => return Ok(()),
            },
            (None, Some(given)) => given.clone(),
            (None, None) => the_board(&ports)?.name,
        };
        let mut queue = self.queue.clone();
        let serial = Serial::open(&name, self.board.baud, move |read| queue.send(read))?;
        self.serial = Some(serial);
        self.reported = None;
        let target = named(&name, &ports);
        let preamble = format!(
            "# gravical {} log, {}, {name}\n",
            env!("CARGO_PKG_VERSION"),
            gravical::calibration_file::creation_time(),
        );
        self.now_s = self.started.elapsed().as_secs_f64();
        self.recorder
            .opened(self.now_s, &name, target.device.clone(), preamble);
        self.target = Some(target);
        Ok(())
    }

    /// Just after plugging in, permissions are not set yet, and other programs probe the port: an error
    /// is reported once, and it is retried.
    fn report_missing(&mut self, error: &Error) {
        let hint = error.hint().filter(|_| !is_missing(error));
        let hint = hint.map_or_else(String::new, |hint| format!(" ({hint})"));
        let text = format!("waiting for the port: {error}{hint}");
        self.report_once(error, Event::Waiting { text });
    }

    fn report_once(&mut self, error: &Error, event: Event) {
        if self.reported.replace(error.code()) != Some(error.code()) {
            self.recorder.report(event);
        }
    }
}

/// There is no port, yet.
fn is_missing(error: &Error) -> bool {
    matches!(error.code(), "no-port" | "no-such-port")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_without_room_are_counted_and_the_port_is_not_waited_for() {
        let (inputs, taken) = channel();
        let waiting = Arc::new(AtomicU64::new(MAX_WAITING - 100));
        let mut queue = Queue {
            inputs,
            waiting: Arc::clone(&waiting),
            dropped: 0,
        };
        for _ in 0..3 {
            assert!(queue.send(Ok(vec![0; 60])));
        }
        waiting.store(0, Ordering::Release);
        assert!(queue.send(Ok(vec![0; 40])));
        let taken: Vec<Input> = taken.try_iter().collect();
        assert!(matches!(
            taken[..],
            [Input::Bytes(..), Input::Dropped(120), Input::Bytes(..)]
        ));
    }
}
