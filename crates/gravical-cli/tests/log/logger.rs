//! The program under test, and a terminal for its user.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use rustix::termios::{LocalModes, tcgetattr};
use serde_json::Value;

use crate::board::pair;

/// A wait that takes longer has failed, on a busy machine too.
const PATIENCE: Duration = Duration::from_secs(30);

/// `gravical` with the words of `line`.
pub fn program(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gravical"));
    command.args(line.split_whitespace()).current_dir(folder);
    command
}

/// Runs `gravical` with the words of `line`: its exit code and its JSON.
pub fn run(folder: &Path, line: &str) -> (i32, Value) {
    let run = program(folder, line).output().unwrap();
    let json = serde_json::from_slice(&run.stdout);
    let json = json.unwrap_or_else(|e| panic!("{e}: {run:?}"));
    (run.status.code().unwrap(), json)
}

/// Waits until `done`.
pub fn until(mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < PATIENCE, "it was not met in time");
        std::thread::sleep(Duration::from_millis(10));
    }
}

pub fn signal(child: &Child, signal: Signal) {
    let pid = Pid::from_raw(i32::try_from(child.id()).unwrap()).unwrap();
    kill_process(pid, signal).unwrap();
}

pub struct Logger {
    child: Child,
    lines: Receiver<String>,
    seen: Vec<Value>,
}

impl Logger {
    /// Runs `gravical` with the words of `line`, and reads its events.
    pub fn start(folder: &Path, line: &str) -> Self {
        Self::start_with(program(folder, line))
    }

    /// Runs a command, and reads its events.
    pub fn start_with(mut command: Command) -> Self {
        Self::of(command.stdin(Stdio::null()).stderr(Stdio::piped()))
    }

    /// Reads the events that have arrived.
    pub fn look(&mut self) {
        while let Ok(line) = self.lines.recv_timeout(Duration::from_millis(10)) {
            self.seen.push(serde_json::from_str(&line).unwrap());
        }
    }

    pub fn has_seen(&self, kind: &str) -> bool {
        self.seen.iter().any(|event| event["type"] == kind)
    }

    /// How often that event has arrived.
    pub fn count(&self, event: &Value) -> usize {
        self.seen.iter().filter(|seen| *seen == event).count()
    }

    /// Runs a command with a terminal for input and messages, and reads its events.
    pub fn start_in(mut command: Command, terminal: &Terminal) -> Self {
        let end = || Stdio::from(terminal.theirs.try_clone().unwrap());
        Self::of(command.env("TERM", "xterm").stdin(end()).stderr(end()))
    }

    fn of(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let (sender, lines) = channel();
        let out = child.stdout.take().unwrap();
        std::thread::spawn(move || {
            let mut lines = BufReader::new(out).lines().map_while(Result::ok);
            lines.all(|line| sender.send(line).is_ok())
        });
        let seen = Vec::new();
        Logger { child, lines, seen }
    }

    /// The next event of that type, which has these values.
    pub fn wait_for_one(&mut self, kind: &str, values: Value) -> Value {
        let event = self.wait_for(kind);
        for (key, value) in values.as_object().unwrap() {
            assert_eq!(event[key], *value, "{key} of {event}");
        }
        event
    }

    /// The next event of that type.
    pub fn wait_for(&mut self, kind: &str) -> Value {
        self.wait(kind, |event| event["type"] == kind)
    }

    /// A status with at least this many rows.
    pub fn wait_for_rows(&mut self, rows: u64) {
        self.wait("enough rows", |event| {
            event["type"] == "status" && event["rows"].as_u64().unwrap() >= rows
        });
    }

    fn wait(&mut self, what: &str, is: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let left = PATIENCE.saturating_sub(start.elapsed());
            let Ok(line) = self.lines.recv_timeout(left) else {
                panic!("waited for {what}; events: {:#?}", self.seen);
            };
            let event: Value = serde_json::from_str(&line).expect(&line);
            assert_eq!(event["v"], 1, "{event}");
            self.seen.push(event.clone());
            if is(&event) {
                return event;
            }
        }
    }

    /// The last event of that type.
    pub fn seen(&self, kind: &str) -> &Value {
        let found = self.seen.iter().rfind(|e| e["type"] == kind);
        found.unwrap_or_else(|| panic!("no {kind} in {:#?}", self.seen))
    }

    pub fn signal(&self, which: Signal) {
        signal(&self.child, which);
    }

    /// Waits for its end: the exit code, none after a signal.
    pub fn gone(&mut self) -> Option<i32> {
        let mut status = None;
        until(|| {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        status.unwrap().code()
    }

    /// The exit code, and the event `ended`, or the error.
    pub fn ended(&mut self) -> (i32, Value) {
        let code = self.gone().expect("ended by a signal");
        let rest: Vec<String> = self.lines.iter().collect();
        // An error is one object on several lines, after all events.
        let mut error = String::new();
        for line in rest {
            match serde_json::from_str::<Value>(&line) {
                Ok(event) if error.is_empty() && event["v"] == 1 => self.seen.push(event),
                _ => error.push_str(&line),
            }
        }
        let last = match serde_json::from_str(&error) {
            Ok(error) => error,
            Err(_) => self.seen("ended").clone(),
        };
        (code, last)
    }

    /// It has to end with this exit code and this error; the error.
    pub fn refused(&mut self, exit: i32, code: &str) -> Value {
        let (ended, error) = self.ended();
        assert_eq!((ended, &error["code"]), (exit, &code.into()), "{error}");
        error
    }

    /// The exit code, and standard error.
    pub fn ended_text(&mut self) -> (i32, String) {
        let code = self.gone().expect("ended by a signal");
        let mut err = String::new();
        let mut from = self.child.stderr.take().unwrap();
        from.read_to_string(&mut err).unwrap();
        (code, err)
    }
}

impl Drop for Logger {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The terminal of a user.
pub struct Terminal {
    ours: File,
    theirs: OwnedFd,
    text: String,
    /// The end of the text that was waited for last.
    read: usize,
}

impl Terminal {
    pub fn new() -> Self {
        let (ours, theirs, _) = pair(false);
        Terminal {
            ours,
            theirs,
            text: String::new(),
            read: 0,
        }
    }

    /// Lines and echo, as a shell has it.
    pub fn is_cooked(&self) -> bool {
        let modes = tcgetattr(&self.theirs).unwrap().local_modes;
        modes.contains(LocalModes::ICANON | LocalModes::ECHO)
    }

    pub fn press(&mut self, keys: &str) {
        self.ours.write_all(keys.as_bytes()).unwrap();
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    pub fn wait_for(&mut self, wanted: &str) {
        let mut bytes = Vec::new();
        until(|| {
            let mut piece = [0; 1024];
            if let Ok(n) = self.ours.read(&mut piece) {
                bytes.extend_from_slice(&piece[..n]);
                if let Ok(text) = std::str::from_utf8(&bytes) {
                    self.text.push_str(text);
                    bytes.clear();
                }
            }
            let found = self.text[self.read..].find(wanted);
            self.read += found.map_or(0, |at| at + wanted.len());
            found.is_some()
        });
    }
}
