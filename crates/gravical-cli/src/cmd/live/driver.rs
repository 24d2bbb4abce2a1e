//! The loop between the source of rows, the session, the disk and those who show the events.

use std::path::Path;
use std::process::ExitCode;
use std::sync::mpsc::TryRecvError;
use std::time::{Duration, Instant};

use gravical::calibrate::CalibrateOptions;
use gravical::calibration_file::Grade;
use gravical::escape::path_word;
use gravical::live::Guide;
use gravical::live::event::{Command, EndReason, Event, Rejection, SourceKind};
use gravical::live::folder::{JOURNAL, Journal, RECORDING, calibrate_folder};
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
    guide: Guide,
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
    let mut guide = Guide::new(opened.kind, &opened.name, &recording, options);
    guide.folder = folder.map(|f| f.display().to_string());
    let mut driver = Driver {
        args,
        console,
        busy_until_s: 0.0,
        opened,
        guide,
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
        Ok(()) if driver.guide.session.is_done() => driver.save(),
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
        self.guide.begin();
        self.show()?;
        let first = std::mem::take(&mut self.opened.first);
        if let (Some(journal), Some(folder)) = (before, &self.args.folder) {
            let path = folder.join(RECORDING);
            let mut bytes = std::fs::read(&path).map_err(|e| Error::io(&path, e))?;
            bytes.truncate(self.opened.restored_bytes as usize);
            for message in self.guide.restore(&bytes, journal)? {
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
        while !self.console.is_interrupted() && !self.guide.session.is_done() {
            let Some(next) = self.opened.source.next()? else {
                self.guide.finish()?;
                return self.show();
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
    fn receive(&mut self, Incoming { bytes, events }: Incoming) -> Result<()> {
        let received = self.guide.receive(&bytes, events);
        self.show()?;
        received
    }

    /// Shows what was said; it is safe in the journal before, and so are the rows that it is about.
    fn show(&mut self) -> Result<()> {
        let messages = self.guide.take();
        let recorded = messages.iter().filter(|m| m.is_recorded());
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
        while self.now_s >= self.busy_until_s && !self.guide.session.is_done() {
            match self.console.typed.try_recv() {
                Ok(Ok(command)) => self.command(&command)?,
                Ok(Err(text)) => {
                    self.guide.warn(&text);
                    self.show()?;
                }
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
        let asked = self.guide.session.next_up();
        match self.opened.source.hand(command, asked) {
            Ok(true) => self.busy_until_s = self.now_s + HAND_S,
            Ok(false) => self.guide.command(command),
            Err(error) => self.guide.warn(&error.to_string()),
        }
        self.show()
    }

    // Ends.

    /// The user has ended it: what was recorded is kept.
    fn stopped(&mut self) -> anyhow::Result<ExitCode> {
        let (reason, what) = if self.guide.session.is_done() {
            (EndReason::Cancelled, "Cancelled without a calibration")
        } else {
            (EndReason::Interrupted, "Interrupted")
        };
        let text = match &self.guide.folder {
            Some(folder) => format!("{what}; what was recorded is in {folder}."),
            None => what.to_owned(),
        };
        self.end(reason, &text)?;
        Ok(ExitCode::from(failure::INTERRUPTED))
    }

    fn out_of_rows(&mut self) -> anyhow::Result<ExitCode> {
        let poses = count(self.guide.session.poses().count(), "pose");
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
            calibrate_folder(folder, &read, &options, Some(self.guide.session.gravity()))
        });
        let recorded = recorded.transpose()?;
        let file = recorded.as_ref().map(|(_, done)| &done.calibration);
        let file = file.or(self.guide.session.calibration()).cloned();
        let file = file.ok_or_else(|| Error::input("too-few-poses", "there is no calibration"))?;
        let grade = file.grade();
        let mut saved = None;
        if let Some(output) = self.args.output() {
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
                    Err(error) => self
                        .guide
                        .warn(&format!("the report was not written: {error}")),
                }
            }
            let event = Event::Saved {
                file: output.display().to_string(),
                folder: self.guide.folder.clone(),
                report: written,
                next: self.next_steps(grade, &path_word(&output)),
            };
            saved = Some((event, format!("Saved to {}.", output.display())));
        }
        if saved.is_none() {
            self.guide.warn("-o cal.json saves the calibration");
        }
        let truth = self.opened.source.truth(&file);
        self.guide.done(&file, saved, truth);
        self.show()?;
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
        self.guide.end(reason, text, self.resume_command());
        self.show()
    }

    fn resume_command(&self) -> Option<String> {
        let folder = path_word(self.args.folder.as_ref()?);
        Some(format!("gravical live --resume {folder}"))
    }
}
