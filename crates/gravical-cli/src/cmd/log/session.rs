//! The loop: port, keyboard, clock and disk on one side, the recorder on the other.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use gravical::Error;

use super::Args;
use super::files::{Continued, Files, continued};
use super::keys::{Key, Keys};
use super::summary::summary;
use super::teller::Teller;
use crate::device::board::MOST_BINARY_HZ;
use crate::device::event::{End, Event};
use crate::device::ports::{Port, Target, list, the_board};
use crate::device::recorder::{Action, Options, Recorder};
use crate::device::serial::Serial;
use crate::device::source::{Incoming, SampleSource};
use crate::device::trouble::holders;
use crate::failure;

/// How long one look at the port takes.
const LOOK: Duration = Duration::from_millis(20);
/// Rows are handed to the disk so often, s.
const HAND_OVER_S: f64 = 0.2;
/// What was handed over is made safe so often, s.
const SYNC_S: f64 = 10.0;
/// A port that is not there is looked for so often, s.
const LOOK_FOR_S: f64 = 0.3;
/// At the end the disk gets so many more chances.
const LAST_CHANCES: u32 = 5;

/// Records until it is told to end.
pub fn record(args: &Args) -> anyhow::Result<ExitCode> {
    let path = args.file();
    let before = if args.append {
        continued(&path)?
    } else {
        Continued::default()
    };
    let wanted = before.wanted(args.wanted())?;
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    ctrlc::set_handler(move || flag.store(true, Ordering::SeqCst))?;
    Files::check(&path, args.append)?;
    let ports = list().unwrap_or_default();
    let mut teller = Teller::new(args.json, args.quiet);
    if let Some(rate) = wanted.rate_hz.filter(|rate| *rate > MOST_BINARY_HZ) {
        teller.tell(&Event::Warning {
            text: format!(
                "at {rate} Hz the board cannot send every sample: it skips some and counts them as overruns; {MOST_BINARY_HZ} Hz get through"
            ),
        });
    }
    let found = target(args, &ports, &mut teller, &interrupted)?;
    let Some(target) = found else {
        return Ok(ExitCode::from(failure::INTERRUPTED));
    };
    let source = if args.board.wait && target.find(&ports).is_none() {
        None
    } else {
        Some(Serial::open(&target.name, args.board.baud)?)
    };
    // After the port: a board that is not there leaves no empty file.
    let files = Files::open(&path, args.append)?;
    let options = Options {
        wanted,
        rows: args.rows,
        duration_s: args.duration,
        wait: args.board.wait,
        preamble: vec![format!(
            "gravical {} log, {}, {}",
            env!("CARGO_PKG_VERSION"),
            gravical::calibration_file::creation_time(),
            target.name
        )],
        continues: before.header,
        baud: args.board.baud,
    };
    let mut session = Session {
        started: Instant::now(),
        recorder: Recorder::new(options),
        teller,
        files,
        source,
        target,
        baud: args.board.baud,
        last_hand_over_s: 0.0,
        last_sync_s: 0.0,
        last_search_s: 0.0,
        disk_error: None,
    };
    session.opened();
    let keys = Keys::new();
    session.teller.raw = keys.is_some();
    let failed = session.run(keys.as_ref(), &interrupted);
    session.teller.close();
    drop(keys);
    session.end(args, failed)
}

/// The port that is meant; none when the user ended the waiting.
fn target(
    args: &Args,
    ports: &[Port],
    teller: &mut Teller,
    interrupted: &AtomicBool,
) -> gravical::Result<Option<Target>> {
    if let Some(name) = &args.board.port {
        return Ok(Some(Target::new(name, ports)));
    }
    let mut found = the_board(ports);
    let mut told = false;
    while args.board.wait && found.as_ref().is_err_and(|e| e.code() == "no-port") {
        if !std::mem::replace(&mut told, true) {
            teller.tell(&Event::Waiting {
                text: "a board to be plugged in".to_owned(),
            });
        }
        if interrupted.load(Ordering::SeqCst) {
            return Ok(None);
        }
        std::thread::sleep(Duration::from_secs_f64(LOOK_FOR_S));
        let ports = list().unwrap_or_default();
        found = the_board(&ports);
        if let Ok(port) = &found {
            return Ok(Some(Target::new(&port.name, &ports)));
        }
    }
    found.map(|port| Some(Target::new(&port.name, ports)))
}

