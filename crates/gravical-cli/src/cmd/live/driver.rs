//! The loop between the source of rows, the session, the disk and those who show the events.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::TryRecvError;
use std::time::{Duration, Instant};

use gravical::calibrate::{CalibrateOptions, Calibrated};
use gravical::calibration_file::{CalibrationFile, Grade};
use gravical::escape::path_word;
use gravical::live::event::{
    Command, EndReason, Event, Loss, Message, PortInfo, Rejection, SourceKind, WarningKind,
};
use gravical::live::folder::{JOURNAL, Journal, RECORDING, calibrate_session};
use gravical::live::{LiveOptions, Session, sentence};
use gravical::numfmt::count;
use gravical::recording::{Recording, read};
use gravical::{Category, Error, Result};
use gravical_report::{figure, report};

use super::Args;
use super::connect::{Absent, OpenSource, Origin, arrived, flash, remedy};
use super::console::{Console, Entry};
use super::source::Incoming;
use super::truth::truth_event;
use crate::cmd::calibrate::save;
use crate::cmd::log::{Existing, LogFile};
use crate::device::ports::{list, list_with_holders};
use crate::failure;
use crate::options::command_line;
use crate::report::write_report;

/// A hand that moves is left alone for this long, s, unless the pose is accepted.
const HAND_S: f64 = 8.0;

/// A session and everything around it.
pub struct Driver<'a> {
    args: &'a Args,
    console: &'a mut Console,
    folder: Option<&'a Path>,
    /// Of a session that goes on.
    before: Option<&'a Journal>,
    origin: Origin,
    opened: OpenSource,
    /// Why the user has to choose another origin.
    trouble: Option<Error>,
    /// The ports that were shown to choose from.
    shown: Option<Vec<PortInfo>>,
    /// The first rows have arrived, or there is no need to wait for them.
    has_begun: bool,
    session: Session,
    /// An event a line.
    journal: Option<LogFile>,
    hand: SimulatedHand,
}

/// Commands that are typed, and the hand that moves a simulated sensor by them.
#[derive(Default)]
struct SimulatedHand {
    waiting: VecDeque<Command>,
    now_s: f64,
    /// Time of the session until which it is busy: it moves the sensor, or leaves it alone, s.
    busy_until_s: f64,
    /// Nobody types any more.
    is_gone: bool,
}

impl SimulatedHand {
    fn is_busy(&self) -> bool {
        self.now_s < self.busy_until_s
    }

    fn moves(&mut self) {
        self.busy_until_s = self.now_s + HAND_S;
    }

    fn see(&mut self, message: &Message) {
        self.now_s = message.t_s;
        let is_over = match &message.event {
            Event::PoseAccepted(_) => true,
            Event::PoseRejected { reason } => !matches!(reason, Rejection::Moved | Rejection::Gaps),
            _ => false,
        };
        if is_over {
            self.busy_until_s = self.now_s;
        }
    }
}

impl<'a> Driver<'a> {
    /// For a session in `folder`, if it has one; `before` is the journal of one that goes on.
    pub fn new(
        args: &'a Args,
        folder: Option<&'a Path>,
        before: Option<&'a Journal>,
        console: &'a mut Console,
    ) -> Self {
        Driver {
            args,
            console,
            folder,
            before,
            origin: args.origin(before),
            opened: OpenSource {
                kind: SourceKind::Port,
                name: String::new(),
                source: Box::new(Absent),
                before: Vec::new(),
            },
            trouble: None,
            shown: None,
            has_begun: false,
            session: Session::new("", LiveOptions::default()),
            journal: None,
            hand: SimulatedHand::default(),
        }
    }

    /// Runs the session to its end.
    ///
    /// # Errors
    ///
    /// Those of the source and of the disk.
    pub fn run(mut self) -> anyhow::Result<ExitCode> {
        let ended = self.guide();
        if !self.has_begun {
            self.discard();
            ended?;
            return self.stopped();
        }
        // What cannot be written has been rescued, and would be once more.
        if ended.as_ref().is_err_and(|error| error.code() == "io") {
            self.journal = None;
        } else {
            self.opened.source.close();
        }
        if let Err(error) = ended {
            // What shows the events may have failed, too.
            let _ = self.end(EndReason::Failed, &error.to_string());
            Err(error.into())
        } else if self.console.is_interrupted() {
            self.stopped()
        } else if self.session.is_done() {
            self.save()
        } else {
            self.out_of_rows()
        }
    }

