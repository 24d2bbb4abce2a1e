//! The loop between port, keyboard, clock and disk and the recorder.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use gravical::Error;

use super::Args;
use super::content::{Content, inspected};
use super::files::{Continued, Files, continued};
use super::keys::{Key, Keys};
use super::reporter::Reporter;
use super::summary::summary;
use super::target::{LOOK_FOR_S, target};
use crate::device::event::{End, Event, FileContent};
use crate::device::live::Poses;
use crate::device::ports::{Target, list};
use crate::device::recorder::{Action, Options, Recorder};
use crate::device::serial::{Incoming, Serial};
use crate::device::trouble::holders;
use crate::failure;

/// Longest wait for bytes of the port.
const WAIT: Duration = Duration::from_millis(20);
/// Bytes that are passed to the recorder at once.
const PIECE: usize = 1 << 12;
/// Time between two writes of rows, s.
const WRITE_S: f64 = 0.2;
/// Time between two synchronisations with the disk, s.
const SYNC_S: f64 = 10.0;
/// Attempts to write at the end.
const LAST_ATTEMPTS: u32 = 5;

/// Records until the end.
pub fn record(args: &Args, reporter: &mut Reporter) -> anyhow::Result<ExitCode> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    ctrlc::set_handler(move || flag.store(true, Ordering::SeqCst))?;
    let Some(mut session) = open(args, reporter, &interrupted)? else {
        return Ok(ExitCode::from(failure::INTERRUPTED));
    };
    let keys = Keys::new();
    session.reporter.raw = keys.is_some();
    let failed = session.run(keys.as_ref(), &interrupted);
    // The next one is for the summary.
    interrupted.store(false, Ordering::SeqCst);
    session.reporter.close();
    drop(keys);
    session.end(args, failed, &interrupted)
}

/// Opens port and file; none when the user ended the waiting.
///
/// # Errors
///
/// Those of the file, of the port and of the options.
pub fn open<'a>(
    args: &Args,
    reporter: &'a mut Reporter,
    interrupted: &AtomicBool,
) -> anyhow::Result<Option<Session<'a>>> {
    let path = args.file();
    let existing = args.existing();
    Files::check(&path, existing)?;
    let before = if args.append {
        continued(&path)?
    } else {
        Continued::default()
    };
    let wanted = before.wanted(args.wanted())?;
    let ports = list().unwrap_or_default();
    let found = target(args, &ports, reporter, interrupted)?;
    let Some(target) = found else {
        return Ok(None);
    };
    let source = if args.board.wait && target.find(&ports).is_none() {
        None
    } else {
        Some(Serial::open(&target.name, args.board.baud)?)
    };
    // After the port: without a board no empty file remains.
    let (files, torn) = Files::open(&path, existing)?;
    if let Some(text) = torn {
        reporter.report(&Event::Warning { text });
    }
    let options = Options {
        wanted,
        columns: args.board.columns.clone(),
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
    };
    // Those who read along read the rows themselves.
    let content = args.write_every_s.is_none();
    let content = content.then(|| Content::new(&path.display().to_string(), files.head()));
    let mut session = Session {
        started: Instant::now(),
        recorder: Recorder::new(options),
        reporter,
        files,
        content,
        source,
        target,
        baud: args.board.baud,
        last_write_s: 0.0,
        last_sync_s: 0.0,
        last_search_s: 0.0,
        disk_error: None,
        rejects_error: None,
        sync_error: None,
        file_loss: None,
        open_error: None,
        write_every_s: args.write_every_s.unwrap_or(WRITE_S),
        written: args.write_every_s.map(|_| Vec::new()),
    };
    session.opened();
    Ok(Some(session))
}

/// A recording and everything around it.
pub struct Session<'a> {
    started: Instant,
    recorder: Recorder,
    reporter: &'a mut Reporter,
    files: Files,
    /// What the rows in the file show; none for those who read along.
    content: Option<Content>,
    source: Option<Serial>,
    target: Target,
    baud: u32,
    last_write_s: f64,
    last_sync_s: f64,
    last_search_s: f64,
    disk_error: Option<String>,
    rejects_error: Option<String>,
    sync_error: Option<String>,
    /// The file was removed, replaced or cut during the recording.
    file_loss: Option<String>,
    /// Code of the error with which the port could not be opened.
    open_error: Option<&'static str>,
    /// Time between two writes of rows, s.
    write_every_s: f64,
    /// What was written since the last call of [`step`](Self::step), for those who read along.
    written: Option<Vec<u8>>,
}