struct Session {
    started: Instant,
    recorder: Recorder,
    teller: Teller,
    files: Files,
    source: Option<Serial>,
    target: Target,
    baud: u32,
    last_hand_over_s: f64,
    last_sync_s: f64,
    last_search_s: f64,
    disk_error: Option<String>,
}

impl Session {
    fn now_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// The port was opened: who else reads it steals from it.
    fn opened(&mut self) {
        if self.source.is_none() {
            self.teller.tell(&Event::Waiting {
                text: format!("{} to be there", self.target.name),
            });
            return;
        }
        let device = self.target.device(&list().unwrap_or_default());
        let now_s = self.now_s();
        let name = self.target.name.clone();
        self.recorder.opened(now_s, &name, device.as_deref());
        self.act(now_s);
        let others = holders(&name);
        if !others.is_empty() {
            let programs = others.join(" and ");
            self.teller.tell(&Event::Shared { programs });
        }
    }

    fn run(&mut self, keys: Option<&Keys>, interrupted: &AtomicBool) -> Option<Error> {
        loop {
            let incoming = match &mut self.source {
                Some(source) => source.next(LOOK),
                None => {
                    std::thread::sleep(LOOK);
                    Incoming::Nothing
                }
            };
            let now_s = self.now_s();
            match incoming {
                Incoming::Bytes(bytes) => self.recorder.bytes(now_s, &bytes),
                Incoming::Nothing => {}
                Incoming::Lost(why) => self.lost(now_s, &why),
            }
            if self.source.is_none() {
                self.search(now_s);
            }
            match keys.and_then(Keys::pressed) {
                Some(Key::Pause) => self.recorder.toggle_pause(now_s),
                Some(Key::End) => interrupted.store(true, Ordering::SeqCst),
                None => {}
            }
            self.recorder.tick(now_s);
            if now_s - self.last_hand_over_s >= HAND_OVER_S {
                self.last_hand_over_s = now_s;
                self.hand_over(now_s);
            }
            self.act(now_s);
            if now_s - self.last_sync_s >= SYNC_S {
                self.sync(now_s);
            }
            let fatal = self.recorder.take_fatal();
            if fatal.is_some()
                || self.recorder.ended().is_some()
                || interrupted.load(Ordering::SeqCst)
            {
                return fatal;
            }
        }
    }

    fn lost(&mut self, now_s: f64, why: &str) {
        self.source = None;
        self.recorder.lost(now_s, why);
        self.last_search_s = now_s;
    }

    /// Looks for the device that was lost.
    fn search(&mut self, now_s: f64) {
        if now_s - self.last_search_s < LOOK_FOR_S {
            return;
        }
        self.last_search_s = now_s;
        let ports = list().unwrap_or_default();
        if let Some(name) = self.target.find(&ports)
            // Just plugged in, its rights are not set yet, and others look at it.
            && let Ok(source) = Serial::open(&name, self.baud)
        {
            self.target.name = name;
            self.source = Some(source);
            self.opened();
        }
    }

    fn act(&mut self, now_s: f64) {
        self.teller.settings = self.recorder.settings().copied();
        for action in self.recorder.take() {
            match action {
                Action::Send(bytes) => {
                    let sent = self.source.as_mut().map(|source| source.send(&bytes));
                    if let Some(Err(e)) = sent {
                        self.lost(now_s, &e.to_string());
                    }
                }
                Action::Baud(baud) => self.set_baud(now_s, baud),
                Action::Sync => {
                    self.hand_over(now_s);
                    self.sync(now_s);
                }
                Action::Tell(event) => self.teller.tell(&event),
            }
        }
    }