    /// Reads rows and does what the user wants, until there is an end.
    fn guide(&mut self) -> Result<()> {
        self.open()?;
        let started = Instant::now();
        while !self.console.is_interrupted() && !self.session.is_done() {
            match self.opened.source.next() {
                Ok(next) => {
                    for incoming in next {
                        if !self.receive(incoming)? {
                            return self.finish();
                        }
                    }
                }
                Err(error) => self.ask(error)?,
            }
            self.look_for_ports()?;
            self.commands()?;
            let hand = &self.hand;
            let is_idle = hand.is_gone && hand.waiting.is_empty() && !hand.is_busy();
            let kind = self.opened.kind;
            if kind == SourceKind::Simulate && is_idle && !self.session.is_done() {
                return self.finish();
            }
            let speed = self.args.speed();
            if kind == SourceKind::Replay && speed > 0.0 {
                let ahead_s = self.hand.now_s / speed - started.elapsed().as_secs_f64();
                std::thread::sleep(Duration::from_secs_f64(ahead_s.clamp(0.0, 1.0)));
            }
        }
        Ok(())
    }

    // The way to the first row.

    /// Opens the source.
    fn open(&mut self) -> Result<()> {
        self.discard();
        self.trouble = None;
        let folder = self.folder.unwrap_or(Path::new(""));
        match self.args.open(&self.origin, folder) {
            Ok(opened) => self.opened = opened,
            Err(error) => return self.ask(error),
        }
        // A port may be that of another device.
        if self.opened.kind == SourceKind::Port {
            return Ok(());
        }
        self.begin()
    }

    /// No file of the source remains.
    fn discard(&mut self) {
        let source = std::mem::replace(&mut self.opened.source, Box::new(Absent));
        source.discard();
    }

    /// Lets the user choose another port, or a simulated sensor. In a script, and once there were rows,
    /// the error ends the program.
    fn ask(&mut self, error: Error) -> Result<()> {
        if self.has_begun || !self.args.is_seen() || error.category() != Category::Device {
            return Err(error);
        }
        self.discard();
        (self.trouble, self.shown) = (Some(error), None);
        Ok(())
    }

    /// Shows the ports to choose from; opens the one that was waited for as soon as it is there.
    fn look_for_ports(&mut self) -> Result<()> {
        let Some(trouble) = self.trouble.take() else {
            return Ok(());
        };
        let found = list_with_holders().unwrap_or_default();
        let tried = self.origin.port();
        if let Some(name) = arrived(&trouble, tried, &found) {
            self.origin = Origin::Port(Some(name));
            return self.open();
        }
        if self.shown.as_ref() != Some(&found) {
            let (remedy, needs_sketch) = remedy(&trouble);
            let flash = needs_sketch.then(|| flash(tried));
            let event = Event::Ports {
                ports: found.clone(),
                tried: tried.map(str::to_owned),
                flash: flash.unwrap_or_default(),
                simulate: self.before.is_none(),
            };
            let text = format!("{} {}", sentence(trouble.message()), sentence(remedy));
            self.note(event, &text)?;
            self.shown = Some(found);
        }
        self.trouble = Some(trouble);
        Ok(())
    }

    /// Another source before the first row. Only a port of this computer can be chosen, or the one that
    /// was tried.
    fn choose(&mut self, command: &Command) -> Result<()> {
        let refusal = match command {
            Command::Simulate if self.before.is_none() => {
                self.origin = Origin::Simulated(None);
                return self.open();
            }
            Command::Simulate => "This session is of another sensor.",
            Command::Port { name } => {
                let ports = list().unwrap_or_default();
                let is_known = ports.iter().any(|port| port.name == *name);
                if is_known || self.origin.port() == Some(name.as_str()) {
                    self.origin = Origin::Port(Some(name.clone()));
                    return self.open();
                }
                &format!("{name} is no port of this computer.")
            }
            _ => "No row has arrived yet: the session has not begun.",
        };
        self.warn(WarningKind::Refused, refusal)
    }

    /// The session begins, or goes on.
    fn begin(&mut self) -> Result<()> {
        self.has_begun = true;
        let kind = self.opened.kind;
        let recording = match self.folder {
            Some(folder) => folder.join(RECORDING).display().to_string(),
            None => self.opened.name.clone(),
        };
        let options = self.args.session_options(kind, self.before)?;
        self.session = Session::new(&recording, options);
        let existing = Existing::of_session(self.before.is_some());
        let journal = self
            .folder
            .map(|f| LogFile::open(&f.join(JOURNAL), existing));
        self.journal = journal.transpose()?;
        let folder = self.folder.map(|f| f.display().to_string());
        let begun = self.session.begin(kind, &self.opened.name, folder);
        if let Some(journal) = self.before {
            self.render(&begun)?;
            let bytes = std::mem::take(&mut self.opened.before);
            let restored = self.session.restore(&bytes, journal)?;
            self.render(&restored)?;
        } else {
            self.show(begun)?;
        }
        if kind == SourceKind::Simulate {
            // It is left alone until its noise is known.
            self.hand.moves();
        }
        Ok(())
    }