impl Session<'_> {
    fn now_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// The port was opened. Other programs that read it take rows away.
    fn opened(&mut self) {
        if self.source.is_none() {
            self.reporter.report(&Event::Waiting {
                text: format!("{} to be plugged in", self.target.name),
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
            self.reporter.report(&Event::Shared { programs });
        }
    }

    fn run(&mut self, keys: Option<&Keys>, interrupted: &AtomicBool) -> Option<Error> {
        loop {
            let fatal = self.step(|session, now_s| match keys.and_then(Keys::pressed) {
                Some(Key::Pause) => session.recorder.toggle_pause(now_s),
                Some(Key::End) => interrupted.store(true, Ordering::SeqCst),
                None => {}
            });
            if fatal.is_some()
                || self.recorder.ended().is_some()
                || interrupted.load(Ordering::SeqCst)
            {
                return fatal;
            }
        }
    }

    /// Waits shortly for bytes, and does what is due; `user` acts in between. An error ends the
    /// recording.
    pub fn step(&mut self, user: impl FnOnce(&mut Self, f64)) -> Option<Error> {
        let incoming = match &mut self.source {
            Some(source) => source.next(WAIT),
            None => {
                std::thread::sleep(WAIT);
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
        user(self, now_s);
        self.recorder.tick(now_s);
        if now_s - self.last_write_s >= self.write_every_s {
            self.last_write_s = now_s;
            self.write(now_s);
        }
        self.act(now_s);
        if now_s - self.last_sync_s >= SYNC_S {
            self.sync(now_s);
        }
        self.recorder.take_fatal()
    }

    /// What was written since the last call, if it is kept.
    pub fn take_written(&mut self) -> Vec<u8> {
        self.written
            .as_mut()
            .map(std::mem::take)
            .unwrap_or_default()
    }

    /// The events since the last call, of a reporter that keeps them.
    pub fn take_events(&mut self) -> Vec<Event> {
        self.reporter.take_kept()
    }

    /// Makes everything that was written safe on the disk.
    ///
    /// # Errors
    ///
    /// The system's error.
    pub fn make_safe(&mut self) -> gravical::Result<()> {
        let now_s = self.now_s();
        self.write(now_s);
        let path = self.files.path().to_owned();
        self.files.sync().map_err(|e| Error::io(&path, e))
    }

    /// The port.
    pub fn port(&self) -> &str {
        &self.target.name
    }

    /// Passes bytes on in pieces, so that the queue for the disk has room.
    fn bytes(&mut self, now_s: f64, bytes: &[u8]) {
        for piece in bytes.chunks(PIECE) {
            self.recorder.bytes(now_s, piece);
            if self.recorder.is_crowded() {
                self.write(now_s);
            }
        }
    }

    fn lost(&mut self, now_s: f64, why: &str) {
        self.source = None;
        self.recorder.lost(now_s, why);
        self.last_search_s = now_s;
    }

    /// Searches for the device that was lost.
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
                self.open_error = None;
                self.target.name = name;
                self.source = Some(source);
                self.opened();
            }
            // Just after plugging in, permissions are not set yet, and other programs
            // probe the port: it is retried. Each error is reported once.
            Err(e) => {
                if self.open_error != Some(e.code()) {
                    self.open_error = Some(e.code());
                    let hint = e.hint().map_or_else(String::new, |h| format!(" ({h})"));
                    self.reporter.report(&Event::Warning {
                        text: format!("{e}; it is retried{hint}"),
                    });
                }
            }
        }
    }

    fn act(&mut self, now_s: f64) {
        self.reporter.settings = self.recorder.settings().copied();
        for action in self.recorder.take() {
            match action {
                Action::Send(bytes) => {
                    let sent = self.source.as_mut().map(|source| source.send(&bytes));
                    if let Some(Err(e)) = sent {
                        self.lost(now_s, &e.to_string());
                    }
                }
                Action::Sync => {
                    self.write(now_s);
                    self.sync(now_s);
                }
                Action::Report(event) => {
                    if let (Event::Status { .. }, Some(content)) = (&event, &mut self.content) {
                        for finding in content.new_findings() {
                            self.reporter.report(&Event::Finding(finding));
                        }
                        self.reporter.accel = content.accel_scale();
                    }
                    self.reporter.report(&event);
                }
            }
        }
    }

    /// Passes rows to the system; true when nothing waits any more.
    fn write(&mut self, now_s: f64) -> bool {
        let mut done = true;
        match self.files.mend() {
            Ok(None) => {}
            Ok(Some(text)) => {
                self.reporter.report(&Event::Warning { text: text.clone() });
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
                    if let Some(content) = &mut self.content {
                        content.observe(&batch);
                    }
                    if let Some(written) = &mut self.written {
                        written.extend_from_slice(&batch);
                    }
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
            self.reporter.disk_error(&mut self.rejects_error, error);
        }
        done
    }

    fn sync(&mut self, now_s: f64) {
        self.last_sync_s = now_s;
        let error = self.files.sync().err().map(|e| e.to_string());
        self.reporter.disk_error(&mut self.sync_error, error);
    }

    /// Writes everything that waits. The recording has ended.
    pub fn close(&mut self, failed: bool) {
        // Rows that arrived during the last write belong to the recording, unless it failed.
        // The reader thread ends first, otherwise a continuous stream would never end here.
        let rest = self.source.take().map(|mut source| source.rest());
        let now_s = self.now_s();
        if let Some(rest) = rest
            && !failed
            && self.recorder.ended().is_none()
        {
            self.bytes(now_s, &rest);
        }
        self.recorder.finish(now_s, End::User);
        for attempt in 0..LAST_ATTEMPTS {
            if self.write(now_s) {
                break;
            }
            if attempt + 1 < LAST_ATTEMPTS {
                std::thread::sleep(Duration::from_millis(100));
            }
        }
        self.recorder.give_up();
        self.act(now_s);
    }

    /// What the file holds, as `inspect` reads it; none where it does not.
    fn file_content(&mut self, path: &Path, interrupted: &AtomicBool) -> Option<Box<FileContent>> {
        if self.recorder.counts().stored == 0 || !path.is_file() {
            return None;
        }
        match inspected(path, self.reporter, interrupted) {
            Ok(inspection) => Some(Box::new(inspection?.into())),
            Err(error) => {
                let text = format!("gravical inspect cannot read the file: {error}");
                self.reporter.report(&Event::Warning { text });
                None
            }
        }
    }

    /// Writes everything that waits, and reports the summary.
    fn end(
        mut self,
        args: &Args,
        failed: Option<Error>,
        interrupted: &AtomicBool,
    ) -> anyhow::Result<ExitCode> {
        let unplugged = self.source.is_none() && self.recorder.is_started();
        let elapsed_s = self.recorder.elapsed_s(self.now_s());
        self.close(failed.is_some());
        let counts = *self.recorder.counts();
        let poses = self.recorder.poses();
        let reason = self.recorder.ended().unwrap_or(End::User);
        let path = self.files.path().to_owned();
        let content = self.file_content(&path, interrupted);
        let ended = Event::Ended {
            file: path.display().to_string(),
            rejected_file: self.files.rejected_file().map(|p| p.display().to_string()),
            reason,
            elapsed_s,
            free_poses: poses.as_ref().map(Poses::free),
            poses: poses.as_ref().map(Poses::faces),
            counts: Box::new(counts),
            content,
        };
        self.reporter.report(&ended);
        if self.recorder.is_started() && !args.json && !args.quiet {
            self.reporter
                .line(&summary(&path.display().to_string(), &ended));
        }
        if !self.recorder.is_started() && !args.append {
            self.files.discard();
        }
        if let Some(error) = failed {
            return Err(error.into());
        }
        let lost = if let Some(text) = self.disk_error {
            Some((path, format!("{text}; {} rows are lost", counts.unstored)))
        } else if counts.rejected_unstored > 0 {
            let file = self.files.rejected_target();
            let mut why = format!("{} rejected lines are lost", counts.rejected_unstored);
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
            && (args.rows.is_some() || args.duration.is_some() || counts.incomplete > 0);
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
