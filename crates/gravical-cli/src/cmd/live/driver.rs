//! The loop between the source of rows, the session, the disk and those who show the events.

use std::path::Path;
use std::process::ExitCode;
use std::sync::mpsc::TryRecvError;
use std::time::{Duration, Instant};

use gravical::calibrate::CalibrateOptions;
use gravical::calibration_file::Grade;
use gravical::escape::path_word;
use gravical::live::event::{Command, EndReason, Event, Loss, Message, Rejection, SourceKind};
use gravical::live::folder::{JOURNAL, Journal, RECORDING, calibrate_session};
use gravical::live::{Session, recorder};
use gravical::numfmt::count;
use gravical::{Error, Result};
use gravical_report::{figure, report};

use super::Args;
use super::connect::OpenSource;
use super::console::Console;
use super::source::Incoming;
use crate::cmd::log::{Existing, LogFile};
use crate::failure;
use crate::options::command_line;
use crate::report::write_report;

/// A hand that moves a simulated sensor is left alone for this long, s, unless the pose is accepted.
const HAND_S: f64 = 8.0;

/// A session and everything around it.
struct Driver<'a> {
    args: &'a Args,
    console: &'a mut Console,
    opened: OpenSource,
    session: Session,
    /// An event a line.
    journal: Option<LogFile>,
    /// Time of the last event, s.
    now_s: f64,
    /// Until then a simulated sensor is left alone, and what is typed waits, s.
    busy_until_s: f64,
}

/// Runs a session to its end; `before` is the journal of one that goes on.
///
/// # Errors
///
/// Those of the options, of the source and of the disk.
pub fn run(
    args: &Args,
    before: Option<&Journal>,
    console: &mut Console,
    opened: OpenSource,
) -> anyhow::Result<ExitCode> {
    let folder = args.folder.as_deref();
    let recording = match folder {
        Some(folder) => folder.join(RECORDING).display().to_string(),
        None => opened.name.clone(),
    };
    let options = args.session_options(opened.kind, before)?;
    let existing = Existing::of_session(before.is_some());
    let journal = folder.map(|f| LogFile::open(&f.join(JOURNAL), existing));
    let mut driver = Driver {
        args,
        console,
        busy_until_s: 0.0,
        opened,
        session: Session::new(&recording, options),
        journal: journal.transpose()?,
        now_s: 0.0,
    };
    let ended = driver.begin(before).and_then(|()| driver.guide());
    // Whatever failed, rows that wait are written.
    let closed = driver.opened.source.close(false);
    let ended = ended.and(closed);
    let done = match ended {
        Err(error) => Err(error.into()),
        Ok(()) if driver.console.is_interrupted() => driver.stopped(),
        Ok(()) if driver.session.is_done() => driver.save(),
        Ok(()) => return driver.out_of_rows(),
    };
    if let Err(error) = &done {
        // What shows the events may have failed, too.
        let _ = driver.end(EndReason::Failed, &error.to_string());
    }
    done
}