    // The session.

    /// Passes to the session what the source has; false at its end.
    fn receive(&mut self, incoming: Incoming) -> Result<bool> {
        let messages = match incoming {
            Incoming::Bytes(bytes) => {
                if !self.has_begun {
                    self.begin()?;
                }
                let mut messages = self.session.resumed();
                messages.extend(self.session.bytes(&bytes)?);
                if self.opened.kind == SourceKind::Port {
                    // The logger has waited for rows enough, also of a slow sensor.
                    messages.extend(self.session.settle_format().unwrap_or_default());
                }
                messages
            }
            Incoming::Connected(name) if !self.has_begun => {
                self.opened.name.clone_from(&name);
                self.origin = Origin::Port(Some(name.clone()));
                let text = format!("{name} is open: waiting for its first rows.");
                self.session.note(Event::Connecting { name }, &text)
            }
            Incoming::Lost(Loss::Unplugged) if !self.has_begun => {
                let text = format!("{}: unplugged before the first row", self.opened.name);
                self.ask(Error::device("no-such-port", text))?;
                Vec::new()
            }
            Incoming::Lost(why) if self.has_begun => self.session.lost(why),
            Incoming::Connected(_) | Incoming::Lost(_) => Vec::new(),
            Incoming::Warning(text) => {
                let kind = WarningKind::Rows;
                self.session.note(Event::Warning { kind }, &text)
            }
            Incoming::End => {
                let messages = self.session.settle_format().unwrap_or_default();
                self.show(messages)?;
                return Ok(false);
            }
        };
        self.show(messages)?;
        Ok(true)
    }

    /// There will be no more rows, or none that matter.
    fn finish(&mut self) -> Result<()> {
        let messages = self.session.command(&Command::Finish);
        self.show(messages)
    }

    /// Shows events; what has to be safe is safe before.
    fn show(&mut self, messages: Vec<Message>) -> Result<()> {
        for message in messages {
            if let Some(journal) = &mut self.journal
                && !message.event.is_status()
            {
                let line = serde_json::to_string(&message);
                let line = line.map_err(|e| Error::io(journal.path(), e.into()))?;
                // Without these a session could not be resumed as it was.
                let is_vital = matches!(
                    message.event,
                    Event::Session { .. }
                        | Event::PoseAccepted(_)
                        | Event::PoseUndone { .. }
                        | Event::Gravity(_)
                );
                if is_vital {
                    self.opened.source.make_safe()?;
                }
                journal.write(format!("{line}\n").as_bytes())?;
                if is_vital {
                    journal.sync()?;
                }
            }
            self.render(&[message])?;
        }
        Ok(())
    }

    /// Shows events that are in the journal.
    fn render(&mut self, messages: &[Message]) -> Result<()> {
        for message in messages {
            self.hand.see(message);
            self.console.show(message)?;
        }
        Ok(())
    }

    /// Does what the user wants.
    fn commands(&mut self) -> Result<()> {
        loop {
            let entry = self.console.entries.try_recv();
            self.hand.is_gone = entry
                .as_ref()
                .is_err_and(|e| *e == TryRecvError::Disconnected);
            let Ok(Entry {
                command,
                is_clicked,
            }) = entry
            else {
                break;
            };
            match command {
                Ok(command) if is_clicked => self.command(&command)?,
                Ok(command) => self.hand.waiting.push_back(command),
                Err(text) => self.warn(WarningKind::Refused, &text)?,
            }
        }
        while !self.hand.is_busy()
            && !self.session.is_done()
            && let Some(command) = self.hand.waiting.pop_front()
        {
            self.command(&command)?;
        }
        Ok(())
    }

    fn command(&mut self, command: &Command) -> Result<()> {
        if *command == Command::Cancel {
            // The program ends as after Ctrl-C.
            self.console.interrupt();
        } else if !self.has_begun {
            return self.choose(command);
        }
        match self.opened.source.hand(command, self.session.next_up()) {
            Ok(true) => {
                self.hand.moves();
                Ok(())
            }
            Ok(false) => {
                let messages = self.session.command(command);
                self.show(messages)
            }
            Err(error) => self.warn(WarningKind::Refused, &error.to_string()),
        }
    }

    // Ends.

    /// The user has ended it: what was recorded is kept.
    fn stopped(&mut self) -> anyhow::Result<ExitCode> {
        self.opened.source.make_safe()?;
        let (reason, what) = if self.session.is_done() {
            (EndReason::Cancelled, "Cancelled without a calibration")
        } else {
            (EndReason::Interrupted, "Interrupted")
        };
        let text = match self.folder {
            _ if !self.has_begun => "Ended before the first row.".to_owned(),
            Some(folder) => format!("{what}; what was recorded is in {}.", folder.display()),
            None => what.to_owned(),
        };
        self.end(reason, &text)?;
        Ok(ExitCode::from(failure::INTERRUPTED))
    }