    fn set_baud(&mut self, now_s: f64, baud: u32) {
        match self.source.as_mut().map(|source| source.set_baud(baud)) {
            Some(Ok(before)) => {
                self.recorder.bytes(now_s, &before);
                self.recorder.baud_is_set(now_s);
            }
            Some(Err(e)) => self.lost(now_s, &e.to_string()),
            None => {}
        }
    }

    /// Rows go to the system; `true` when nothing waits any more.
    fn hand_over(&mut self, now_s: f64) -> bool {
        let mut done = true;
        if let Some(batch) = self.recorder.batch() {
            match self.files.rows(&batch.bytes) {
                Ok(()) => {
                    self.recorder.stored();
                    self.disk_error = None;
                }
                Err(e) => {
                    self.recorder.failed(now_s, &e.to_string());
                    self.disk_error = Some(e.to_string());
                    done = false;
                }
            }
        }
        if let Some(batch) = self.recorder.rejects() {
            let stored = self.files.rejects(&batch.bytes).is_ok();
            self.recorder.rejects_done(stored);
            done &= stored;
        }
        done
    }

    fn sync(&mut self, now_s: f64) {
        self.last_sync_s = now_s;
        if let Err(e) = self.files.sync() {
            self.disk_error = Some(e.to_string());
            self.teller.tell(&Event::DiskFailed {
                text: e.to_string(),
            });
        }
    }

    /// Everything that waits is written, and the sum is told.
    fn end(mut self, args: &Args, failed: Option<Error>) -> anyhow::Result<ExitCode> {
        let unplugged = self.source.is_none() && self.recorder.is_started();
        // What came while the last rows were written belongs to it.
        while self.recorder.ended().is_none()
            && let Some(source) = &mut self.source
            && let Incoming::Bytes(bytes) = source.next(Duration::ZERO)
        {
            let now_s = self.started.elapsed().as_secs_f64();
            self.recorder.bytes(now_s, &bytes);
        }
        self.source = None;
        let now_s = self.now_s();
        let elapsed_s = self.recorder.elapsed_s(now_s);
        self.recorder.finish(now_s, End::User);
        for chance in 0..LAST_CHANCES {
            if self.hand_over(now_s) {
                break;
            }
            if chance + 1 < LAST_CHANCES {
                std::thread::sleep(Duration::from_millis(100));
            }
        }
        self.recorder.give_up();
        self.act(now_s);
        let account = *self.recorder.account();
        let reason = self.recorder.ended().unwrap_or(End::User);
        let path = args.file();
        let ended = Event::Ended {
            file: path.display().to_string(),
            rejected_file: self.files.rejected_file().map(|p| p.display().to_string()),
            reason,
            elapsed_s,
            account,
        };
        self.teller.tell(&ended);
        if self.recorder.is_started() && !args.json && !args.quiet {
            self.teller
                .line(&summary(&path.display().to_string(), &ended));
        }
        if !self.recorder.is_started() && !args.append {
            self.files.discard();
        }
        if let Some(error) = failed {
            return Err(error.into());
        }
        if let Some(text) = self.disk_error {
            let error =
                std::io::Error::other(format!("{text}; {} rows are lost", account.unstored));
            return Err(Error::io(&path, error).into());
        }
        let short = reason == End::User
            && (args.rows.is_some() || args.duration.is_some() || account.incomplete > 0);
        let nothing = !self.recorder.is_started();
        Ok(ExitCode::from(
            if reason == End::User && (short || nothing || unplugged) {
                failure::INTERRUPTED
            } else if unplugged {
                failure::DEVICE
            } else if self.recorder.ended_in_gap() {
                failure::INTERRUPTED
            } else {
                0
            },
        ))
    }
}