impl Driver<'_> {
    /// The session begins, or goes on.
    fn begin(&mut self, before: Option<&Journal>) -> Result<()> {
        let mut text = self.opened.name.clone();
        if let Some(folder) = self.folder_name() {
            text += &format!("; the session is in {folder}");
        }
        let event = Event::Session {
            source: self.opened.kind,
            name: self.opened.name.clone(),
            folder: self.folder_name(),
            gravity: self.session.gravity(),
        };
        self.note(event, &text)?;
        let first = std::mem::take(&mut self.opened.first);
        if let (Some(journal), Some(folder)) = (before, &self.args.folder) {
            let path = folder.join(RECORDING);
            let mut bytes = std::fs::read(&path).map_err(|e| Error::io(&path, e))?;
            bytes.truncate(self.opened.restored_bytes as usize);
            for message in self.session.restore(&bytes, journal)? {
                self.now_s = message.t_s;
                self.console.show(&message)?;
            }
        }
        if self.opened.kind == SourceKind::Simulate {
            // It is left alone until its noise is known.
            self.busy_until_s = self.now_s + HAND_S;
        }
        self.receive(first)
    }

    /// Reads rows and does what the user wants, until there is an end.
    fn guide(&mut self) -> Result<()> {
        let started = Instant::now();
        while !self.console.is_interrupted() && !self.session.is_done() {
            let Some(next) = self.opened.source.next()? else {
                let messages = self.session.settle_format()?;
                self.show(messages)?;
                return self.command(&Command::Finish);
            };
            self.receive(next)?;
            let kind = self.opened.kind;
            let is_seen = self.console.page.is_some();
            if !self.commands()? && kind == SourceKind::Simulate && !is_seen {
                return self.command(&Command::Finish);
            }
            let speed = self.args.speed();
            if kind == SourceKind::Replay && speed > 0.0 {
                let ahead_s = self.now_s / speed - started.elapsed().as_secs_f64();
                std::thread::sleep(Duration::from_secs_f64(ahead_s.clamp(0.0, 1.0)));
            }
        }
        Ok(())
    }

    /// Passes to the session what the source has.
    fn receive(&mut self, incoming: Incoming) -> Result<()> {
        let Incoming { bytes, events } = incoming;
        let mut messages = Vec::new();
        if !bytes.is_empty() {
            messages = self.session.resumed();
            messages.extend(self.session.bytes(&bytes)?);
            if self.opened.kind == SourceKind::Port {
                // The logger has waited for rows enough, also of a slow sensor.
                messages.extend(self.session.settle_format().unwrap_or_default());
            }
        }
        self.show(messages)?;
        for event in events {
            match event {
                recorder::Event::Lost { .. } => self.lost(Loss::Unplugged)?,
                recorder::Event::Silent { .. } => self.lost(Loss::Silent)?,
                recorder::Event::Warning { text } | recorder::Event::Waiting { text } => {
                    self.warn(&text)?
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn lost(&mut self, why: Loss) -> Result<()> {
        let messages = self.session.lost(why);
        self.show(messages)
    }

    /// Shows events; they are safe in the journal before, and so are the rows that they are of.
    fn show(&mut self, messages: Vec<Message>) -> Result<()> {
        let is_recorded = |m: &&Message| !matches!(m.event, Event::Status(_));
        let recorded = messages.iter().filter(is_recorded);
        let lines: String = recorded.map(|m| m.to_json() + "\n").collect();
        if let Some(journal) = &mut self.journal
            && !lines.is_empty()
        {
            self.opened.source.make_safe()?;
            journal.write(lines.as_bytes())?;
            journal.sync()?;
        }
        for message in messages {
            self.now_s = message.t_s;
            let is_over = match &message.event {
                Event::PoseAccepted(_) => true,
                Event::PoseRejected { reason } => {
                    !matches!(reason, Rejection::Moved | Rejection::Gaps)
                }
                _ => false,
            };
            if is_over {
                self.busy_until_s = self.now_s;
            }
            self.console.show(&message)?;
        }
        Ok(())
    }

    /// Does what the user wants; false once nobody types any more.
    fn commands(&mut self) -> Result<bool> {
        while let Ok(command) = self.console.clicked.try_recv() {
            self.command(&command)?;
        }
        while self.now_s >= self.busy_until_s && !self.session.is_done() {
            match self.console.typed.try_recv() {
                Ok(Ok(command)) => self.command(&command)?,
                Ok(Err(text)) => self.warn(&text)?,
                Err(error) => return Ok(error != TryRecvError::Disconnected),
            }
        }
        Ok(true)
    }

    fn command(&mut self, command: &Command) -> Result<()> {
        if *command == Command::Cancel {
            // The program ends as after Ctrl-C.
            self.console.interrupt();
        }
        match self.opened.source.hand(command, self.session.next_up()) {
            Ok(true) => {
                self.busy_until_s = self.now_s + HAND_S;
                Ok(())
            }
            Ok(false) => {
                let messages = self.session.command(command);
                self.show(messages)
            }
            Err(error) => self.warn(&error.to_string()),
        }
    }

    // Ends.

    /// The user has ended it: what was recorded is kept.
    fn stopped(&mut self) -> anyhow::Result<ExitCode> {
        let (reason, what) = if self.session.is_done() {
            (EndReason::Cancelled, "Cancelled without a calibration")
        } else {
            (EndReason::Interrupted, "Interrupted")
        };
        let text = match self.folder_name() {
            Some(folder) => format!("{what}; what was recorded is in {folder}."),
            None => what.to_owned(),
        };
        self.end(reason, &text)?;
        Ok(ExitCode::from(failure::INTERRUPTED))
    }

    fn out_of_rows(&mut self) -> anyhow::Result<ExitCode> {
        let poses = count(self.session.poses().count(), "pose");
        let what = format!("the rows ended after {poses}, too few for a calibration");
        self.end(EndReason::SourceEnded, &what)?;
        let error = Error::input("too-few-poses", what).with_hint(match self.resume_command() {
            Some(command) => format!("{command} goes on"),
            None => "--any-pose accepts every steady hold, and --capture 1 shorter ones".to_owned(),
        });
        Err(error.into())
    }

    /// Saves the calibration: that of what is on the disk, where the session has a folder.
    fn save(&mut self) -> anyhow::Result<ExitCode> {
        let recorded = self.args.folder.as_ref().map(|folder| {
            let options = CalibrateOptions {
                command: Some(command_line()),
                ..CalibrateOptions::default()
            };
            let read = self.args.read_options();
            calibrate_session(folder, &read, &options, Some(self.session.gravity()))
        });
        let recorded = recorded.transpose()?;
        let file = recorded.as_ref().map(|(_, done)| &done.calibration);
        let file = file.or(self.session.calibration()).cloned();
        let file = file.ok_or_else(|| Error::input("too-few-poses", "there is no calibration"))?;
        let grade = file.grade();
        let output = self.args.output();
        let done = match &output {
            Some(_) => "Done and saved",
            None => "Done, and not saved (-o cal.json does)",
        };
        if let Some(output) = output {
            file.write(&output, false)?;
            let mut written = None;
            if let (Some(folder), Some((recordings, done))) = (&self.args.folder, &recorded) {
                let session = Some((&recordings[..], &done.segmentation));
                let figures = figure::calibration::figures(&file, session);
                let document = report::calibration(&file, Some(&output), &figures);
                let name = Path::new(output.file_name().unwrap_or_default());
                let path = folder.join(name.with_extension("html"));
                match write_report(&path, false, &document) {
                    Ok(()) => written = Some(path.display().to_string()),
                    // The calibration is saved all the same.
                    Err(error) => self.warn(&format!("the report was not written: {error}"))?,
                }
            }
            let saved = Event::Saved {
                file: output.display().to_string(),
                folder: self.folder_name(),
                report: written,
                next: self.next_steps(grade, &path_word(&output)),
            };
            let text = format!("Saved to {}.", output.display());
            self.note(saved, &text)?;
        }
        if let Some((event, text)) = self.opened.source.truth(&file) {
            self.note(event, &text)?;
        }
        let poses = count(self.session.poses().count(), "pose");
        let text = format!("{done}: {poses}, verdict {grade}");
        self.end(EndReason::Finished, &text)?;
        Ok(failure::quality(grade == Grade::Poor))
    }

    /// Commands to go on with: to a better calibration where it is not good, else to its use.
    fn next_steps(&self, grade: Grade, calibration: &str) -> Vec<String> {
        let mut steps = Vec::new();
        if grade != Grade::Good {
            steps.extend(self.resume_command());
        } else if self.opened.kind == SourceKind::Port {
            steps.push("gravical log -o move.csv".to_owned());
            steps.push(format!(
                "gravical motion move.csv -c {calibration} --report move.html"
            ));
        }
        steps.push(format!(
            "gravical apply {calibration} RECORDING.csv -o calibrated.csv"
        ));
        steps.push(format!("gravical export {calibration} --to arduino"));
        steps
    }

    fn end(&mut self, reason: EndReason, text: &str) -> Result<()> {
        let resume = self.resume_command();
        let event = Event::End {
            reason,
            poses: self.session.poses().count() as u32,
            resume: resume.filter(|_| reason != EndReason::Finished),
        };
        self.note(event, text)
    }

    fn warn(&mut self, text: &str) -> Result<()> {
        self.note(Event::Warning, text)
    }

    /// Shows what only the program knows.
    fn note(&mut self, event: Event, text: &str) -> Result<()> {
        self.show(vec![Message::new(self.now_s, event, text)])
    }

    fn folder_name(&self) -> Option<String> {
        let folder = self.args.folder.as_ref()?;
        Some(folder.display().to_string())
    }

    fn resume_command(&self) -> Option<String> {
        let folder = path_word(self.args.folder.as_ref()?);
        Some(format!("gravical live --resume {folder}"))
    }
}
