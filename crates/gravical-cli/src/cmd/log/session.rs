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
use super::target::{LOOK_FOR_S, target};
use super::teller::Teller;
use crate::device::board::MOST_BINARY_HZ;
use crate::device::event::{End, Event};
use crate::device::ports::{Target, list};
use crate::device::recorder::{Action, Options, Recorder};
use crate::device::serial::{Incoming, Serial};
use crate::device::trouble::holders;
use crate::failure;

/// How long one look at the port takes.
const LOOK: Duration = Duration::from_millis(20);
/// Bytes that are taken at once.
const PIECE: usize = 1 << 12;
/// Rows are handed to the disk so often, s.
const HAND_OVER_S: f64 = 0.2;
/// What was handed over is made safe so often, s.
const SYNC_S: f64 = 10.0;
/// At the end the disk gets so many more chances.
const LAST_CHANCES: u32 = 5;

/// Records until it is told to end.
pub fn record(args: &Args, teller: &mut Teller) -> anyhow::Result<ExitCode> {
    let path = args.file();
    Files::check(&path, args.append)?;
    let before = if args.append {
        continued(&path)?
    } else {
        Continued::default()
    };
    let wanted = before.wanted(args.wanted())?;
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    ctrlc::set_handler(move || flag.store(true, Ordering::SeqCst))?;
    let ports = list().unwrap_or_default();
    if let Some(rate) = wanted.rate_hz.filter(|rate| *rate > MOST_BINARY_HZ) {
        teller.tell(&Event::Warning {
            text: format!(
                "at {rate} Hz the board cannot send every sample: it skips some and counts them as overruns; {MOST_BINARY_HZ} Hz get through"
            ),
        });
    }
    let found = target(args, &ports, teller, &interrupted)?;
    let Some(target) = found else {
        return Ok(ExitCode::from(failure::INTERRUPTED));
    };
    let source = if args.board.wait && target.find(&ports).is_none() {
        None
    } else {
        Some(Serial::open(&target.name, args.board.baud)?)
    };
    // After the port: a board that is not there leaves no empty file.
    let (files, torn) = Files::open(&path, args.append)?;
    if let Some(text) = torn {
        teller.tell(&Event::Warning { text });
    }
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
        rejects_error: None,
        sync_error: None,
        file_loss: None,
        refused: None,
    };
    session.opened();
    let keys = Keys::new();
    session.teller.raw = keys.is_some();
    let failed = session.run(keys.as_ref(), &interrupted);
    session.teller.close();
    drop(keys);
    session.end(args, failed)
}

struct Session<'a> {
    started: Instant,
    recorder: Recorder,
    teller: &'a mut Teller,
    files: Files,
    source: Option<Serial>,
    target: Target,
    baud: u32,
    last_hand_over_s: f64,
    last_sync_s: f64,
    last_search_s: f64,
    disk_error: Option<String>,
    rejects_error: Option<String>,
    sync_error: Option<String>,
    /// The file was taken away while it was recorded.
    file_loss: Option<String>,
    /// Why the port could not be opened when it was looked for.
    refused: Option<&'static str>,
}

impl Session<'_> {
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
                Incoming::Bytes(bytes) => self.bytes(now_s, &bytes),
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

    /// What came, in pieces: of what waits for the disk none is too much.
    fn bytes(&mut self, now_s: f64, bytes: &[u8]) {
        for piece in bytes.chunks(PIECE) {
            self.recorder.bytes(now_s, piece);
            if self.recorder.is_crowded() {
                self.hand_over(now_s);
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
        let Some(name) = self.target.find(&ports) else {
            return;
        };
        match Serial::open(&name, self.baud) {
            Ok(source) => {
                self.refused = None;
                self.target.name = name;
                self.source = Some(source);
                self.opened();
            }
            // Just plugged in, its rights are not set yet, and others look at it: it is
            // tried again. Each reason is told once.
            Err(e) => {
                if self.refused != Some(e.code()) {
                    self.refused = Some(e.code());
                    let hint = e.hint().map_or_else(String::new, |h| format!(" ({h})"));
                    self.teller.tell(&Event::Warning {
                        text: format!("{e}; it is tried again{hint}"),
                    });
                }
            }
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
                self.bytes(now_s, &before);
                self.recorder.baud_is_set(now_s);
            }
            Some(Err(e)) => self.lost(now_s, &e.to_string()),
            None => {}
        }
    }

    /// Rows go to the system; `true` when nothing waits any more.
    fn hand_over(&mut self, now_s: f64) -> bool {
        let mut done = true;
        match self.files.mend_loss() {
            Ok(None) => {}
            Ok(Some(text)) => {
                self.teller.tell(&Event::Warning { text: text.clone() });
                self.file_loss = Some(text);
            }
            Err(e) => {
                self.recorder.failed(now_s, &e.to_string());
                self.disk_error = Some(e.to_string());
                return false;
            }
        }
        if let Some(batch) = self.recorder.batch() {
            match self.files.rows(&batch) {
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
            let handed = self.files.rejects(&batch);
            if handed.is_ok() {
                self.recorder.rejects_stored();
            }
            done &= handed.is_ok();
            let file = self.files.rejected_target();
            let error = handed.err().map(|e| format!("{}: {e}", file.display()));
            self.teller.failing(&mut self.rejects_error, error);
        }
        done
    }

    fn sync(&mut self, now_s: f64) {
        self.last_sync_s = now_s;
        let error = self.files.sync().err().map(|e| e.to_string());
        self.teller.failing(&mut self.sync_error, error);
    }

    /// Everything that waits is written, and the sum is told.
    fn end(mut self, args: &Args, failed: Option<Error>) -> anyhow::Result<ExitCode> {
        let unplugged = self.source.is_none() && self.recorder.is_started();
        // What came while the last rows were written belongs to it, unless it cannot go on.
        // The reader ends first, else a stream that never rests would never end here.
        let rest = self.source.take().map(|mut source| source.rest());
        let now_s = self.now_s();
        if let Some(rest) = rest
            && failed.is_none()
            && self.recorder.ended().is_none()
        {
            self.bytes(now_s, &rest);
        }
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
        let path = self.files.path().to_owned();
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
        let lost = if let Some(text) = self.disk_error {
            Some((path, format!("{text}; {} rows are lost", account.unstored)))
        } else if account.rejected_unstored > 0 {
            let file = self.files.rejected_target();
            let mut why = format!("{} rejected lines are lost", account.rejected_unstored);
            if let Some(text) = self.rejects_error {
                // The error names the file itself.
                let text = text.trim_start_matches(&format!("{}: ", file.display()));
                why = format!("{text}; {why}");
            }
            Some((file, why))
        } else {
            self.sync_error
                .map(|text| (path, format!("{text}; the last rows may not be safe")))
        };
        let lost = lost.or_else(|| Some((args.file(), self.file_loss?)));
        if let Some((path, text)) = lost {
            return Err(Error::io(&path, std::io::Error::other(text)).into());
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