    fn out_of_rows(&mut self) -> anyhow::Result<ExitCode> {
        let poses = self.session.poses().count();
        if self.opened.kind == SourceKind::Replay && poses == 0 {
            // What is no recording is refused as by every command.
            read(Path::new(&self.opened.name), &self.args.read_options())?;
        }
        let poses = count(poses, "pose");
        let text = format!("The rows ended after {poses}");
        self.end(EndReason::SourceEnded, &text)?;
        let hint = match self.resume_command() {
            Some(command) => format!("{command} goes on"),
            None => "--any-pose accepts every steady hold, and --capture 1 shorter ones".to_owned(),
        };
        let what = format!("the session ended after {poses}, too few for a calibration");
        Err(Error::input("too-few-poses", what).with_hint(hint).into())
    }

    /// Saves the calibration, and reads it back: that of what is on the disk, where the session has a
    /// folder.
    fn save(&mut self) -> anyhow::Result<ExitCode> {
        self.opened.source.make_safe()?;
        let recorded = self.folder.map(|folder| {
            let options = CalibrateOptions {
                command: Some(command_line()),
                ..CalibrateOptions::default()
            };
            let read = self.args.read_options();
            calibrate_session(folder, &read, &options, Some(self.session.gravity()))
        });
        let recorded = recorded.transpose()?;
        let file = recorded.as_ref().map(|(_, done)| &done.file);
        let file = file.or(self.session.calibration()).cloned();
        let file = file.ok_or_else(|| Error::input("too-few-poses", "there is no calibration"))?;
        let output = self.args.output(self.folder);
        let done = match &output {
            Some(_) => "Done and saved",
            None => "Done, and not saved (-o cal.json does)",
        };
        if let Some(output) = output {
            save(&output, false, &file)?;
            let report = self.report(&file, recorded.as_ref(), &output)?;
            let saved = Event::Saved {
                file: output.display().to_string(),
                folder: self.folder.map(|f| f.display().to_string()),
                report: report.map(|path| path.display().to_string()),
                next: self.next_steps(file.verdict.grade, &path_word(&output)),
            };
            let text = format!("Saved to {}, read back and compared.", output.display());
            self.note(saved, &text)?;
        }
        if let Some(truth) = self.opened.source.truth() {
            let (event, text) = truth_event(&truth, &file);
            self.note(event, &text)?;
        }
        let grade = file.verdict.grade;
        let poses = count(self.session.poses().count(), "pose");
        let text = format!("{done}: {poses}, verdict {grade}");
        self.end(EndReason::Finished, &text)?;
        Ok(match grade {
            Grade::Poor => ExitCode::from(failure::QUALITY),
            _ => ExitCode::SUCCESS,
        })
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

    /// The calibration report, for the page and into the folder. Where it cannot be written, the
    /// calibration is saved all the same.
    fn report(
        &mut self,
        file: &CalibrationFile,
        recorded: Option<&(Vec<Recording>, Calibrated)>,
        output: &Path,
    ) -> Result<Option<PathBuf>> {
        let session = recorded.map(|(recordings, done)| figure::calibration::Session {
            recordings,
            segmentation: &done.segmentation,
        });
        let figures = figure::calibration::figures(file, session);
        let document = report::calibration(file, Some(output), &figures);
        let html = document.to_html();
        let renderers = self.console.renderers.iter_mut();
        renderers.for_each(|r| r.report(&html));
        let Some(folder) = self.folder else {
            return Ok(None);
        };
        let name = Path::new(output.file_name().unwrap_or_default()).with_extension("html");
        let path = folder.join(name);
        if let Err(error) = write_report(&path, false, &document) {
            let why = format!("the report was not written: {error}");
            self.warn(WarningKind::Other, &why)?;
            return Ok(None);
        }
        Ok(Some(path))
    }

    fn end(&mut self, reason: EndReason, text: &str) -> Result<()> {
        let resume = self.resume_command();
        let event = Event::End {
            reason,
            poses: self.session.poses().count() as u32,
            resume: resume.filter(|_| self.has_begun && reason != EndReason::Finished),
        };
        self.note(event, text)
    }

    fn warn(&mut self, kind: WarningKind, text: &str) -> Result<()> {
        self.note(Event::Warning { kind }, text)
    }

    /// Shows what only the program knows.
    fn note(&mut self, event: Event, text: &str) -> Result<()> {
        let messages = self.session.note(event, text);
        self.show(messages)
    }

    fn resume_command(&self) -> Option<String> {
        let folder = path_word(self.folder?);
        Some(format!("gravical live --resume {folder}"))
    }
}
